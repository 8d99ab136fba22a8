//! Bad input: each ends with exit code 2 and a message that names what is wrong and what is
//! allowed, and leaves no file.

use crate::common::Folder;

const HEADER: &str = "omega0_rad_s,phi0_rad,alpha_f_rad,valve_open_s";

fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    folder.write("empty.csv", "");
    folder.write("header.csv", format!("{HEADER}\n"));
    folder.write("columns.csv", "a,b,c\n1,2,3\n");
    folder.write("nan.csv", format!("{HEADER}\n5,0,0,0.1\n5,0,NaN,0.1\n"));
    folder.write("inf.csv", format!("{HEADER}\ninf,0,0,0.1\n"));
    folder.write("negative.csv", format!("{HEADER}\n5,0,0,-0.1\n"));
    folder.write("word.csv", format!("{HEADER}\n5,0,forward,0.1\n"));
    folder.write("ragged.csv", format!("{HEADER}\n5,0,0\n"));
    folder.write("twice.csv", format!("{HEADER},phi0_rad\n5,0,0,0.1,0\n"));
    folder.write(
        "binary.csv",
        [HEADER.as_bytes(), b"\n5,0,\xff\xfe,0.1\n"].concat(),
    );
    folder.write("robot.toml", "name = \"x\"\n");
    folder.write("broken.toml", "name = = 3\n");
    folder.write(
        "course.toml",
        "approach_rate_rad_s = 5\ntarget_x_m = 1\nlength_m = 3\n",
    );
    folder.write("rate.toml", "approach_rate_rad_s = -5\ntarget_x_m = 1\n");
    folder.write(
        "narrow.toml",
        "approach_rate_rad_s = 5\ntarget_x_m = 1\n[[obstacle]]\nfront_x_m = 1\nwidth_m = \
         0\nheight_m = 1\n",
    );
    folder.write(
        "course2.toml",
        "approach_rate_rad_s = 5\ntarget_x_m = 0.9\n",
    );
    let made = "landing_height_m,start_lean_rad,valve_open_s";
    folder.write(
        "falling.csv",
        format!("omega_rad_s,alpha_f_rad,{made}\n5,0,0,0,0.1\n4,0,0,0,0.1\n"),
    );
    folder.write(
        "two.csv",
        format!(
            "omega_rad_s,distance_m,alpha_f_rad,{made}\n5,0.6,0,0,0,0.1\n5,0.8,0.1,0,0.1,0.1\n"
        ),
    );
    folder.write(
        "gaps.csv",
        format!("omega_rad_s,alpha_f_rad,{made}\n5,,0,,0.1\n"),
    );
    std::fs::create_dir(folder.path("folder")).unwrap();
    folder
}

/// Words after `saltus`, and what the message must contain.
const CASES: &[(&str, &[&str])] = &[
    // The command line itself.
    ("", &["Usage: saltus"]),
    ("fly", &["unrecognized subcommand 'fly'"]),
    ("simulate --speed 5", &["unexpected argument '--speed'"]),
    (
        "simulate --omega",
        &["a value is required for '--omega <RATE>'"],
    ),
    ("simulate", &["--omega is missing", "--batch"]),
    ("simulate --omega 5", &["--alpha-f is missing"]),
    ("simulate --alpha-f 0", &["--omega is missing"]),
    (
        "simulate --batch nan.csv --omega 5",
        &["cannot be used with", "--omega"],
    ),
    (
        "simulate --omega 5 --omega 6 --alpha-f 0",
        &["'--omega <RATE>' cannot be used multiple times"],
    ),
    ("completions csh", &["invalid value 'csh'", "bash"]),
    ("completions", &["<SHELL>"]),
    ("export", &["Usage: saltus export"]),
    ("export sdf", &["unrecognized subcommand 'sdf'"]),
    ("export c --distance 0.6", &["--out <FOLDER>"]),
    ("export c --out x", &["--distance <LENGTHS>"]),
    (
        "export gait fixed --distance 0.6 --out x",
        &["unexpected argument '--distance'"],
    ),
    (
        "export gait fixed --lines one --out x",
        &["unexpected argument '--lines'"],
    ),
    (
        "export c --distance 0.6 --zone 0 --out x",
        &["unexpected argument '--zone'"],
    ),
    (
        "export gait fixed --firing-angle 1.4 --out x",
        &["--firing-angle", "firing angle (rad) = 1.4", "zone"],
    ),
    (
        "export gait fixed --set body.legs=2 --out x",
        &["legs = 2", "from 3 to 12"],
    ),
    (
        "export gait disc-stable --robot rats-run --out x",
        &["rats-run", "legs = 5", "body.shape = \"sphere\""],
    ),
    (
        "export gait disc-stable --zone 0 --out x",
        &["unexpected argument '--zone'"],
    ),
    (
        "export gait disc-stable --valve-open 30ms --out x",
        &["unexpected argument '--valve-open'"],
    ),
    (
        "export c --gait disc-stable --out x",
        &["saltus export gait"],
    ),
    (
        "export gait disc-stable --set sensors.period_ms=0 --out x",
        &["sensors.period_ms = 0"],
    ),
    (
        "export gait fixed --robot rats-twelve --out x",
        &["rats-twelve"],
    ),
    (
        "export c --distance 0.3,0.5,0.6 --out x",
        &["--distance [0.3, 0.5, 0.6]", "rising in even steps"],
    ),
    (
        "export c --distance 0.6:0.3:4 --out x",
        &["--distance", "rising in even steps"],
    ),
    (
        "export c --distance -0.6:0.3:4 --out x",
        &["--distance", "\"-0.6\" must be a distance"],
    ),
    (
        "export c --distance 0.3:0.6:1001 --out x",
        &["--distance", "1 to 1000 values"],
    ),
    (
        "export c --distance 0.6 --omega 5 --out x",
        &["--omega [5.0]", "2 to 1000 values"],
    ),
    (
        "export c --distance 0.6 --alpha-f 0.1 --out x",
        &["--alpha-f", "2 to 1000 values"],
    ),
    (
        "export c --distance 0.6 --newton 4 --out x",
        &["'4'", "--newton", "0..=3"],
    ),
    (
        "export c --distance 0.6 --valve-range 30ms --out x",
        &["--valve-range", "two times, the lower first"],
    ),
    (
        "export c --distance 0.6 --valve-range 40ms:30ms --out x",
        &["--valve-range", "two times, the lower first"],
    ),
    (
        "export c --distance 0.6 --valve-range 30ms:40ms --out x",
        &["--valve-range 0.03:0.04", "that holds --valve-open 0.1"],
    ),
    (
        "export c --distance 0.6 --valve-open 0 --out x",
        &["--valve-open", "above 0"],
    ),
    (
        "export c --distance 0.6 --real half --out x",
        &["'half'", "float", "double"],
    ),
    (
        "export c --distance 0.6 --tolerance 0 --out x",
        &["--tolerance", "above 0"],
    ),
    (
        "export c --distance 0.6 --start-lean 2 --out x",
        &["--start-lean", "between -pi/2 and pi/2"],
    ),
    (
        "export c --distance 0.6 --set environment.drag_per_m=0.1 --out x",
        &["environment.drag_per_m = 0.1", "must be 0"],
    ),
    (
        "export c --distance 0.6 --robot nobody --out x",
        &["nobody"],
    ),
    (
        "export c --distance 0.6 --out robot.toml",
        &["robot.toml: cannot be written"],
    ),
    (
        "export rust --distance 0.6 --name rats",
        &["--name", "\"rats\"", "capitals, digits and underscores"],
    ),
    (
        "export rust --distance 0.6 --out nowhere/a.rs",
        &["nowhere/a.rs: cannot be written"],
    ),
    ("export mjcf --robot nobody", &["nobody"]),
    (
        "export mjcf --robot broken.toml --out a.xml",
        &["broken.toml"],
    ),
    ("export mjcf --set leg.stroke_m=-1", &["leg.stroke_m"]),
    (
        "export mjcf --out nowhere/a.xml",
        &["nowhere/a.xml: cannot be written"],
    ),
    // Numbers.
    (
        "simulate --omega five --alpha-f 0",
        &["--omega", "\"five\" must be a number from 0 to 1000 rad/s"],
    ),
    (
        "simulate --omega nan --alpha-f 0",
        &["--omega", "\"nan\" must be a number from 0 to 1000 rad/s"],
    ),
    (
        "simulate --omega inf --alpha-f 0",
        &["--omega", "\"inf\" must be"],
    ),
    (
        "simulate --omega 1e400 --alpha-f 0",
        &["--omega", "\"1e400\" must be"],
    ),
    (
        "simulate --omega -1 --alpha-f 0",
        &["--omega", "\"-1\" must be a number from 0 to 1000 rad/s"],
    ),
    (
        "simulate --omega 5m --alpha-f 0",
        &["--omega", "\"5m\" must be"],
    ),
    (
        "simulate --omega 5 --alpha-f 1.6",
        &[
            "--alpha-f",
            "\"1.6\" must be an angle strictly between -pi/2 and pi/2 rad",
        ],
    ),
    (
        "simulate --omega 5 --alpha-f 90deg",
        &["--alpha-f", "\"90deg\" must be an angle"],
    ),
    (
        "simulate --omega 5 --alpha-f 0 --start-lean 2",
        &["--start-lean", "\"2\" must be an angle"],
    ),
    (
        "simulate --omega 5 --alpha-f 0 --valve-open -1ms",
        &["--valve-open", "\"-1ms\" must be a time from 0 to 1000 s"],
    ),
    (
        "simulate --omega 5 --alpha-f 0 --threads 0",
        &["--threads", "invalid value '0'"],
    ),
    // Ranges.
    (
        "simulate --omega 3:6 --alpha-f 0",
        &[
            "--omega",
            "\"3:6\" must be a number or start:stop:count, as in 3:6:61",
        ],
    ),
    (
        "simulate --omega 3:6:0 --alpha-f 0",
        &["count \"0\" must be a whole number from 1 to 1000000"],
    ),
    (
        "simulate --omega 3:6:1 --alpha-f 0",
        &["\"3:6:1\" has two ends and one value"],
    ),
    (
        "simulate --omega 3:6:2.5 --alpha-f 0",
        &["count \"2.5\" must be a whole number"],
    ),
    (
        "simulate --omega 3:6:1e9 --alpha-f 0",
        &["count \"1e9\" must be a whole number"],
    ),
    (
        "simulate --omega 3,,4 --alpha-f 0",
        &["--omega", "\"\" must be a number"],
    ),
    (
        "simulate --omega 3:6:2000 --alpha-f 0:1:2000",
        &["must be 1000000 combinations at most, not 4000000"],
    ),
    (
        "map --omega 3:6:2000 --alpha-f 0:1:2000",
        &["must be 1000000 combinations at most, not 4000000"],
    ),
    (
        "table --omega 3:6:2000 --distance 0:1:2000",
        &["1000000 pairs of rate and target at most"],
    ),
    // Targets.
    (
        "table --omega 5",
        &["--distance is missing: the distances to reach (m), or --clearance with an --obstacle"],
    ),
    ("table --distance 1", &["--omega <RATES>"]),
    (
        "table --omega 5 --distance -1",
        &["--distance", "\"-1\" must be a distance from 0 to 1000 m"],
    ),
    (
        "table --omega 5 --distance 1 --clearance 0.1",
        &["cannot be used with"],
    ),
    (
        "table --omega 5 --clearance 0.1",
        &["--obstacle <FRONT,WIDTH,HEIGHT>"],
    ),
    (
        "table --omega 5 --clearance 0.1 --obstacle 0.4,0.2",
        &["\"0.4,0.2\" must be three lengths, as in 0.4,0.21,0.21"],
    ),
    (
        "table --omega 5 --clearance 0.1 --obstacle 0.4,0,0.2",
        &["WIDTH \"0\" must be a length above 0"],
    ),
    (
        "table --omega 5 --clearance 0.1 --obstacle 0.1,0.2,0.2",
        &["--obstacle 0.1,0.2,0.2", "at least its radius, 0.24 m"],
    ),
    (
        "table --omega 5 --distance 1 --firing-angles 0.5:-0.5",
        &["must be two angles, the lower first, as in -0.6:0.8"],
    ),
    (
        "table --omega 5 --distance 1 --landing-height 1e9",
        &["--landing-height", "must be a height from -1000 to 1000 m"],
    ),
    (
        "law --omega 3:6:5 --distance 1 --tolerance 0",
        &["--tolerance", "\"0\" must be a length above 0"],
    ),
    ("map --omega 5", &["--alpha-f <ANGLES>"]),
    // Robots.
    (
        "simulate --omega 5 --alpha-f 0 --robot rat",
        &["rat: no such robot or file", "rats-planar"],
    ),
    (
        "simulate --omega 5 --alpha-f 0 --robot robot.toml",
        &["robot.toml", "missing key"],
    ),
    (
        "simulate --omega 5 --alpha-f 0 --robot broken.toml",
        &["broken.toml:1: not TOML"],
    ),
    (
        "simulate --omega 5 --alpha-f 0 --robot folder",
        &["folder: cannot be read"],
    ),
    (
        "simulate --omega 5 --alpha-f 0 --set leg.boer_mm=20",
        &["unknown key leg.boer_mm", "leg.bore_mm"],
    ),
    (
        "simulate --omega 5 --alpha-f 0 --set leg.bore_mm=-1",
        &["--set leg.bore_mm=-1", "must be"],
    ),
    (
        "simulate --omega 5 --alpha-f 0 --set leg.bore_mm=nan",
        &["leg.bore_mm", "must be"],
    ),
    (
        "simulate --omega 5 --alpha-f 0 --set leg.bore_mm",
        &["--set leg.bore_mm: must be KEY=VALUE"],
    ),
    // Files that are read.
    (
        "simulate --batch nowhere.csv",
        &["nowhere.csv: cannot be read"],
    ),
    ("simulate --batch folder", &["folder: cannot be read"]),
    (
        "simulate --batch empty.csv",
        &["empty.csv:1: no column omega0_rad_s: the header must name"],
    ),
    ("simulate --batch header.csv", &["header.csv: no rows"]),
    (
        "simulate --batch columns.csv",
        &["columns.csv:1: no column omega0_rad_s"],
    ),
    (
        "simulate --batch nan.csv --out a.csv",
        &["nan.csv:3: alpha_f_rad = NaN: must be an angle"],
    ),
    (
        "simulate --batch inf.csv --out a.csv",
        &["inf.csv:2: omega0_rad_s = inf: must be a number from 0 to 1000 rad/s"],
    ),
    (
        "simulate --batch negative.csv",
        &["negative.csv:2: valve_open_s = -0.1: must be a time from 0 to 1000 s"],
    ),
    (
        "simulate --batch word.csv",
        &["word.csv:2: alpha_f_rad = forward: must be an angle"],
    ),
    (
        "simulate --batch ragged.csv",
        &["ragged.csv:2: 3 fields where the header has 4"],
    ),
    (
        "simulate --batch twice.csv",
        &["twice.csv:1: column phi0_rad is there twice"],
    ),
    (
        "simulate --batch binary.csv",
        &["binary.csv:2: alpha_f_rad = "],
    ),
    // Courses.
    ("plan", &["<COURSE.toml>"]),
    ("plan nowhere.toml", &["nowhere.toml: cannot be read"]),
    (
        "plan course.toml --plot a.svg",
        &["course.toml:3: unknown key length_m; the keys allowed there are jumps, start_x_m,"],
    ),
    (
        "plan rate.toml --out a.json",
        &["rate.toml:1: approach_rate_rad_s = -5: must be a finite number ≥ 0 and ≤ 1000 rad/s"],
    ),
    (
        "plan narrow.toml",
        &["narrow.toml:5: obstacle 1.width_m = 0: must be a finite number > 0 and ≤ 1000 m"],
    ),
    ("verify", &["COURSE.toml|TABLE.csv"]),
    ("verify nowhere.toml", &["nowhere.toml: cannot be read"]),
    (
        "verify rate.toml --out a.csv",
        &["rate.toml:1: approach_rate_rad_s = -5"],
    ),
    (
        "verify broken.toml --samples 0",
        &["broken.toml:1: not TOML"],
    ),
    (
        "verify empty.csv",
        &["empty.csv:1: no column omega_rad_s: the header must name omega_rad_s, alpha_f_rad"],
    ),
    ("verify --law=-0.1,0.4", &["--omega <RATES>"]),
    (
        "verify --law=-0.1 --omega 5",
        &[
            "--law",
            "\"-0.1\" must be a slope (s) and an intercept (rad)",
        ],
    ),
    (
        "verify --law=-0.1,9 --omega 5",
        &[
            "--law -0.1,9",
            "between -pi/2 and pi/2 rad; at 5 rad/s it is 8.5",
        ],
    ),
    (
        "verify --law=-0.1,0.4 --omega 5 box.toml",
        &["cannot be used with"],
    ),
    ("verify --law=-0.1,0.4 --omega 5 --plant rover", &["rover"]),
    (
        "verify --law=-0.1,0.4 --omega 5 --plant-set leg.bore_mm=-1",
        &["bore_mm", "-1"],
    ),
    (
        "verify --law=-0.1,0.4 --omega 5 --friction=-1",
        &["--friction", "\"-1\" must be a number from 0 to 10000"],
    ),
    (
        "verify --law=-0.1,0.4 --omega 5 --share 2",
        &["--share", "must be a share from 0 to 1"],
    ),
    (
        "verify --law=-0.1,0.4 --omega 5 --samples 1e9",
        &["--samples"],
    ),
    (
        "verify --law=-0.1,0.4 --omega 5 --tolerance 0",
        &["--tolerance", "above 0"],
    ),
    (
        "verify course2.toml --animate a.txt",
        &["--animate", "the name must end in .html"],
    ),
    (
        "verify course2.toml --samples 0 --format text --out a.html --animate a.html",
        &["--animate a.html: must be another file than --out"],
    ),
    (
        "verify course2.toml --omega 5",
        &["--omega: must be left out where a course says"],
    ),
    (
        "verify falling.csv",
        &["falling.csv:3: omega_rad_s = 4: must be above the one before"],
    ),
    (
        "verify two.csv",
        &["two.csv: holds 2 distances (m): 0.6, 0.8; --distance says which one to verify"],
    ),
    (
        "verify two.csv --distance 0.7",
        &["--distance 0.7: must be one of those in two.csv (m): 0.6, 0.8"],
    ),
    ("verify gaps.csv", &["gaps.csv: no row with a firing angle"]),
    (
        "verify two.csv --distance 0.6 --omega 9",
        &["--omega 9: must be within the table: from 5 to 5 rad/s"],
    ),
    ("plan broken.toml", &["broken.toml:1: not TOML"]),
    (
        "plan binary.csv",
        &["binary.csv: byte 51 is not UTF-8 text"],
    ),
    // Files that are written.
    (
        "simulate --omega 5 --alpha-f 0 --format xml",
        &["invalid value 'xml'", "text, json, csv"],
    ),
    (
        "simulate --omega 5 --alpha-f 0 --out folder",
        &["folder: cannot be written"],
    ),
    (
        "simulate --omega 5 --alpha-f 0 --out nowhere/a.csv",
        &["nowhere/a.csv: cannot be written"],
    ),
    (
        "simulate --omega 5 --alpha-f 0 --plot a.pdf",
        &["--plot", "the name must end in .svg or .png"],
    ),
    (
        "simulate --omega 5 --alpha-f 0 --plot nowhere/a.svg --out a.csv",
        &["nowhere/a.svg: cannot be written"],
    ),
    (
        "simulate --omega 5 --alpha-f 0 --out nowhere/a.csv --plot a.svg",
        &["nowhere/a.csv: cannot be written"],
    ),
    (
        "simulate --omega 5 --alpha-f 0 --out a.svg --format text --plot a.svg",
        &["--plot a.svg: must be another file than --out"],
    ),
    (
        "simulate --omega 3:6:200 --alpha-f 0 --plot a.svg",
        &["--plot: must be used with 100 jumps at most, not 200"],
    ),
    (
        "map --omega 3:6:300 --alpha-f 0:1:300 --plot a.svg",
        &["--plot: must be used with 40000 combinations at most"],
    ),
    (
        "table --omega 3:6:2 --distance 0.5:1:50 --plot a.svg",
        &["--plot: must be used with 40 targets at most, not 50"],
    ),
];

#[test]
fn bad_input_is_refused_with_its_reason_and_leaves_nothing() {
    let folder = folder("bad");
    let before = folder.names();
    for (line, messages) in CASES {
        let run = folder.run(&line.split_whitespace().collect::<Vec<_>>());
        assert_eq!(run.code, Some(2), "{line}: {run:?}");
        assert_eq!(run.out, "", "{line}");
        for message in *messages {
            assert!(
                run.err.contains(message),
                "{line}: {message:?} is not in {}",
                run.err
            );
        }
        assert!(!run.err.contains("panicked"), "{line}: {}", run.err);
        assert_eq!(folder.names(), before, "{line}");
    }
}

#[test]
fn what_was_there_stays_when_a_run_fails() {
    let folder = folder("stays");
    folder.write("a.csv", "old");
    let run = folder.run(&[
        "simulate", "--batch", "nan.csv", "--out", "a.csv", "--plot", "a.svg",
    ]);
    assert_eq!((run.code, folder.read("a.csv").as_str()), (Some(2), "old"));
}

#[test]
fn endless_files_are_refused() {
    let folder = Folder::new("endless");
    if std::path::Path::new("/dev/zero").exists() {
        let run = folder.run(&[
            "simulate",
            "--omega",
            "5",
            "--alpha-f",
            "0",
            "--robot",
            "/dev/zero",
        ]);
        assert!(
            run.code == Some(2) && run.err.contains("larger than"),
            "{run:?}"
        );
    }
}
