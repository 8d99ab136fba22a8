//! A ball that rolls up to a box, jumps over it, and goes on.

use saltus_controller::ball::{
    Balance, Balancer, Estimate, Firing, Lead, Lying, Pilot, Plane, Sight, View,
};
use saltus_gait::space::FALLS;

use super::Cycle;

/// When a robot that rolls jumps: by twins, whose two legs push.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leap {
    /// Distance (m) to the box's front at which twins shall come onto the ground: the run-up is chosen for it.
    pub aim: f64,
    /// Distance (m) to the box's front, from where the legs meet, from which on twins jump, at a speed of [`SPEED`].
    pub from: f64,
    /// Lean (rad) at which they fire at that distance and speed.
    pub lean: f64,
    /// How much more they lean (rad) for each metre nearer to the box.
    pub nearer: f64,
    /// Valve opening time (s).
    pub open: f64,
    /// How much farther (m) from the box they jump, and how much more they lean (rad), for each m/s faster.
    pub by_speed: [f64; 2],
    /// Rate (rad/s) at which it runs up.
    pub rate: f64,
}

/// The speed (m/s) for which [`Leap::from`] and [`Leap::lean`] stand.
pub const SPEED: f64 = 1.1;

/// Runs, jumps, runs on.
pub(super) struct Leaper<'a> {
    leap: Leap,
    /// Where the box's front is (m).
    front: f64,
    /// Where its line is, across it (m): where it begins.
    line: Option<f64>,
    /// What rolls it until it falls after its landing, and what sets it out again after that.
    balancer: Balancer<'a, f64>,
    pilot: Pilot<'a, f64>,
    phase: Phase,
    /// Distance (m) to the box at the jump, and when (s).
    jumped: Option<(f64, f64)>,
    /// The last station of twins that was left to the gait.
    decided: Option<i32>,
    /// Stations that have passed, and when (s) the last one did.
    last: (i32, f64),
}

/// What it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Runs,
    /// Its legs push; it is still on the ground.
    Pushes,
    Flies,
    Landed,
    /// It has fallen after its landing.
    Fell,
}

/// For how long (s) no station may come after the landing before it sets out again.
const STUCK: f64 = 1.5;

impl<'a> Leaper<'a> {
    /// For a box whose front is at `front` (m), rolling by `balance` in a plane; after a fall led by `lead` in one of `planes`
    /// along a path.
    pub(super) fn new(
        leap: Leap,
        front: f64,
        (balance, plane): (Balance<f64>, Plane<'a, f64>),
        (lead, planes, path): (Lead<f64>, &'a [Plane<'a, f64>], &'a [[f64; 2]]),
    ) -> Leaper<'a> {
        Leaper {
            leap,
            front,
            line: None,
            balancer: Balancer::new(balance, plane),
            pilot: Pilot::new(lead, planes, path),
            phase: Phase::Runs,
            jumped: None,
            decided: None,
            last: (i32::MIN, 0.0),
        }
    }

    /// Distance (m) to the box at the jump, and when (s); none: it has not jumped.
    pub(super) fn jumped(&self) -> Option<(f64, f64)> {
        self.jumped
    }

    /// The legs that fire in the cycle `now` of a robot that takes its motion for what is `known`.
    pub(super) fn fire(&mut self, now: &Cycle, known: &Estimate<f64>) -> Vec<Firing<f64>> {
        if self.phase == Phase::Fell {
            let view = View::of(known, now.touching);
            return self.pilot.step(&view).into_iter().flatten().collect();
        }
        let sight = Sight {
            attitude: known.attitude,
            spin: known.spin,
            aside: known.place[1] - *self.line.get_or_insert(known.place[1]),
            aside_rate: known.velocity[1],
            course: 0.0,
            touching: now.touching,
        };
        let (lying, fired) = self.balancer.step(&sight);
        self.turn_over(now, &lying);
        match self.phase {
            Phase::Runs => {}
            Phase::Landed => return fired.into_iter().flatten().collect(),
            Phase::Pushes | Phase::Flies | Phase::Fell => return Vec::new(),
        }
        let fires = fired.iter().any(Option::is_some);
        if self.jumps(known, &lying, (fires, now)) {
            self.phase = Phase::Pushes;
            self.jumped = Some((self.front - known.place[0], now.time));
            let legs = self.balancer.tracker().station().map(|it| it.legs);
            let open = self.leap.open;
            let fire = |leg| Firing { leg, open };
            return legs.into_iter().flatten().map(fire).collect();
        }
        fired.into_iter().flatten().collect()
    }

    /// From one phase to the next.
    fn turn_over(&mut self, now: &Cycle, lying: &Lying<f64>) {
        let passed = self.balancer.tracker().passed();
        if passed > self.last.0 {
            self.last = (passed, now.time);
        }
        let is_stuck = now.time > self.last.1 + STUCK;
        self.phase = match self.phase {
            Phase::Pushes if now.touching == 0 => Phase::Flies,
            Phase::Flies if now.touching != 0 => Phase::Landed,
            Phase::Pushes | Phase::Landed if lying.roll.abs() > FALLS || is_stuck => Phase::Fell,
            phase => phase,
        };
    }

    /// Whether the station that stands jumps; `fires`: whether the gait fires it in the cycle `now`.
    fn jumps(
        &mut self,
        known: &Estimate<f64>,
        lying: &Lying<f64>,
        (fires, now): (bool, &Cycle),
    ) -> bool {
        let tracker = self.balancer.tracker();
        let here = tracker.passed();
        let Some(station) = tracker.station().filter(|it| it.is_of_twins()) else {
            return false;
        };
        let leap = &self.leap;
        let faster = known.velocity[0] - SPEED;
        let from = leap.from + leap.by_speed[0] * faster;
        let far = self.front - known.place[0];
        let lean = leap.lean + leap.nearer * (from - far) + leap.by_speed[1] * faster;
        let touches = |leg: &u32| now.touching >> *leg & 1 == 1;
        let stands = station.legs.iter().any(touches);
        // Twins decide once, where they come to their lean; legs that have pushed have no stroke left.
        if !stands || self.decided == Some(here) || !(lying.lean >= lean || fires) {
            return false;
        }
        self.decided = Some(here);
        far <= from && far > 0.0
    }
}
