//! Numbers that can be read and cannot be meant: another unit, or the sign turned round.
//!
//! Every column and setting here has a size that follows from the robot and the run. A size far
//! from it is refused, with the unit that explains it. What real effects do is well within what is
//! allowed: they change sizes by parts, units by tens.

use saltus_diagnosis::{Run, Sort};
use saltus_robot::{Cylinder, Drive, Robot};

use super::Folder;
use super::error::{Error, one_line};

/// Refuses data whose sizes are far from what `robot`, believed to be the one that was measured,
/// and the runs allow.
///
/// # Errors
/// [`Error::Signal`], with the unit that would explain the size.
pub fn plausible(folder: &Folder, robot: Option<&Robot>) -> Result<(), Error> {
    let experiment = &folder.experiment;
    for check in CHECKS
        .iter()
        .filter(|check| check.sorts.contains(&experiment.kind))
    {
        for run in &experiment.runs {
            let view = View {
                columns: &experiment.columns,
                run,
                robot,
            };
            if let Some(symptom) = check.symptom(&view) {
                return Err(Error::signal(one_line(&run.name), check.name, symptom));
            }
        }
    }
    Ok(())
}

/// A column or setting with a size that follows from robot and run.
struct Check {
    sorts: &'static [Sort],
    name: &'static str,
    /// Its size and the size that is expected, in SI and with their signs; none where this run does
    /// not tell.
    sizes: fn(&View<'_>) -> Option<(f64, f64)>,
    /// What the expected size is.
    what: &'static str,
    /// Sizes that are allowed, in terms of the expected one.
    allowed: (f64, f64),
    /// Whether a size beyond them is refused even if no unit explains it.
    strict: bool,
    units: Units,
}

/// Units in which numbers come by mistake: name, and factor to SI.
type Units = &'static [(&'static str, f64)];

const LENGTHS: Units = &[("mm", 1e-3), ("cm", 1e-2), ("in", 0.0254), ("ft", 0.3048)];
const PRESSURES: Units = &[
    ("mbar", 100.0),
    ("kPa", 1e3),
    ("psi", 6_894.757_293_168),
    ("bar", 1e5),
];
const RATES: Units = &[("deg/s", DEGREE), ("rpm", 6.0 * DEGREE)];
const ANGLES: Units = &[("deg", DEGREE)];
const FORCES: Units = &[("lbf", 4.448_221_615_260_5), ("kgf", 9.806_65), ("kN", 1e3)];
const MASSES: Units = &[("g", 1e-3)];
const DEGREE: f64 = std::f64::consts::PI / 180.0;

const FIRED: &[Sort] = &[Sort::Bench, Sort::Hop, Sort::Jump];

const CHECKS: &[Check] = &[
    Check {
        sorts: &[Sort::Bench],
        name: "position_m",
        sizes: |view| Some((view.travel("position_m")?, view.robot?.leg.stroke)),
        what: "the stroke of the leg",
        allowed: (TURNED, 2.0),
        strict: true,
        units: LENGTHS,
    },
    Check {
        sorts: &[Sort::Bench],
        name: "pressure_pa",
        sizes: |view| {
            Some((
                quantile(view.column("pressure_pa")?, 0.95)?,
                view.supply()? + view.ambient()?,
            ))
        },
        what: "the absolute supply pressure",
        allowed: (0.02, 5.0),
        strict: false,
        units: PRESSURES,
    },
    Check {
        sorts: &[Sort::Bench],
        name: "load_mass_kg",
        sizes: |view| {
            let heaviest = view.thrust()? / view.robot?.environment.gravity;
            Some((view.setting("load_mass_kg")?, 0.1 * heaviest))
        },
        what: "a tenth of the heaviest load that the leg lifts",
        allowed: (TURNED, 50.0),
        strict: false,
        units: MASSES,
    },
    Check {
        sorts: FIRED,
        name: "supply_pressure_gauge_pa",
        sizes: |view| Some((view.supply()?, view.cylinder()?.supply.0)),
        what: "the supply pressure of the robot's file",
        allowed: (0.02, 15.0),
        strict: false,
        units: PRESSURES,
    },
    Check {
        sorts: &[Sort::Hop, Sort::Jump],
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
    },
    Check {
        sorts: &[Sort::Hop, Sort::Jump],
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
    },
    Check {
        sorts: &[Sort::Jump],
        name: "wheel_rate_rad_s",
        sizes: |view| view.rates(),
        what: "the slope of wheel_angle_rad before the command",
        allowed: (0.25, 4.0),
        strict: false,
        units: RATES,
    },
    Check {
        sorts: &[Sort::Outcomes],
        name: "omega_rad_s",
        sizes: |view| {
            let robot = view.robot?;
            let lifts = (robot.environment.gravity / robot.body.radius).sqrt();
            Some((quantile(view.column("omega_rad_s")?, 0.5)?, lifts))
        },
        what: "the rate at which a wheel on a rigid leg lifts off",
        allowed: (0.05, 4.0),
        strict: false,
        units: RATES,
    },
    Check {
        sorts: &[Sort::Outcomes],
        name: "apex_m",
        sizes: |view| {
            Some((
                quantile(view.column("apex_m")?, 0.5)?,
                view.rise()? + view.robot?.body.radius,
            ))
        },
        what: "the height that the work of the leg is good for",
        allowed: (TURNED, 3.0),
        strict: false,
        units: LENGTHS,
    },
    Check {
        sorts: &[Sort::Outcomes],
        name: "distance_m",
        sizes: |view| {
            let rate = quantile(view.column("omega_rad_s")?, 0.5)?.abs().min(20.0);
            let (rise, robot) = (view.rise()?, view.robot?);
            // A throw at 45° with the energy of the leg and of the rolling wheel; the wheel's way
            // over its leg comes on top.
            let speed_squared =
                (rate * robot.body.radius).powi(2) + 2.0 * robot.environment.gravity * rise;
            let throw = speed_squared / robot.environment.gravity + 2.0 * robot.body.radius;
            Some((quantile(view.column("distance_m")?, 0.5)?, throw))
        },
        what: "the distance that the work of the leg is good for",
        allowed: (TURNED, 3.0),
        strict: false,
        units: LENGTHS,
    },
    Check {
        sorts: &[Sort::Flight],
        name: "y_m",
        sizes: |view| Some((view.fall("y_m")?, 9.806_65)),
        what: "a fall (m/s²) under gravity",
        allowed: (0.02, 2.0),
        strict: false,
        units: LENGTHS,
    },
    Check {
        sorts: &[Sort::Stroke],
        name: "force_n",
        sizes: |view| {
            let area = std::f64::consts::FRAC_PI_4 * view.setting("bore_m")?.powi(2);
            let pressure = quantile(view.column("pressure_gauge_pa")?, 0.5)?;
            // Friction of the seal is as large as the force of a low pressure.
            (pressure > 5e4).then_some(())?;
            Some((quantile(view.column("force_n")?, 0.5)?, pressure * area))
        },
        what: "pressure times area",
        allowed: (0.35, 5.0),
        strict: false,
        units: FORCES,
    },
    Check {
        sorts: &[Sort::Vessel],
        name: "pressure_pa",
        sizes: |view| {
            let expected = view
                .setting("initial_pressure_pa")?
                .max(view.setting("ambient_pressure_pa")?);
            Some((quantile(view.column("pressure_pa")?, 0.95)?, expected))
        },
        what: "the higher of initial and ambient pressure",
        allowed: (0.05, 4.0),
        strict: false,
        units: PRESSURES,
    },
];

/// A size is explained by a unit in which it is the expected one within this factor.
const NEAR: f64 = 3.0;
/// A size so far below 0, in terms of the expected one, has the wrong sign; noise and offsets are
/// nearer to 0.
const TURNED: f64 = -0.3;

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
        let unit = self
            .units
            .iter()
            .filter(|(_, factor)| far(*factor) < NEAR.ln());
        let unit = unit.min_by(|a, b| far(a.1).total_cmp(&far(b.1)));
        match unit {
            Some((unit, _)) => Some(format!(
                "is {size:.4} in SI, where {what} is {expected:.4}: is it in {unit}?"
            )),
            None if self.strict => Some(format!(
                "is {size:.4}, {ratio:.1} times {what}, {expected:.4}"
            )),
            None => None,
        }
    }
}

/// A run as the checks see it.
struct View<'a> {
    columns: &'a [String],
    run: &'a Run,
    robot: Option<&'a Robot>,
}

impl View<'_> {
    fn column(&self, name: &str) -> Option<&[f64]> {
        let column = self.columns.iter().position(|own| own == name)?;
        Some(&self.run.values[column])
    }

    fn setting(&self, key: &str) -> Option<f64> {
        self.run.settings.get(key).copied()
    }

    fn cylinder(&self) -> Option<&Cylinder> {
        match &self.robot?.leg.drive {
            Drive::Pneumatic(cylinder) => Some(cylinder),
            _ => None,
        }
    }

    /// Gauge pressure (Pa) of the supply, as the operator set it or as the robot has it.
    fn supply(&self) -> Option<f64> {
        self.setting("supply_pressure_gauge_pa")
            .or(Some(self.cylinder()?.supply.0))
    }

    fn ambient(&self) -> Option<f64> {
        Some(self.robot?.environment.ambient.0)
    }

    /// Greatest force (N) of the leg.
    fn thrust(&self) -> Option<f64> {
        Some(self.supply()? * std::f64::consts::FRAC_PI_4 * self.cylinder()?.bore.powi(2))
    }

    /// How high (m) the work of the leg over its stroke lifts the robot.
    fn rise(&self) -> Option<f64> {
        let robot = self.robot?;
        Some(self.thrust()? * robot.leg.stroke / (robot.body.mass * robot.environment.gravity))
    }

    /// Change of a column from before the command to what it is farthest away from that for a
    /// twentieth of the rows.
    fn travel(&self, name: &str) -> Option<f64> {
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
    fn rates(&self) -> Option<(f64, f64)> {
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
    fn fall(&self, name: &str) -> Option<f64> {
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
    let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let count = time.len() as f64;
    let mean = time.iter().sum::<f64>() / count;
    // Polynomials that are orthogonal on these times.
    let first: Vec<f64> = time.iter().map(|t| t - mean).collect();
    let square: Vec<f64> = first.iter().map(|p| p * p).collect();
    let (size, skew) = (sum(&first, &first), sum(&square, &first));
    let second: Vec<f64> = first
        .iter()
        .map(|p| p * p - size / count - skew / size * p)
        .collect();
    let found = [
        sum(&first, &values) / size,
        sum(&second, &values) / sum(&second, &second),
    ];
    found.iter().all(|x| x.is_finite()).then_some(found)
}

/// The value that a share of those that are filled is below.
fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut filled: Vec<f64> = values
        .iter()
        .copied()
        .filter(|value| value.is_finite())
        .collect();
    filled.sort_by(f64::total_cmp);
    // A row.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let row = (share * filled.len().saturating_sub(1) as f64).round() as usize;
    filled.get(row).copied()
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
