//! One jump of a rig: from standing on a foot through firing and lift-off to the landing.

use std::f64::consts::FRAC_PI_2;

use saltus_robot::{Launch, LiftOff, Outcome};

use crate::SimError;
use crate::error::ensure;
use crate::rig::Rig;
use crate::sim::{Happening, Ledger, Pause, Settings, Sim, Stepping};

/// How a jump ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// It flew, and its axle came down to the height of standing.
    Landed,
    /// It never left the ground after firing.
    NoLiftOff,
    /// It came to rest, or fell back, before the firing angle.
    Stalled,
    /// The foot left the ground before firing.
    EarlyLiftOff,
}

/// The robot at an instant.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Time (s).
    pub time: f64,
    /// Travel and height of the axle (m), from the foothold.
    pub axle: [f64; 2],
    /// Their rates (m/s).
    pub axle_rates: [f64; 2],
    /// Lean of the jumping leg (rad), relative to what carries the axle.
    pub lean: f64,
    /// Extension of the jumping leg (m).
    pub extension: f64,
    /// Chamber pressure (Pa, absolute); 0 for a leg without a chamber.
    pub pressure: f64,
    /// The ground's force on the jumping foot (N): normal, along the travel, across it.
    pub force: [f64; 3],
    /// Slip speed of that foot (m/s), along the travel and across it.
    pub slip: [f64; 2],
    /// All coordinates.
    pub coordinates: Vec<f64>,
    /// All velocities.
    pub velocities: Vec<f64>,
}

/// What happened in a jump.
#[derive(Clone, Debug)]
pub struct Report {
    /// How it ended.
    pub end: End,
    /// The jumping foot's lift-off, if there was one: at the end stop or, where its normal force
    /// fell to 0, before it.
    pub lift_off: Option<LiftOff>,
    /// Greatest height of the axle (m).
    pub apex: f64,
    /// Travel (m) from the foothold to where the axle comes down to the height of standing; NaN
    /// where it does not.
    pub landing: f64,
    /// The same, to the landing height asked for.
    pub landing_at: f64,
    /// Least normal force on the jumping foot (N) while it stood or slipped.
    pub least_normal: f64,
    /// Greatest |force along the travel|/normal of the standing foot.
    pub friction_needed: f64,
    /// When the jumping foot first slipped along the travel (s); none: never.
    pub slips_at: Option<f64>,
    /// How far it slipped along the travel and across it, net, until lift-off (m).
    pub slipped: [f64; 2],
    /// Work and energy at the end.
    pub ledger: Ledger,
    /// Energy (J) that no entry of the ledger explains.
    pub residual: f64,
    /// The course, every `Plan::sample` seconds, at lift-off and at the lowest landing.
    pub samples: Vec<Sample>,
}

/// How a jump is simulated.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// The integrator's settings.
    pub settings: Settings,
    /// Time (s) between samples, > 0.
    pub sample: f64,
    /// The same in flight; none: as before it.
    pub flight_sample: Option<f64>,
    /// Height of the axle (m) at which [`Report::landing_at`] is taken.
    pub landing_height: f64,
    /// Longest time (s) from the start to firing, and from there to lift-off.
    pub patience: f64,
}

/// Longest flight (s): one on a boom that is balanced does not end.
const LONGEST_FLIGHT: f64 = 100.0;

impl Default for Plan {
    fn default() -> Plan {
        Plan {
            settings: Settings::default(),
            sample: 1e-3,
            flight_sample: None,
            landing_height: 0.0,
            patience: 3.0,
        }
    }
}

impl Rig {
    /// Simulates the jump `launch`. In flight nothing touches: the axle may come down as low as
    /// asked.
    ///
    /// # Errors
    /// [`SimError`] for numbers that are no jump, or a motion that cannot go on.
    pub fn jump(&self, launch: &Launch, plan: &Plan) -> Result<Report, SimError> {
        check(launch, plan)?;
        let (q, v) = self.stand(launch.lean, launch.rate)?;
        let sim = Sim::new(
            &self.mechanism,
            &q,
            &v,
            Settings {
                penetration: 1e-9,
                ..plan.settings
            },
        )?;
        let start = sim.ledger();
        let recorder = Recorder {
            rig: self,
            plan: *plan,
            sim,
            samples: Vec::new(),
            start,
        };
        recorder.fly(launch)
    }
}

fn check(launch: &Launch, plan: &Plan) -> Result<(), SimError> {
    let (angle, open) = (launch.firing_angle, launch.valve_open);
    let (sample, patience, height) = (plan.sample, plan.patience, plan.landing_height);
    let in_flight = plan.flight_sample.unwrap_or(sample);
    ensure! {
        "firing angle (rad)", angle, angle.abs() < FRAC_PI_2 => "between -pi/2 and pi/2";
        "valve opening time (s)", open, (0.0..=1e3).contains(&open) => "from 0 to 1000";
        "time between samples (s)", sample, sample > 1e-7 && sample.is_finite() => "above 1e-7";
        "time between samples in flight (s)", in_flight, in_flight > 1e-7 && in_flight.is_finite()
            => "above 1e-7";
        "patience (s)", patience, patience > 0.0 && patience < 1e4 => "above 0, below 10000";
        "landing height (m)", height, height.is_finite() => "a finite number";
    }
    Ok(())
}

struct Recorder<'a> {
    rig: &'a Rig,
    plan: Plan,
    sim: Sim<'a>,
    samples: Vec<Sample>,
    start: Ledger,
}

impl Recorder<'_> {
    fn fly(mut self, launch: &Launch) -> Result<Report, SimError> {
        let (lean, rate) = (self.rig.lean_coordinate(), self.rig.lean_velocity());
        self.record();
        if self.has_left() {
            return Ok(self.finish(End::EarlyLiftOff, None));
        }
        let fire = |_: f64, q: &[f64], _: &[f64]| launch.firing_angle - q[lean];
        let rest = |_: f64, _: &[f64], v: &[f64]| v[rate];
        if launch.lean < launch.firing_angle {
            // At rest and leaning forward, it falls forward.
            if launch.rate <= 0.0 && launch.lean <= 0.0 {
                return Ok(self.finish(End::Stalled, None));
            }
            let until = self.plan.patience;
            match self.go(until, &[&fire, &rest], Recorder::has_left)? {
                Stopped::Watch(0) => {}
                Stopped::Left => return Ok(self.finish(End::EarlyLiftOff, None)),
                _ => return Ok(self.finish(End::Stalled, None)),
            }
        }
        let time_fire = self.sim.time();
        self.sim.fire(0, launch.valve_open)?;
        // A robot that has fallen over will not jump.
        let fallen = |_: f64, q: &[f64], _: &[f64]| FRAC_PI_2 - q[lean].abs();
        let until = time_fire + self.plan.patience;
        match self.go(until, &[&fallen], Recorder::has_left)? {
            Stopped::Left => {}
            _ => return Ok(self.finish(End::NoLiftOff, None)),
        }
        let lift_off = self.lift_off(time_fire);
        // A foot that leaves before its leg is free to move was not thrown off.
        let freed = Happening::BreakAway(self.rig.legs[0]);
        if !self.sim.events().iter().any(|e| e.what == freed) {
            return Ok(self.finish(End::EarlyLiftOff, Some(lift_off)));
        }
        self.descend(lift_off)
    }

    /// Whether the jumping foot has left the ground.
    fn has_left(&self) -> bool {
        self.sim
            .events()
            .iter()
            .any(|e| e.what == Happening::LiftOff(0, 0))
    }

    /// Goes on, sampling, until the time, a watch, or `left` holds.
    fn go(
        &mut self,
        until: f64,
        watches: &[crate::sim::Watch<'_>],
        left: impl Fn(&Self) -> bool,
    ) -> Result<Stopped, SimError> {
        // Samples do not cut fixed steps.
        let sample = match self.plan.settings.stepping {
            Stepping::Adaptive => self.plan.sample,
            Stepping::Fixed(h) => h * (self.plan.sample / h - 1e-9).ceil().max(1.0),
        };
        while self.sim.time() < until {
            let next = (self.sim.time() + sample).min(until);
            let pause = self.sim.run_eventwise(next, watches)?;
            if left(self) {
                return Ok(Stopped::Left);
            }
            if let Some(Pause::Watch(i)) = pause {
                return Ok(Stopped::Watch(i));
            }
            if pause.is_some() {
                self.record();
            }
        }
        Ok(Stopped::Time)
    }

    fn lift_off(&mut self, time_fire: f64) -> LiftOff {
        self.record();
        let (q, v) = (self.sim.coordinates(), self.sim.velocities());
        let extension = q[self.rig.extension_coordinate(0)];
        LiftOff {
            time: self.sim.time(),
            time_fire,
            outcome: if extension >= self.rig.mechanism.legs[0].leg.stroke {
                Outcome::Stroke
            } else {
                Outcome::Force
            },
            lean: q[self.rig.lean_coordinate()],
            rate: v[self.rig.lean_velocity()],
            extension,
            extension_rate: v[self.rig.mechanism.tree.velocity_of(self.rig.legs[0])],
            pressure: self.sim.pressure(0),
            axle: self.rig.axle(q),
            axle_rates: self.rig.axle_rates(q, v),
        }
    }

    /// The flight, down to both landing heights.
    fn descend(mut self, lift_off: LiftOff) -> Result<Report, SimError> {
        self.sim.stop_touching();
        self.plan.sample = self.plan.flight_sample.unwrap_or(self.plan.sample);
        let rig = self.rig;
        let rising = |_: f64, q: &[f64], v: &[f64]| rig.axle_rates(q, v)[1];
        let until = self.sim.time() + LONGEST_FLIGHT;
        let mut apex = lift_off.axle[1];
        if lift_off.axle_rates[1] > 0.0 {
            if self.go(until, &[&rising], |_| false)? != Stopped::Watch(0) {
                return Ok(self.finish(End::NoLiftOff, Some(lift_off)));
            }
            apex = rig.axle(self.sim.coordinates())[1];
        }
        let mut landings = [f64::NAN; 2];
        let mut heights = [(0, rig.radius), (1, self.plan.landing_height)];
        heights.sort_by(|a, b| b.1.total_cmp(&a.1));
        for (which, height) in heights {
            let above = |_: f64, q: &[f64], _: &[f64]| rig.axle(q)[1] - height;
            if apex < height {
                continue;
            }
            let here = rig.axle(self.sim.coordinates());
            // The second of two equal heights is where the first is.
            if here[1] <= height + 1e-12
                || self.go(until, &[&above], |_| false)? == Stopped::Watch(0)
            {
                landings[which] = rig.axle(self.sim.coordinates())[0];
            }
        }
        self.record();
        let mut report = self.finish(End::Landed, Some(lift_off));
        (report.apex, report.landing, report.landing_at) = (apex, landings[0], landings[1]);
        Ok(report)
    }

    fn record(&mut self) {
        let contacts = self.sim.contacts();
        let foot = contacts.iter().find(|c| c.point == 0);
        let (q, v) = (self.sim.coordinates(), self.sim.velocities());
        let sample = Sample {
            time: self.sim.time(),
            axle: self.rig.axle(q),
            axle_rates: self.rig.axle_rates(q, v),
            lean: q[self.rig.lean_coordinate()],
            extension: q[self.rig.extension_coordinate(0)],
            pressure: self.sim.pressure(0),
            force: foot.map_or([0.0; 3], |c| c.parts.into()),
            slip: foot.map_or([0.0; 2], |c| c.slip),
            coordinates: q.to_vec(),
            velocities: v.to_vec(),
        };
        self.samples.push(sample);
    }

    fn finish(self, end: End, lift_off: Option<LiftOff>) -> Report {
        let ledger = self.sim.ledger();
        let stance = lift_off.map_or(f64::INFINITY, |l| l.time);
        // The last sample of a stance is that of a foot in the air.
        let standing: Vec<&Sample> = self.samples.iter().filter(|s| s.time < stance).collect();
        let least_normal = standing
            .iter()
            .map(|s| s.force[0])
            .fold(f64::INFINITY, f64::min);
        let needed = |s: &&Sample| (s.force[0] > 0.0).then(|| (s.force[1] / s.force[0]).abs());
        let last = lift_off
            .filter(|l| l.outcome == Outcome::Stroke)
            .and_then(|l| at_end(&standing, l.time, needed));
        let friction_needed = standing
            .iter()
            .filter_map(needed)
            .chain(last)
            .fold(0.0, f64::max);
        let slips_at = self
            .sim
            .events()
            .iter()
            .find(|e| e.time < stance && e.what == Happening::Slip(0, 0, 0))
            .map(|e| e.time);
        let mut slipped = [0.0; 2];
        for pair in standing.windows(2) {
            for k in 0..2 {
                slipped[k] +=
                    0.5 * (pair[0].slip[k] + pair[1].slip[k]) * (pair[1].time - pair[0].time);
            }
        }
        Report {
            end,
            lift_off,
            apex: f64::NAN,
            landing: f64::NAN,
            landing_at: f64::NAN,
            least_normal,
            friction_needed,
            slips_at,
            slipped,
            residual: ledger.residual(&self.start),
            ledger,
            samples: self.samples,
        }
    }
}

/// What `of` comes to at the end of the stance, which is later than its last sample: by the
/// parabola through the last three.
fn at_end(standing: &[&Sample], end: f64, of: impl Fn(&&Sample) -> Option<f64>) -> Option<f64> {
    let [.., a, b, c] = standing else { return None };
    let (fa, fb, fc) = (of(a)?, of(b)?, of(c)?);
    let (ta, tb, tc) = (a.time - end, b.time - end, c.time - end);
    let value = fa * tb * tc / ((ta - tb) * (ta - tc))
        + fb * ta * tc / ((tb - ta) * (tb - tc))
        + fc * ta * tb / ((tc - ta) * (tc - tb));
    value.is_finite().then_some(value)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stopped {
    Time,
    Watch(usize),
    Left,
}
