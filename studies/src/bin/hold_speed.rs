//! How well a commanded speed is held: on the level from rest, then with another supply pressure, up
//! to 20 % off, and on a slope of up to 3°.
//!
//! ```text
//! cd studies && cargo run --release --bin hold_speed -- 100
//! ```
//!
//! So many runs for each speed; 4 where nothing is given.

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use saltus_gait::{Disturbance, Footfall, GaitError, Row, Run, Setup, What, When, run};
use saltus_numeric::parallel::{available, map};

/// When it is disturbed, when the speed counts, and when it is to stop (s).
const DISTURBED: f64 = 3.0;
const COUNTS: [f64; 2] = [4.0, 14.0];
const END: f64 = 17.0;

#[derive(Default)]
struct Way {
    travel: [f64; 2],
    stalls: usize,
    was_stalled: bool,
}

impl Run for Way {
    fn row(&mut self, row: &Row<'_>) {
        for (at, travel) in COUNTS.iter().zip(&mut self.travel) {
            if row.time <= *at {
                *travel = row.axle[0];
            }
        }
        let counts = (COUNTS[0]..COUNTS[1]).contains(&row.time);
        self.stalls += usize::from(counts && row.action.stalled && !self.was_stalled);
        self.was_stalled = row.action.stalled;
    }

    fn footfall(&mut self, _: &Footfall) {}
}

/// Mean speed (m/s), stalls, and the way to a stop (m).
fn one(base: &Setup, k: usize) -> Result<(f64, usize, f64), GaitError> {
    let mut random = Pcg64::new(17, k as u128);
    let uniform = Uniform::new_inclusive(-1.0, 1.0)
        .map_err(|_| ())
        .expect("-1 is below 1");
    let supply = base.robot.leg.cylinder().map_or(0.0, |c| c.supply.0);
    let when = When::Time(DISTURBED, 1e9);
    let mut setup = base.clone();
    setup.seed = k as u64;
    for what in [
        What::Supply(supply * (1.0 + 0.2 * uniform.sample(&mut random))),
        What::Slope(3_f64.to_radians() * uniform.sample(&mut random)),
    ] {
        setup.disturbances.push(Disturbance { when, what });
    }
    let mut way = Way::default();
    let summary = run(&setup, &mut way)?;
    let mean = (way.travel[1] - way.travel[0]) / (COUNTS[1] - COUNTS[0]);
    Ok((mean, way.stalls, summary.travel - way.travel[1]))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let given = std::env::args().nth(1);
    let count: usize = given.map_or(Ok(4), |count| count.parse())?;
    let robot = saltus_robot::resolve("rats-run", &[])?;
    for speed in [1.0, 1.5, 2.0, 2.5, 3.0] {
        let speeds = [[0.0, speed], [COUNTS[1], 0.0]];
        let base = Setup::at_speeds(&robot, &speeds, END, available())?;
        let runs: Vec<_> = map(count, |k| one(&base, k))
            .into_iter()
            .collect::<Result<_, _>>()?;
        let within = runs
            .iter()
            .filter(|r| (r.0 / speed - 1.0).abs() <= 0.05)
            .count();
        let stalled = runs.iter().filter(|r| r.1 > 0).count();
        let sorted = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values
        };
        let means = sorted(runs.iter().map(|r| r.0).collect());
        let stops = sorted(runs.iter().map(|r| r.2).collect());
        let near = stops.iter().filter(|way| **way <= 2.0).count();
        let last = count - 1;
        println!(
            "{speed} m/s: mean within 5 % in {within} of {count} ({:.2} to {:.2}), {stalled} \
             stalled; stops within {:.2} m (median), {:.2} m (greatest), {near} within 2 m",
            means[0],
            means[last],
            stops[count / 2],
            stops[last]
        );
    }
    Ok(())
}
