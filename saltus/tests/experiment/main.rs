//! Data folders: good ones give what is in them, spoiled ones a message that names the place.

#![allow(clippy::unwrap_used)]

mod damage;
mod folder;
mod machine;
#[cfg(feature = "telemetry")]
mod mcap;
mod rig;
mod spoiled;
mod written;

use std::cell::Cell;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use folder::Folder;
use saltus::experiment::{Sort, read, read_all};

const KINDS: [&str; 8] = [
    "bench", "hop", "jump", "flight", "outcomes", "stroke", "slide", "vessel",
];

/// A small good folder of each kind: `experiment.toml`, and the runs `a.csv` and `b.csv`.
fn good(kind: &str) -> [(&'static str, String); 3] {
    let settings = match kind {
        "bench" => "load_mass_kg = 2.5\nsupply_pressure_gauge_pa = 827000\n",
        "hop" | "jump" => "supply_pressure_gauge_pa = 827000.0\n",
        "flight" => "mass_kg = 0.05\n",
        "stroke" => "bore_m = 0.025\n",
        "slide" => "mass_kg = 1_000e-3\n",
        "vessel" => {
            "volume_m3 = 0.016\norifice_diameter_m = 0.0027\ninitial_pressure_pa = 7.9e5\n\
             initial_temperature_k = 298\nambient_pressure_pa = 1e5\n"
        }
        _ => "",
    };
    let robot = if ["bench", "hop", "jump", "outcomes"].contains(&kind) {
        "robot = \"rats-boom\"\n"
    } else {
        ""
    };
    let toml = format!(
        "kind = \"{kind}\"\n{robot}[[run]]\nfile = \"a.csv\"\n{settings}[[run]]\nfile = \
         \"b.csv\"\n{settings}"
    );
    [
        ("experiment.toml", toml),
        ("a.csv", rows(kind, 0)),
        ("b.csv", rows(kind, 1)),
    ]
}

/// Twelve rows, which differ from run to run; the valve is 1 in the fourth to the eighth.
fn rows(kind: &str, run: u32) -> String {
    let header = match kind {
        "bench" => "time_s,valve,position_m,pressure_pa",
        "hop" => "time_s,valve,pivot_angle_rad",
        "jump" => "time_s,valve,wheel_angle_rad,pivot_angle_rad,radius_angle_rad,wheel_rate_rad_s",
        "flight" => "time_s,x_m,y_m",
        "outcomes" => "omega_rad_s,alpha_f_rad,valve_open_s,distance_m,apex_m",
        "stroke" => "time_s,position_m,pressure_gauge_pa,force_n",
        "slide" => "time_s,force_n,position_m",
        _ => "time_s,pressure_pa,temperature_k",
    };
    let mut text = format!("{header}\n");
    for i in 0..12 {
        let (time, valve) = (f64::from(i) / 10.0, u8::from((3..8).contains(&i)));
        let x = f64::from(i + 12 * run) / 100.0;
        let pressure = 300_000 - 1000 * (i + 12 * run);
        let cells = match kind {
            "bench" => format!("{time},{valve},{x},{pressure}"),
            "hop" => format!("{time},{valve},{x}"),
            "jump" => format!("{time},{valve},{x},{x},{x},{x}"),
            "flight" | "slide" => format!("{time},{x},{x}"),
            "outcomes" => format!("5,-0.1,0.1,{x},{x}"),
            "stroke" => format!("{time},{x},{pressure},{x}"),
            _ if i % 2 == 0 => format!("{time},{pressure},"),
            _ => format!("{time},,{}", 298.0 - x),
        };
        let _ = writeln!(text, "{cells}");
    }
    text
}

fn laid(folder: &Folder, files: &[(&'static str, String)]) {
    for (name, text) in files {
        folder.write(name, text);
    }
}

/// What reading the folder says, with the folder's path as `DATA`.
fn said(folder: &Folder) -> String {
    match read(&folder.path(""), &|_| ()) {
        Ok(folder) => format!("read, notes {:?}", folder.notes),
        Err(error) => error
            .to_string()
            .replace(folder.path("").to_str().unwrap(), "DATA/"),
    }
}

#[cfg(not(feature = "telemetry"))]
#[test]
fn an_mcap_file_is_refused_without_the_feature_that_reads_it() {
    let folder = Folder::new("without-mcap");
    folder.write("a.mcap", "\u{89}MCAP0\r\n");
    folder.write(
        "experiment.toml",
        "kind = \"slide\"\n[[run]]\nfile = \"a.mcap\"\n",
    );
    let error = read(&folder.path("."), &|_| ()).unwrap_err().to_string();
    assert!(
        error.contains("a.mcap") && error.contains("feature telemetry"),
        "{error}"
    );
}

#[test]
fn good_folders_are_read() {
    for kind in KINDS {
        let data = Folder::new(&format!("good-{kind}"));
        laid(&data, &good(kind));
        let seen = Cell::new(0);
        let folder = read(&data.path(""), &|rows| seen.set(seen.get() + rows)).unwrap();
        assert_eq!(folder.notes, Vec::<String>::new(), "{kind}");
        assert_eq!((folder.rows, seen.get()), (24, 24));
        let experiment = &folder.experiment;
        assert_eq!(format!("{:?}", experiment.kind).to_lowercase(), kind);
        assert_eq!(experiment.runs.len(), 2);
        for run in &experiment.runs {
            assert_eq!(run.time.len(), 12);
            assert_eq!(run.values.len(), experiment.columns.len());
            let opened = ["bench", "hop", "jump"].contains(&kind);
            assert_eq!(run.valve, opened.then_some((0.3, Some(0.8))), "{kind}");
        }
        let last = experiment.runs[0].time[11];
        assert_eq!(last, if kind == "outcomes" { 11.0 } else { 1.1 });
    }
}

#[test]
fn what_is_read_is_what_is_there() {
    let data = Folder::new("contents");
    data.write(
        "experiment.toml",
        "kind = 'flight'\n[noise]\ny_m = 1e-3\nx_m = 2e-3\n[resolution]\ny_m = \
         5e-4\n[[run]]\nfile = './a.csv'\nmass_kg = 2\n",
    );
    // Windows' line ends, a byte order mark, quotes, blanks, blank lines, and columns in another
    // order.
    data.write(
        "a.csv",
        "\u{feff}\"time_s\",y_m , x_m\r\n0,1.5,0\r\n\r\n\"0.1\", 1.4 \
         ,0.1\r\n.2,1.2,\r\n3e-1,+0.9,0.3\r\n0.4,0.5,0.4",
    );
    let folder = read(&data.path(""), &|_| ()).unwrap();
    let experiment = folder.experiment;
    assert_eq!(experiment.columns, ["x_m", "y_m"]);
    assert_eq!(experiment.noise, [Some(2e-3), Some(1e-3)]);
    assert_eq!(experiment.resolution, [None, Some(5e-4)]);
    let run = &experiment.runs[0];
    assert_eq!(
        (run.name.as_str(), run.settings["mass_kg"], run.valve),
        ("a.csv", 2.0, None)
    );
    assert_eq!(run.time, [0.0, 0.1, 0.2, 0.3, 0.4]);
    assert_eq!(run.values[1], [1.5, 1.4, 1.2, 0.9, 0.5]);
    assert_eq!(run.values[0][3], 0.3);
    assert!(run.values[0][2].is_nan());
}

#[test]
fn only_the_valid_part_is_kept() {
    let data = Folder::new("valid");
    let [(toml, text), (name, run), _] = good("flight");
    data.write(
        toml,
        text.split("[[run]]\nfile = \"b").next().unwrap().to_owned()
            + "valid_from_s = 0.2\nvalid_to_s = 0.9\n",
    );
    // Nobody looks at the rest.
    data.write(name, run.replace("1.1,0.11", "1.1,broken"));
    let folder = read(&data.path(""), &|_| ()).unwrap();
    let run = &folder.experiment.runs[0];
    // Times count from the first row.
    assert_eq!(run.time, [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]);
    assert_eq!(
        (run.values[0][0], folder.rows, run.settings.len()),
        (0.02, 12, 1)
    );

    let data = Folder::new("valid-valve");
    let [(toml, text), (name, run), _] = good("hop");
    let text =
        text.split("[[run]]\nfile = \"b").next().unwrap().to_owned() + "valid_from_s = 0.4\n";
    data.write(toml, text);
    data.write(name, run + "1.2,0,0.12\n1.3,0,0.13\n");
    let folder = read(&data.path(""), &|_| ()).unwrap();
    let run = &folder.experiment.runs[0];
    assert_eq!((run.valve, run.time[0]), (Some((-0.1, Some(0.4))), 0.0));
}

#[test]
fn folders_are_joined() {
    let (data, both) = (Folder::new("joined"), |names: [&str; 2], data: &Folder| {
        read_all(&names.map(|name| data.path(name)), &|_| ())
    });
    for (i, name) in ["one", "two", "three", "other", "copy"].iter().enumerate() {
        std::fs::create_dir(data.path(name)).unwrap();
        let kind = if *name == "other" { "hop" } else { "bench" };
        let [(_, toml), ..] = good(kind);
        let toml = if *name == "three" {
            toml.replace("rats-boom", "robot.toml")
        } else {
            toml
        };
        let noise = if *name == "two" {
            "[noise]\nposition_m = 1e-3\n"
        } else {
            ""
        };
        let run = if *name == "copy" {
            0
        } else {
            u32::try_from(2 * i).unwrap()
        };
        data.write(&format!("{name}/experiment.toml"), toml + noise);
        data.write(&format!("{name}/a.csv"), rows(kind, run));
        data.write(&format!("{name}/b.csv"), rows(kind, run + 1));
    }
    let joined = both(["one", "two"], &data).unwrap();
    let names: Vec<&str> = joined
        .experiment
        .runs
        .iter()
        .map(|run| run.name.as_str())
        .collect();
    assert_eq!(names, ["one/a.csv", "one/b.csv", "two/a.csv", "two/b.csv"]);
    assert_eq!((joined.rows, joined.experiment.noise[0]), (48, Some(1e-3)));
    assert_eq!(joined.notes.len(), 1);
    let single = read_all(&[data.path("one")], &|_| ()).unwrap();
    assert_eq!(single, read(&data.path("one"), &|_| ()).unwrap());
    assert!(single.hash != joined.hash && joined.hash.len() == 16);

    let check = |names, message: &str| {
        let error = both(names, &data).unwrap_err().to_string();
        assert_eq!(
            error.replace(data.path("").to_str().unwrap(), "DATA/"),
            message
        );
    };
    let alike = "only what was done alike goes into one experiment";
    check(
        ["one", "other"],
        &format!("DATA/other: kind = hop differs from bench of DATA/one: {alike}"),
    );
    check(
        ["one", "three"],
        &format!("DATA/three: robot = robot.toml differs from rats-boom of DATA/one: {alike}"),
    );
    check(
        ["one", "one"],
        "DATA/one: duplicate run: the folder is given twice",
    );
    check(
        ["one", "copy"],
        "DATA/copy: duplicate run: copy/a.csv has the same contents as one/a.csv",
    );
}

/// A million rows in a second or two, unoptimised.
#[test]
fn long_runs_are_thinned() {
    const ROWS: usize = 1_000_000;
    let data = Folder::new("long");
    let [(toml, text), ..] = good("bench");
    data.write(toml, text.split("[[run]]\nfile = \"b").next().unwrap());
    let mut run = String::from("time_s,valve,position_m,pressure_pa\n");
    for i in 0..ROWS {
        let valve = u8::from((123_457..200_001).contains(&i));
        let _ = writeln!(
            run,
            "{},{valve},{},{}",
            i as f64 / 1e4,
            i as f64 / 1e6,
            101_325 + i
        );
    }
    data.write("a.csv", run);
    let folder = read(&data.path(""), &|_| ()).unwrap();
    let run = &folder.experiment.runs[0];
    // The valve's times are none of those that are kept.
    assert_eq!(run.valve, Some((12.3457, Some(20.0001))));
    assert_eq!(
        (folder.rows, run.time.len(), run.time[1]),
        (ROWS, 3907, 0.0256)
    );
    assert!(
        run.time
            .iter()
            .zip(&run.values[0])
            .all(|(time, value)| (time - 100.0 * value).abs() < 1e-9)
    );
    let note = "a.csv: thinned to one row in 256, 3907 of 1000000; valid_from_s and valid_to_s \
        keep a part in full";
    assert_eq!(folder.notes, [note]);
}

#[test]
fn measured_drops_are_read() {
    let drops = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/reference/ball-drops");
    let balls = [
        "baseball",
        "bowling-ball",
        "green-basketball",
        "orange-whiffle-ball",
        "tennis-ball",
        "whiffle-ball-1",
    ];
    let folders: Vec<PathBuf> = balls.iter().map(|ball| drops.join(ball)).collect();
    let folder = read_all(&folders, &|_| ()).unwrap();
    assert_eq!(folder.notes, Vec::<String>::new());
    assert_eq!((folder.experiment.runs.len(), folder.rows), (12, 569));
    assert_eq!((folder.experiment.kind, folder.robot), (Sort::Flight, None));
    assert_eq!(folder.experiment.noise, [Some(0.04)]);
    // What identifies the data is the same everywhere.
    assert_eq!(
        read(&drops.join("tennis-ball"), &|_| ()).unwrap().hash,
        "3b63fb012537ada3"
    );
}
