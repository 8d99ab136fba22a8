//! Who corrects a column by what a diagnosis says of its sensor has data of which nothing is wrong.

use saltus::inject::{Effect, Request, make};
use saltus_diagnosis::{Diagnosis, Experiment, Kind, Sensor, Settings, Sort, diagnose, kinds};
use saltus_robot::Robot;
use saltus_tests::verdict;

/// Faults of columns that are predicted, and of forces and torques that drive.
const FAULTS: [(Sort, &str); 12] = [
    (Sort::Bench, "encoder-scale=position_m:1.08"),
    (Sort::Bench, "sensor-delay=pressure_pa:0.004"),
    (Sort::Stroke, "sensor-offset=force_n:6"),
    (Sort::Vessel, "encoder-scale=temperature_k:1.06"),
    (Sort::Slide, "sensor-delay=position_m:0.02"),
    (Sort::Slide, "sensor-offset=force_n:2"),
    (Sort::Pendulum, "encoder-scale=torque_nm:1.15"),
    (Sort::Pendulum, "sensor-delay=torque_nm:0.03"),
    (Sort::Machine, "sensor-delay=shoulder_nm:0.02"),
    (Sort::Walk, "encoder-scale=torque_nm:1.2"),
    (
        Sort::TankLeg,
        "sensor-offset=knee_left_pressure_gauge_pa:9000",
    ),
    (Sort::Jump, "sensor-delay=wheel_rate_rad_s:0.006"),
];

/// The experiment after its column is corrected by the fault of its sensor: by whole rows where it is
/// late, of which the last then lack it and are left out.
fn corrected(mut data: Experiment, column: &str, sensor: &Sensor) -> Experiment {
    let column = data.column(column).expect("a column");
    for run in &mut data.runs {
        let late = (sensor.delay + sensor.held) / (run.time[1] - run.time[0]);
        // A number of rows.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let late = late.round() as usize;
        let rows = run.time.len() - late;
        run.values[column].rotate_left(late);
        for value in &mut run.values[column] {
            *value = sensor.truth(*value);
        }
        run.time.truncate(rows);
        run.values.iter_mut().for_each(|own| own.truncate(rows));
    }
    data
}

fn diagnosed(data: &Experiment, robot: Option<&Robot>) -> (Box<dyn Kind>, Diagnosis) {
    let kind = kinds::build(data, robot).expect("a model of the data");
    let found = diagnose(kind.as_ref(), &Settings::default(), &|_| ()).expect("an answer");
    (kind, found)
}

#[test]
#[ignore = "nightly: 30 s"]
fn a_report_of_a_sensor_that_is_applied_leaves_nothing_wrong() {
    let mut wrong = Vec::new();
    for (sort, fault) in FAULTS {
        let effect: Effect = fault.parse().expect("an effect");
        let robot = sort.spec().robot.and_then(Robot::builtin);
        let made = make(&Request {
            kind: sort,
            robot: robot.as_ref(),
            effects: std::slice::from_ref(&effect),
            seed: 62,
            runs: None,
            asked: &[],
        });
        let data = made.expect("data").experiment;
        let (kind, found) = diagnosed(&data, robot.as_ref());
        let candidates = found.findings.iter().map(|finding| &finding.best);
        let best = candidates
            .into_iter()
            .find(|best| best.id == effect.id && best.column == effect.name);
        let Some(best) = best else {
            wrong.push(format!("{sort:?} {fault}: {}", verdict::say(&found)));
            continue;
        };
        let fault_of = kind.causes()[best.cause]
            .fault
            .expect("a fault of a sensor");
        let sensor = Sensor::default().with(fault_of, best.reported[0].value);
        let column = best.column.as_deref().expect("a column");
        let (_, again) = diagnosed(&corrected(data, column, &sensor), robot.as_ref());
        if !again.findings.is_empty() || again.unknown.is_some() {
            wrong.push(format!(
                "{sort:?} {fault}, corrected: {}",
                verdict::say(&again)
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
