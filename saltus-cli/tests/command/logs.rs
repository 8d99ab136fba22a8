//! Logs as people have them: docs/logs.md, columns of their own, other units, and slips.

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::Path;

use crate::common::Folder;
use saltus::Robot;
use saltus::diagnosis::Kind as _;
use saltus::diagnosis::kinds::Firings;
use saltus::experiment::{Experiment, Run, Sort, read, write};

/// The files of docs/logs.md: blocks whose first line names one.
fn files_of_the_page() -> Vec<(String, String)> {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/logs.md");
    let page = std::fs::read_to_string(page).unwrap();
    let mut files = Vec::new();
    for block in page.split("\n```").skip(1).step_by(2) {
        let (head, text) = block.split_once('\n').unwrap();
        if let Some((_, name)) = head.split_once(' ') {
            files.push((name.to_owned(), format!("{text}\n")));
        }
    }
    files
}

#[test]
fn the_examples_of_the_page_are_read_and_nothing_is_wrong() {
    let folder = Folder::new("logs-page");
    let files = files_of_the_page();
    let mut kinds: Vec<&str> = files
        .iter()
        .map(|(name, _)| name.split_once('/').unwrap().0)
        .collect();
    kinds.dedup();
    assert_eq!(
        kinds,
        [
            "bench", "hop", "jump", "outcomes", "flight", "stroke", "slide", "vessel", "pendulum",
            "tank-leg", "machine", "walk"
        ]
    );
    for kind in &kinds {
        std::fs::create_dir(folder.path(kind)).unwrap();
    }
    for (name, text) in &files {
        folder.write(name, text);
    }
    for kind in kinds {
        let data = read(&folder.path(kind), &|_| ()).unwrap();
        assert_eq!(data.experiment.kind.spec().id, kind);
        assert_eq!(data.notes, [""; 0], "{kind}");
        let robot = data
            .robot
            .as_deref()
            .map(|name| Robot::builtin(name).unwrap());
        saltus::experiment::plausible(&data, robot.as_ref()).unwrap();
        // Nothing is hidden in them.
        let run = folder.run(&["diagnose", kind]);
        assert_eq!(run.code, Some(0), "{kind}: {}{}", run.out, run.err);
    }
}

/// What `[rig]` says of a robot with a tank, and what it must not say.
#[test]
fn robots_with_a_tank_that_are_none_are_refused() {
    let folder = Folder::new("logs-tank");
    folder.done("inject --kind tank-leg --runs 2 --out data", 0);
    let manifest = folder.read("data/experiment.toml");
    let wrong = [
        ("tube_diameter_m = ", "0.0", "must be a diameter > 0"),
        ("tank_volume_m3 = ", "nan", "must be a volume > 0"),
        (
            "supply_pressure_gauge_pa = ",
            "-2e5",
            "must be a gauge pressure",
        ),
        (
            "link_mass_kg = ",
            "[0.3, 0.0, 1.0, 0.5, 0.3]",
            "item 2 = 0.0: must be a mass > 0",
        ),
        (
            "link_mass_kg = ",
            "[0.3, 0.5]",
            "has 2 numbers: must be one, or 5",
        ),
        (
            "actuators = ",
            "[\"knee_right\", \"hip_right\"]",
            "has an actuator at each joint",
        ),
        (
            "actuators = ",
            "[\"knee_right\", \"hip_right\", \"hip_left\", \"toe\"]",
            "toe must begin with knee or hip",
        ),
        ("link_names = ", "[1, 2]", "must be a list of names"),
        ("muscle_x0_coefficients_cm = ", "[-1.0]", "must be above 0"),
        (
            "muscle_slope_per_kpa_n_cm = ",
            "50",
            "the muscle would push near its end",
        ),
    ];
    for (key, value, says) in wrong {
        let line = |line: &str| {
            if line.starts_with(key) {
                format!("{key}{value}\n")
            } else {
                format!("{line}\n")
            }
        };
        let text: String = manifest.lines().map(line).collect();
        assert_ne!(text, manifest, "{key}");
        folder.write("data/experiment.toml", text);
        let run = folder.run(&["diagnose", "data"]);
        assert_eq!(run.code, Some(2), "{key}{value}: {}{}", run.out, run.err);
        let named = key.trim_end_matches(" = ");
        let has_both = run.err.contains(named) && run.err.contains(says);
        assert!(has_both, "{key}{value}: {}", run.err);
    }
}

/// Two firings on the bench with a hidden friction, in `data`.
fn bench(name: &str) -> Folder {
    let folder = Folder::new(&format!("logs-{name}"));
    folder.done("inject viscous-friction=25 --runs 2 --out data", 0);
    folder
}

/// Changes every run of `data`, cell by cell: the header's cells are row 0.
fn change(folder: &Folder, cells: impl Fn(usize, &[&str]) -> Vec<String>) {
    for name in folder
        .names_in("data")
        .into_iter()
        .filter(|name| name.starts_with("run"))
    {
        let text = folder.read(&format!("data/{name}"));
        let row = |(i, line): (usize, &str)| {
            cells(i, &line.split(',').collect::<Vec<_>>()).join(",") + "\n"
        };
        let text: String = text.lines().enumerate().map(row).collect();
        folder.write(&format!("data/{name}"), text);
    }
}

fn owned(cells: &[&str]) -> Vec<String> {
    cells.iter().map(|cell| (*cell).to_owned()).collect()
}

/// The row with one cell replaced: by `name` in the header, by `value` of the number elsewhere.
fn replaced(
    i: usize,
    cells: &[&str],
    column: usize,
    name: &str,
    value: impl Fn(f64) -> f64,
) -> Vec<String> {
    let mut cells = owned(cells);
    cells[column] = if i == 0 {
        name.into()
    } else {
        value(cells[column].parse().unwrap()).to_string()
    };
    cells
}

#[test]
fn columns_of_their_own_are_skipped_with_one_note() {
    let folder = bench("strange");
    let before = read(&folder.path("data"), &|_| ()).unwrap();
    change(&folder, |i, cells| {
        let own = if i == 0 {
            ["battery_v", "comment"]
        } else {
            ["11.7", "warm; \"ok\""]
        };
        [
            &owned(&cells[..2])[..],
            &own.map(str::to_owned),
            &owned(&cells[2..]),
        ]
        .concat()
    });
    let after = read(&folder.path("data"), &|_| ()).unwrap();
    assert_eq!(
        (after.experiment, after.hash),
        (before.experiment, before.hash)
    );
    let note = "run-01.csv: not read: battery_v, comment; the columns of a bench are time_s, \
        valve, position_m, pressure_pa; 1 more run is treated alike";
    assert_eq!(after.notes, [note]);

    let said = |from: &str, to: &str| {
        change(&folder, |i, cells| {
            owned(cells)
                .into_iter()
                .map(|cell| {
                    if i == 0 && cell == from {
                        to.into()
                    } else {
                        cell
                    }
                })
                .collect()
        });
        let error = read(&folder.path("data"), &|_| ()).unwrap_err().to_string();
        change(&folder, |i, cells| {
            owned(cells)
                .into_iter()
                .map(|cell| {
                    if i == 0 && cell == to {
                        from.into()
                    } else {
                        cell
                    }
                })
                .collect()
        });
        error.rsplit_once(".csv:1: ").unwrap().1.to_owned()
    };
    for slip in ["positon_m", "Position_m", "position", "position_furlong"] {
        assert_eq!(
            said("position_m", slip),
            format!("unknown column {slip}; the nearest known column is position_m"),
        );
    }
    assert_eq!(
        said("position_m", "pos"),
        "missing column position_m; not known are battery_v, comment, pos"
    );
    assert_eq!(
        said("pressure_pa", "pressure_gauge_pa"),
        "unknown column pressure_gauge_pa; the nearest known column is pressure_pa"
    );
    assert_eq!(
        said("battery_v", "position_mm"),
        "column position_m is there twice"
    );
}

#[test]
fn a_bench_works_without_pressure() {
    let folder = bench("no-pressure");
    let mut said = Vec::new();
    change(&folder, |i, cells| {
        if i == 0 {
            owned(cells)
        } else {
            [&owned(&cells[..3])[..], &[String::new()]].concat()
        }
    });
    said.push(folder.run(&["diagnose", "data", "--most", "1"]));
    change(&folder, |_, cells| owned(&cells[..3]));
    said.push(folder.run(&["diagnose", "data", "--most", "1"]));
    for run in said {
        assert_eq!(run.code, Some(1), "{}", run.err);
        assert!(run.out.contains("viscous-friction"), "{}", run.out);
        assert!(
            run.out.contains("pressure_pa is") || run.out.contains("noise.pressure_pa is not used"),
            "{}",
            run.out
        );
    }
}

/// A jump of a robot without a boom, as the model has it: lean, rate, travel and height, whether
/// travel counts from the foot or the axle.
#[test]
fn a_jump_works_without_a_boom() {
    let folder = Folder::new("logs-no-boom");
    let robot = Robot::rats_planar();
    let columns = ["wheel_angle_rad", "wheel_rate_rad_s", "x_m", "y_m"];
    let run = Run {
        name: "run.csv".into(),
        settings: [("supply_pressure_gauge_pa".to_owned(), 8e5)].into(),
        valve: Some((0.05, Some(0.13))),
        time: (0..200).map(|row| f64::from(row) * 2e-3).collect(),
        values: [-0.2, 4.0, -0.05, 0.24]
            .map(|first| vec![first; 200])
            .into(),
    };
    let mut experiment = Experiment {
        kind: Sort::Jump,
        mechanism: None,
        columns: columns.map(str::to_owned).into(),
        noise: [1e-3, 0.02, 1e-3, 1e-3].map(Some).into(),
        resolution: vec![None; 4],
        runs: vec![run],
    };
    let model = Firings::new(&experiment, &robot).unwrap();
    let exact = model
        .predict(
            0,
            &saltus::diagnosis::Terms::off(model.causes()),
            &[-0.2, 4.0],
        )
        .unwrap();
    let start = exact[2];
    for (i, (reading, value)) in model.logs()[0].readings.iter().zip(exact).enumerate() {
        let sigma = [1e-3, 0.02, 1e-3, 1e-3][reading.channel];
        // A low-discrepancy sequence stands for noise.
        let chance = (0.618_034 * i as f64).fract() - 0.5;
        experiment.runs[0].values[reading.channel][i / 4] = value + 3.0 * sigma * chance;
    }
    for (name, from) in [("foot", 0.0), ("axle", start)] {
        experiment.runs[0].values[2]
            .iter_mut()
            .for_each(|x| *x -= from);
        write(&folder.path(name), &experiment, Some("rats-planar")).unwrap();
        let run = folder.run(&["diagnose", name, "--most", "1"]);
        assert_eq!(run.code, Some(0), "{name}: {}{}", run.out, run.err);
    }
}

#[test]
#[expect(clippy::too_many_lines, reason = "one experiment")]
fn units_are_those_of_the_names() {
    let folder = bench("units");
    // Numbers of few digits, which other units have too.
    let digits = |text: &str, places: usize| format!("{:.places$}", text.parse::<f64>().unwrap());
    change(&folder, |i, cells| match i {
        0 => owned(cells),
        _ => vec![
            digits(cells[0], 3),
            cells[1].into(),
            digits(cells[2], 5),
            digits(cells[3], 0),
        ],
    });
    let toml = folder.read("data/experiment.toml");
    let number = |key: &str| -> Vec<f64> {
        toml.lines()
            .filter_map(|line| line.strip_prefix(key)?.strip_prefix(" = ")?.parse().ok())
            .collect()
    };
    let [loads, supplies] = ["load_mass_kg", "supply_pressure_gauge_pa"].map(number);
    let manifest =
        |load: &str, supply: &str, noise: &str, loads: &[String], supplies: &[String]| {
            let mut text = format!("kind = \"bench\"\nrobot = \"rats-planar\"\n[noise]\n{noise}\n");
            for k in 0..2 {
                let (mass, pressure) = (&loads[k], &supplies[k]);
                writeln!(
                    text,
                    "[[run]]\nfile = \"run-0{}.csv\"\n{load} = {mass}\n{supply} = {pressure}",
                    k + 1
                )
                .unwrap();
            }
            text
        };
    let say = |values: &[f64], factor: f64, places: usize| -> Vec<String> {
        values
            .iter()
            .map(|value| format!("{:.places$}", value * factor))
            .collect()
    };
    let psi = 1.0 / 6_894.757_293_168;
    let si = manifest(
        "load_mass_kg",
        "supply_pressure_gauge_psi",
        "position_m = 0.0001",
        &say(&loads, 1.0, 3),
        &say(&supplies, psi, 0),
    );
    folder.write("data/experiment.toml", si);
    let expected = read(&folder.path("data"), &|_| ()).unwrap();
    let supply = expected.experiment.runs[0].settings["supply_pressure_gauge_pa"];
    assert!((supply - supplies[0]).abs() < 1e-3, "{supply}");

    let other = manifest(
        "load_mass_g",
        "supply_pressure_gauge_psi",
        "position_mm = 0.1",
        &say(&loads, 1e3, 0),
        &say(&supplies, psi, 0),
    );
    folder.write("data/experiment.toml", other);
    change(&folder, |i, cells| {
        if i == 0 {
            return ["time_ms", "valve", "position_mm", "pressure_kpa"]
                .map(str::to_owned)
                .into();
        }
        let shifted = |k: usize, factor: f64, places: usize| {
            format!("{:.places$}", cells[k].parse::<f64>().unwrap() * factor)
        };
        vec![
            shifted(0, 1e3, 0),
            cells[1].into(),
            shifted(2, 1e3, 2),
            shifted(3, 1e-3, 3),
        ]
    });
    let found = read(&folder.path("data"), &|_| ()).unwrap();
    assert_eq!(
        (found.experiment, found.hash),
        (expected.experiment, expected.hash)
    );
    let twice = folder
        .read("data/experiment.toml")
        .replace("load_mass_g", "load_mass_kg = 2\nload_mass_g");
    folder.write("data/experiment.toml", twice);
    let error = read(&folder.path("data"), &|_| ()).unwrap_err().to_string();
    assert!(
        error.ends_with(
            "run 1.load_mass_g is already given as run 1.load_mass_kg; give one of them"
        ),
        "{error}"
    );
}

/// A jump that is logged long before the touch-down cannot be simulated from its first row: what to
/// do is said.
#[test]
fn a_jump_that_starts_too_early_is_told_where_to_start() {
    let folder = Folder::new("logs-early");
    folder.done("inject --kind jump --runs 3 --out data", 0);
    let text = folder.read("data/run-01.csv");
    let (header, rows) = text.split_once('\n').unwrap();
    let mut early = format!("{header}\n");
    for k in 0..3000 {
        let time = f64::from(k) * 1e-3 - 3.0;
        let lean = -0.42 + 0.1 * (3.0 * time).sin();
        writeln!(
            early,
            "{time:.3},0,{lean:.4},0,{:.4},{:.3}",
            0.1 * lean,
            0.3 * (3.0 * time).cos()
        )
        .unwrap();
    }
    folder.write("data/run-01.csv", early + rows);
    let run = folder.run(&["diagnose", "data"]);
    assert_eq!(run.code, Some(2), "{}", run.out);
    let said = [
        "run-01.csv: the model has no such motion from the first valid row",
        "set valid_from_s",
    ];
    assert!(
        said.iter().all(|words| run.err.contains(words)),
        "{}",
        run.err
    );
    let toml = folder.read("data/experiment.toml");
    folder.write(
        "data/experiment.toml",
        toml.replacen("[[run]]", "[[run]]\nvalid_from_s = 0", 1),
    );
    assert_eq!(folder.run(&["diagnose", "data"]).code, Some(0));
}

/// What both commands say of the bench with one column changed.
#[track_caller]
fn refused(folder: &Folder, commands: &[&str], words: &[&str]) {
    for command in commands {
        let run = folder.run(&[command, "data"]);
        assert_eq!(run.code, Some(2), "{command}: {}", run.out);
        assert!(
            words.iter().all(|word| run.err.contains(word)),
            "{command}: {}",
            run.err
        );
    }
}

#[test]
fn slips_of_unit_on_the_bench_are_named() {
    let folder = bench("slips");
    let both = ["diagnose", "fit"];
    let mut before = 1.0;
    for (factor, unit) in [
        (100.0, "is it in cm, or in inch?"),
        (1.0 / 0.0254, "is it in inch, or in cm?"),
        (11.4, "times the stroke"),
        (-1.0, "sign turned"),
    ] {
        change(&folder, |i, cells| {
            replaced(i, cells, 2, "position_m", |x| x * factor / before)
        });
        refused(&folder, &both, &["position_m", unit]);
        before = factor;
    }
    change(&folder, |i, cells| {
        replaced(i, cells, 2, "position_m", |x| x / before)
    });
    let toml = folder.read("data/experiment.toml");
    for (key, factor, unit) in [
        ("load_mass_kg", 400.0, "is it in g?"),
        ("supply_pressure_gauge_pa", 0.01, "is it in mbar?"),
    ] {
        let text: String = toml
            .lines()
            .map(|line| match line.split_once(" = ") {
                Some((k, value)) if k == key => {
                    format!("{key} = {}\n", value.parse::<f64>().unwrap() * factor)
                }
                _ => format!("{line}\n"),
            })
            .collect();
        folder.write("data/experiment.toml", text);
        refused(&folder, &both, &[key, unit]);
    }
    // And right data are read, whatever the leg does.
    folder.write("data/experiment.toml", toml);
    assert_eq!(
        folder.run(&["diagnose", "data", "--most", "1"]).code,
        Some(1)
    );
}

#[test]
fn slips_of_unit_elsewhere_are_named() {
    let check = |kind: &str, column: &str, factor: f64, unit: &str| {
        let folder = Folder::new(&format!("logs-slip-{kind}-{}", column.replace('/', "")));
        folder.done(&format!("inject --kind {kind} --runs 3 --out data"), 0);
        let place = |text: &str| text.split(',').position(|name| name == column).unwrap();
        let k = place(folder.read("data/run-01.csv").lines().next().unwrap());
        change(&folder, |i, cells| {
            replaced(i, cells, k, column, |x| x * factor)
        });
        refused(&folder, &["diagnose"], &[column, unit]);
    };
    check("flight", "y_m", 1e3, "is it in mm?");
    check("flight", "y_m", 1.0 / 0.3048, "is it in ft?");
    check("flight", "y_m", -1.0, "sign turned");
    check(
        "stroke",
        "force_n",
        1e-3,
        "is it in kN, or in N, and bore_m in inch?",
    );
    check("stroke", "force_n", 1.0 / 4.448, "is it in lbf, or in");
    check("stroke", "force_n", -1.0, "sign turned");
    check("vessel", "pressure_pa", 0.01, "absolute pressure ≥ 1000 Pa");
    check("outcomes", "omega_rad_s", 9.549, "is it in rpm?");
    check("outcomes", "apex_m", 39.37, "is it in inch?");
    check("outcomes", "distance_m", 100.0, "or in cm?");
    check("outcomes", "distance_m", 1e3, "not mm, cm or inch");
    check("flight", "x_m", 100.0, "is it in inch, or in cm?");
    check("stroke", "position_m", 100.0, "or in cm?");
    check("slide", "position_m", 1e3, "not mm, cm or inch");
    check("tank-leg", "com_y_m", 100.0, "not mm, cm or inch");
    check("tank-leg", "com_y_m", 39.37, "is it in inch?");
    check("pendulum", "angle_rad", 180.0 / PI, "not degrees");
    check("jump", "wheel_rate_rad_s", 9.549, "is it in rpm?");
    check("jump", "wheel_rate_rad_s", -1.0, "sign turned");
}

const OWN: &str = "experiment.toml";

/// Kind, file, key of a setting, what it is multiplied by, and what is asked then.
#[rustfmt::skip]
const SETTINGS: &[(&str, &str, &str, f64, &str)] = &[
    ("stroke", OWN, "bore_m", 1e3, "not mm, cm or inch"),
    ("stroke", OWN, "bore_m", 39.37, "is it in N, and bore_m in inch"),
    ("vessel", OWN, "volume_m3", 1e3, "is it in l?"),
    ("vessel", OWN, "orifice_diameter_m", 100.0, "orifice_diameter_m in cm?"),
    ("vessel", OWN, "wall_area_m2", 1e4, "is it in cm2?"),
    ("pendulum", OWN, "centre_from_axle_m", 1e3, "is it in mm?"),
    ("pendulum", OWN, "centre_from_axle_m", 39.37, "is it in inch?"),
    ("pendulum", OWN, "inertia_about_centre_kg_m2", 1e6, "the inertia at which"),
    ("walk", OWN, "leg_length_m", 1e3, "not mm, cm or inch"),
    ("walk", OWN, "inner_centre_from_hip_m", 39.37, "must be within the leg"),
    ("tank-leg", OWN, "link_length_m", 1e3, "not mm, cm or inch"),
    ("tank-leg", OWN, "tube_diameter_m", 1e3, "not mm, cm or inch"),
    ("tank-leg", OWN, "knee_pulley_radius_m", 100.0, "not mm, cm or inch"),
    ("tank-leg", OWN, "tank_volume_m3", 1e3, "not l, cm3"),
    ("machine", "chain.toml", "at_m", 1e3, "lengths of links in mm?"),
    ("machine", "chain.toml", "centre_m", 1e3, "lengths of links in mm?"),
];

/// Numbers of the machine that come in a smaller unit, where no robot tells how large they can be.
#[test]
fn slips_of_unit_in_settings_are_named() {
    let check = |kind: &str, file: &str, key: &str, factor: f64, words: &str| {
        let folder = Folder::new(&format!("logs-setting-{kind}-{key}-{factor:.0}"));
        folder.done(&format!("inject --kind {kind} --runs 3 --out data"), 0);
        let larger = |number: &str| {
            let number = number.trim();
            number
                .parse::<f64>()
                .map_or_else(|_| number.into(), |x| (x * factor).to_string())
        };
        let line = |line: &str| match line.split_once(" = ") {
            Some((own, list)) if own == key && list.starts_with('[') => {
                let numbers = list.trim_matches(['[', ']']).split(',');
                format!(
                    "{key} = [{}]\n",
                    numbers.map(larger).collect::<Vec<_>>().join(", ")
                )
            }
            Some((own, number)) if own == key => format!("{key} = {}\n", larger(number)),
            _ => format!("{line}\n"),
        };
        let path = format!("data/{file}");
        let text: String = folder.read(&path).lines().map(line).collect();
        assert_ne!(text, folder.read(&path), "{key}");
        folder.write(&path, text);
        refused(&folder, &["diagnose"], &[words]);
    };
    for (kind, file, key, factor, words) in SETTINGS {
        check(kind, file, key, *factor, words);
    }
}

/// What real effects and instruments do is not taken for a slip: every kind with and without
/// effects, and measured drops.
#[test]
fn right_data_are_not_refused() {
    let sets = [
        ("bench", "valve-discharge=0.95"),
        ("bench", "encoder-scale=position_m:1.3"),
        ("bench", "supply-pressure=supply_pressure_factor:0.4"),
        ("hop", "gravity=4"),
        ("hop", "coulomb-friction=40"),
        ("jump", "encoder-scale=wheel_rate_rad_s:0.7"),
        ("outcomes", "gravity=5"),
        ("flight", "gravity=4.5"),
        ("flight", "air-drag=0.3"),
        ("stroke", "seal-friction=3e-5"),
        ("slide", "viscous-friction=5"),
        ("slide", "return-spring=2000,0"),
        ("pendulum", "coulomb-friction=0.01"),
        ("machine", "encoder-scale=shoulder_rad:1.3"),
        ("tank-leg", "tube=1e-4,0.5"),
        ("walk", "counterweight=1.5,3"),
        ("vessel", "gas-type=1"),
    ];
    let judge = |path: &Path| {
        let data = read(path, &|_| ()).unwrap();
        let robot = data
            .robot
            .as_deref()
            .map(|name| Robot::builtin(name).unwrap());
        saltus::experiment::plausible(&data, robot.as_ref()).unwrap();
    };
    for (i, (kind, effect)) in sets.into_iter().enumerate() {
        let folder = Folder::new(&format!("logs-right-{i}"));
        folder.done(
            &format!("inject {effect} --kind {kind} --runs 3 --out data"),
            0,
        );
        judge(&folder.path("data"));
    }
    // A ball thrown 40 m far.
    let folder = Folder::new("logs-right-throw");
    std::fs::create_dir(folder.path("data")).unwrap();
    let manifest =
        "kind = \"flight\"\n[[run]]\nfile = \"a.csv\"\nmass_kg = 0.145\ndiameter_m = 0.073\n";
    folder.write("data/experiment.toml", manifest);
    let mut rows = String::from("time_s,x_m,y_m\n");
    for k in 0..60 {
        let t = 0.05 * f64::from(k);
        let _ = writeln!(rows, "{t},{},{}", 13.8 * t, 1.5 + 14.4 * t - 4.9 * t * t);
    }
    folder.write("data/a.csv", rows);
    judge(&folder.path("data"));
    let drops = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/reference/ball-drops");
    for entry in std::fs::read_dir(drops)
        .unwrap()
        .map(Result::unwrap)
        .filter(|entry| entry.path().is_dir())
    {
        judge(&entry.path());
    }
}

/// A stamp that leaves all others behind is refused with its row; lines with # are no rows.
#[test]
fn a_lost_stamp_is_refused_and_comments_are_skipped() {
    let folder = Folder::new("logs-stamp");
    std::fs::create_dir(folder.path("d")).unwrap();
    folder.write(
        "d/experiment.toml",
        "kind = \"pendulum\"\n[noise]\nangle_rad = 1e-3\n[rig]\nmass_kg = 0.5\n\
         centre_from_axle_m = 0.1\ninertia_about_centre_kg_m2 = 1e-3\n[[run]]\nfile = \"a.csv\"\n",
    );
    let rows = |stamp: &str| {
        let mut text = format!("# a comment\ntime_s,angle_rad\n0,0.1\n{stamp},0.1\n");
        for k in 0..100 {
            let time = f64::from(k) * 0.01;
            let _ = writeln!(text, "{},{}", 1.7e9 + 0.5 + time, 0.1 * (10.0 * time).cos());
        }
        text
    };
    folder.write("d/a.csv", rows("1700000000.25"));
    let run = folder.run(&["diagnose", "d"]);
    assert_eq!(run.code, Some(2), "{}", run.out);
    assert!(
        run.err.contains("a.csv:4: time_s = 1700000000.25") && run.err.contains("stamps wrong"),
        "{}",
        run.err
    );
    folder.done("inject --kind pendulum --out e", 0);
    let name = folder
        .names_in("e")
        .into_iter()
        .find(|name| name.starts_with("run"))
        .unwrap();
    let text = folder.read(&format!("e/{name}"));
    folder.write(&format!("e/{name}"), format!("# by hand\n{text}"));
    let told = folder.done("diagnose e", 0);
    let note = told.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        note.contains("1 line left out that begins with #"),
        "{note}"
    );
}

/// The gas of a vessel is named or described, and one that is far from perfect is noted.
#[test]
fn a_vessel_has_the_gas_that_it_is_said_to_have() {
    let folder = Folder::new("logs-gas");
    folder.done("inject --kind vessel --runs 3 --out data", 0);
    let manifest = folder.read("data/experiment.toml");
    let said = |gas: &str| {
        let text = manifest.replace("[[run]]\n", &format!("[[run]]\n{gas}\n"));
        folder.write("data/experiment.toml", text);
        let run = folder.run(&["diagnose", "data", "--most", "1"]);
        (
            run.code,
            format!("{}{}", run.out, run.err)
                .split_whitespace()
                .collect::<Vec<_>>()
                .join(" "),
        )
    };
    assert_eq!(said("gas = \"air\"").0, Some(0));
    assert_eq!(
        said("molar_mass_g_mol = 28.965\nheat_ratio = 1.4").0,
        Some(0)
    );
    // It is air, in truth.
    let (code, text) = said("gas = \"carbon dioxide\"");
    assert_eq!(code, Some(1), "{text}");
    assert!(
        text.contains("Found: gas-type") && text.contains("air_share"),
        "{text}"
    );
    assert!(
        text.contains("compressibility factor p V/(n R T) is 0.9"),
        "{text}"
    );
    let (code, text) = said("gas = \"argon\"\nheat_ratio = 1.4");
    assert_eq!(code, Some(2), "{text}");
    assert!(
        text.contains("gas and heat_ratio: a vessel's gas is"),
        "{text}"
    );
}
