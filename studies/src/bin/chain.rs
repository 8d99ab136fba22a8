//! The chain from a log to a plan: hidden plants, what the diagnosis makes of their jumps, and how
//! many jumps pass of the plan for the robot as believed, as diagnosed, and as it really is.
//!
//!     cd studies && cargo run --release --bin chain -- plants=40 samples=200 [first=1001]
//!
//! With nothing given it takes two plants, and 60 runs of each plan.
//! Each plant is `rats-boom` with one cause of jumps hidden at 6 to 12 σ of a reading. A plant whose
//! truth is worth less than a tenth of the runs tells nothing of a diagnosis: it is listed, and
//! counts in no share.

use saltus::replan::replan;
use saltus::study::study;
use saltus::verify::Verification;
use saltus_diagnosis::{Settings, Sort};
use saltus_planner::Crossing;
use saltus_robot::{Robot, resolve};
use saltus_tests::lab::{self, Case, Size};
use saltus_tests::verdict;

const COURSE: &str = "approach_rate_rad_s = 5
goal_from_x_m = 0.65
goal_to_x_m = 0.75
clearance_m = 0.01
[[obstacle]]
front_x_m = 0.3
width_m = 0.15
height_m = 0.12";

fn number(name: &str, default: usize) -> usize {
    let given =
        std::env::args().find_map(|a| a.strip_prefix(name)?.strip_prefix('=')?.parse().ok());
    given.unwrap_or(default)
}

fn main() {
    let (plants, first, samples) = (
        number("plants", 2),
        number("first", 1001),
        number("samples", 60),
    );
    let crossing = saltus::course::parse(COURSE, "the course").expect("a course");
    let causes = lab::causes_of(Sort::Jump).iter();
    let causes: Vec<&str> = causes
        .copied()
        .filter(|id| !id.contains("sensor") && !id.contains("encoder"))
        .collect();
    let (mut saved, mut worth, mut counted) = (0.0, 0.0, 0);
    println!("| hidden | found | passes as believed | as diagnosed | with the truth |");
    println!("| --- | --- | --- | --- | --- |");
    for k in 0..plants {
        let seed = first + k / causes.len();
        let case = lab::make(
            Sort::Jump,
            &[(causes[k % causes.len()], Size::Clear)],
            seed as u64,
        );
        let Some((said, [believed, diagnosed, truth])) = shares(&case, &crossing, samples) else {
            println!("| {} | no answer | – | – | – |", causes[k % causes.len()]);
            continue;
        };
        println!(
            "| {} {:?} | {said} | {believed:.3} | {diagnosed:.3} | {truth:.3} |",
            case.truth[0].id, case.truth[0].parameters
        );
        if truth - believed >= 0.1 {
            (saved, worth, counted) = (
                saved + diagnosed - believed,
                worth + truth - believed,
                counted + 1,
            );
        }
    }
    println!(
        "\n{counted} of {plants} plants are worth knowing; the diagnosed plan saves {:.1} % of what the truth would",
        100.0 * saved / worth
    );
}

/// What was found, and the share of runs on the true robot that pass of three plans.
fn shares(case: &Case, crossing: &Crossing, samples: usize) -> Option<(String, [f64; 3])> {
    let name = case.robot.as_deref()?;
    let believed = Robot::builtin(name)?;
    let parameters = case.truth[0].parameters.iter();
    // The lab adds to what the gauge says.
    let gauge = believed.leg.cylinder().map_or(0.0, |c| c.supply.0);
    let hidden = parameters.map(|(key, x)| match &**key {
        "supply_pressure_pa added" => format!("leg.supply_pressure_gauge_pa={}", gauge + x),
        key if key.starts_with("leg.gas.") => "leg.gas=co2".into(),
        key => format!("{key}={x:e}"),
    });
    let truth = resolve(name, &hidden.collect::<Vec<_>>());
    let truth = truth.unwrap_or_else(|error| panic!("{:?}: {error}", case.truth));
    let found = study(
        &case.experiment,
        Some(&believed),
        &Settings::default(),
        &|_| (),
    )
    .ok()?;
    let diagnosed = found.extended().unwrap_or_else(|| believed.clone());
    let how = Verification {
        samples,
        seed: 77,
        tolerance: Some(f64::INFINITY),
        share: 0.95,
        ..Verification::default()
    };
    let share = |robot: &Robot| -> Option<f64> {
        let plan = replan(robot, &truth, crossing, &how).ok()?;
        let runs = plan.as_ref().and_then(|verdict| verdict.all(true));
        Some(runs.map_or(0.0, |it| it.runs_passed as f64 / it.runs as f64))
    };
    Some((
        verdict::say(&found.diagnosis),
        [share(&believed)?, share(&diagnosed)?, share(&truth)?],
    ))
}
