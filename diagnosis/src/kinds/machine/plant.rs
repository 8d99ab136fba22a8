//! A mechanism in motion, with effects at work.

use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Vector3};
use saltus_sim_check::chain::{Chain, MOST, Moving};
use saltus_sim_check::{Body, Joint as Way3, Placement, Tree};

use super::Piece;
use super::guesses::{Likely, Start};
use crate::kind::Log;
use crate::kinds::input::Input;
use crate::machine::{Machine, Part, State};
use crate::mechanism::{Inertia, Law, Link, Mechanism, Shows, Way};
use crate::sensor::Sensor;
use crate::spec::Problem;

/// By how much (rad) the phase of the fastest swing may be off at the end of the longest run: by
/// fixed steps of a turn s it is off by s²/24 of itself.
const PHASE: f64 = 2e-4;
/// Turn (rad) after which it is forgotten: of a swing that is driven or rubs.
const FORGOTTEN: f64 = 30.0;
/// Longest and shortest step (s).
const STEPS: (f64, f64) = (2.5e-3, 1e-4);

/// The numbers of a mechanism that effects change; each list is in its order.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Change {
    /// Mass and inertia of each link in terms of what is believed.
    pub(super) mass: Vec<f64>,
    /// Inertia (kg m²) about the centre.
    pub(super) inertia: Vec<f64>,
    /// How far (m) each centre is beyond its place, as seen from the joint.
    pub(super) beyond: Vec<f64>,
    /// Weight and inertia (kg) of what hangs by a counterweight.
    pub(super) counterweight: Vec<[f64; 2]>,
    /// Of each joint: dry friction, damping, drag, stiffness, and a torque that goes with sin 2q.
    pub(super) friction: Vec<f64>,
    pub(super) damping: Vec<f64>,
    pub(super) drag: Vec<f64>,
    pub(super) stiffness: Vec<f64>,
    pub(super) second: Vec<f64>,
    /// Stiffness of each spring in terms of what is believed.
    pub(super) springs: Vec<f64>,
    /// The sensor of each drive's column.
    pub(super) drives: Vec<Sensor>,
    /// Slope (rad) of the ground, uphill positive.
    pub(super) slope: f64,
}

/// Inertia (kg m²) that a link has about its centre where nobody knows it: that of a rod whose
/// middle is there.
pub(super) fn guess(link: &Link) -> f64 {
    let [x, y] = link.center;
    link.mass * x.hypot(y).max(0.01).powi(2) / 3.0
}

impl Change {
    /// As the operator believes it is.
    pub(super) fn none(mechanism: &Mechanism) -> Change {
        let each = |of: fn(&Link) -> f64| mechanism.links.iter().map(of).collect::<Vec<_>>();
        let zeros = vec![0.0; mechanism.links.len()];
        Change {
            mass: vec![1.0; mechanism.links.len()],
            inertia: each(|link| match link.inertia {
                Inertia::Center(inertia) => inertia,
                Inertia::Unknown => guess(link),
            }),
            beyond: zeros.clone(),
            counterweight: mechanism
                .links
                .iter()
                .map(|link| {
                    link.counterweight
                        .as_ref()
                        .map_or([0.0; 2], |c| [c.mass; 2])
                })
                .collect(),
            friction: each(|link| link.joint.friction),
            damping: each(|link| link.joint.damping),
            drag: zeros.clone(),
            stiffness: zeros.clone(),
            second: zeros,
            springs: vec![1.0; mechanism.springs.len()],
            drives: vec![Sensor::default(); mechanism.drives.len()],
            slope: 0.0,
        }
    }
}

/// A mechanism with effects at work.
pub(super) struct Plant<'a> {
    pub(super) mechanism: &'a Mechanism,
    pub(super) change: Change,
    machine: Machine,
}

/// Where every joint is, and its rate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub(super) q: [f64; MOST],
    pub(super) v: [f64; MOST],
}

/// A run: rows at the times (s) of its readings.
pub(super) struct Course {
    times: Vec<f64>,
    pub(super) rows: Vec<Row>,
}

impl Course {
    /// What has the values and rates `shown` in its rows, at `time` (s); `at` is the last row before
    /// it, from which the search goes on.
    pub(super) fn at(&self, shown: &[[f64; 2]], time: f64, at: &mut usize) -> f64 {
        let last = self.times.len() - 1;
        while *at < last && self.times[*at + 1] <= time {
            *at += 1;
        }
        let since = time - self.times[*at];
        let [a, b] = shown[*at];
        if since <= 0.0 || *at == last {
            return a + since * b;
        }
        // The cubic of Hermite.
        let ([c, d], h) = (shown[*at + 1], self.times[*at + 1] - self.times[*at]);
        let s = since / h;
        let (rise, bend) = (c - a - h * b, h * (d - b));
        a + since * b + s * s * ((3.0 * rise - bend) + s * (bend - 2.0 * rise))
    }
}

impl<'a> Plant<'a> {
    /// The mechanism with a change; none where it cannot move.
    pub(super) fn new(mechanism: &'a Mechanism, change: Change) -> Option<Plant<'a>> {
        let mut tree = Tree::default();
        for (k, link) in mechanism.links.iter().enumerate() {
            tree.add(body(link, k, &change)).ok()?;
        }
        let (sin, cos) = change.slope.sin_cos();
        let gravity = [-mechanism.gravity * sin, -mechanism.gravity * cos];
        let mut chain = Chain::new(&tree, gravity).ok()?;
        for (k, link) in mechanism.links.iter().enumerate() {
            if let Some(own) = &link.counterweight {
                let [weight, inertia] = change.counterweight[k];
                chain.weigh(k, own.at, weight - inertia);
            }
        }
        let part = |k: usize| Part {
            friction: change.friction[k],
            damping: change.damping[k],
            ..Part::default()
        };
        let machine = Machine {
            chain,
            parts: (0..mechanism.links.len()).map(part).collect(),
            points: Vec::new(),
        };
        Some(Plant {
            mechanism,
            change,
            machine,
        })
    }

    /// Torque or force of what is in joint `k` at a coordinate and a rate, but for friction and
    /// damping.
    fn held(&self, k: usize, q: f64, v: f64) -> f64 {
        let change = &self.change;
        let springs = self.mechanism.springs.iter().zip(&change.springs);
        let of_springs: f64 = springs
            .filter(|(spring, _)| spring.joint == k)
            .map(|(spring, share)| share * spring.law.at(q))
            .sum();
        of_springs
            - change.stiffness[k] * q
            - change.drag[k] * v.abs() * v
            - change.second[k] * (2.0 * q).sin()
    }

    /// A motion from coordinates and rates on, with rows where `log` has readings; none where it
    /// has no answer.
    pub(super) fn run(
        &self,
        (q, v): (&[f64], &[f64]),
        log: &Log,
        inputs: &[Input],
        longest: f64,
    ) -> Option<Course> {
        let mut state = State::new(&self.machine, q, v);
        let mut now = log.readings.first()?.time;
        let mut at = vec![0; inputs.len()];
        let mut course = Course {
            times: Vec::new(),
            rows: Vec::new(),
        };
        for reading in &log.readings {
            if course.times.last() == Some(&reading.time) {
                continue;
            }
            let left = reading.time - now;
            // As many steps as the longest allows.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let count = (left / longest).ceil() as usize;
            for i in 0..count {
                let h = left / count as f64;
                let middle = now + (i as f64 + 0.5) * h;
                self.step(&mut state, h, middle, (inputs, &mut at))?;
            }
            now = reading.time;
            course.times.push(now);
            course.rows.push(Row {
                q: state.q,
                v: state.v,
            });
        }
        Some(course)
    }

    /// Goes on by `h` (s), of which the middle is at `middle` (s).
    fn step(
        &self,
        state: &mut State,
        h: f64,
        middle: f64,
        (inputs, at): (&[Input], &mut [usize]),
    ) -> Option<()> {
        let mut torques = [0.0; MOST];
        let count = self.mechanism.links.len();
        for (k, torque) in torques.iter_mut().enumerate().take(count) {
            *torque = self.held(k, state.ahead(k, 0.5 * h), state.v[k]);
        }
        for (k, drive) in self.mechanism.drives.iter().enumerate() {
            let sensor = &self.change.drives[k];
            torques[drive.joint] += inputs[k].truth(middle, sensor, &mut at[k]);
        }
        self.machine.step(state, h, &torques[..count]).then_some(())
    }

    /// State after `length` (s) from `time` (s) on.
    pub(super) fn after(
        &self,
        (q, v): (&[f64], &[f64]),
        (time, length): (f64, f64),
        inputs: &[Input],
        longest: f64,
    ) -> Option<Row> {
        let mut state = State::new(&self.machine, q, v);
        let mut at = vec![0; inputs.len()];
        // As many steps as the longest allows.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let count = (length / longest).ceil().max(1.0) as usize;
        let h = length / count as f64;
        for i in 0..count {
            let middle = time + (i as f64 + 0.5) * h;
            self.step(&mut state, h, middle, (inputs, &mut at))?;
        }
        Some(Row {
            q: state.q,
            v: state.v,
        })
    }

    /// What a gauge shows of a row, and its rate.
    pub(super) fn shown(&self, shows: Shows, row: &Row) -> [f64; 2] {
        match shows {
            Shows::Coordinate(k) => [row.q[k], row.v[k]],
            Shows::Angle { link, back } => {
                let sign = if back { -1.0 } else { 1.0 };
                let mut all = [0.0; 2];
                for k in self.mechanism.to_ground(link) {
                    let joint = &self.mechanism.links[k].joint;
                    all[0] += sign * joint.angle;
                    if let Way::Turns { back } = joint.way {
                        let sign = if back { -sign } else { sign };
                        all[0] += sign * row.q[k];
                        all[1] += sign * row.v[k];
                    }
                }
                all
            }
            Shows::Place { link, at, axis } => {
                let (chain, mut moving) = (&self.machine.chain, Moving::default());
                chain.put(&row.q[..chain.len()], &row.v[..chain.len()], &mut moving);
                let [place, speed] = chain.place(&moving, link, at);
                [place[axis], speed[axis]]
            }
        }
    }

    /// Kinetic and potential energy (J), without that of springs.
    #[cfg(test)]
    pub(super) fn energy(&self, row: &Row) -> f64 {
        let (chain, mut moving) = (&self.machine.chain, Moving::default());
        chain.put(&row.q[..chain.len()], &row.v[..chain.len()], &mut moving);
        chain.energy(&moving).iter().sum()
    }

    /// Fastest rate (rad/s) at which it swings about `q`; none where it cannot move.
    fn fastest(&self, q: &[f64]) -> Option<f64> {
        /// Step (rad or m) of a difference quotient.
        const STEP: f64 = 1e-4;
        /// Steps of a power iteration: more than enough for a size.
        const ROUNDS: usize = 30;
        let (chain, n) = (&self.machine.chain, self.mechanism.links.len());
        let still = vec![0.0; n];
        let forces = |q: &[f64]| {
            let mut moving = Moving::default();
            chain.put(q, &still, &mut moving);
            let mut forces = chain.forces(&moving);
            for k in 0..n {
                forces[k] += self.held(k, q[k], 0.0);
            }
            forces
        };
        let mut moving = Moving::default();
        chain.put(q, &still, &mut moving);
        if !chain.factor(&mut moving) {
            return None;
        }
        let column = |k: usize| {
            let (mut low, mut high) = (q.to_vec(), q.to_vec());
            low[k] -= STEP;
            high[k] += STEP;
            let (low, high) = (forces(&low), forces(&high));
            let mut slope = [0.0; MOST];
            for i in 0..n {
                slope[i] = (high[i] - low[i]) / (2.0 * STEP);
            }
            chain.solve(&moving, &mut slope[..n]);
            slope
        };
        let columns: Vec<[f64; MOST]> = (0..n).map(column).collect();
        let matrix = DMatrix::from_fn(n, n, |i, k| columns[k][i]);
        let mut x = DVector::from_fn(n, |i, _| 1.0 + 0.1 * i as f64);
        let mut size = 0.0;
        for _ in 0..ROUNDS {
            x = &matrix * x;
            size = x.norm();
            if size == 0.0 {
                break;
            }
            x /= size;
        }
        size.is_finite().then(|| size.sqrt())
    }
}

/// A link as a body of the simulation.
fn body(link: &Link, k: usize, change: &Change) -> Body {
    let at = |[x, y]: [f64; 2]| Vector3::new(x, 0.0, y);
    let joint = match link.joint.way {
        Way::Turns { back: false } => Way3::Revolute(Vector3::y()),
        Way::Turns { back: true } => Way3::Revolute(-Vector3::y()),
        Way::Slides(along) => Way3::Prismatic(at(along)),
    };
    let [x, y] = link.center;
    let reach = x.hypot(y);
    let longer = if reach > 0.0 {
        1.0 + change.beyond[k] / reach
    } else {
        1.0
    };
    let mut body = Body {
        name: link.name.clone(),
        parent: link.joint.parent,
        joint,
        placement: Placement {
            rotation: Rotation3::from_axis_angle(&Vector3::y_axis(), link.joint.angle).into_inner(),
            position: at(link.joint.at),
        },
        mass: change.mass[k] * link.mass,
        center: at([longer * x, longer * y]),
        inertia: Matrix3::identity() * (change.mass[k] * change.inertia[k]),
    };
    if let Some(own) = &link.counterweight {
        body.add_point_mass(change.counterweight[k][1], at(own.at));
    }
    body
}

/// Refuses a mechanism that cannot move, or of which nothing is measured.
pub(super) fn check(mechanism: &Mechanism) -> Result<(), Problem> {
    let refused = |what: String| {
        let what = format!("{}: {what}", mechanism.name);
        Err(Problem::NoMachine { what })
    };
    if mechanism.links.is_empty() || mechanism.links.len() > MOST {
        let count = mechanism.links.len();
        return refused(format!("{count} links: must be from 1 to {MOST}"));
    }
    if mechanism.gauges.is_empty() {
        return refused("nothing is measured: must have a table [[measured]] at least".into());
    }
    let columns: Vec<&str> = mechanism
        .gauges
        .iter()
        .map(|gauge| gauge.column.as_str())
        .chain(mechanism.drives.iter().map(|drive| drive.column.as_str()))
        .collect();
    if let Some(name) = super::twice(&columns) {
        return refused(format!(
            "column {name} is named twice: each stands for one thing"
        ));
    }
    for spring in &mechanism.springs {
        if let Law::Table(points) = &spring.law
            && (points.len() < 2 || points.windows(2).any(|w| w[1][0] <= w[0][0]))
        {
            return refused("a table of a spring must have two places at least, which rise".into());
        }
    }
    // Apart from where links lie on each other.
    let apart: Vec<f64> = (0..mechanism.links.len())
        .map(|k| 0.3 + 0.7 * k as f64)
        .collect();
    let plant = Plant::new(mechanism, Change::none(mechanism));
    match plant.and_then(|plant| plant.fastest(&apart)) {
        Some(_) => Ok(()),
        None => refused(
            "a joint moves nothing that has mass or inertia: links without mass must carry one \
             that has, and each must move it another way"
                .into(),
        ),
    }
}

/// Longest step (s) for every run, by how fast the machine swings where it hangs and where its runs
/// start.
///
/// # Errors
/// [`Problem`] where the longest run takes so many of them that no search ends.
pub(super) fn longest_step(
    mechanisms: &[Mechanism],
    starts: &[Start],
    runs: &[Piece],
    (likely, logs): (&Likely, &[Log]),
) -> Result<f64, Problem> {
    /// Most steps of a run: 0.2 s.
    const MOST: f64 = 2e5;
    let ends = |log: &Log| Some(log.readings.last()?.time - log.readings.first()?.time);
    let longest = logs.iter().filter_map(ends).fold(0.0, f64::max);
    let fastest = |which: usize, q: &[f64]| {
        let mechanism = &mechanisms[which];
        let change = Change {
            inertia: likely.inertia.clone(),
            ..Change::none(mechanism)
        };
        let change = if which == 0 {
            change
        } else {
            Change::none(mechanism)
        };
        Plant::new(mechanism, change)?.fastest(q)
    };
    let hanging = (0..mechanisms.len()).map(|k| (k, vec![0.0; mechanisms[k].links.len()]));
    let starting = runs
        .iter()
        .zip(starts)
        .map(|(run, start)| (run.mechanism, start.q.clone()));
    let rates = hanging.chain(starting).filter_map(|(k, q)| fastest(k, &q));
    let fastest = rates.fold(0.0, f64::max);
    let turn = (fastest * longest).clamp(1.0, FORGOTTEN);
    let step = (24.0 * PHASE / turn).sqrt() / fastest.max(1e-9);
    let step = step.clamp(STEPS.1, STEPS.0);
    if longest > MOST * step {
        let what = format!(
            "a run lasts {longest:.0} s, and this machine swings so fast that it is computed in steps of \
             {step:.0e} s, {MOST:e} of them at most: is time_s in ms?"
        );
        return Err(Problem::NoMachine { what });
    }
    Ok(step)
}
