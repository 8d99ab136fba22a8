//! Numbers that can be read and cannot be meant: another unit, or the sign turned round.
//!
//! Every column and setting here has a size that follows from the robot and the run. A size far
//! from it is refused, with the unit that explains it. What real effects do is well within what is
//! allowed: they change sizes by parts, units by tens.

mod motion;

use saltus_numeric::statistics::{dot, quantile};
use saltus_robot::{Cylinder, Drive, Robot};

use crate::experiment::{Experiment, Run};
use crate::mechanism::Mechanism;
pub(crate) use motion::{FORCES_AND_BORES, LINKS, PENDULUM, PLACES, SLIDE};

/// A column or a setting of a run whose size cannot be meant.
#[derive(Clone, Debug, PartialEq)]
pub struct Implausible {
    /// The run's file.
    pub run: String,
    /// The column or the setting.
    pub name: String,
    /// What its size is and what is expected, with the unit that would explain it.
    pub symptom: String,
}

/// The first column or setting of an experiment whose size is far from what `robot`, believed to be
/// the one that was measured, and the runs allow.
pub fn implausible(experiment: &Experiment, robot: Option<&Robot>) -> Option<Implausible> {
    let spec = experiment.kind.spec();
    // A check of a family is of each of its columns.
    let is_own = |check: &Check, name: &str| {
        let is_family = check.name.contains('*');
        name == check.name || (is_family && spec.family(name) == Some(check.name))
    };
    let of = |check: &Check| {
        let columns = experiment.columns.iter().map(String::as_str);
        let columns = columns.filter(|name| is_own(check, name));
        let setting = (!check.name.contains('*')).then_some(check.name);
        let mut names = columns.map(Some).chain([setting]).flatten();
        names.find_map(|name| {
            experiment.runs.iter().find_map(|run| {
                let view = View {
                    columns: &experiment.columns,
                    name,
                    run,
                    robot,
                    mechanism: experiment.mechanism.as_ref(),
                };
                Some(Implausible {
                    symptom: check.symptom(&view)?,
                    run: run.name.clone(),
                    name: name.to_owned(),
                })
            })
        })
    };
    spec.checks.iter().find_map(of)
}

/// A column or setting with a size that follows from robot and run.
#[derive(Debug)]
pub struct Check {
    pub(crate) name: &'static str,
    /// Its size and the size that is expected, in SI and with their signs; none where this run does
    /// not tell.
    pub(crate) sizes: fn(&View<'_>) -> Option<(f64, f64)>,
    /// What the expected size is.
    pub(crate) what: &'static str,
    /// Sizes that are allowed, in terms of the expected one.
    pub(crate) allowed: (f64, f64),
    /// Whether a size beyond them is refused even if no unit explains it.
    pub(crate) strict: bool,
    pub(crate) units: Units,
}

/// Units in which numbers come by mistake: name, and factor to SI.
pub(crate) type Units = &'static [(&'static str, f64)];

pub(crate) const LENGTHS: Units = &[("mm", 1e-3), ("cm", 1e-2), ("inch", 0.0254), ("ft", 0.3048)];
/// The same of what is never near 0: its name may have another unit than its numbers.
pub(crate) const JUMPS: Units = &[
    ("mm", 1e-3),
    ("cm", 1e-2),
    ("inch", 0.0254),
    ("ft", 0.3048),
    ("m, and not in mm as its name says", 1e3),
    ("m, and not in cm as its name says", 1e2),
];
pub(crate) const PRESSURES: Units = &[
    ("mbar", 100.0),
    ("kPa", 1e3),
    ("psi", 6_894.757_293_168),
    ("bar", 1e5),
];
/// Units of a clock.
pub(crate) const TIMES: Units = &[("ms", 1e-3)];
/// The same of what a camera sees.
pub(crate) const FRAMES: Units = &[("ms", 1e-3), ("frames of a camera", 1.0 / 60.0)];
pub(crate) const RATES: Units = &[("deg/s", DEGREE), ("rpm", 6.0 * DEGREE)];
pub(crate) const ANGLES: Units = &[("deg", DEGREE)];
pub(crate) const MASSES: Units = &[("g", 1e-3)];
const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// The supply of a firing.
pub(crate) const SUPPLY: Check = Check {
    name: "supply_pressure_gauge_pa",
    sizes: |view| Some((view.supply()?, view.cylinder()?.supply.0)),
    what: "the supply pressure of the robot's file",
    allowed: (0.02, 15.0),
    strict: false,
    units: PRESSURES,
};

/// The pivot of a boom in a hop or a jump.
pub(crate) const PIVOT: Check = Check {
    name: "pivot_angle_rad",
    sizes: |view| {
        let boom = view.robot?.boom?.length;
        Some((
            quantile(view.column("pivot_angle_rad")?, 0.95)?,
            (view.rise()? / boom).min(1.0),
        ))
    },
    what: "the pivot angle that the work of the leg is good for",
    allowed: (TURNED, 3.0),
    strict: false,
    units: ANGLES,
};

/// The height of the axle in a hop or a jump.
pub(crate) const HEIGHT: Check = Check {
    name: "y_m",
    sizes: |view| {
        Some((
            quantile(view.column("y_m")?, 0.95)?,
            view.rise()? + view.robot?.body.radius,
        ))
    },
    what: "the height that the work of the leg is good for",
    allowed: (TURNED, 3.0),
    strict: false,
    units: LENGTHS,
};

/// The clock of a run, by the length (s) of the run and the length that is expected.
pub(crate) const fn clock(sizes: fn(&View<'_>) -> Option<(f64, f64)>, units: Units) -> Check {
    Check {
        name: "time_s",
        sizes,
        what: "the time that such a motion takes",
        allowed: (0.0, 15.0),
        strict: false,
        units,
    }
}

/// A size is explained by a unit in which it is the expected one within this factor.
const NEAR: f64 = 3.0;
/// A size so far below 0, in terms of the expected one, has the wrong sign; noise and offsets are
/// nearer to 0.
pub(crate) const TURNED: f64 = -0.3;

impl Check {
    /// What is wrong with the sizes of a run, if anything.
    fn symptom(&self, view: &View<'_>) -> Option<String> {
        let (size, expected) = (self.sizes)(view)?;
        let ratio = size / expected;
        let (low, high) = self.allowed;
        let what = self.what;
        if !ratio.is_finite() || (low..=high).contains(&ratio) {
            return None;
        }
        if ratio < TURNED {
            return Some(format!(
                "is {size:.4}, where {what} is {expected:.4}: is its sign turned round?"
            ));
        }
        let far = |factor: f64| (ratio.abs() * factor).ln().abs();
        let units = self.units.iter();
        let mut near: Vec<_> = units.filter(|unit| far(unit.1) < NEAR.ln()).collect();
        near.sort_by(|a, b| far(a.1).total_cmp(&far(b.1)));
        let near: Vec<&str> = near.into_iter().map(|unit| unit.0).collect();
        match near.join(", or in ") {
            none if none.is_empty() => self
                .strict
                .then(|| format!("is {size:.4}, {ratio:.1} times {what}, {expected:.4}")),
            units => Some(format!(
                "is {size:.4} in SI, where {what} is {expected:.4}: is it in {units}?"
            )),
        }
    }
}

/// A run as the checks see it.
pub struct View<'a> {
    columns: &'a [String],
    /// The column or setting that is looked at.
    pub(crate) name: &'a str,
    pub(crate) run: &'a Run,
    pub(crate) robot: Option<&'a Robot>,
    pub(crate) mechanism: Option<&'a Mechanism>,
}

impl View<'_> {
    pub(crate) fn column(&self, name: &str) -> Option<&[f64]> {
        let column = self.columns.iter().position(|own| own == name)?;
        Some(&self.run.values[column])
    }

    pub(crate) fn setting(&self, key: &str) -> Option<f64> {
        self.run.settings.get(key).copied()
    }

    pub(crate) fn cylinder(&self) -> Option<&Cylinder> {
        match &self.robot?.leg.drive {
            Drive::Pneumatic(cylinder) => Some(cylinder),
            _ => None,
        }
    }

    /// Mean rate (rad/s) of the gyro over a run, and of the wheel's angle; none of a wheel that turns
    /// less than once.
    pub(crate) fn mean_rates(&self) -> Option<(f64, f64)> {
        let gyro = self.column("wheel_rate_rad_s")?;
        let angle = self.column("wheel_angle_rad")?;
        let rates: Vec<f64> = gyro.iter().copied().filter(|x| x.is_finite()).collect();
        let mut angles = (self.run.time.iter().zip(angle)).filter(|(_, x)| x.is_finite());
        let (first, last) = (angles.next()?, angles.next_back()?);
        let turned = last.1 - first.1;
        let mean = rates.iter().sum::<f64>() / rates.len().max(1) as f64;
        (turned.abs() > std::f64::consts::TAU).then_some((mean, turned / (last.0 - first.0)))
    }

    /// Greatest pivot angle (rad) but for a few rows, and that of a hop as high as the wheel's radius.
    pub(crate) fn highest_pivot(&self) -> Option<(f64, f64)> {
        let robot = self.robot?;
        let highest = quantile(self.column("pivot_angle_rad")?, 0.95)?;
        Some((highest, (robot.body.radius / robot.boom?.length).min(1.0)))
    }

    /// From the least to the greatest value of a column but for a twentieth of its rows at each end.
    pub(crate) fn span(&self, name: &str) -> Option<f64> {
        let values = self.column(name)?;
        Some(quantile(values, 0.95)? - quantile(values, 0.05)?)
    }

    /// Time (s) from the first to the last row.
    pub(crate) fn length(&self) -> Option<f64> {
        Some(self.run.time.last()? - self.run.time.first()?).filter(|length| *length > 0.0)
    }

    /// Length (s) of a run, and what it is if accelerations that are `measured` are those that are `able` to be.
    pub(crate) fn paced(&self, able: f64, measured: f64) -> Option<(f64, f64)> {
        let length = self.length()?;
        (able > 0.0).then_some((length, length * (measured / able).sqrt()))
    }

    /// Distance (m) of a throw at 45° with the energy of the leg and of a wheel that rolls at `rate`
    /// (rad/s); the wheel's way over its leg comes on top.
    pub(crate) fn throw(&self, rate: f64) -> Option<f64> {
        let (rise, robot) = (self.rise()?, self.robot?);
        let (radius, gravity) = (robot.body.radius, robot.environment.gravity);
        let speed_squared = (rate.abs().min(20.0) * radius).powi(2) + 2.0 * gravity * rise;
        Some(speed_squared / gravity + 2.0 * radius)
    }

    /// Gauge pressure (Pa) of the supply, as the operator set it or as the robot has it.
    pub(crate) fn supply(&self) -> Option<f64> {
        self.setting("supply_pressure_gauge_pa")
            .or(Some(self.cylinder()?.supply.0))
    }

    pub(crate) fn ambient(&self) -> Option<f64> {
        Some(self.robot?.environment.ambient.0)
    }

    /// Greatest force (N) of the leg.
    pub(crate) fn thrust(&self) -> Option<f64> {
        Some(self.supply()? * std::f64::consts::FRAC_PI_4 * self.cylinder()?.bore.powi(2))
    }

    /// How high (m) the work of the leg over its stroke lifts the robot.
    pub(crate) fn rise(&self) -> Option<f64> {
        let robot = self.robot?;
        Some(self.thrust()? * robot.leg.stroke / (robot.body.mass * robot.environment.gravity))
    }

    /// Change of a column from before the command to what it is farthest away from that for a
    /// twentieth of the rows.
    pub(crate) fn travel(&self, name: &str) -> Option<f64> {
        let values = self.column(name)?;
        let open = self.run.valve?.0;
        let before = self
            .run
            .time
            .partition_point(|time| *time <= open)
            .clamp(1, values.len());
        let rest = quantile(&values[..before], 0.5)?;
        let ends = [0.05, 0.95].map(|share| quantile(values, share).map(|value| value - rest));
        ends.into_iter()
            .flatten()
            .max_by(|a, b| a.abs().total_cmp(&b.abs()))
    }

    /// The gyro's mean and the slope (rad/s) of the wheel's angle before the command.
    pub(crate) fn rates(&self) -> Option<(f64, f64)> {
        let (angle, rate) = (
            self.column("wheel_angle_rad")?,
            self.column("wheel_rate_rad_s")?,
        );
        let open = self.run.valve?.0;
        let rows = self.run.time.partition_point(|time| *time <= open);
        let [slope, _] = slope_and_bend(&self.run.time[..rows], &angle[..rows])?;
        // A turn of a few counts has no slope.
        (slope.abs() > 0.3).then_some((quantile(&rate[..rows], 0.5)?, slope))
    }

    /// Acceleration (m/s²) downwards.
    pub(crate) fn fall(&self, name: &str) -> Option<f64> {
        let time = &self.run.time;
        let long = time.last()? - time.first()? > 0.1;
        let [_, bend] = slope_and_bend(time, self.column(name)?)?;
        long.then_some(-2.0 * bend)
    }
}

/// Slope of the line, and half the second derivative of the parabola, that are nearest to a column.
fn slope_and_bend(time: &[f64], values: &[f64]) -> Option<[f64; 2]> {
    let (time, values): (Vec<f64>, Vec<f64>) = time
        .iter()
        .zip(values)
        .filter(|(_, value)| value.is_finite())
        .unzip();
    let count = time.len() as f64;
    let mean = time.iter().sum::<f64>() / count;
    // Polynomials that are orthogonal on these times.
    let first: Vec<f64> = time.iter().map(|t| t - mean).collect();
    let square: Vec<f64> = first.iter().map(|p| p * p).collect();
    let (size, skew) = (dot(&first, &first), dot(&square, &first));
    let second: Vec<f64> = first
        .iter()
        .map(|p| p * p - size / count - skew / size * p)
        .collect();
    let found = [
        dot(&first, &values) / size,
        dot(&second, &values) / dot(&second, &second),
    ];
    found.iter().all(|x| x.is_finite()).then_some(found)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_found() {
        let time: Vec<f64> = (0..20).map(|i| 0.1 * f64::from(i * i)).collect();
        let values: Vec<f64> = time.iter().map(|t| 3.0 + 2.0 * t - 0.5 * t * t).collect();
        assert!((slope_and_bend(&time, &values).unwrap()[1] + 0.5).abs() < 1e-9);
        let line: Vec<f64> = time.iter().map(|t| 1.0 - 4.0 * t).collect();
        let [slope, bend] = slope_and_bend(&time, &line).unwrap();
        assert!(
            (slope + 4.0).abs() < 1e-9 && bend.abs() < 1e-9,
            "{slope} {bend}"
        );
        assert_eq!(slope_and_bend(&[1.0, 2.0], &[1.0, f64::NAN]), None);
    }
}
