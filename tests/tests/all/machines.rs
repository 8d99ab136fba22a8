//! Measured machines that are no robot of Saltus: what a diagnosis has to find in them.

use std::path::Path;

use saltus::diagnosis::{Fit, Kind, Settings, diagnose, estimate, kinds};
use saltus::experiment::read;

/// The experiment in a folder of `tests/reference`.
fn kind_of(folder: &str) -> Box<dyn Kind> {
    let reference = Path::new(env!("CARGO_MANIFEST_DIR")).join("reference");
    let data = read(&reference.join(folder), &|_| ()).expect("data");
    kinds::build(&data.experiment, None).expect("a model")
}

/// Indices of the causes with these ids: where several have one, the first.
fn indices(kind: &dyn Kind, ids: &[&str]) -> Vec<usize> {
    let of = |id: &&str| {
        let mut listed = kind.common()..kind.listed();
        listed
            .find(|c| kind.causes()[*c].id == *id)
            .expect("a cause")
    };
    ids.iter().map(of).collect()
}

/// Root mean square of what `fit` leaves of the channels whose names end with `end`, in their unit.
fn left(kind: &dyn Kind, fit: &Fit, end: &str) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for (run, log) in kind.logs().iter().enumerate() {
        let predicted = kind
            .predict(run, &fit.terms, &fit.unknowns[run])
            .expect("a jump");
        for (reading, value) in log.readings.iter().zip(predicted) {
            if kind.channels()[reading.channel].name.ends_with(end) {
                sum += (reading.value - value).powi(2);
                count += 1;
            }
        }
    }
    (sum / f64::from(count)).sqrt()
}

/// Four jumps of a robot with muscles: lags of valves, tubes, heat and tendons explain its pressures
/// and the way of its centre of mass; without lags much is left.
#[test]
#[ignore = "nightly: 18 s"]
fn a_jumper_with_a_tank_is_explained() {
    let kind = kind_of("gtd-jumper");
    let ids = [
        "series-spring",
        "tube",
        "valve-delay",
        "heat-transfer",
        "tank",
    ];
    let all = indices(kind.as_ref(), &ids);
    let explained = estimate(kind.as_ref(), &all).expect("a fit").after;
    let muscles = |fit: &Fit| {
        let of = |name: &str| left(kind.as_ref(), fit, name);
        let each = ["knee_right", "hip_right", "hip_left", "knee_left"];
        let squares = each.map(|name| of(&format!("{name}_pressure_gauge_pa")).powi(2));
        (squares.iter().sum::<f64>() / 4.0).sqrt()
    };
    let center = |fit: &Fit| left(kind.as_ref(), fit, "com_y_m");
    assert!(muscles(&explained) < 9e3, "{}", muscles(&explained));
    assert!(center(&explained) < 0.016, "{}", center(&explained));
    let tank = left(kind.as_ref(), &explained, "tank_pressure_gauge_pa");
    assert!(tank < 8.6e3, "{tank}");
    let rest = indices(
        kind.as_ref(),
        &["series-spring", "tube", "heat-transfer", "tank"],
    );
    let no_lags = estimate(kind.as_ref(), &rest).expect("a fit").after;
    let ratio = muscles(&no_lags) / muscles(&explained);
    assert!(ratio > 1.5, "{ratio}");
}

/// Chambers that were filled and shut: all leak, one by far more than the others. No single opening describes
/// how that one empties: the leak is named, and what it leaves there is unknown.
#[test]
#[ignore = "nightly: 4 s"]
fn chambers_that_were_shut_leak() {
    let kind = kind_of("air-chambers");
    let found = diagnose(kind.as_ref(), &Settings::default(), &|_| ()).expect("an answer");
    let [finding] = &found.findings[..] else {
        panic!("{:?}", found.findings);
    };
    assert_eq!(finding.best.id, "chamber-leak");
    assert!(finding.rivals.is_empty(), "{:?}", finding.rivals);
    let unknown = found.unknown.expect("more than a leak");
    assert_eq!(unknown.channel, "ultimaker-020.pressure_pa");
    let leaks: Vec<f64> = finding.best.reported.iter().map(|r| r.value).collect();
    assert!(leaks[..3].iter().all(|leak| *leak < 1e-6), "{leaks:?}");
    assert!(leaks[3] > 300.0 * leaks[2], "{leaks:?}");
    // Each chamber leaks, whatever the unknown does, and the last one leaks most.
    let ends = finding.best.reported.iter().map(|reported| {
        let interval = reported.interval.expect("an interval");
        let [low, high] = [interval.low, interval.high].map(|end| end.expect("an end"));
        assert!(0.0 < low && low < reported.value && reported.value < high);
        [low, high]
    });
    let ends: Vec<[f64; 2]> = ends.collect();
    assert!(
        ends[..3].iter().all(|[_, high]| ends[3][0] > 100.0 * high),
        "{ends:?}"
    );
    let rms: Vec<f64> = found.gains.iter().map(|gain| gain.rms.1).collect();
    assert!(
        rms[..3].iter().all(|rms| *rms < 500.0) && rms[3] < 26e3,
        "{rms:?}"
    );
    // What is unknown is far more than what is left of the others.
    assert!(unknown.rms > 10.0 * rms[..3].iter().copied().fold(0.0, f64::max));
}
