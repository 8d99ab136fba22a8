//! Where a ball goes: along a path, in the plane that leads there; and on from wherever it fell.

use super::balance::{Balance, Balancer, Firing, Sight, wrapped};
use super::estimate::Estimate;
use super::plane::Plane;
use super::rotation::{Rotation, angle, dot};
use crate::Real;
use crate::real::{cosine, sine};

/// How a ball is led along a path.
///
/// Source: thesis 7.2.1, by which six planes are open wherever a ball stands, one every 60°, and 8.3.2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lead<R> {
    /// How it rolls, and is kept in its plane.
    pub balance: Balance<R>,
    /// How far ahead (m) on the path the place is to which it turns.
    pub ahead: R,
    /// How fast (rad/s) its course is turned.
    pub slew: R,
    /// Roll (rad) from which on no leg fires, until it lies still.
    pub tips: R,
    /// Way aside of its path (m) from which on it stops, to choose another plane.
    pub astray: R,
    /// How far (rad) the way to go may be off its heading before it stops, to choose another plane.
    pub turn: R,
    /// How near (m) it must come to a point of its path.
    pub near: R,
    /// Spin (rad/s) below which it lies still.
    pub still: R,
    /// For how long (s).
    pub rests: R,
    /// For how long (s) no station may come before it tries another plane.
    pub patience: R,
}

/// What a cycle of a [`Pilot`] sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View<R> {
    /// Attitude, from the body's axes to the world's.
    pub attitude: Rotation<R>,
    /// Spin (rad/s), the world's axes.
    pub spin: [R; 3],
    /// Where the legs meet (m): along the first heading, to its left.
    pub place: [R; 2],
    /// Velocity of that place (m/s).
    pub velocity: [R; 2],
    /// Feet on the ground: bit k is leg k's.
    pub touching: u64,
}

impl<R: Copy> View<R> {
    /// That of a ball that takes its motion for `known`, with these feet on the ground.
    pub fn of(known: &Estimate<R>, touching: u64) -> View<R> {
        View {
            attitude: known.attitude,
            spin: known.spin,
            place: [known.place[0], known.place[1]],
            velocity: [known.velocity[0], known.velocity[1]],
            touching,
        }
    }
}

/// Leads a ball along a path, a cycle at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pilot<'a, R> {
    lead: Lead<R>,
    planes: &'a [Plane<'a, R>],
    path: &'a [[R; 2]],
    /// Where the present piece of the path begins, and the number of the point where it ends.
    from: [R; 2],
    next: usize,
    /// What rolls it; none while it comes to rest.
    rolls: Option<Balancer<'a, R>>,
    plane: usize,
    course: R,
    /// Cycles for which it has been still, and since a station came.
    still: u32,
    idle: u32,
    /// Stations that have come in this plane, and starts since one went well.
    passed: i32,
    attempts: u32,
    starts: u32,
    /// Whether it has faced the way to go in this plane.
    faces: bool,
}

/// Where the path is.
#[derive(Clone, Copy, Debug)]
struct Way<R> {
    /// Heading (rad) of its present piece.
    line: R,
    /// How far (m) the ball is to its left.
    left: R,
    /// How fast (m/s) it goes to the left of its course.
    left_rate: R,
    /// Heading (rad) to the place ahead.
    aim: R,
}

/// Tilt (its sine) of a plane's axis up to which it counts as upright.
const UPRIGHT: f64 = 0.2;
/// Among how many planes it changes where starts fail.
const CHOICES: usize = 3;
/// Points of the path that it may come to in one cycle.
const POINTS: u32 = 8;
/// Stations after which a start has gone well.
const WENT_WELL: i32 = 6;

impl<'a, R: Real> Pilot<'a, R> {
    /// A ball that begins at the origin, by any of `planes`, through the points of `path` (m).
    pub fn new(lead: Lead<R>, planes: &'a [Plane<'a, R>], path: &'a [[R; 2]]) -> Pilot<'a, R> {
        Pilot {
            lead,
            planes,
            path,
            from: [R::ZERO; 2],
            next: 0,
            rolls: None,
            plane: 0,
            course: R::ZERO,
            still: 0,
            idle: 0,
            passed: 0,
            attempts: 0,
            starts: 0,
            faces: false,
        }
    }

    /// The plane in which it rolls, by its number; none while it comes to rest.
    pub fn plane(&self) -> Option<usize> {
        self.rolls.map(|_| self.plane)
    }

    /// How many points of the path it has come to.
    pub fn reached(&self) -> usize {
        self.next
    }

    /// How many times it has set out.
    pub fn starts(&self) -> u32 {
        self.starts
    }

    /// A cycle: the legs that fire now.
    #[inline]
    pub fn step(&mut self, view: &View<R>) -> [Option<Firing<R>>; 2] {
        let Some(way) = self.find(view) else {
            self.rolls = None;
            return [None; 2];
        };
        if self.rolls.is_none() && self.lies(view) {
            self.set_out(view, &way);
        }
        let Some(mut balancer) = self.rolls else {
            return [None; 2];
        };
        let l = self.lead;
        let most = l.slew * l.balance.period;
        let off = wrapped(way.aim - self.course);
        self.course = wrapped(self.course + off.lesser(most).greater(-most));
        let sight = Sight {
            attitude: view.attitude,
            spin: view.spin,
            aside: R::ZERO,
            aside_rate: way.left_rate,
            course: self.course,
            touching: view.touching,
        };
        let (lying, fired) = balancer.step(&sight);
        self.rolls = Some(balancer);
        let passed = balancer.tracker().passed();
        self.idle = self.idle.saturating_add(1);
        if passed > self.passed {
            (self.passed, self.idle) = (passed, 0);
        }
        if self.passed > WENT_WELL {
            self.attempts = 0;
        }
        let is_stuck = self.seconds(self.idle) > l.patience;
        let is_astray = self.leaves(&way, lying.heading);
        let faces = wrapped(way.aim - lying.heading).magnitude() < l.turn;
        let turns = self.faces && !faces;
        self.faces = faces;
        if lying.roll.magnitude() > l.tips || is_stuck || is_astray || turns {
            self.rolls = None;
            self.attempts = self.attempts.saturating_add(u32::from(is_stuck));
            self.still = 0;
            return [None; 2];
        }
        fired
    }

    /// Whether it is far from its path, and `heading` (rad) leads farther.
    fn leaves(&self, way: &Way<R>, heading: R) -> bool {
        (way.left.magnitude() - self.lead.astray).is_positive()
            && (way.left * wrapped(heading - way.line)).is_positive()
    }

    fn seconds(&self, cycles: u32) -> R {
        R::of_count(i32::try_from(cycles).unwrap_or(i32::MAX)) * self.lead.balance.period
    }

    /// Where the path is, past the points that have been reached; none at its end.
    fn find(&mut self, view: &View<R>) -> Option<Way<R>> {
        for _ in 0..POINTS {
            let &to = self.path.get(self.next)?;
            let piece = [to[0] - self.from[0], to[1] - self.from[1]];
            let length = (piece[0] * piece[0] + piece[1] * piece[1]).sqrt();
            let rest = [to[0] - view.place[0], to[1] - view.place[1]];
            let is_near = rest[0] * rest[0] + rest[1] * rest[1] < self.lead.near * self.lead.near;
            if !is_near && length.is_positive() {
                let along = [piece[0] / length, piece[1] / length];
                let gone = [view.place[0] - self.from[0], view.place[1] - self.from[1]];
                let way = along[0] * gone[0] + along[1] * gone[1];
                let far = (way + self.lead.ahead).lesser(length);
                let aim = [
                    self.from[0] + far * along[0] - view.place[0],
                    self.from[1] + far * along[1] - view.place[1],
                ];
                let [x, y] = direction(self.course);
                return Some(Way {
                    line: angle(along[1], along[0]),
                    left: along[0] * gone[1] - along[1] * gone[0],
                    left_rate: x * view.velocity[1] - y * view.velocity[0],
                    aim: angle(aim[1], aim[0]),
                });
            }
            self.from = to;
            self.next += 1;
        }
        None
    }

    /// Whether it has been still for long enough.
    fn lies(&mut self, view: &View<R>) -> bool {
        let l = &self.lead;
        let is_still = (l.still * l.still - dot(&view.spin, &view.spin)).is_positive();
        self.still = if is_still {
            self.still.saturating_add(1)
        } else {
            0
        };
        self.seconds(self.still) > self.lead.rests
    }

    /// Sets out in the plane that leads most nearly where the path goes; after a start that failed in the next best one, and
    /// so on.
    fn set_out(&mut self, view: &View<R>, way: &Way<R>) {
        // The three that lead most nearly there, each plane looked at once; of equal ones the first.
        let mut best: [Option<(usize, R, R)>; CHOICES] = [None; CHOICES];
        let up = view.attitude.back().turn(&[R::ZERO, R::ZERO, R::ONE]);
        for (k, plane) in self.planes.iter().enumerate() {
            if dot(&up, &plane.axis).magnitude() > R::of(UPRIGHT) {
                continue;
            }
            let axis = view.attitude.turn(&plane.axis);
            let heading = angle(-axis[0], axis[1]);
            let off = wrapped(way.aim - heading).magnitude();
            if self.leaves(way, heading) || !off.is_at_least_zero() {
                continue;
            }
            let mut next = Some((k, off, heading));
            for place in &mut best {
                let Some((_, off, _)) = next else {
                    break;
                };
                match *place {
                    Some((_, nearer, _)) if nearer < off => {}
                    // As near as one before it: that one counts.
                    Some((_, same, _)) if same <= off => break,
                    _ => core::mem::swap(place, &mut next),
                }
            }
        }
        let tries = self.attempts as usize % CHOICES;
        let chosen = best.iter().take(tries + 1).flatten().last();
        let chosen = chosen.map(|(k, _, heading)| (*k, *heading));
        if let Some((k, heading)) = chosen {
            self.plane = k;
            self.course = heading;
            self.rolls = Some(Balancer::new(self.lead.balance, self.planes[k]));
            (self.idle, self.passed, self.faces) = (0, i32::MIN, false);
            self.starts = self.starts.saturating_add(1);
        }
    }
}

/// The unit vector along a heading (rad) of at most a turn.
fn direction<R: Real>(heading: R) -> [R; 2] {
    let half = heading * R::of(0.5);
    let (x, y) = (cosine(half), sine(half));
    [x * x - y * y, (x + x) * y]
}
