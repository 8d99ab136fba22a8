//! The fitted simulation: one jump of a robot, fast enough to be fitted to data.
//!
//! It has the model of the multi-body simulation in the five coordinates that one leg on the ground
//! needs (docs/model.md, "The simulation that is fitted to data"). The two share the force of the
//! leg and nothing else. `diagnosis/tests/rig.rs` compares them for every term of a robot file.
//!
//! | file | content |
//! | --- | --- |
//! | `bodies.rs` | the robot as rigid bodies |
//! | `machine.rs` | kinematics, mass matrix, forces |
//! | `contact.rs` | the foot on the ground: constraint rows, contact modes, accelerations |
//! | `gas.rs` | the gas behind the leg |
//! | `fed.rs` | the gas behind a leg that is fed from a tank, through a tube, or by a valve that moves in time |
//! | `guards.rs` | guards of each mode, and the mode changes at their events |
//! | `run.rs` | steps from event to event |
//! | `course.rs` | the result: states at knots, and what sensors would read between them |

use std::sync::Arc;

mod bodies;
mod contact;
mod course;
mod fed;
mod floor;
mod gas;
mod guard;
mod machine;
mod modes;
mod run;

pub use course::{BoomPose, Course, Pose};
use machine::Machine;
use run::{LONG, Run, Slide};
use saltus_pneumatics::Leg;
use saltus_robot::{Drive, Robot};

/// Terms of the motion that belong to no listed cause. They describe what no cause explains; 0 is
/// off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extra {
    /// Force −c |ḋ| ḋ on the leg (N s²/m²).
    pub quadratic: f64,
    /// Dry friction of the leg for each metre of its extension (N/m).
    pub tightening: f64,
    /// Leak from the chamber for each metre of the leg's extension, as an area (m²/m).
    pub leak_along: f64,
    /// Time (s) over which the valve opens, instead of at once.
    pub opening: f64,
    /// Torque −c φ̇ against the wheel's spin (N m s/rad).
    pub spin_damping: f64,
    /// Torque −c θ̇ against the boom's pivot (N m s/rad).
    pub pivot_damping: f64,
    /// Torque −k θ against the boom's pivot (N m/rad).
    pub pivot_spring: f64,
    /// Torque −c ψ̇ against the boom's turn (N m s/rad).
    pub turn_damping: f64,
}

/// How a jump begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// On the retracted foot at a lean (rad), turning forward at a rate (rad/s).
    Rolling {
        /// Lean (rad), forward positive.
        lean: f64,
        /// Its rate (rad/s).
        rate: f64,
    },
    /// In the air with all legs home; its foot touches down where it comes to the ground.
    Flying(Flight),
    /// Upright, at rest; on the bench the rod retracted under its load.
    Rest,
}

/// A state in the air; the radius angle, or the travel, is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// Lean (rad) and its rate (rad/s).
    pub lean: (f64, f64),
    /// Pivot angle (rad) and its rate; height of the axle (m) without a boom.
    pub pivot: (f64, f64),
    /// Rate of the radius angle (rad/s); of the travel (m/s) without a boom.
    pub turn_rate: f64,
}

/// What the legs that are out, beside the one that jumps, add to the wheel's moment of inertia about
/// its axle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Others {
    /// Time (s) from one value to the next, of which the first is at 0.
    pub step: f64,
    /// The moment (kg m²).
    pub inertia: Vec<f64>,
}

impl Others {
    /// The moment (kg m²) at a time (s), and its rate; between the values it is a line.
    fn at(&self, time: f64) -> (f64, f64) {
        if self.inertia.is_empty() {
            return (0.0, 0.0);
        }
        let place = (time / self.step).max(0.0);
        // An index.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let k = place as usize;
        match self.inertia.get(k..k + 2) {
            Some([a, b]) => (a + (place - k as f64) * (b - a), (b - a) / self.step),
            _ => (self.inertia.last().copied().unwrap_or(0.0), 0.0),
        }
    }
}

/// A robot that jumps.
#[derive(Clone, Debug)]
pub struct Rig {
    machine: Machine,
    leg: Leg<f64>,
    massless: bool,
    /// 1/√T of the supplied gas (1/√K).
    per_root: f64,
    extra: Extra,
    others: Arc<Others>,
}

/// End (s) of a jump that does not land.
const PATIENCE: f64 = 3.0;

impl Rig {
    /// The rig of `robot`.
    pub fn new(robot: &Robot) -> Rig {
        let per_root = match &robot.leg.drive {
            Drive::Pneumatic(cylinder) => 1.0 / cylinder.temperature.sqrt(),
            _ => 0.0,
        };
        Rig {
            per_root,
            machine: Machine::new(robot),
            leg: Leg::new(robot, |_, x| x),
            massless: robot.leg.body.mass == 0.0,
            extra: Extra::default(),
            others: Arc::default(),
        }
    }

    /// The rig with other legs that are out.
    #[must_use]
    pub fn beside(self, others: Arc<Others>) -> Rig {
        Rig { others, ..self }
    }

    /// One upright leg of `robot` on the bench, which moves nothing but a dead load (kg). At the
    /// end of its stroke the leg stays.
    pub fn bench(robot: &Robot, load: f64) -> Rig {
        Rig {
            machine: Machine::bench(robot, load),
            ..Rig::new(robot)
        }
    }

    /// The rig with terms that belong to no listed cause.
    #[must_use]
    pub fn with(self, extra: Extra) -> Rig {
        Rig {
            machine: self.machine.with(extra),
            extra,
            ..self
        }
    }

    /// The motion from `start` at time 0, with the valve commanded open at `open` and shut at
    /// `shut` (s), up to `until` (s). Without `until` it ends as the axle is back at its height on
    /// a retracted, upright leg. None if the equations have no solution or the robot falls over.
    pub fn jump(&self, start: Start, open: f64, shut: f64, until: Option<f64>) -> Option<Course> {
        self.jump_in_steps(start, open, shut, until, LONG)
    }

    /// The same with a longest step `rests` (s) while the rod rests on the bench.
    fn jump_in_steps(
        &self,
        start: Start,
        open: f64,
        shut: f64,
        until: Option<f64>,
        rests: f64,
    ) -> Option<Course> {
        let mut run = Run::new(self, start)?;
        run.rests = rests;
        let (fire, release) = self.leg.answers(open, shut - open);
        let release = release.unwrap_or(f64::INFINITY);
        let end = until.unwrap_or(PATIENCE);
        let mut marks = [(open, 0), (fire, 1), (release, 2)];
        marks.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (time, what) in marks {
            run.go(time.min(end), until.is_none())?;
            if time >= end || run.landed {
                break;
            }
            match what {
                0 => run.mode.leg = Slide::Held,
                1 => run.switch(release > fire),
                _ => run.switch(false),
            }
        }
        run.go(end, until.is_none())?;
        Some(run.course)
    }

    /// Apex and landing of a jump that is fired at its start: the greatest height of the axle (m),
    /// and its travel (m) from the foot as it is back at its height on the retracted leg.
    pub fn outcome(&self, lean: f64, rate: f64, valve_open: f64) -> Option<(f64, f64)> {
        let course = self.jump(Start::Rolling { lean, rate }, 0.0, valve_open, None)?;
        course.leaves?;
        course.apex_and_landing()
    }
}

#[cfg(test)]
mod tests;
