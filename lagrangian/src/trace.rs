//! A stance in full: its course, the ground's reaction, and where the energy went.

use saltus_numeric::root::greatest;
use saltus_numeric::{Single, dop853};

use crate::advance::index::{EXTENSION, LEAN, RATE, SPEED, TIME};
use crate::advance::{CHECKED, State, WIDE, WIDTH, Wide};
use crate::observer::{Observer, Unobserved};
use crate::phase::{Drives, Extension, Held};
use crate::{Contact, Launch, LiftOff, Reaction, Stance, StanceError};

/// A stance with what happened on the way.
#[derive(Clone, Debug)]
pub struct Trace<S = f64> {
    /// How it ended.
    pub lift_off: LiftOff<S>,
    /// Its course: every integration step in `samples_per_step` parts.
    pub samples: Vec<Sample<S>>,
    /// The ground's reaction along the whole stance.
    pub contact: Contact<S>,
    /// Work and energy.
    pub energy: EnergyLedger<S>,
}

/// The robot at an instant of its stance.
#[derive(Clone, Copy, Debug)]
pub struct Sample<S = f64> {
    /// Time (s) from the start.
    pub time: S,
    /// Lean φ (rad).
    pub lean: S,
    /// Lean rate ω (rad/s).
    pub rate: S,
    /// Extension d (m).
    pub extension: S,
    /// Extension rate ḋ (m/s).
    pub extension_rate: S,
    /// Chamber pressure (Pa, absolute); the ambient one for a leg without a chamber.
    pub pressure: S,
    /// The ground's force on the foot.
    pub reaction: Reaction<S>,
}

/// Where the energy of a stance comes from and goes to (J). It closes: `drive` − `losses` −
/// `springs` = Δ(`kinetic` + `potential`).
#[derive(Clone, Copy, Debug)]
pub struct EnergyLedger<S = f64> {
    /// Work of the drive (the gas) on the leg.
    pub drive: S,
    /// Taken by friction, seal and cushion damping.
    pub losses: S,
    /// Change of the kinetic energy.
    pub kinetic: S,
    /// Change of the potential energy of the weight.
    pub potential: S,
}

impl EnergyLedger<f64> {
    /// What is left unexplained (J).
    pub fn residual(&self) -> f64 {
        self.drive - self.losses - self.kinetic - self.potential
    }
}

/// Parts into which each integration step is divided for samples and quadrature.
const PARTS: usize = 8;
/// Golden sections of two such parts, to 1e-9 of the step.
const SECTIONS: u32 = 41;

/// Gauss–Legendre nodes (on [0, 1]) and weights of 5 points, exact to degree 9, for the work within
/// a step.
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_24),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_24),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

impl<S: Single> Stance<S> {
    /// As [`Stance::trace`], which stands for each kind of number.
    pub(crate) fn recorded(&self, launch: &Launch<S>) -> Result<Trace<S>, StanceError> {
        // What cannot be integrated says so sooner without a record of each of its many steps.
        self.run(launch, &mut Unobserved)?;
        let mut recorder = Recorder::new(self);
        let lift_off = self.run(launch, &mut recorder)?;
        Ok(recorder.finish(lift_off))
    }

    /// As [`Stance::way`], which stands for each kind of number.
    pub(crate) fn passed(&self, launch: &Launch<S>) -> Result<Vec<Sample<S>>, StanceError> {
        let mut way = Way {
            stance: self,
            samples: Vec::new(),
        };
        self.run(launch, &mut way)?;
        Ok(way.samples)
    }
}

/// Parts of an integration step in a [`Way`].
const STRIDES: usize = 3;

/// The course of a stance alone.
struct Way<'a, S: Single> {
    stance: &'a Stance<S>,
    samples: Vec<Sample<S>>,
}

impl<S: Single> Way<'_, S> {
    fn step<const W: usize>(&mut self, phase: &dyn Drives<S, W>, from: &[S; W], to: &[S; W]) {
        let start = phase.at(from);
        let length = to[TIME] - from[TIME];
        let (checked, tolerance) = (CHECKED, self.stance.tolerance);
        for i in usize::from(!self.samples.is_empty())..=STRIDES {
            let y = match i {
                0 => *from,
                STRIDES => *to,
                _ => {
                    let part = length * S::of(i as f64 / STRIDES as f64);
                    dop853::step(phase, from, &start, part, checked, tolerance).state
                }
            };
            self.samples.push(self.stance.sample(phase, &y));
        }
    }
}

impl<S: Single> Observer<S> for Way<'_, S> {
    fn held(&mut self, phase: &Held<'_, S>, from: &State<S>, to: &State<S>) {
        self.step(phase, from, to);
    }
    fn extension(&mut self, phase: &Extension<'_, S>, from: &State<S>, to: &State<S>) {
        self.step(phase, from, to);
    }
    fn fed(&mut self, phase: &dyn Drives<S, WIDE>, from: &Wide<S>, to: &Wide<S>) {
        self.step(phase, from, to);
    }
}

struct Recorder<'a, S: Single> {
    stance: &'a Stance<S>,
    samples: Vec<Sample<S>>,
    contact: Contact<S>,
    drive: S,
    losses: S,
    first: Option<State<S>>,
    last: Option<State<S>>,
}

impl<S: Single> Observer<S> for Recorder<'_, S> {
    fn held(&mut self, phase: &Held<'_, S>, from: &State<S>, to: &State<S>) {
        self.step(phase, from, to);
    }
    fn extension(&mut self, phase: &Extension<'_, S>, from: &State<S>, to: &State<S>) {
        self.step(phase, from, to);
    }
    fn fed(&mut self, phase: &dyn Drives<S, WIDE>, from: &Wide<S>, to: &Wide<S>) {
        self.step(phase, from, to);
    }
}

/// The part of a state that all have.
fn common<S: Single, const W: usize>(y: &[S; W]) -> State<S> {
    let mut common = [S::of(0.0); WIDTH];
    common.copy_from_slice(&y[..WIDTH]);
    common
}

impl<'a, S: Single> Recorder<'a, S> {
    fn new(stance: &'a Stance<S>) -> Self {
        let zero = S::of(0.0);
        Recorder {
            stance,
            samples: Vec::new(),
            contact: Contact::none(),
            drive: zero,
            losses: zero,
            first: None,
            last: None,
        }
    }

    /// Takes in the step of `phase` between two states. A state inside a step is a shorter step.
    fn step<const W: usize>(&mut self, phase: &dyn Drives<S, W>, from: &[S; W], to: &[S; W]) {
        self.first.get_or_insert(common(from));
        self.last = Some(common(to));
        let start = phase.at(from);
        let length = to[TIME] - from[TIME];
        let inside = |fraction: f64| match fraction {
            0.0 => *from,
            1.0 => *to,
            _ => {
                dop853::step(
                    phase,
                    from,
                    &start,
                    length * S::of(fraction),
                    CHECKED,
                    self.stance.tolerance,
                )
                .state
            }
        };
        for (x, weight) in GAUSS {
            let y = inside(x);
            let (drive, force) = phase.forces(&y);
            let share = y[SPEED] * length * S::of(weight);
            self.drive = self.drive + drive * share;
            self.losses = self.losses + (drive - force) * share;
        }
        let at = |fraction: f64| self.stance.sample(phase, &inside(fraction));
        let parts: Vec<Sample<S>> = (0..=PARTS).map(|i| at(i as f64 / PARTS as f64)).collect();
        for (i, here) in parts.iter().enumerate() {
            let neighbours = i.checked_sub(1).map(|j| &parts[j]).zip(parts.get(i + 1));
            // Between samples an extremum shows as a middle sample that beats both neighbours.
            let refined = neighbours
                .map(|(a, b)| (a.reaction, b.reaction))
                .map(|(a, b)| {
                    let refine = |measure: &dyn Fn(&Reaction<S>) -> f64| {
                        (measure(&here.reaction) > measure(&a)
                            && measure(&here.reaction) >= measure(&b))
                        .then(|| {
                            let (centre, width) = (i as f64 / PARTS as f64, 1.0 / PARTS as f64);
                            let f = |x| measure(&at(x).reaction);
                            at(greatest(centre - width, centre + width, SECTIONS, f))
                        })
                    };
                    (refine(&|r| -r.normal.value()), refine(&Reaction::demand))
                });
            let (normal, friction) = refined.unwrap_or((None, None));
            for found in [Some(*here), normal, friction].into_iter().flatten() {
                self.contact.extend(found.time.value(), &found.reaction);
            }
        }
        let skip = usize::from(!self.samples.is_empty());
        self.samples.extend(parts.into_iter().skip(skip));
    }

    fn finish(self, lift_off: LiftOff<S>) -> Trace<S> {
        let zero = S::of(0.0);
        let ends = self.first.zip(self.last);
        let (kinetic, potential) = ends.map_or((zero, zero), |(a, b)| {
            let ((ka, pa), (kb, pb)) = (self.stance.energy(&a), self.stance.energy(&b));
            (kb - ka, pb - pa)
        });
        Trace {
            lift_off,
            samples: self.samples,
            contact: self.contact,
            energy: EnergyLedger {
                drive: self.drive,
                losses: self.losses,
                kinetic,
                potential,
            },
        }
    }
}

impl<S: Single> Stance<S> {
    fn sample<const W: usize>(&self, phase: &dyn Drives<S, W>, y: &[S; W]) -> Sample<S> {
        Sample {
            time: y[TIME],
            lean: y[LEAN],
            rate: y[RATE],
            extension: y[EXTENSION],
            extension_rate: y[SPEED],
            pressure: phase.gas_pressure(y),
            reaction: self.reaction(y, &phase.at(y)),
        }
    }
}
