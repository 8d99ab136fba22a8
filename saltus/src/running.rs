//! What many runs come to: shares with their intervals, and what gas could do.

use saltus_gait::Summary;
use saltus_numeric::statistics::median;
use saltus_robot::Robot;

/// Speeds (m/s, in the direction of the run) over the last 4 s, or over all of a shorter run, from which a robot counts as
/// running.
///
/// Below 1.5 m/s a robot stands or rocks; the high bounce of a fixed
/// gait is at 1.8 m/s, the fast mode above 2.5 m/s.
pub const RUNS_FROM: [f64; 2] = [1.5, 2.5];

/// A share of so many, with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// How many did.
    pub count: usize,
    /// Of how many, > 0.
    pub of: usize,
}

impl Share {
    /// The share; NaN of none.
    pub fn value(&self) -> f64 {
        self.count as f64 / self.of as f64
    }

    /// From and to what the share lies with 95 % confidence; 0 and 1 for a share of none.
    ///
    /// Source: Wilson 1927, the score interval.
    pub fn interval(&self) -> [f64; 2] {
        // The normal distribution's quantile for 97.5 %.
        const Z: f64 = 1.959963984540054;
        if self.of == 0 {
            return [0.0, 1.0];
        }
        let (p, n) = (self.value(), self.of as f64);
        let middle = (p + Z * Z / (2.0 * n)) / (1.0 + Z * Z / n);
        let half = Z / (1.0 + Z * Z / n) * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
        // Round-off must not exclude a share of none or of all.
        let low = if self.count == 0 { 0.0 } else { middle - half };
        let high = if self.count == self.of {
            1.0
        } else {
            middle + half
        };
        [low, high]
    }
}

/// What the runs of many robots came to. Speeds are positive forwards: of runs backwards, the least and the greatest are
/// those in size.
#[derive(Clone, Debug, PartialEq)]
pub struct Together {
    /// Robots that could be simulated.
    pub robots: usize,
    /// Those that ran at the end, for each of [`RUNS_FROM`].
    pub running: [Share; 2],
    /// Speed (m/s) over the last 4 s of those over the first of [`RUNS_FROM`]: least, median,
    /// greatest; none without any.
    pub speed: Option<[f64; 3]>,
    /// Robots that reached 3.2 m/s.
    pub reached: Share,
    /// Time to 3.2 m/s (s) of those that reached it: least and median; none without any.
    pub time_to_3_2: Option<[f64; 2]>,
    /// Robots that reached it within 3 s.
    pub within_3_s: Share,
    /// Speed (m/s) at 1.6 s: median and greatest; none for shorter runs.
    pub speed_at_1_6: Option<[f64; 2]>,
    /// Gas (kg/m) of those that ran: median; none without any.
    pub gas_per_metre: Option<f64>,
}

impl Together {
    /// Of `runs` in one direction, 1 forwards and −1 backwards.
    pub fn of<'s>(runs: &(impl Iterator<Item = &'s Summary> + Clone), sign: f64) -> Together {
        let robots = runs.clone().count();
        let share = |holds: &dyn Fn(&Summary) -> bool| Share {
            count: runs.clone().filter(|run| holds(run)).count(),
            of: robots,
        };
        let running = RUNS_FROM.map(|least| share(&|run| sign * run.late_speed() > least));
        let runners = runs
            .clone()
            .filter(|run| sign * run.late_speed() > RUNS_FROM[0]);
        let speeds = runners.clone().map(|run| sign * run.late_speed());
        let signed = |speed: f64| sign * speed;
        let times = runs.clone().filter_map(|run| run.reached_3_2);
        let starts = runs
            .clone()
            .filter_map(|run| Some(sign * run.speed_at_1_6?));
        let gas = runners.map(|run| run.gas / run.travel.abs());
        Together {
            robots,
            running,
            speed: three(speeds).map(|all| all.map(signed)),
            reached: share(&|run| run.reached_3_2.is_some()),
            time_to_3_2: three(times).map(|[least, middle, _]| [least, middle]),
            within_3_s: share(&|run| run.reached_3_2.is_some_and(|time| time < 3.0)),
            speed_at_1_6: three(starts).map(|[_, middle, most]| [middle, most].map(signed)),
            gas_per_metre: three(gas).map(|[_, middle, _]| middle),
        }
    }
}

/// Least, median and greatest.
fn three(values: impl Iterator<Item = f64>) -> Option<[f64; 3]> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let (first, last) = (*values.first()?, *values.last()?);
    Some([first, median(&mut values), last])
}

/// Work (J/kg) that a kilogram of `robot`'s gas could do at most on its way from the supply to the
/// surroundings: R T ln(p_supply/p_ambient). None for a leg without gas.
pub fn exergy_of_gas(robot: &Robot) -> Option<f64> {
    let cylinder = robot.leg.cylinder()?;
    let ambient = robot.environment.ambient.0;
    let ratio = (ambient + cylinder.supply.0) / ambient;
    Some(cylinder.gas.constant * cylinder.temperature * ratio.ln())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ends of Wilson's interval are the roots of |p − p̂| = z √(p (1 − p)/n).
    #[test]
    fn intervals_solve_wilsons_equation() {
        for (count, of) in [(1, 2), (17, 100), (150, 200), (199, 200)] {
            let share = Share { count, of };
            for p in share.interval() {
                let score = (p - share.value()).abs() / (p * (1.0 - p) / of as f64).sqrt();
                assert!((score - 1.96).abs() < 1e-4, "{count} of {of}: {score}");
            }
        }
        // Of none and of all, the closed forms z²/(n + z²) and its complement.
        assert_eq!(Share { count: 0, of: 0 }.interval(), [0.0, 1.0]);
        let [low, high] = Share { count: 0, of: 10 }.interval();
        assert!(low == 0.0 && (high - 0.27753).abs() < 1e-5, "{high}");
        let [low, high] = Share { count: 10, of: 10 }.interval();
        assert!((low - 0.72247).abs() < 1e-5 && high == 1.0, "{low}");
    }

    #[test]
    fn air_at_120_psi_can_do_186_kj_a_kilogram() {
        let robot = Robot::builtin("rats-run").unwrap();
        let exergy = exergy_of_gas(&robot).unwrap();
        // 287.05 · 293.15 · ln(1 + 827370.8/101325)
        assert!((exergy - 186_427.1).abs() < 0.1, "{exergy}");
        let spring = Robot::builtin("spring-hopper").unwrap();
        assert_eq!(exergy_of_gas(&spring), None);
    }
}
