//! Fits friction and restitution to measured tosses of a cube, and scores the simulation on tosses
//! that it was not fitted to: `tosses [FOLDER]`; without a folder the twelve tosses of the
//! reference.
//!
//! Every other toss is for the fit, in the order of their numbers; the rest are held out. A toss is
//! rolled out from its first state, and its error is the mean distance between the centres,
//! simulated and measured, over all its samples, as a part of the cube's width. The fit is to the
//! corners in place of the centre, which tells attitudes apart, too. Tosses are chaotic, so it goes
//! by scan: of the coefficient, of the restitution, then finer of both, each least refined by a
//! parabola through its neighbours. Standard errors are of 1000 draws of tosses with replacement.

use std::path::PathBuf;

use saltus_sim_check::SimError;

#[path = "../../../sim-check/tests/all/tosses/toss.rs"]
mod toss;
use toss::{Law, Toss, board_height, compare, read_folder};

/// Errors above this count no more: such a toss has fallen onto another face, and says nothing of
/// how far it slid.
const CAP: f64 = 0.5;

/// The capped errors of each toss at each value of a parameter.
struct Scan {
    values: Vec<f64>,
    errors: Vec<Vec<f64>>,
}

impl Scan {
    fn new(tosses: &[&Toss], values: &[f64], law: impl Fn(f64) -> Law) -> Result<Scan, SimError> {
        let capped = |toss: &Toss, x| Ok(compare(toss, &law(x))?.corners.min(CAP));
        let of = |toss: &Toss| values.iter().map(|&x| capped(toss, x)).collect();
        let errors = tosses
            .iter()
            .map(|toss| of(toss))
            .collect::<Result<_, _>>()?;
        Ok(Scan {
            values: values.to_vec(),
            errors,
        })
    }

    /// The value of least mean error over the tosses of these indices.
    fn least(&self, tosses: &[usize]) -> f64 {
        let mean = |k: usize| tosses.iter().map(|&i| self.errors[i][k]).sum::<f64>();
        let means: Vec<f64> = (0..self.values.len()).map(mean).collect();
        let best = (0..means.len())
            .min_by(|&a, &b| means[a].total_cmp(&means[b]))
            .unwrap_or(0);
        if best == 0 || best + 1 == means.len() {
            return self.values[best];
        }
        let (low, high) = (means[best - 1] - means[best], means[best + 1] - means[best]);
        let step = 0.5 * (self.values[best + 1] - self.values[best - 1]);
        self.values[best] + 0.5 * step * (low - high) / (low + high).max(f64::MIN_POSITIVE)
    }

    /// The value of least mean error, and its standard error.
    fn estimate(&self) -> (f64, f64) {
        let n = self.errors.len();
        let mut random = 1_u64;
        let mut draw = || {
            // Knuth's MMIX generator; its high bits are good.
            random = random
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            usize::try_from(random >> 33).unwrap_or(0) % n
        };
        let draws: Vec<f64> = (0..1000)
            .map(|_| self.least(&(0..n).map(|_| draw()).collect::<Vec<_>>()))
            .collect();
        let mean = draws.iter().sum::<f64>() / 1000.0;
        let variance = draws.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 999.0;
        (self.least(&(0..n).collect::<Vec<_>>()), variance.sqrt())
    }
}

/// Values around `middle`, `step` apart, none below 0.
fn around(middle: f64, step: f64) -> Vec<f64> {
    (-4..=4)
        .map(|k| middle + step * f64::from(k))
        .filter(|x| *x >= 0.0)
        .collect()
}

/// Mean error over `tosses` and its standard error.
fn score(tosses: &[&Toss], law: &Law) -> Result<(f64, f64), SimError> {
    let errors = tosses
        .iter()
        .map(|toss| compare(toss, law).map(|apart| apart.center))
        .collect::<Result<Vec<_>, _>>()?;
    let n = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / n;
    let variance = errors.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    Ok((mean, (variance / n).sqrt()))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).unwrap_or(
        concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../tests/reference/cube-tosses"
        )
        .into(),
    );
    let tosses = read_folder(&PathBuf::from(folder))?;
    let (fitted, held): (Vec<_>, Vec<_>) = tosses.iter().enumerate().partition(|(i, _)| i % 2 == 0);
    let fitted: Vec<&Toss> = fitted.into_iter().map(|(_, toss)| toss).collect();
    let held: Vec<&Toss> = held.into_iter().map(|(_, toss)| toss).collect();
    let board = board_height(fitted.iter().copied());
    println!(
        "{} tosses to fit, {} held out; board at {:.2} mm",
        fitted.len(),
        held.len(),
        board * 1e3
    );

    let published = Law::published(board);
    let mut best = Law {
        friction: 0.15,
        restitution: 0.1,
        board,
    };
    let coarse = Scan::new(&fitted, &[0.05, 0.1, 0.15, 0.2, 0.25, 0.3], |friction| {
        Law { friction, ..best }
    })?;
    best.friction = coarse.estimate().0;
    let coarse = Scan::new(&fitted, &[0.0, 0.1, 0.2, 0.3], |restitution| Law {
        restitution,
        ..best
    })?;
    best.restitution = coarse.estimate().0;
    let fine = Scan::new(&fitted, &around(best.friction, 0.005), |friction| Law {
        friction,
        ..best
    })?;
    let (friction, friction_error) = fine.estimate();
    best.friction = friction;
    let fine = Scan::new(&fitted, &around(best.restitution, 0.03), |restitution| {
        Law {
            restitution,
            ..best
        }
    })?;
    let (restitution, restitution_error) = fine.estimate();
    best.restitution = restitution;
    println!("friction coefficient {friction:.4} ± {friction_error:.4} (published 0.18)");
    println!("restitution {restitution:.3} ± {restitution_error:.3} (published 0.125)");

    println!("mean error of position, % of the width:         to fit         held out");
    for (name, law) in [
        ("fitted", best),
        ("published", published),
        (
            "fitted, without restitution",
            Law {
                restitution: 0.0,
                ..best
            },
        ),
        (
            "fitted, without friction",
            Law {
                friction: 0.0,
                ..best
            },
        ),
    ] {
        let ((a, da), (b, db)) = (score(&fitted, &law)?, score(&held, &law)?);
        let percent = |x: f64| 100.0 * x;
        println!(
            "{name:<42} {:7.2} ± {:5.2} {:8.2} ± {:5.2}",
            percent(a),
            percent(da),
            percent(b),
            percent(db)
        );
    }
    Ok(())
}
