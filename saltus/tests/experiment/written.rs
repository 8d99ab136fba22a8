//! Experiments written as folders, and read back.

use saltus::experiment::{Experiment, Run, Sort, read, write};

use crate::folder::Folder;

/// An experiment with all that a file can say.
fn written(kind: Sort, columns: &[&str], settings: &[(&str, f64)]) -> Experiment {
    let valve = matches!(kind, Sort::Bench | Sort::Hop | Sort::Jump);
    let run = |run: u32| {
        let time = |i: u32| {
            if kind == Sort::Outcomes {
                f64::from(i)
            } else {
                f64::from(i) / 100.0
            }
        };
        let value = |column: usize, i: u32| {
            let x = f64::from(i + 13 * run) / 300.0;
            match columns[column] {
                "pressure_pa" | "pressure_gauge_pa" => 1e5 + 1e3 * x / 3.0,
                "temperature_k" => 300.0 - x,
                _ => 1e-9 + x,
            }
        };
        Run {
            name: format!("part/run \"{run}\".csv"),
            settings: settings
                .iter()
                .map(|(key, value)| ((*key).into(), *value))
                .collect(),
            valve: valve.then(|| (time(3), (run == 0).then(|| time(7)))),
            time: (0..20).map(time).collect(),
            values: (0..columns.len())
                .map(|column| (0..20).map(|i| value(column, i)).collect())
                .collect(),
        }
    };
    let mut noise = vec![None; columns.len()];
    noise[0] = Some(1.0 / 3.0);
    let resolution = noise.iter().rev().copied().collect();
    Experiment {
        kind,
        mechanism: None,
        columns: columns.iter().map(|&name| name.into()).collect(),
        noise,
        resolution,
        runs: vec![run(0), run(1)],
    }
}

#[test]
fn what_is_written_is_read_back() {
    let supply = ("supply_pressure_gauge_pa", 827000.0 / 7.0);
    let vessel = [
        ("volume_m3", 0.01),
        ("orifice_diameter_m", 1e-7),
        ("initial_pressure_pa", 1e5),
        ("initial_temperature_k", 300.0),
        ("ambient_pressure_pa", 1e5),
        ("wall_area_m2", 0.4),
    ];
    let part = [
        ("mass_kg", 0.7),
        ("centre_from_axle_m", 0.0448),
        ("inertia_about_centre_kg_m2", 1e-4),
    ];
    let experiments = [
        written(
            Sort::Bench,
            &["position_m", "pressure_pa"],
            &[supply, ("load_mass_kg", 2.5)],
        ),
        written(Sort::Hop, &["pivot_angle_rad"], &[supply]),
        written(
            Sort::Jump,
            &[
                "wheel_angle_rad",
                "pivot_angle_rad",
                "radius_angle_rad",
                "wheel_rate_rad_s",
            ],
            &[supply],
        ),
        written(Sort::Flight, &["y_m"], &[("boom_radius_m", 1.1)]),
        written(
            Sort::Outcomes,
            &[
                "omega_rad_s",
                "alpha_f_rad",
                "valve_open_s",
                "distance_m",
                "apex_m",
            ],
            &[],
        ),
        written(
            Sort::Stroke,
            &["position_m", "pressure_gauge_pa", "force_n"],
            &[("bore_m", 0.025)],
        ),
        written(Sort::Slide, &["force_n", "position_m"], &[]),
        written(Sort::Vessel, &["pressure_pa", "temperature_k"], &vessel),
        written(Sort::Pendulum, &["angle_rad", "torque_nm"], &part),
        written(Sort::Pendulum, &["angle_rad"], &[("axis", -1.0)]),
    ];
    for experiment in experiments {
        let columns = experiment.columns.len();
        let data = Folder::new(&format!("written-{:?}-{columns}", experiment.kind));
        let path = data.path("new/folder");
        let robot = Some("my \"robot\"\n.toml");
        write(&path, &experiment, robot).unwrap();
        let folder = read(&path, &|_| ()).unwrap();
        assert_eq!(folder.experiment, experiment);
        let is_part = experiment.runs[0].settings.contains_key("mass_kg");
        let is_robot = experiment.kind != Sort::Pendulum || !is_part;
        assert_eq!(folder.robot.as_deref(), robot.filter(|_| is_robot));
        // And no other file is there.
        assert_eq!(data.names(), ["new"]);
        assert_eq!(std::fs::read_dir(path.join("part")).unwrap().count(), 2);
        assert_eq!(std::fs::read_dir(&path).unwrap().count(), 2);
        let error = write(&path, &experiment, robot).unwrap_err().to_string();
        assert!(
            error.ends_with("new/folder: is not empty: data go into a new or an empty folder"),
            "{error}"
        );
    }
}

#[test]
fn a_switch_between_rows_is_written() {
    let data = Folder::new("written-switch");
    let mut experiment = written(
        Sort::Hop,
        &["pivot_angle_rad"],
        &[("supply_pressure_gauge_pa", 8e5)],
    );
    experiment.runs[0].valve = Some((-0.1, Some(0.012)));
    experiment.runs[0].values[0][4] = f64::NAN;
    write(&data.path(""), &experiment, Some("rats-boom")).unwrap();
    let run = &read(&data.path(""), &|_| ()).unwrap().experiment.runs[0];
    // Times count from the first row, which has the command alone.
    assert_eq!(run.valve, Some((0.0, Some(0.112))));
    assert_eq!(
        (run.time.len(), run.time[0], run.time[2], run.time[3]),
        (22, 0.0, 0.11, 0.112)
    );
    assert!([0, 3, 6].iter().all(|row| run.values[0][*row].is_nan()) && run.values[0][5] > 0.0);
}

#[test]
fn what_files_cannot_say_is_not_written() {
    let check = |spoil: &dyn Fn(&mut Experiment), message: &str| {
        let data = Folder::new("unwritable");
        let mut experiment = written(Sort::Hop, &["pivot_angle_rad"], &[]);
        spoil(&mut experiment);
        assert_eq!(
            write(&data.path(""), &experiment, None)
                .unwrap_err()
                .to_string(),
            message
        );
        assert_eq!(data.names(), [""; 0]);
    };
    let name = |name: &'static str| {
        move |experiment: &mut Experiment| experiment.runs[0].name = name.into()
    };
    check(
        &name("../a.csv"),
        "../a.csv: must be the name of a file within the folder",
    );
    check(
        &name("experiment.toml"),
        "experiment.toml: must be the name of a file within the folder",
    );
    check(
        &name("part/run \"1\".csv"),
        "part/run \"1\".csv: is the name of two runs",
    );
    check(
        &|it| it.runs[1].time.push(9.0),
        "part/run \"1\".csv: has columns of unequal length",
    );
    check(
        &|it| it.runs[1].values[0][3] = f64::INFINITY,
        "part/run \"1\".csv: has a number that is not finite",
    );
    check(
        &|it| it.runs[1].valve = None,
        "part/run \"1\".csv: has no opening of the valve",
    );
}
