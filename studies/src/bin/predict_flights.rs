//! Flights predicted from their first 20 samples, with gravity as believed and as other flights
//! say.
//!
//!     cd studies && cargo run --release --bin predict_flights -- BELIEVED FIT… -- OTHER…
//!
//! BELIEVED is the operator's gravity (m/s²), FIT and OTHER are data folders of kind `flight` with
//! a column `y_m`.

use std::path::PathBuf;

use saltus::diagnosis::kinds::Flights;
use saltus::diagnosis::{Experiment, Settings, diagnose};
use saltus::experiment::read_all;

/// Samples from which a flight is predicted.
const SAMPLES: usize = 20;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let Some((believed, folders)) = args.split_first() else {
        println!("predict_flights BELIEVED FIT… -- OTHER…: see the head of this file");
        return Ok(());
    };
    let believed: f64 = believed.parse()?;
    let (fit, other) = match folders.iter().position(|a| a == "--") {
        Some(k) => (&folders[..k], &folders[k + 1..]),
        None => (folders, &[][..]),
    };
    let read = |folders: &[String]| {
        let paths: Vec<PathBuf> = folders.iter().map(PathBuf::from).collect();
        read_all(&paths, &|_| ())
    };
    let flights = Flights::new(&read(fit)?.experiment, believed);
    let found =
        diagnose(&flights, &Settings::default(), &|_| ()).ok_or("no model of these flights")?;
    let mut gravity = believed;
    for finding in &found.findings {
        let id = finding.best.id;
        for r in &finding.best.reported {
            println!("{id}: {} = {:.5} ± {:.1e}", r.name, r.value, r.error);
        }
        gravity = match (id, finding.best.reported.first()) {
            ("counterweight", Some(share)) => share.value * believed,
            ("gravity", Some(found)) => found.value,
            _ => gravity,
        };
    }
    let experiment = read(other)?.experiment;
    for (what, gravity) in [("believed", believed), ("found", gravity)] {
        println!(
            "{what}: gravity {gravity:.4} m/s2, rms of the rest of each flight {:.1} mm",
            1e3 * rms(&experiment, gravity)
        );
    }
    Ok(())
}

/// Root mean square (m) of the heights after the first samples of each flight, predicted from them.
fn rms(experiment: &Experiment, gravity: f64) -> f64 {
    let column = experiment
        .columns
        .iter()
        .position(|c| c == "y_m")
        .unwrap_or(0);
    let (mut sum, mut count) = (0.0, 0.0);
    for run in &experiment.runs {
        let heights = &run.values[column];
        let n = SAMPLES.min(heights.len());
        // A line through what gravity leaves of the first samples.
        let flat = |i: usize| {
            let t = run.time[i] - run.time[0];
            (t, heights[i] + 0.5 * gravity * t * t)
        };
        let mean = (0..n).map(flat).fold((0.0, 0.0), |s, p| {
            (s.0 + p.0 / n as f64, s.1 + p.1 / n as f64)
        });
        let (mut above, mut below) = (0.0, 0.0);
        for (t, y) in (0..n).map(flat) {
            above += (t - mean.0) * (y - mean.1);
            below += (t - mean.0).powi(2);
        }
        let speed = above / below;
        for (t, y) in (n..heights.len()).map(flat) {
            sum += (y - mean.1 - speed * (t - mean.0)).powi(2);
            count += 1.0;
        }
    }
    f64::sqrt(sum / f64::max(count, 1.0))
}
