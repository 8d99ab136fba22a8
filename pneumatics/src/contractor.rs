//! A muscle in a leg: it contracts as the leg extends, through a lever and a tendon.

use saltus_numeric::{Scalar, Single};
use saltus_robot::{Cylinder, Robot, Term};

use crate::muscle::Muscle;

/// A muscle with its lever and its tendon.
#[derive(Clone, Copy, Debug)]
pub struct Contractor<S> {
    /// The muscle, in plain numbers: for roots.
    plain: Muscle,
    /// Its force and its slope: see [`Muscle`].
    force: S,
    slope: S,
    /// Volume at its full length (m³), what is beside it included.
    volume: S,
    /// Contraction of the muscle with its tendon for each metre of the leg.
    lever: S,
    /// Compliance of the tendon (m/N).
    compliance: S,
}

/// What a muscle does at an extension and a gauge pressure, and how that changes.
#[derive(Clone, Copy, Debug)]
pub struct Contracted<S> {
    /// Force on the wheel (N), by extension (N/m) and by pressure (m²).
    pub force: [S; 3],
    /// Volume (m³), by extension (m²) and by pressure (m³/Pa).
    pub volume: [S; 3],
}

/// A muscle alone, at a contraction and a gauge pressure: pull (N) and volume (m³), each by
/// contraction and by pressure.
struct Alone<S> {
    pull: [S; 3],
    volume: [S; 3],
}

impl<S: Scalar> Contractor<S> {
    /// The muscle of `cylinder`, if it is one.
    pub(crate) fn new(
        robot: &Robot,
        cylinder: &Cylinder,
        lift: impl Fn(Term, f64) -> S,
    ) -> Option<Contractor<S>> {
        let muscle = cylinder.muscle?;
        // Where the polynomial of the free contraction falls again it is not meant.
        let most = Muscle::rising_to(muscle.free_contraction, cylinder.supply.0.max(1.0));
        let compliance = S::of(1.0) / lift(Term::TendonStiffness, muscle.tendon_stiffness);
        Some(Contractor {
            plain: Muscle {
                volume: cylinder.dead_volume,
                force: muscle.force,
                slope: muscle.slope,
                reach: muscle.free_contraction,
                most,
            },
            force: lift(Term::MuscleForce, muscle.force),
            slope: lift(Term::MuscleSlope, muscle.slope),
            volume: lift(Term::DeadVolume, cylinder.dead_volume) + tube_volume(robot, &lift),
            lever: lift(Term::MuscleLever, muscle.lever),
            compliance: if muscle.tendon_stiffness.is_finite() {
                compliance
            } else {
                S::of(0.0)
            },
        })
    }
}

/// Volume (m³) of the tube of the leg of `robot`, 0 without one.
pub(crate) fn tube_volume<S: Scalar>(robot: &Robot, lift: &impl Fn(Term, f64) -> S) -> S {
    let tube = robot.leg.cylinder().and_then(|cylinder| cylinder.tube);
    tube.filter(|tube| tube.length > 0.0)
        .map_or(S::of(0.0), |tube| {
            let diameter = lift(Term::TubeDiameter, tube.diameter);
            let length = lift(Term::TubeLength, tube.length);
            S::of(std::f64::consts::PI) * diameter * diameter * length / S::of(4.0)
        })
}

impl<S: Single> Contractor<S> {
    /// The muscle at extension `d` (m) and gauge pressure `pressure` (Pa).
    ///
    /// The pull T through the tendon obeys T = f(x, p) with the contraction x = r d + c T.
    pub fn at(&self, d: S, pressure: S) -> Contracted<S> {
        let (one, travel) = (S::of(1.0), self.lever * d);
        let pull =
            self.plain
                .pull_through(self.compliance.value(), travel.value(), pressure.value());
        // One Newton step more carries derivatives.
        let guess = S::of(pull);
        let near = self.alone(self.compliance.mul_add(guess, travel), pressure);
        let give = one - self.compliance * near.pull[1];
        let pull = guess + (near.pull[0] - guess) / give;
        let alone = self.alone(self.compliance.mul_add(pull, travel), pressure);
        let [_, by_contraction, by_pressure] = alone.pull;
        let give = one - self.compliance * by_contraction;
        let (by_travel, by_pressure) = (by_contraction / give, by_pressure / give);
        let [volume, grows, swells] = alone.volume;
        // How the contraction itself goes with the leg and with the pressure.
        let along = self.lever * (one + self.compliance * by_travel);
        let across = self.compliance * by_pressure;
        Contracted {
            force: [
                self.lever * pull,
                self.lever * self.lever * by_travel,
                self.lever * by_pressure,
            ],
            volume: [volume, grows * along, grows.mul_add(across, swells)],
        }
    }

    /// The muscle alone: [`Muscle`], with derivatives.
    fn alone(&self, x: S, pressure: S) -> Alone<S> {
        /// As that of [`Muscle`].
        const LEAST: f64 = 1.0;
        let (zero, of) = (S::of(0.0), S::of);
        let (a, b) = (self.force, self.slope);
        let p = if pressure.value() > 0.0 {
            pressure
        } else {
            zero
        };
        // Where the free contraction stays as it is.
        let stays = pressure.value() <= LEAST || pressure.value() >= self.plain.most;
        let at = if stays {
            of(pressure.value().max(LEAST).min(self.plain.most))
        } else {
            pressure
        };
        let reach = &self.plain.reach;
        let end = reach
            .iter()
            .rev()
            .fold(zero, |sum, c| sum.mul_add(at, of(*c)));
        let powers = (1..5_u8).zip(&reach[1..]).rev();
        let slope = powers.fold(zero, |sum, (k, c)| sum.mul_add(at, of(f64::from(k) * c)));
        let end_by_pressure = if stays { zero } else { slope };
        let inverse = of(1.0) / end;
        let (two, three, six) = (of(2.0), of(3.0), of(6.0));
        let square = (two * b * end - three * a) * inverse * inverse;
        let cube = (two * a - b * end) * inverse * inverse * inverse;
        let square_by_end = (six * a - two * b * end) * inverse * inverse * inverse;
        let cube_by_end = (two * b * end - six * a) * inverse * inverse * inverse * inverse;
        let is_free = x.value() >= end.value();
        let x = if is_free { end } else { x };
        let is_stretched = x.value() < 0.0;
        let (square, cube) = if is_stretched {
            (zero, zero)
        } else {
            (square, cube)
        };
        let (square_by_end, cube_by_end) = if is_stretched {
            (zero, zero)
        } else {
            (square_by_end, cube_by_end)
        };
        let each = a + x * (x * (square + x * cube) - b);
        let each_by_x = x * (two * square + three * x * cube) - b;
        let each_by_end = x * x * (square_by_end + x * cube_by_end);
        let grown = x * (a + x * (x * (square / three + x * cube / of(4.0)) - b / two));
        let grown_by_end = x * x * x * (square_by_end / three + x * cube_by_end / of(4.0));
        let (each, each_by_x, each_by_end) = if is_free {
            (zero, zero, zero)
        } else {
            (each, each_by_x, each_by_end)
        };
        let by_pressure = each + p * each_by_end * end_by_pressure;
        Alone {
            pull: [
                p * each,
                p * each_by_x,
                if p.value() > 0.0 { by_pressure } else { zero },
            ],
            volume: [self.volume + grown, each, grown_by_end * end_by_pressure],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The muscle of the jumping robot of `GTDynamics`.
    fn contractor(tendon: f64) -> Contractor<f64> {
        let (cm, kpa) = (1e-2, 1e3_f64);
        let reach = [
            3.055_839_30,
            7.583_616_26e-2,
            -4.915_797_71e-4,
            1.427_926_18e-6,
            -1.548_174_77e-9,
        ];
        let mut power = cm;
        let reach = reach.map(|c| {
            let x = c * power;
            power /= kpa;
            x
        });
        let most = Muscle::rising_to(reach, 4.5e5);
        Contractor {
            plain: Muscle {
                volume: 4.243e-5,
                force: 1.966_409e-3,
                slope: 0.355_416e-3 / cm,
                reach,
                most,
            },
            force: 1.966_409e-3,
            slope: 0.355_416e-3 / cm,
            volume: 4.243e-5,
            lever: 0.8,
            compliance: if tendon.is_finite() {
                1.0 / tendon
            } else {
                0.0
            },
        }
    }

    #[test]
    fn a_free_contraction_may_be_the_same_at_all_pressures() {
        for slope in [0.0, -1e-7] {
            let mut leg = contractor(f64::INFINITY);
            leg.plain.reach = [0.03, slope, 0.0, 0.0, 0.0];
            leg.plain.most = Muscle::rising_to(leg.plain.reach, 4.5e5);
            assert_eq!(leg.plain.free_contraction(2e5), 0.03);
            let pull = leg.plain.at(2e5).pull(0.008);
            assert!(pull > 0.0 && (leg.at(0.01, 2e5).force[0] - 0.8 * pull).abs() < 1e-9 * pull);
        }
    }

    #[test]
    fn it_is_the_muscle_and_its_derivatives_are_those_of_differences() {
        for tendon in [f64::INFINITY, 8200.0, 4000.0] {
            let leg = contractor(tendon);
            for d in [0.0, 0.01, 0.03, 0.05] {
                for p in [2e4, 1e5, 2.5e5, 4.4e5] {
                    let found = leg.at(d, p);
                    let pull = leg.plain.pull_through(leg.compliance, leg.lever * d, p);
                    assert!((found.force[0] - leg.lever * pull).abs() < 1e-6 * (1.0 + pull));
                    let x = leg.lever * d + leg.compliance * pull;
                    let volume = leg.plain.at(p).volume(x);
                    assert!((found.volume[0] - volume).abs() < 1e-9 * volume, "{d} {p}");
                    let (h, k) = (1e-6, 1.0);
                    for (what, of) in [("force", 0), ("volume", 1)] {
                        let number = |at: Contracted<f64>| [at.force, at.volume][of][0];
                        let by = [found.force, found.volume][of];
                        let along =
                            (number(leg.at(d + h, p)) - number(leg.at(d - h, p))) / (2.0 * h);
                        let across =
                            (number(leg.at(d, p + k)) - number(leg.at(d, p - k))) / (2.0 * k);
                        let size = (by[1].abs() + along.abs()).max(1e-6);
                        // Second order in the step, on what bends in centimetres and kilopascals.
                        assert!(
                            (by[1] - along).abs() < 1e-4 * size,
                            "{what} {tendon} {d} {p}: {by:?} {along}"
                        );
                        let size = by[2].abs() + across.abs() + 1e-12;
                        assert!(
                            (by[2] - across).abs() < 1e-4 * size,
                            "{what} {tendon} {d} {p}: {by:?} {across}"
                        );
                    }
                }
            }
        }
    }
}
