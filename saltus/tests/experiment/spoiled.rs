//! Spoiled folders: each by one change to a good one, and the message that names the place.

use saltus::experiment::{read, read_all};

use crate::folder::Folder;
use crate::{good, laid, rows, said};

/// A kind, a file of its good folder, what is replaced in it by what (once), and what is said then.
#[rustfmt::skip] // One case a line.
const SPOILED: &[(&str, &str, &str, &str, &str)] = &[
    ("bench", "experiment.toml", "kind = \"bench\"\n", "", "DATA/experiment.toml: missing key kind: one of bench, hop, jump, flight, outcomes, stroke, slide, vessel, pendulum, run, tank-leg, walk, machine, in quotes"),
    ("bench", "experiment.toml", "\"bench\"", "\"banch\"", "DATA/experiment.toml:1: kind = \"banch\": must be one of bench, hop, jump, flight, outcomes, stroke, slide, vessel, pendulum, run, tank-leg, walk, machine, in quotes"),
    ("bench", "experiment.toml", "\"bench\"", "7", "DATA/experiment.toml:1: kind = 7: must be one \
        of bench, hop, jump, flight, outcomes, stroke, slide, vessel, pendulum, run, tank-leg, walk, machine, in quotes"),
    ("bench", "experiment.toml", "\"bench\"", "\"toss\"", "DATA/experiment.toml: kind = \"toss\": tosses are read by the multi-body simulation's example tosses, not here"),
    ("bench", "experiment.toml", "kind", "knid", "DATA/experiment.toml:1: unknown key knid; the \
        nearest known key is kind"),
    ("bench", "experiment.toml", "kind = ", "kind = = ", "DATA/experiment.toml:1: not TOML: extra \
        `=`, expected nothing"),
    ("bench", "experiment.toml", "robot = \"rats-boom\"\n", "", "DATA/experiment.toml: missing key robot: a robot's name or the path of its file, in quotes"),
    ("hop", "experiment.toml", "\"rats-boom\"", "\"\"", "DATA/experiment.toml:2: robot = \"\": \
        must be a robot's name or the path of its file, in quotes"),
    ("jump", "experiment.toml", "robot = \"rats-boom\"\n", "", "DATA/experiment.toml: missing key robot: a robot's name or the path of its file, in quotes"),
    ("outcomes", "experiment.toml", "robot = \"rats-boom\"\n", "", "DATA/experiment.toml: missing key robot: a robot's name or the path of its file, in quotes"),
    ("bench", "experiment.toml", "load_mass_kg = 2.5\n", "", "DATA/experiment.toml:3: missing key run 1.load_mass_kg or load_mass_g or load_mass_lb"),
    ("bench", "experiment.toml", "load_mass_kg = 2.5", "load_mas_kg = 2.5", "DATA/experiment.toml:5: unknown key run 1.load_mas_kg; the nearest known key is run 1.load_mass_kg"),
    ("bench", "experiment.toml", "load_mass_kg = 2.5", "load_mass_kg = 0", "DATA/experiment.toml:5: run 1.load_mass_kg = 0: must be a mass > 0 and ≤ 1000 kg"),
    ("bench", "experiment.toml", "load_mass_kg = 2.5", "load_mass_kg = 2500", "DATA/experiment.toml:5: run 1.load_mass_kg = 2500: must be a mass > 0 and ≤ 1000 kg"),
    ("bench", "experiment.toml", "load_mass_kg = 2.5", "load_mass_kg = \"2.5\"", "DATA/experiment.toml:5: run 1.load_mass_kg = \"2.5\": must be a mass > 0 and ≤ 1000 kg"),
    ("bench", "experiment.toml", "load_mass_kg = 2.5", "load_mass_kg = nan", "DATA/experiment.toml:5: run 1.load_mass_kg = nan: must be a mass > 0 and ≤ 1000 kg"),
    ("bench", "experiment.toml", "827000", "-1", "DATA/experiment.toml:6: run 1.supply_pressure_gauge_pa = -1: must be a gauge pressure ≥ 1000 Pa and ≤ 1e8 Pa, not kPa, bar or psi"),
    ("bench", "experiment.toml", "827000", "8.27", "DATA/experiment.toml:6: run 1.supply_pressure_gauge_pa = 8.27: must be a gauge pressure ≥ 1000 Pa and ≤ 1e8 Pa, not kPa, bar or psi"),
    ("hop", "experiment.toml", "827000.0", "120", "DATA/experiment.toml:5: run 1.supply_pressure_gauge_pa = 120: must be a gauge pressure ≥ 1000 Pa and ≤ 1e8 Pa, not kPa, bar or psi"),
    ("hop", "experiment.toml", "827000.0", "8.3e8", "DATA/experiment.toml:5: run 1.supply_pressure_gauge_pa = 8.3e8: must be a gauge pressure ≥ 1000 Pa and ≤ 1e8 Pa, not kPa, bar or psi"),
    ("flight", "experiment.toml", "mass_kg = 0.05", "mass_kg = -0.05", "DATA/experiment.toml:4: run 1.mass_kg = -0.05: must be a mass > 0 and ≤ 1000 kg"),
    ("stroke", "experiment.toml", "bore_m = 0.025", "bore_m = 25", "DATA/experiment.toml:4: run 1.bore_m = 25: must be a diameter > 0 and ≤ 1 m, not mm, cm or inch"),
    ("vessel", "experiment.toml", "initial_temperature_k = 298", "initial_temperature_k = 25", "DATA/experiment.toml:7: run 1.initial_temperature_k = 25: must be a temperature ≥ 100 K and ≤ 3000 K, not degC"),
    ("vessel", "experiment.toml", "ambient_pressure_pa = 1e5", "ambient_pressure_pa = 1", "DATA/experiment.toml:8: run 1.ambient_pressure_pa = 1: must be an absolute pressure ≥ 1000 Pa and ≤ 1e8 Pa, not gauge, kPa, bar or psi"),
    ("vessel", "experiment.toml", "volume_m3 = 0.016\n", "", "read, notes []"),
    ("vessel", "experiment.toml", "ambient_pressure_pa = 1e5", "ambient_pressure_pa = 1e5\ngas = \"xenon\"", "DATA/experiment.toml:9: run 1.gas = \"xenon\": must be one of \"air\", \"nitrogen\", \"oxygen\", \"argon\", \"helium\", \"hydrogen\", \"carbon dioxide\", \"co2\", \"methane\""),
    ("vessel", "experiment.toml", "ambient_pressure_pa = 1e5", "ambient_pressure_pa = 1e5\nmolar_mass_kg_mol = 0", "DATA/experiment.toml:9: run 1.molar_mass_kg_mol = 0: must be a molar mass > 0 and ≤ 1 kg/mol, not g/mol"),
    ("vessel", "experiment.toml", "ambient_pressure_pa = 1e5", "ambient_pressure_pa = 1e5\nmolar_mass_kg_mol = 28.96", "DATA/experiment.toml:9: run 1.molar_mass_kg_mol = 28.96: must be a molar mass > 0 and ≤ 1 kg/mol, not g/mol"),
    ("vessel", "experiment.toml", "ambient_pressure_pa = 1e5", "ambient_pressure_pa = 1e5\nheat_ratio = 1", "DATA/experiment.toml:9: run 1.heat_ratio = 1: must be a ratio of heat capacities > 1 and ≤ 1.67"),
    ("vessel", "experiment.toml", "ambient_pressure_pa = 1e5", "ambient_pressure_pa = 1e5\nheat_ratio = 1.7", "DATA/experiment.toml:9: run 1.heat_ratio = 1.7: must be a ratio of heat capacities > 1 and ≤ 1.67"),
    ("flight", "experiment.toml", "[[run]]", "[noise]\ny_m = 0\n[[run]]", "DATA/experiment.toml:3: noise.y_m = 0: must be a finite number > 0, in the column's unit"),
    ("flight", "experiment.toml", "[[run]]", "[noise]\ny_m = inf\n[[run]]", "DATA/experiment.toml:3: noise.y_m = inf: must be a finite number > 0, in the column's unit"),
    ("flight", "experiment.toml", "[[run]]", "[noise]\nz_m = 0.1\n[[run]]", "DATA/experiment.toml:3: unknown key noise.z_m; the nearest known key is noise.x_m"),
    ("flight", "experiment.toml", "[[run]]", "[resolution]\ny_m = -1\n[[run]]", "DATA/experiment.toml:3: resolution.y_m = -1: must be a finite number > 0, in the column's unit"),
    ("flight", "experiment.toml", "[[run]]", "noise = 3\n[[run]]", "DATA/experiment.toml:2: noise \
        = 3: must be a table"),
    ("flight", "experiment.toml", "b.csv", "a.csv", "DATA/experiment.toml:5: duplicate run: a.csv is listed twice"),
    ("flight", "experiment.toml", "b.csv", "./a.csv", "DATA/experiment.toml:5: duplicate run: a.csv is listed twice"),
    ("flight", "experiment.toml", "b.csv", "c.csv", "DATA/c.csv: is listed in experiment.toml and \
        is not there"),
    ("flight", "experiment.toml", "b.csv", "../b.csv", "DATA/experiment.toml:6: run 2.file = \"../b.csv\": must be the name of a file in this folder, without .. and not absolute"),
    ("flight", "experiment.toml", "b.csv", "/b.csv", "DATA/experiment.toml:6: run 2.file = \"/b.csv\": must be the name of a file in this folder, without .. and not absolute"),
    ("flight", "experiment.toml", "file = \"a.csv\"\n", "", "DATA/experiment.toml:2: missing key run 1.file: the name of a file in this folder, without .. and not absolute"),
    ("flight", "experiment.toml", "mass_kg = 0.05", "valid_from_s = 0.9", "DATA/a.csv: 3 rows \
        from valid_from_s to valid_to_s: a run of kind flight needs 5 at least"),
    ("flight", "experiment.toml", "mass_kg = 0.05", "valid_from_s = 0.9\nvalid_to_s = 0.2", "DATA/experiment.toml:5: run 1.valid_to_s = 0.2: must be a time from -1e14 to 1e14 s, after valid_from_s = 0.9"),
    ("outcomes", "experiment.toml", "file = \"a.csv\"\n", "file = \"a.csv\"\nvalid_from_s = 1\n", "DATA/experiment.toml:5: unknown key run 1.valid_from_s; the keys allowed there are columns, file"),
    ("bench", "a.csv", "time_s", "time_h", "DATA/a.csv:1: unknown column time_h; the nearest \
        known column is time_s"),
    ("bench", "a.csv", "pressure_pa", "presure_pa", "DATA/a.csv:1: unknown column presure_pa; the \
        nearest known column is pressure_pa"),
    ("bench", "a.csv", "valve,", ",", "DATA/a.csv:1: column 2 has no name"),
    ("bench", "a.csv", "time_s,valve,position_m,pressure_pa\n", "", "DATA/a.csv:1: 0 stands where \
        the first line must name columns of time_s,valve,position_m,pressure_pa"),
    ("bench", "a.csv", "position_m,pressure_pa", "position_m,position_m", "DATA/a.csv:1: column \
        position_m is there twice"),
    ("flight", "a.csv", "time_s,x_m,y_m", "time_s;x_m;y_m", "DATA/a.csv:1: cells are separated by \
        semicolons: must be commas, and points in numbers"),
    ("flight", "a.csv", "time_s,x_m,y_m", "time_s\tx_m\ty_m", "DATA/a.csv:1: cells are separated \
        by tabs: must be commas, and points in numbers"),
    ("outcomes", "a.csv", "apex_m", "time_s", "DATA/a.csv:1: missing column apex_m; not known are \
        time_s"),
    ("bench", "a.csv", "0.2,0,0.02,298000\n", "0.2,0,0.02\n", "DATA/a.csv:4: 3 cells where the \
        header has 4"),
    ("bench", "a.csv", "0.02,", "NaN,", "DATA/a.csv:4: position_m = NaN: must be a finite number, \
        or empty where none was measured"),
    ("bench", "a.csv", "0.02,", "-inf,", "DATA/a.csv:4: position_m = -inf: must be a finite \
        number, or empty where none was measured"),
    ("bench", "a.csv", "0.02,", "1e999,", "DATA/a.csv:4: position_m = 1e999: must be a finite \
        number, or empty where none was measured"),
    ("bench", "a.csv", "0.02,", "0.02 m,", "DATA/a.csv:4: position_m = 0.02 m: must be a finite \
        number, or empty where none was measured"),
    ("bench", "a.csv", "0.2,0,", "0.2,2,", "DATA/a.csv:4: valve = 2: must be 0 or 1"),
    ("bench", "a.csv", "0.9,0,", "0.9,1,", "DATA/a.csv:11: valve opens a second time: a run has \
        one opening"),
    ("bench", "a.csv", "0.2,0,", "0.1,0,", "DATA/a.csv:4: time_s = 0.1 is also that of the row \
        before: it must increase"),
    ("bench", "a.csv", "0.2,0,", ",0,", "DATA/a.csv:4: time_s is empty: every row must have its \
        time"),
    ("bench", "a.csv", "0.1,0,0.01,299000\n0.2,0,0.02,298000\n", "0.2,0,0.02,298000\n0.1,0,0.01,299000\n", "DATA/a.csv:4: time_s = 0.1 follows 0.2: it must increase; the rows only are shuffled: sort them by time"),
    ("bench", "a.csv", "0.6,", "0.1,", "DATA/a.csv:8: time_s = 0.1 follows 0.5: it must increase; \
        without this row or the one before it all would be in order"),
    ("bench", "a.csv", "1.1,", "1200,", "DATA/a.csv:13: time_s = 1200 is 1.20e3 s after the row before, and \
        all other rows are within 1.00e0 s: is one of the two stamps wrong?"),
    ("hop", "a.csv", "1.1,", "1200,", "DATA/a.csv:13: time_s = 1200 is 1.20e3 s after the row before, and \
        all other rows are within 1.00e0 s: is one of the two stamps wrong?"),
    ("jump", "a.csv", "1.1,", "1200,", "DATA/a.csv:13: time_s = 1200 is 1.20e3 s after the row before, and \
        all other rows are within 1.00e0 s: is one of the two stamps wrong?"),
    ("bench", "a.csv", "298000", "2.98", "DATA/a.csv:4: pressure_pa = 2.98: must be an absolute pressure ≥ 20000 Pa and ≤ 1e8 Pa, not gauge, kPa, bar or psi"),
    ("bench", "a.csv", "298000", "0", "DATA/a.csv:4: pressure_pa = 0: must be an absolute pressure ≥ 20000 Pa and ≤ 1e8 Pa, not gauge, kPa, bar or psi"),
    ("bench", "a.csv", "298000", "298", "DATA/a.csv:4: pressure_pa = 298: must be an absolute pressure ≥ 20000 Pa and ≤ 1e8 Pa, not gauge, kPa, bar or psi"),
    ("bench", "a.csv", "298000", "2e8", "DATA/a.csv:4: pressure_pa = 2e8: must be an absolute pressure ≥ 20000 Pa and ≤ 1e8 Pa, not gauge, kPa, bar or psi"),
    ("bench", "a.csv", "0.02,", "20,", "DATA/a.csv:4: position_m = 20: must be a position ≥ -10 m and ≤ 10 m, not mm, cm or inch"),
    ("hop", "a.csv", "0.02", "1.6", "DATA/a.csv:4: pivot_angle_rad = 1.6: must be an angle ≥ -pi/2 rad and ≤ pi/2 rad, not degrees"),
    ("jump", "a.csv", "0.02,", "20,", "DATA/a.csv:4: wheel_angle_rad = 20: must be an angle ≥ -4 pi rad and ≤ 4 pi rad, not degrees"),
    ("jump", "a.csv", "0.02,0.02,0.02,0.02", "0.02,0.02,0.02,115", "DATA/a.csv:4: wheel_rate_rad_s = 115: must be a rate ≥ -100 rad/s and ≤ 100 rad/s, not degrees a second"),
    ("outcomes", "a.csv", "-0.1,", "-5.7,", "DATA/a.csv:2: alpha_f_rad = -5.7: must be an angle ≥ -pi/2 rad and ≤ pi/2 rad, not degrees"),
    ("outcomes", "a.csv", ",0.1,", ",100,", "DATA/a.csv:2: valve_open_s = 100: must be a time > 0 and ≤ 10 s"),
    ("vessel", "a.csv", "297.99", "24.99", "DATA/a.csv:3: temperature_k = 24.99: must be a temperature ≥ 100 K and ≤ 3000 K, not degC"),
    ("vessel", "a.csv", "298000", "-298000", "DATA/a.csv:4: pressure_pa = -298000: must be an absolute pressure ≥ 1000 Pa and ≤ 1e8 Pa, not gauge, kPa, bar or psi"),
    ("vessel", "a.csv", "298000", "2.98", "DATA/a.csv:4: pressure_pa = 2.98: must be an absolute pressure ≥ 1000 Pa and ≤ 1e8 Pa, not gauge, kPa, bar or psi"),
];

#[test]
fn spoiled_folders_are_refused() {
    let mut wrong = Vec::new();
    for (i, &(kind, file, from, to, message)) in SPOILED.iter().enumerate() {
        let data = Folder::new(&format!("spoiled-{i}"));
        let files = good(kind).map(|(name, text)| {
            assert!(
                name != file || text.contains(from),
                "{kind} {file}: no {from:?}"
            );
            (
                name,
                if name == file {
                    text.replacen(from, to, 1)
                } else {
                    text
                },
            )
        });
        laid(&data, &files);
        let said = said(&data);
        if said != message {
            wrong.push(format!(
                "    ({kind:?}, {file:?}, {from:?}, {to:?}, {said:?}),"
            ));
        }
    }
    assert_eq!(wrong, Vec::<String>::new(), "\n{}", wrong.join("\n"));
}

/// A folder's files put together otherwise, and what is said then.
fn check(test: &str, spoil: impl FnOnce(&Folder), message: &str) {
    let data = Folder::new(&format!("spoiled-{test}"));
    spoil(&data);
    assert_eq!(said(&data), message, "{test}");
}

/// A good folder with one column of its first run made of `cell(row)`.
fn with_column(kind: &str, column: usize, cell: impl Fn(usize) -> String) -> impl FnOnce(&Folder) {
    let [toml, (name, text), b] = good(kind);
    let row = |(i, line): (usize, &str)| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if i > 0 {
            cells[column] = cell(i - 1);
        }
        cells.join(",") + "\n"
    };
    let text = text.lines().enumerate().map(row).collect();
    move |data| laid(data, &[toml, (name, text), b])
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of cases")]
fn spoiled_columns_are_refused() {
    let same = |cell: &'static str| move |_: usize| cell.to_owned();
    let some = |count: usize| {
        move |row: usize| {
            if row < count {
                row.to_string()
            } else {
                String::new()
            }
        }
    };
    let dead = "the sensor seems dead";
    let check = |kind, column, cell: &dyn Fn(usize) -> String, message: &str| {
        check(
            &format!("{kind}-{column}"),
            with_column(kind, column, cell),
            message,
        );
    };
    check(
        "bench",
        2,
        &same("0.03"),
        &format!("DATA/a.csv: position_m is 0.03 in all 12 rows: {dead}"),
    );
    check(
        "bench",
        3,
        &same("101325"),
        &format!("DATA/a.csv: pressure_pa is 101325 in all 12 rows: {dead}"),
    );
    check(
        "hop",
        2,
        &same(""),
        "DATA/a.csv: all cells are empty: nothing was measured",
    );
    check(
        "hop",
        2,
        &same("0"),
        &format!("DATA/a.csv: pivot_angle_rad is 0 in all 12 rows: {dead}"),
    );
    check(
        "jump",
        5,
        &same("5"),
        &format!("DATA/a.csv: wheel_rate_rad_s is 5 in all 12 rows: {dead}"),
    );
    check(
        "flight",
        2,
        &same("1.5"),
        &format!("DATA/a.csv: y_m is 1.5 in all 12 rows: {dead}"),
    );
    check(
        "outcomes",
        3,
        &same("0.9"),
        &format!("DATA/a.csv: distance_m is 0.9 in all 12 rows: {dead}"),
    );
    check(
        "stroke",
        3,
        &same("1"),
        &format!("DATA/a.csv: force_n is 1 in all 12 rows: {dead}"),
    );
    check(
        "slide",
        2,
        &same("0"),
        &format!("DATA/a.csv: position_m is 0 in all 12 rows: {dead}"),
    );
    check(
        "bench",
        2,
        &same(""),
        "DATA/a.csv: position_m is empty in all 12 rows",
    );
    check(
        "jump",
        3,
        &|row| {
            if row < 5 {
                format!("0.{row}")
            } else {
                String::new()
            }
        },
        "DATA/a.csv: pivot_angle_rad is empty in 7 of 12 rows: at most half may be",
    );
    check(
        "flight",
        1,
        &some(1),
        "DATA/a.csv: x_m is empty in 11 of 12 rows: at most nine tenths may be",
    );
    check(
        "hop",
        1,
        &same("0"),
        "DATA/a.csv: valve is 0 in all rows: it never opens",
    );
    check(
        "hop",
        1,
        &same(""),
        "DATA/a.csv: valve is empty in all rows",
    );
    // What is odd, or nothing.
    check(
        "hop",
        1,
        &same("1"),
        "read, notes [\"a.csv:2: valve is 1 from the start, which is taken for the command\"]",
    );
    check(
        "hop",
        1,
        &|row| ["0", "", "", "1", "1"].get(row).unwrap_or(&"0").to_string(),
        "read, notes [\"a.csv:5: valve switched at some time since line 3, where it is empty\"]",
    );
    check(
        "flight",
        1,
        &same("0"),
        "read, notes [\"a.csv: x_m is 0 in all 12 rows\"]",
    );
    check(
        "flight",
        0,
        &|row| {
            if row < 6 {
                row.to_string()
            } else {
                (row + 20).to_string()
            }
        },
        "read, notes [\"a.csv:8: 2.10e1 s after the row before, where the usual step is 1.00e0 \
         s\"]",
    );
    // Of few values, a coarse sensor may give the same.
    check(
        "outcomes",
        4,
        &|row| if row < 7 { "0.5".into() } else { String::new() },
        "read, notes [\"a.csv: apex_m is 0.5 in all 7 filled rows\"]",
    );
    check(
        "slide",
        1,
        &same("2"),
        "read, notes [\"a.csv: force_n is 2 in all 12 rows\"]",
    );
    check("outcomes", 0, &same("5.5"), "read, notes []");
    check(
        "outcomes",
        1,
        &|row| if row == 2 { String::new() } else { "0".into() },
        "read, notes [\"a.csv: 1 row left out for an empty cell, the first at line 4 for its \
         alpha_f_rad\"]",
    );
    check(
        "outcomes",
        2,
        &|row| if row < 2 { "0.1".into() } else { String::new() },
        "DATA/a.csv: 2 rows complete: a run of kind outcomes needs 3 at least",
    );
}

/// Good folders of a bench with one file made of these bytes, and what is said then.
fn check_files(cases: Vec<(&str, &str, Vec<u8>, &str)>) {
    for (test, name, bytes, message) in cases {
        let spoil = |data: &Folder| {
            laid(data, &good("bench"));
            data.write(name, bytes);
        };
        check(test, spoil, message);
    }
}

#[test]
#[rustfmt::skip] // One case a line.
fn spoiled_manifests_are_refused() {
    check_files(vec![
        ("empty-manifest", "experiment.toml", Vec::new(), "DATA/experiment.toml: missing key \
            kind: one of bench, hop, jump, flight, outcomes, stroke, slide, vessel, pendulum, run, tank-leg, walk, machine, in quotes"),
        ("no-runs", "experiment.toml", b"kind = 'flight'".to_vec(), "DATA/experiment.toml: \
            missing key run: a table [[run]] for each file"),
        ("empty-runs", "experiment.toml", b"kind = 'flight'\nrun = []".to_vec(), "DATA/experiment.toml: missing key run: a table [[run]] for each file"),
        ("run-table", "experiment.toml", b"kind = 'flight'\n[run]\nfile = 'a.csv'".to_vec(), "DATA/experiment.toml:2: run = [run]: must be a list of tables, in TOML [[run]]"),
        ("many-runs", "experiment.toml", format!("kind = 'flight'\n{}", "[[run]]\nfile = 'a.csv'\n".repeat(10_001)).into_bytes(), "DATA/experiment.toml:2: [[run]] = 10001 tables: must be at most 10000 tables; the columns of a.csv (time_s, valve, position_m, pressure_pa) are those of kind bench, and not of flight: is kind right?"),
        ("latin-1", "experiment.toml", b"kind = 'flight'\n# \xb5".to_vec(), "DATA/experiment.toml:2: not UTF-8 text"),
        ("huge-manifest", "experiment.toml", vec![b'#'; (8 << 20) + 1], "DATA/experiment.toml: \
            larger than 8 MiB, the most it may have"),
    ]);
}

#[test]
#[rustfmt::skip]
fn spoiled_runs_are_refused() {
    let header = "time_s,valve,position_m,pressure_pa\n";
    let first = |rows: usize| rows_of("bench", rows).into_bytes();
    check_files(vec![
        ("empty-run", "a.csv", Vec::new(), "DATA/a.csv: is empty"),
        ("blank-run", "a.csv", b"\n \r\n".to_vec(), "DATA/a.csv: is empty"),
        ("header-only", "a.csv", header.into(), "DATA/a.csv: has a header and no rows"),
        ("one-row", "a.csv", first(1), "DATA/a.csv: 1 row: a run of kind bench needs 10 at least"),
        ("nine-rows", "a.csv", first(9), "DATA/a.csv: 9 rows: a run of kind bench needs 10 at \
            least"),
        ("binary", "a.csv", vec![0; 1000], "DATA/a.csv:1: not UTF-8 text: a run is a CSV file \
            whose first line names the columns"),
        ("utf-16", "a.csv", header.encode_utf16().flat_map(u16::to_le_bytes).collect(), "DATA/a.csv:1: not UTF-8 text: a run is a CSV file whose first line names the columns"),
        ("one-line", "a.csv", vec![b'1'; 1 << 20], "DATA/a.csv:1: more than 65536 bytes without a \
            line break: not rows of numbers"),
        ("bad-cell", "a.csv", [header.as_bytes(), b"0,0,\xff,1\n"].concat(), "DATA/a.csv:2: \
            position_m is not UTF-8 text"),
        ("long-cell", "a.csv", format!("{header}0,0,{}\t,1\n", "9".repeat(50) + "x").into_bytes(), "DATA/a.csv:2: position_m = 9999999999999999999999999999999999999999…: must be a finite number, or empty where none was measured"),
        ("same-contents", "b.csv", rows("bench", 0).into_bytes(), "DATA/b.csv: duplicate run: its \
            contents are those of a.csv"),
        ("two-clocks", "a.csv", (rows("bench", 0) + &rows("bench", 1)[header.len()..]).into_bytes(), "DATA/a.csv:14: time_s = 0 follows 1.1: it must increase; the clock starts again: a file must be one run"),
        ("no-column", "a.csv", b"time_s,valve,pressure_pa\n0,0,0\n".to_vec(), "DATA/a.csv:1: missing column position_m"),
    ]);
}

#[test]
fn spoiled_sets_of_files_are_refused() {
    let check = |test, kind, spoil: &dyn Fn(&Folder), message| {
        let spoiled = |data: &Folder| {
            laid(data, &good(kind));
            spoil(data);
        };
        check(test, spoiled, message);
    };
    check(
        "other-columns",
        "flight",
        &|data| data.write("b.csv", "time_s,y_m\n0,1\n1,2\n2,3\n3,4\n4,5\n"),
        "DATA/b.csv:1: columns = y_m differs from x_m y_m of a.csv: only what was done alike goes \
         into one experiment",
    );
    check(
        "no-columns",
        "flight",
        &|data| data.write("a.csv", "time_s\n0\n1\n2\n3\n4\n"),
        "DATA/a.csv:1: missing column x_m or y_m",
    );
    check(
        "bars",
        "stroke",
        &|data| {
            for name in ["a.csv", "b.csv"] {
                data.write(name, data.read(name).replace("000,", ","));
            }
        },
        "DATA/: pressure_gauge_pa never exceeds 300 in any run: it must be in Pa, not kPa, bar or \
         psi",
    );
    check(
        "a-folder",
        "bench",
        &|data| {
            std::fs::remove_file(data.path("a.csv")).unwrap();
            std::fs::create_dir(data.path("a.csv")).unwrap();
        },
        "DATA/a.csv: is not a file",
    );
    let nothing = Folder::new("spoiled-nothing");
    assert_eq!(
        said(&nothing),
        "DATA/: has no experiment.toml, which says what was measured"
    );
}

/// The header and the first so many rows.
fn rows_of(kind: &str, count: usize) -> String {
    rows(kind, 0)
        .lines()
        .take(count + 1)
        .flat_map(|line| [line, "\n"])
        .collect()
}

#[test]
fn what_is_no_folder_is_refused() {
    let data = Folder::new("no-folder");
    data.write("file", "");
    let check = |name: &str, message: &str| {
        let error = read(&data.path(name), &|_| ()).unwrap_err().to_string();
        assert_eq!(
            error.replace(data.path("").to_str().unwrap(), "DATA/"),
            message
        );
    };
    check(
        "file",
        "DATA/file: is not a folder; data are a folder with experiment.toml and its runs",
    );
    check(
        "none",
        "DATA/none: cannot be read: No such file or directory (os error 2)",
    );
    assert_eq!(
        read_all(&[], &|_| ()).unwrap_err().to_string(),
        "data: no folder is given"
    );
}

#[test]
fn what_is_odd_is_noted() {
    check(
        "unlisted",
        |data| {
            laid(data, &good("flight"));
            data.write("notes.txt", "");
            for name in ["c.csv", "d.CSV", "e.csv", "f.csv", "g.csv"] {
                data.write(name, "");
            }
        },
        "read, notes [\"c.csv: not read, as experiment.toml does not list it\", \"d.CSV: not \
         read, as experiment.toml does not list it\", \"e.csv: not read, as experiment.toml does \
         not list it\", \"experiment.toml: 2 more CSV or MCAP files are not listed\"]",
    );
    check(
        "unused",
        |data| {
            laid(data, &good("vessel"));
            data.write(
                "experiment.toml",
                format!("robot = 'x'\n{}", data.read("experiment.toml"))
                    + "[noise]\ntemperature_k = 1\n",
            );
            for name in ["a.csv", "b.csv"] {
                let warm: Vec<String> = data
                    .read(name)
                    .lines()
                    .filter(|line| !line.contains(",,"))
                    .map(|line| line.rsplit_once(',').unwrap().0.to_owned())
                    .collect();
                data.write(name, warm.join("\n"));
            }
        },
        "read, notes [\"experiment.toml: robot is not used for the kind vessel\", \
         \"experiment.toml: noise.temperature_k is not used: no run has that column\"]",
    );
}
