//! A robot in its loop, stride by stride, that fires when it is told.

use rand_pcg::Pcg64;
use saltus_controller::run::{Action, Gait, Law, Runner, Signals, Standing};
use saltus_gait::{GaitError, Setup, Surroundings, World, instruments};
use saltus_numeric::parallel;
use saltus_robot::Sensors;

/// Longest stride (s): a slower one counts as a stall.
const PATIENCE: f64 = 1.0;
/// Least speed (m/s) at which the rest of the way is thought to go.
const SLOWEST: f64 = 0.5;

/// The way of a robot without disturbances.
pub(super) struct Way {
    setup: Setup,
    sensors: Sensors,
    surroundings: Surroundings,
    /// To travel (m).
    distance: f64,
    /// Stream of the noise.
    stream: u128,
}

/// A robot in the loop of its controller, which finds the leg in the zone and its rate; nothing fires
/// by itself. A clone goes on from the same state, to the bit.
#[derive(Clone)]
pub(super) struct Walker<'a> {
    way: &'a Way,
    world: World<'a>,
    runner: Runner<'a, f64>,
    /// What the controller found in this cycle.
    pub(super) action: Action<f64>,
    /// Legs that have come into the zone, less those that went back.
    pub(super) passed: i32,
    /// Time (s).
    pub(super) time: f64,
}

/// What a stride comes to.
#[derive(Clone)]
pub(super) enum After<'a> {
    /// A leg enters the zone.
    Entry(Box<Walker<'a>>),
    /// The distance is reached, at a time (s).
    Goal(f64),
    /// The stride takes too long.
    Stall,
}

impl Way {
    /// Without the sensors' noise; they still have their counts.
    pub(super) fn quiet(setup: &Setup, distance: f64) -> Result<Way, GaitError> {
        let sensors = Sensors {
            gyro_noise: 0.0,
            accelerometer_noise: 0.0,
            ..setup.sensors()
        };
        Way::new(setup, distance, (sensors, 0x0971))
    }

    /// With the noise that [`run`](saltus_gait::run) has.
    pub(super) fn noisy(setup: &Setup, distance: f64) -> Result<Way, GaitError> {
        Way::new(setup, distance, (setup.sensors(), 0x5a17))
    }

    fn new(
        setup: &Setup,
        distance: f64,
        (sensors, stream): (Sensors, u128),
    ) -> Result<Way, GaitError> {
        setup.flashed(|_| ())?;
        Ok(Way {
            surroundings: Surroundings::new(&setup.robot, &[], &[])?,
            setup: setup.clone(),
            sensors,
            distance,
            stream,
        })
    }

    fn gait(&self) -> Gait<'_, f64> {
        Gait {
            law: Law::Lines(&[]),
            zone: self.setup.zone,
            legs: self.setup.robot.body.legs,
            period: self.sensors.period,
            instruments: instruments(&self.sensors),
            taps: &self.setup.taps,
            hold: None,
            stall: self.setup.stall,
            first: &[],
            ahead: None,
            leap: None,
        }
    }

    /// At rest, in the first cycle.
    pub(super) fn begin(&self) -> Result<Walker<'_>, GaitError> {
        let q = self.surroundings.rig.rest(0)?;
        let v = vec![0.0; self.surroundings.rig.mechanism.tree.velocities()];
        let stepping = self.setup.stepping;
        let random = Pcg64::new(u128::from(self.setup.seed), self.stream);
        let mut world = World::new(&self.surroundings, self.sensors, stepping, (&q, &v), random)?;
        let gait = self.gait();
        let (rear, wheel) = self.stand(&mut world, &gait)?;
        let mut runner = Runner::new(gait, rear, wheel, true);
        let now = world.read();
        let action = runner.step(&now.readings);
        Ok(Walker {
            way: self,
            world,
            runner,
            action,
            passed: 0,
            time: now.time,
        })
    }

    /// The rear leg on which the robot finds itself, and its wheel's count there.
    fn stand(&self, world: &mut World<'_>, gait: &Gait<'_, f64>) -> Result<(u32, i32), GaitError> {
        let signals = Signals::new(gait.instruments, gait.taps);
        let mut standing = Standing::new();
        let mut wheel = 0;
        for _ in 0..200 {
            let readings = world.read().readings;
            standing.take(&signals, &readings);
            wheel = readings.wheel;
        }
        let gravity = self.setup.robot.environment.gravity;
        let rear = standing.rear_leg(&signals, gait.legs, gravity);
        rear.map(|rear| (rear, wheel)).map_err(GaitError::Unsure)
    }
}

impl<'a> Walker<'a> {
    /// Travel (m).
    pub(super) fn travel(&mut self) -> f64 {
        let rig = self.world.rig();
        rig.axle(self.world.sim().coordinates())[0]
    }

    /// What is left of the way (m).
    pub(super) fn left(&mut self) -> f64 {
        self.way.distance - self.travel()
    }

    /// Time (s) for what is left at the present speed.
    pub(super) fn time_left(&mut self) -> f64 {
        self.left() / self.measures()[3].max(SLOWEST)
    }

    /// What tells states apart beside `passed`: filtered rate (rad/s), travel and
    /// height of the axle (m), their rates (m/s), and by how much all legs are out (m).
    pub(super) fn measures(&mut self) -> [f64; 6] {
        let rig = self.world.rig();
        let sim = self.world.sim();
        let (q, v) = (sim.coordinates(), sim.velocities());
        let [travel, height] = rig.axle(q);
        let [along, up] = rig.axle_rates(q, v);
        let legs = 0..rig.legs.len();
        let out = legs.map(|leg| q[rig.extension_coordinate(leg)]).sum();
        [self.action.rate, travel, height, along, up, out]
    }

    /// A cycle, with the leg in the zone fired for `opening` (s) or not; whether a leg entered the
    /// zone.
    pub(super) fn cycle(&mut self, opening: Option<f64>) -> Result<bool, GaitError> {
        let fire = opening.map(|opening| (self.action.in_zone as usize, opening));
        self.world.command(fire.into())?;
        self.world.go_on(|_| ())?;
        let now = self.world.read();
        let before = self.action.in_zone;
        self.action = self.runner.step(&now.readings);
        self.time = now.time;
        let legs = self.way.setup.robot.body.legs;
        let came = (self.action.in_zone + legs - before) % legs;
        // Of two ways round the shorter.
        self.passed += if 2 * came < legs {
            came.cast_signed()
        } else {
            -(legs - came).cast_signed()
        };
        Ok(came != 0)
    }

    /// A cycle of a stride that began at `since` (s), and how the stride ends in it, if it does.
    fn after_cycle(&mut self, since: f64, opening: Option<f64>) -> Result<Option<End>, GaitError> {
        let enters = self.cycle(opening)?;
        Ok(if self.travel() >= self.way.distance {
            Some(End::Goal)
        } else if enters {
            Some(End::Entry)
        } else {
            (self.time - since > PATIENCE).then_some(End::Stall)
        })
    }

    /// The stride with a firing at an angle (rad) for a time (s), or without one.
    pub(super) fn follow(&self, firing: Option<[f64; 2]>) -> Result<After<'a>, GaitError> {
        let (mut walker, since) = (self.clone(), self.time);
        loop {
            if let Some([angle, opening]) = firing
                && walker.action.lean >= angle
            {
                return walker.roll(since, opening);
            }
            if let Some(end) = walker.after_cycle(since, None)? {
                return Ok(end.into_after(walker));
            }
        }
    }

    /// The stride that began at `since` (s), with a firing now for `opening` (s).
    fn roll(mut self, since: f64, opening: f64) -> Result<After<'a>, GaitError> {
        let mut opening = Some(opening);
        loop {
            if let Some(end) = self.after_cycle(since, opening.take())? {
                return Ok(end.into_after(self));
            }
        }
    }
}

/// How a stride ends.
enum End {
    Entry,
    Goal,
    Stall,
}

impl End {
    fn into_after(self, walker: Walker<'_>) -> After<'_> {
        match self {
            End::Entry => After::Entry(Box::new(walker)),
            End::Goal => After::Goal(walker.time),
            End::Stall => After::Stall,
        }
    }
}

/// Firing angles (rad, rising) and valve opening times (s) to choose from.
#[derive(Clone, Debug)]
pub(super) struct Choices {
    pub(super) angles: Vec<f64>,
    pub(super) openings: Vec<f64>,
}

/// What each choice comes to: firing none first, then each opening time at each group of angles that
/// fire in the same cycle; and the group of each angle, if its cycle comes.
pub(super) struct Fan<'a> {
    pub(super) after: Vec<After<'a>>,
    pub(super) groups: Vec<Option<usize>>,
}

impl<'a> Walker<'a> {
    /// What each of `choices` comes to, computed on so many `threads`.
    pub(super) fn fan(&self, choices: &Choices, threads: usize) -> Result<Fan<'a>, GaitError> {
        let since = self.time;
        let (mut fires, mut groups) = (Vec::new(), vec![None; choices.angles.len()]);
        let mut walker = self.clone();
        let mut next = 0;
        let never = loop {
            let lean = walker.action.lean;
            let due = choices.angles[next..]
                .iter()
                .take_while(|angle| lean >= **angle);
            let due = due.count();
            if due > 0 {
                groups[next..next + due].fill(Some(fires.len()));
                fires.push(walker.clone());
                next += due;
            }
            if let Some(after) = walker.after_cycle(since, None)? {
                break after.into_after(walker);
            }
        };
        let count = choices.openings.len();
        let one = |k: usize| {
            let walker = fires[k / count].clone();
            walker.roll(since, choices.openings[k % count])
        };
        let fired = parallel::map_on(threads, fires.len() * count, one);
        let after = std::iter::once(Ok(never))
            .chain(fired)
            .collect::<Result<_, _>>()?;
        Ok(Fan { after, groups })
    }
}
