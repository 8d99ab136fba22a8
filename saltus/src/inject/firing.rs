//! Hops, jumps and outcomes by the multi-body simulation.
//!
//! A leg is commanded at the tick at which the robot that the operator believes in would be: what
//! is hidden shows in the motion, and not in the command.

use saltus_diagnosis::kinds::{self, Problem};
use saltus_diagnosis::{Experiment, Sort, Terms};
use saltus_robot::{Drive, GaugePressure, Robot};
use saltus_sim_check::{Happening, Pause, Rig, Settings, Sim, Watch};

use super::layout::{Draw, Layout, TICK, round, supply};
use super::{Error, name};

/// Least runs, or rows of outcomes, with a motion.
const LEAST: usize = 3;
/// Motions that are tried for each that is wanted: not every one that is drawn jumps.
const TRIES: usize = 40;

/// One firing: a start (rad, rad/s), a supply (Pa, gauge), a command (s) and how long the valve is
/// open (s).
#[derive(Clone, Copy, Debug)]
struct Firing {
    lean: f64,
    rate: f64,
    supply: f64,
    on: f64,
    opening: f64,
}

/// What the operator asked of a jump: approach rate (rad/s), firing angle (rad), valve opening (s).
type Asked = [f64; 3];

/// Fills a layout with motions of `robot` with the effects of `terms`.
pub(super) fn fill(
    layout: &mut Layout,
    robot: &Robot,
    terms: &Terms,
    draw: &mut Draw,
) -> Result<(), Error> {
    let kind = layout.experiment.kind;
    if robot.boom.is_none() && kind != Sort::Outcomes {
        return Err(Error::NoBoom {
            robot: robot.name.clone(),
            kind: name(kind),
        });
    }
    let sensors = Sensors::new(&layout.experiment, robot, terms)?;
    if kind == Sort::Outcomes {
        return outcomes(layout, robot, terms, &sensors, draw);
    }
    let columns: Vec<usize> = layout
        .experiment
        .columns
        .iter()
        .map(|name| {
            [
                "wheel_angle_rad",
                "pivot_angle_rad",
                "radius_angle_rad",
                "wheel_rate_rad_s",
            ]
            .iter()
            .position(|n| n == name)
        })
        .map(Option::unwrap_or_default)
        .collect();
    let wanted = layout.experiment.runs.len();
    let mut made = 0;
    for _ in 0..TRIES * wanted {
        let firing = if kind == Sort::Hop {
            Some(hop(draw))
        } else {
            jump(robot, draw)
        };
        let Some(firing) = firing else { continue };
        let hidden = hidden(&layout.experiment, &supplied(robot, firing.supply), terms)?;
        let Some((_, rows)) = Stand::new(&hidden).and_then(|stand| stand.flown(&firing)) else {
            continue;
        };
        let values = columns.iter().enumerate().map(|(c, k)| {
            let exact: Vec<f64> = rows.iter().map(|row| row[*k]).collect();
            sensors.read(c, &exact)
        });
        layout.put(
            made,
            firing.supply,
            (firing.on, round(firing.on + firing.opening)),
            values.collect(),
        );
        made += 1;
        if made == wanted {
            break;
        }
    }
    layout.experiment.runs.truncate(made);
    if made < LEAST.min(wanted) {
        Err(Error::NoMotion {
            made,
            wanted,
            least: LEAST.min(wanted),
        })
    } else {
        Ok(())
    }
}

/// Fills the rows of outcomes.
fn outcomes(
    layout: &mut Layout,
    robot: &Robot,
    terms: &Terms,
    sensors: &Sensors,
    draw: &mut Draw,
) -> Result<(), Error> {
    let hidden = hidden(&layout.experiment, robot, terms)?;
    let wanted = layout.experiment.runs[0].time.len();
    let no_motion = |made| Error::NoMotion {
        made,
        wanted,
        least: LEAST.min(wanted),
    };
    let (believed, stand) = Stand::new(robot)
        .zip(Stand::new(&hidden))
        .ok_or_else(|| no_motion(0))?;
    let mut rows: Vec<[f64; 5]> = Vec::new();
    for _ in 0..TRIES * wanted {
        let asked = [
            draw.stepped(3.0, 6.0, 0.01),
            draw.stepped(-0.25, 0.3, 1e-3),
            draw.stepped(0.03, 0.1, TICK),
        ]
        .map(round);
        if believed.landed(&asked).is_none() {
            continue;
        }
        if let Some([distance, apex]) = stand.landed(&asked) {
            rows.push([asked[0], asked[1], asked[2], distance, apex]);
        }
        if rows.len() == wanted {
            break;
        }
    }
    if rows.len() < LEAST.min(wanted) {
        return Err(no_motion(rows.len()));
    }
    let column = |k: usize| sensors.read(k, &rows.iter().map(|row| row[k]).collect::<Vec<_>>());
    let run = &mut layout.experiment.runs[0];
    run.values = (0..5).map(column).collect();
    run.time.truncate(rows.len());
    Ok(())
}

/// The robot at a supply that the operator set (Pa, gauge).
fn supplied(robot: &Robot, supply: f64) -> Robot {
    let mut robot = robot.clone();
    if let Drive::Pneumatic(cylinder) = &mut robot.leg.drive {
        cylinder.supply = GaugePressure(supply);
    }
    robot
}

/// The robot with the effects of `terms`.
fn hidden(experiment: &Experiment, robot: &Robot, terms: &Terms) -> Result<Robot, Problem> {
    let mut robot = kinds::build(experiment, Some(robot))?
        .robot(terms)
        .ok_or(Problem::NoRobot)?;
    if robot.ground.stiffness.is_some() && robot.ground.static_friction.is_infinite() {
        // A foot that could not slip at all would take an impulse along soft ground as its leg
        // meets its stop.
        (robot.ground.static_friction, robot.ground.kinetic_friction) = (3.0, 3.0);
    }
    Ok(robot)
}

/// Gain, offset and delay (s) of each column.
struct Sensors(Vec<[f64; 3]>);

impl Sensors {
    fn new(experiment: &Experiment, robot: &Robot, terms: &Terms) -> Result<Sensors, Problem> {
        let model = kinds::build(experiment, Some(robot))?;
        let of = |column: &String| {
            let one = |id: &str, none: f64| {
                let is_it =
                    |c: &saltus_diagnosis::Cause| c.id == id && c.column.as_ref() == Some(column);
                model
                    .causes()
                    .iter()
                    .position(is_it)
                    .map_or(none, |cause| terms.get(cause, 0))
            };
            [
                one("encoder-scale", 1.0),
                one("sensor-offset", 0.0),
                one("sensor-delay", 0.0),
            ]
        };
        Ok(Sensors(experiment.columns.iter().map(of).collect()))
    }

    /// What a column says, whose exact values are a tick apart.
    fn read(&self, column: usize, exact: &[f64]) -> Vec<f64> {
        let [gain, offset, delay] = self.0[column];
        let late = |row: usize| {
            // Before the first row it went on as it does there.
            let place = (row as f64 - delay / TICK).min(exact.len() as f64 - 1.0);
            // A row.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let k = place.max(0.0) as usize;
            let next = exact[(k + 1).min(exact.len() - 1)];
            exact[k] + (place - k as f64) * (next - exact[k])
        };
        (0..exact.len())
            .map(|row| gain * if delay > 0.0 { late(row) } else { exact[row] } + offset)
            .collect()
    }
}

fn hop(draw: &mut Draw) -> Firing {
    let supply = supply(80.0, 120.0, draw);
    Firing {
        lean: 0.0,
        rate: 0.0,
        supply,
        on: 5.0 * TICK,
        opening: round(draw.stepped(0.02, 0.08, TICK)),
    }
}

/// A jump of the robot without effects, if what is drawn is one.
fn jump(robot: &Robot, draw: &mut Draw) -> Option<Firing> {
    let (lean, rate) = (draw.between(-0.45, -0.15), draw.between(3.0, 6.0));
    let (angle, opening) = (
        draw.between(-0.1, 0.25),
        round(draw.stepped(0.04, 0.1, TICK)),
    );
    let supply = supply(100.0, 120.0, draw);
    let stand = Stand::new(&supplied(robot, supply))?;
    let mut shot = Shot::new(&stand, [lean, rate])?;
    let reached = |_: f64, q: &[f64], _: &[f64]| angle - q[stand.rig.lean_coordinate()];
    shot.sim.run(0.6, &[&reached]).ok()?;
    let on = round((shot.sim.time() / TICK).ceil() * TICK);
    let firing = Firing {
        lean,
        rate,
        supply,
        on,
        opening,
    };
    let (lift_off, rows) = stand.flown(&firing)?;
    // With some flight to see.
    (on < 0.55 && rows.len() as f64 * TICK > lift_off + 0.15).then_some(firing)
}

/// A robot that stands on a foot.
struct Stand {
    rig: Rig,
    /// What stands on the foot at rest (N).
    weight: f64,
    /// Pressure (Pa) around it, where its chamber has an opening beside its valve.
    leaks_to: Option<f64>,
}

impl Stand {
    fn new(robot: &Robot) -> Option<Stand> {
        let rig = Rig::new(robot, &[]).ok()?;
        let leaks_to = match &robot.leg.drive {
            Drive::Pneumatic(c) if c.leak_area > 0.0 || c.exhaust_port.is_some() => {
                Some(robot.environment.ambient.0)
            }
            _ => None,
        };
        Some(Stand {
            weight: weight(&rig),
            rig,
            leaks_to,
        })
    }

    /// Lean, pivot angle and radius angle (rad), and what the gyro says (rad/s).
    fn readings(&self, sim: &Sim<'_>) -> [f64; 4] {
        let (q, v) = (sim.coordinates(), sim.velocities());
        let (turn, pivot, lean) = (q[0], q[1], q[self.rig.lean_coordinate()]);
        [
            lean,
            pivot,
            turn,
            v[self.rig.lean_velocity()] + v[0] * pivot.sin(),
        ]
    }

    /// A firing from standing through its flight, a row a tick, until the axle is back at its
    /// height or a foot touches: how long (s) it stood, and rows. None where the robot does not
    /// jump.
    fn flown(&self, firing: &Firing) -> Option<(f64, Vec<[f64; 4]>)> {
        let rig = &self.rig;
        let mut shot = Shot::new(self, [firing.lean, firing.rate])?;
        let mut rows = vec![self.readings(&shot.sim)];
        let mut is_fired = false;
        for row in 1..4000_u32 {
            let until = f64::from(row) * TICK;
            if !is_fired && until > firing.on + 0.5 * TICK {
                shot.sim.fire(0, firing.opening).ok()?;
                is_fired = true;
            }
            shot.go(until, &[])?;
            let q = shot.sim.coordinates();
            let (lean, extension) = (q[rig.lean_coordinate()], q[rig.extension_coordinate(0)]);
            if let Some(at) = shot.lift_off {
                let height = rig.axle(q)[1];
                let foot = height - (rig.radius + extension) * lean.cos();
                if !is_fired {
                    return None;
                }
                if height < rig.radius || (foot < 0.0 && until > at + 0.03) {
                    // Not every foot that leaves the ground has jumped.
                    return (until > at + 0.08 && extension > 0.02).then_some((at, rows));
                }
            } else if until > firing.on + 0.6 || lean.abs() > 1.5 {
                return None;
            }
            rows.push(self.readings(&shot.sim));
        }
        None
    }

    /// Distance and apex (m) of a jump that is commanded at its start, where it is one.
    fn landed(&self, &[rate, lean, opening]: &Asked) -> Option<[f64; 2]> {
        let rig = &self.rig;
        let mut shot = Shot::new(self, [lean, rate])?;
        shot.sim.fire(0, opening).ok()?;
        let rising = |_: f64, q: &[f64], v: &[f64]| rig.axle_rates(q, v)[1];
        let above = |_: f64, q: &[f64], _: &[f64]| rig.axle(q)[1] - rig.radius;
        let mut apex = None;
        while shot.time() < 3.0 {
            let stood = shot.lift_off.is_none();
            let watches: &[Watch<'_>] = match apex {
                _ if stood => &[],
                None => &[&rising],
                Some(_) => &[&above],
            };
            let pause = shot.go(shot.time() + if stood { TICK } else { 4.0 * TICK }, watches)?;
            let (q, v) = (shot.sim.coordinates(), shot.sim.velocities());
            match (pause, apex) {
                (Pause::Watch(_), None) => apex = Some(rig.axle(q)[1]),
                (Pause::Watch(_), Some(apex)) => return Some([rig.axle(q)[0], apex]),
                (Pause::Time, _) => {}
            }
            let leaves = stood && shot.lift_off.is_some();
            let falls =
                leaves && (rising(0.0, q, v) <= 0.0 || q[rig.extension_coordinate(0)] <= 0.0);
            let stays = shot.lift_off.is_none()
                && (shot.time() > 1.0 || q[rig.lean_coordinate()].abs() > 1.5);
            if falls || stays {
                return None;
            }
        }
        None
    }
}

/// What stands on the foot (N) of a robot at rest.
fn weight(rig: &Rig) -> f64 {
    let length = rig.boom.unwrap_or(1.0);
    // Along the boom, from its base; what is on the axle is a boom away.
    let arm = |name: &str, center: f64| match name {
        "boom" | "boom turn" => center,
        "boom's outer half" => center + 0.5 * length,
        _ => length,
    };
    let moment: f64 = rig
        .mechanism
        .tree
        .bodies()
        .iter()
        .map(|b| b.mass * arm(&b.name, b.center.y))
        .sum();
    -rig.mechanism.gravity.z * moment / length
}

/// A jump that takes more steps is not worth the wait.
fn settings() -> Settings {
    Settings {
        most_steps: 4_000,
        ..Settings::default()
    }
}

/// A motion from standing on a foot, in the air without touching.
struct Shot<'a> {
    stand: &'a Stand,
    sim: Sim<'a>,
    /// When (s) `sim` began.
    began: f64,
    lift_off: Option<f64>,
}

impl<'a> Shot<'a> {
    fn new(stand: &'a Stand, [lean, rate]: [f64; 2]) -> Option<Shot<'a>> {
        let rig = &stand.rig;
        let (mut q, v) = rig.stand(lean, rate).ok()?;
        let mut settings = settings();
        if let Some((stiffness, _)) = rig.mechanism.material.compliance {
            // Soft ground carries the robot from the start.
            let lighter = 1.0 - rate * rate * rig.radius * lean.cos() / -rig.mechanism.gravity.z;
            let sink = stand.weight * lighter.max(0.1) / stiffness;
            settings.penetration = 1.01 * sink + 1e-9;
            q[1] -= sink / rig.boom.unwrap_or(1.0);
        }
        let sim = Sim::new(&rig.mechanism, &q, &v, settings).ok()?;
        Some(Shot {
            stand,
            sim,
            began: 0.0,
            lift_off: None,
        })
    }

    fn time(&self) -> f64 {
        self.began + self.sim.time()
    }

    /// Goes on until `until` (s), or until a watch. None where that does not work.
    fn go(&mut self, until: f64, watches: &[Watch<'_>]) -> Option<Pause> {
        loop {
            match self.sim.run_eventwise(until - self.began, watches).ok()? {
                Some(Pause::Time) => {
                    if self
                        .lift_off
                        .is_some_and(|at| self.time() > at + 10.0 * TICK)
                    {
                        self.sim.stop_touching();
                    }
                    self.forget_chamber();
                    return Some(Pause::Time);
                }
                Some(pause) => return Some(pause),
                None => {}
            }
            let left = |sim: &Sim<'_>| {
                sim.events()
                    .iter()
                    .any(|e| e.what == Happening::LiftOff(0, 0))
            };
            if self.lift_off.is_none() && left(&self.sim) {
                self.lift_off = Some(self.time());
                // Soft ground lets go of a foot that is still in it.
                if self.stand.rig.mechanism.material.compliance.is_none() {
                    self.sim.stop_touching();
                }
            }
        }
    }

    /// Once the leg is exhausted in the air, and held, its chamber is as it was before: one with a
    /// leak that has come to the pressure around it costs thousands of events.
    fn forget_chamber(&mut self) {
        let rig = &self.stand.rig;
        let leg = rig.mechanism.tree.velocity_of(rig.legs[0]);
        let (q, v) = (self.sim.coordinates(), self.sim.velocities());
        let is_exhausted = |ambient: f64| (self.sim.pressure(0) - ambient).abs() < 500.0;
        let flies = self
            .lift_off
            .is_some_and(|at| self.time() > at + 5.0 * TICK);
        if self.began == 0.0
            && flies
            && v[leg] == 0.0
            && self.stand.leaks_to.is_some_and(is_exhausted)
            && let Ok(mut sim) = Sim::new(&rig.mechanism, q, v, settings())
        {
            sim.stop_touching();
            self.began = self.time();
            self.sim = sim;
        }
    }
}
