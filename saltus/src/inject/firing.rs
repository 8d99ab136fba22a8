//! Hops, jumps and outcomes by the multi-body simulation.
//!
//! A leg is commanded at the tick at which the robot that the operator believes in would be: what
//! is hidden shows in the motion, and not in the command.

use saltus_diagnosis::kinds::{self, Problem};
use saltus_diagnosis::layout::{Draw, Layout, SUPPLY, TICK, round, supply};
use saltus_diagnosis::{Cause, Experiment, Kind, Sort, Terms};
use saltus_robot::{Drive, GaugePressure, Robot};
use saltus_sim_check::{Firing, Launch, Rig, Settings, Shot};

use super::{Asked, Error};

/// Least runs, or rows of outcomes, with a motion.
const LEAST: usize = 3;
/// Motions that are tried for each that is wanted: not every one that is drawn jumps.
const TRIES: usize = 40;

/// Fills a layout with motions of `robot` with the effects of `terms`.
pub(super) fn fill(
    layout: &mut Layout,
    robot: &Robot,
    terms: &Terms,
    asked: &[Asked],
    draw: &mut Draw,
) -> Result<(), Error> {
    let kind = layout.experiment.kind;
    let sensors = Sensors::new(&layout.experiment, robot, terms)?;
    if kind == Sort::Outcomes {
        return outcomes(layout, robot, terms, &sensors, asked, draw);
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
                "x_m",
                "y_m",
            ]
            .iter()
            .position(|n| n == name)
        })
        .map(Option::unwrap_or_default)
        .collect();
    let wanted = layout.experiment.runs.len();
    let mut made = 0;
    let tries = if asked.is_empty() {
        TRIES * wanted
    } else {
        asked.len()
    };
    for attempt in 0..tries {
        let firing = match asked.get(attempt) {
            _ if kind == Sort::Hop => Some(hop(robot, draw)),
            Some(asked) => jump_as_asked(robot, asked),
            None => jump(robot, draw),
        };
        let Some((supply, firing)) = firing else {
            continue;
        };
        let hidden = hidden(&layout.experiment, &supplied(robot, supply), terms)?;
        let rig = Rig::new(&hidden, &[]).ok();
        let Some(flown) = rig.and_then(|rig| rig.flown(&firing, settings())) else {
            continue;
        };
        let values = columns.iter().enumerate().map(|(c, k)| {
            let exact: Vec<f64> = flown.rows.iter().map(|row| row[*k]).collect();
            sensors.read(c, &exact)
        });
        layout.put(
            made,
            supply,
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
    asked: &[Asked],
    draw: &mut Draw,
) -> Result<(), Error> {
    let hidden = hidden(&layout.experiment, robot, terms)?;
    let wanted = layout.experiment.runs[0].time.len();
    let no_motion = |made| Error::NoMotion {
        made,
        wanted,
        least: LEAST.min(wanted),
    };
    let rig = |robot: &Robot| Rig::new(robot, &[]).map_err(|_| no_motion(0));
    let (believed, rig) = (rig(robot)?, rig(&hidden)?);
    let mut rows: Vec<[f64; 5]> = Vec::new();
    let tries = if asked.is_empty() {
        TRIES * wanted
    } else {
        asked.len()
    };
    for attempt in 0..tries {
        let asked = asked.get(attempt).map_or_else(
            || {
                [
                    pace(robot) * draw.stepped(3.0, 6.0, 0.01),
                    draw.stepped(-0.25, 0.3, 1e-3),
                    draw.stepped(0.03, 0.1, TICK),
                ]
                .map(round)
            },
            |asked| [asked.rate, asked.firing_angle, asked.valve_open],
        );
        let launch = Launch {
            rate: asked[0],
            lean: asked[1],
            firing_angle: asked[1],
            valve_open: asked[2],
        };
        if believed.landed(&launch, settings()).is_none() {
            continue;
        }
        if let Some([distance, apex]) = rig.landed(&launch, settings()) {
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

/// Gain, offset and delay (s) of a column.
pub(super) fn sensor(model: &dyn Kind, column: &str, terms: &Terms) -> [f64; 3] {
    let one = |id: &str, none: f64| {
        let is_it = |c: &Cause| c.id == id && c.column.as_deref() == Some(column);
        let cause = model.causes().iter().position(is_it);
        cause.map_or(none, |cause| terms.get(cause, 0))
    };
    [
        one("encoder-scale", 1.0),
        one("sensor-offset", 0.0),
        one("sensor-delay", 0.0),
    ]
}

/// Gain, offset and delay (s) of each column.
struct Sensors(Vec<[f64; 3]>);

impl Sensors {
    fn new(experiment: &Experiment, robot: &Robot, terms: &Terms) -> Result<Sensors, Problem> {
        let model = kinds::build(experiment, Some(robot))?;
        let of = |column: &String| sensor(model.as_ref(), column, terms);
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

/// Gauge pressure (Pa) of the supply; of a leg without gas any.
fn full(robot: &Robot) -> f64 {
    robot.leg.cylinder().map_or(SUPPLY, |own| own.supply.0)
}

/// Rates of a robot in terms of those of the thesis' one, whose wheel is larger or smaller.
fn pace(robot: &Robot) -> f64 {
    let fall = |gravity: f64, radius: f64| (gravity / radius).sqrt();
    let thesis = Robot::rats_planar();
    fall(robot.environment.gravity, robot.body.radius)
        / fall(thesis.environment.gravity, thesis.body.radius)
}

/// A supply (Pa, gauge), and a hop at it.
fn hop(robot: &Robot, draw: &mut Draw) -> (f64, Firing) {
    let supply = supply(full(robot), 8.0, 12.0, draw);
    let firing = Firing {
        lean: 0.0,
        rate: 0.0,
        on: 5.0 * TICK,
        opening: round(draw.stepped(0.02, 0.08, TICK)),
    };
    (supply, firing)
}

/// A supply (Pa, gauge), and a jump at it of the robot without effects, if what is drawn is one.
fn jump(robot: &Robot, draw: &mut Draw) -> Option<(f64, Firing)> {
    let lean = draw.between(-0.45, -0.15);
    let rate = pace(robot) * draw.between(3.0, 6.0);
    let (angle, opening) = (
        draw.between(-0.1, 0.25),
        round(draw.stepped(0.04, 0.1, TICK)),
    );
    let supply = supply(full(robot), 10.0, 12.0, draw);
    firing(robot, [lean, rate], angle, opening, supply)
}

/// How long before the firing angle (rad) a jump that is asked for begins.
const BEFORE: f64 = 0.25;

/// The same of what is asked for.
fn jump_as_asked(robot: &Robot, asked: &Asked) -> Option<(f64, Firing)> {
    let of_robot = robot.leg.cylinder().map(|cylinder| cylinder.supply.0);
    let supply = asked.supply.or(of_robot)?;
    let angle = asked.firing_angle;
    // The leg's pivoting keeps its energy: ω² + 2 g M r cos φ/(I + M r²).
    let (mass, radius) = (robot.axle_mass(), robot.body.radius);
    let lever = mass * radius / (robot.body.inertia + mass * radius * radius);
    let square = |before: f64| {
        let fall = (angle - before).cos() - angle.cos();
        asked.rate * asked.rate - 2.0 * robot.axle_gravity() * lever * fall
    };
    let before = [BEFORE, 0.5 * BEFORE, 0.25 * BEFORE];
    let before = before.into_iter().find(|b| square(*b) > 0.0)?;
    let start = [angle - before, square(before).sqrt()];
    firing(robot, start, angle, asked.valve_open, supply)
}

/// The firing of a robot that starts at a lean (rad) and a rate (rad/s), if it is a jump.
fn firing(
    robot: &Robot,
    [lean, rate]: [f64; 2],
    angle: f64,
    opening: f64,
    supply: f64,
) -> Option<(f64, Firing)> {
    let rig = Rig::new(&supplied(robot, supply), &[]).ok()?;
    let mut shot = Shot::new(&rig, [lean, rate], settings()).ok()?;
    let reached = |_: f64, q: &[f64], _: &[f64]| angle - q[rig.lean_coordinate()];
    shot.go(0.6, &[&reached]).ok()?;
    let on = round((shot.time() / TICK).ceil() * TICK);
    let firing = Firing {
        lean,
        rate,
        on,
        opening,
    };
    let flown = rig.flown(&firing, settings())?;
    // With some flight to see.
    let has_flight = flown.rows.len() as f64 * TICK > flown.lift_off + 0.15;
    (on < 0.55 && has_flight).then_some((supply, firing))
}

/// A jump that takes more steps is not worth the wait.
fn settings() -> Settings {
    Settings {
        most_steps: 4_000,
        ..Settings::default()
    }
}
