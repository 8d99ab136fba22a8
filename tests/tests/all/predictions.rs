//! How many predictions a diagnosis takes: a bound that does not depend on the machine.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use saltus_diagnosis::{Data, Kind, Parameter, Settings, Sort, Terms, diagnose, kinds};
use saltus_robot::Robot;
use saltus_tests::lab::{self, Size};

/// A kind that counts its predictions, one for each run, and those of its windows; proposals are not
/// counted.
struct Counted {
    inner: Box<dyn Kind>,
    count: Arc<AtomicUsize>,
}

impl Kind for Counted {
    fn data(&self) -> &Data {
        self.inner.data()
    }

    fn inner(&self) -> Option<&dyn Kind> {
        Some(self.inner.as_ref())
    }

    fn unknowns(&self, run: usize) -> Vec<Parameter> {
        self.inner.unknowns(run)
    }

    fn notes(&self) -> Vec<String> {
        self.inner.notes()
    }

    fn amplitudes(&self) -> Vec<f64> {
        self.inner.amplitudes()
    }

    fn predict(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Option<Vec<f64>> {
        self.count.fetch_add(1, Ordering::Relaxed);
        self.inner.predict(run, terms, unknowns)
    }

    fn windows(&self, count: usize) -> Option<Box<dyn Kind>> {
        Some(Box::new(Counted {
            inner: self.inner.windows(count)?,
            count: self.count.clone(),
        }))
    }
}

/// A clear effect on each kind of the laboratory, and the most predictions that its diagnosis takes: 1.5
/// times those that it took. Threads make a few more or less of them.
const MOST: [(Sort, &str, usize); 10] = [
    (Sort::Bench, "valve-delay", 1630),
    (Sort::Hop, "viscous-friction", 3420),
    (Sort::Jump, "across-friction", 5160),
    (Sort::Flight, "air-drag", 1460),
    (Sort::Outcomes, "axle-friction", 5500),
    (Sort::Stroke, "seal-friction", 3610),
    (Sort::Slide, "coulomb-friction", 3700),
    (Sort::Vessel, "gas-type", 1390),
    (Sort::Pendulum, "viscous-friction", 1010),
    (Sort::TankLeg, "tube", 1080),
];

#[test]
#[ignore = "nightly: 26 s"]
fn a_diagnosis_takes_no_more_predictions_than_it_did() {
    let mut wrong = Vec::new();
    for (sort, id, most) in MOST {
        let case = lab::make(sort, &[(id, Size::Clear)], 44);
        let robot = case.robot.as_deref().and_then(Robot::builtin);
        let inner = kinds::build(&case.experiment, robot.as_ref()).expect("a model of the data");
        let runs = inner.logs().len();
        let count = Arc::default();
        let kind = Counted {
            inner,
            count: Arc::clone(&count),
        };
        diagnose(&kind, &Settings::default(), &|_| ()).expect("an answer");
        let count = count.load(Ordering::Relaxed);
        if count > most {
            wrong.push(format!(
                "{sort:?}, {id}: {count} predictions of {runs} runs, at most {most}"
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
