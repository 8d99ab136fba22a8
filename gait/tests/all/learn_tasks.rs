//! The robot in the tasks of learning: which way is forwards, which leg fires, what is the goal.

use saltus_gait::learn::{
    Act, Actions, Bin, Bins, Environment, Episode, Gridded, Legs, Outcome, Plant, Reward, Step,
    Stride, Task, Term, Zone,
};
use saltus_gait::{
    Decides, Footfall, GaitError, Learnt, Obstacle, Program, Row, Run, Setup, Smooth, run,
};
use saltus_robot::Robot;

fn robot() -> Robot {
    saltus_robot::resolve("rats-run", &[]).expect("built in")
}

fn plant(rear: usize) -> Plant {
    Plant {
        rear: Some(rear),
        ..Plant::new(robot())
    }
}

fn rate() -> Reward {
    Reward(vec![(Term::Rate, 1.0)])
}

fn legs(plant: Plant, reward: Reward, steps: usize) -> Legs {
    Legs::new(plant, reward, steps).expect("legal")
}

/// Goes on to the end, or for so many steps; the sum of the rewards.
fn go(
    episode: &mut dyn Episode,
    steps: usize,
    mut act: impl FnMut(&[f64]) -> usize,
) -> Result<(f64, Outcome), GaitError> {
    let mut total = 0.0;
    for _ in 0..steps {
        let choice = act(episode.observation());
        let step = episode.step(Act::Choice(choice))?;
        total += step.reward;
        if step.is_over() {
            break;
        }
    }
    Ok((total, episode.outcome()))
}

#[test]
fn the_rear_leg_pushes_forwards_and_the_front_leg_back() -> Result<(), GaitError> {
    for rear in 0..5 {
        let task = legs(plant(rear), rate(), 200);
        let pushed = |leg: usize| go(&mut *task.start(1)?, 200, |_| 1 + leg);
        let (forwards, ahead) = pushed(rear)?;
        let (_, back) = pushed((rear + 1) % 5)?;
        assert!(
            ahead.angle > 0.05 && ahead.travel > 0.01 && forwards > 0.0,
            "{ahead:?}"
        );
        assert!(back.angle < -0.05 && back.travel < -0.01, "{back:?}");
        let (_, rests) = go(&mut *task.start(1)?, 200, |_| 0)?;
        assert!(rests.angle.abs() < 1e-6 && rests.firings == 0 && rests.gas == 0.0);
    }
    Ok(())
}

#[test]
fn the_leg_in_the_zone_does_not_depend_on_where_the_wheel_stands() -> Result<(), GaitError> {
    // A wheel of five equal legs, turned by one: the same motion. Were another leg fired, another.
    let of = |rear: usize| {
        let task = Zone::new(plant(rear), rate(), Task::default())?;
        // What the task fires first is the rear leg.
        let (_, first) = go(&mut *task.start(3)?, 12, |_| 1)?;
        let (_, leg) = go(&mut *legs(plant(rear), rate(), 60).start(3)?, 60, |_| {
            1 + rear
        })?;
        assert!((leg.angle - first.angle).abs() < 1e-12, "{leg:?} {first:?}");
        // Then each leg in the late part of the zone.
        let late = |seen: &[f64]| usize::from((seen[0] + 0.3).rem_euclid(PITCH) > 0.6);
        let (_, outcome) = go(&mut *task.start(3)?, 200, late)?;
        Ok::<Outcome, GaitError>(outcome)
    };
    let first = of(0)?;
    assert!(first.angle > 0.5 && first.firings > 1, "{first:?}");
    for rear in 1..5 {
        let other = of(rear)?;
        assert!(
            (other.angle - first.angle).abs() < 1e-9,
            "{first:?} {other:?}"
        );
        assert_eq!(other.firings, first.firings);
    }
    Ok(())
}

#[test]
fn a_mirrored_robot_would_run_the_other_way() -> Result<(), GaitError> {
    // The pose of rest is its own mirror image: pushing with the front leg is pushing with the rear leg, backwards.
    let task = legs(plant(0), rate(), 150);
    let (_, ahead) = go(&mut *task.start(1)?, 150, |_| 1)?;
    let (_, back) = go(&mut *task.start(1)?, 150, |_| 2)?;
    assert!(
        (ahead.angle + back.angle).abs() < 1e-6,
        "{ahead:?} {back:?}"
    );
    assert!((ahead.travel + back.travel).abs() < 1e-6);
    Ok(())
}

#[test]
fn rewards_are_what_the_episode_came_to() -> Result<(), GaitError> {
    let total = |term: Term| {
        let task = legs(plant(0), Reward(vec![(term, 1.0)]), 400);
        go(&mut *task.start(1)?, 400, |seen| usize::from(seen[0] > 0.4))
    };
    let (time, outcome) = total(Term::Time)?;
    assert!((time + outcome.time).abs() < 1e-9 && (outcome.time - 0.4).abs() < 1e-9);
    let (gas, outcome) = total(Term::Gas)?;
    assert!(outcome.gas > 0.0 && (gas + outcome.gas).abs() < 1e-12);
    let (way, outcome) = total(Term::Travel)?;
    assert!((way - outcome.travel).abs() < 1e-12);
    // Rates summed over 1 ms are angles, and speeds ways.
    let (rates, outcome) = total(Term::Rate)?;
    assert!((1e-3 * rates - outcome.angle).abs() < 0.02 * outcome.angle.abs());
    let (speeds, outcome) = total(Term::Speed(-100.0))?;
    let way = -1e-3 * speeds - 100.0 * outcome.time;
    assert!((way - outcome.travel).abs() < 0.02 * outcome.travel.abs());
    Ok(())
}

/// Angle (rad) between two legs.
const PITCH: f64 = std::f64::consts::TAU / 5.0;

/// Fires each leg once as it comes to stand upright.
fn runs(seen: &[f64]) -> usize {
    let lean = |leg: usize| {
        let turned = seen[0] - PITCH * leg as f64;
        turned - std::f64::consts::TAU * (turned / std::f64::consts::TAU).round()
    };
    let from = if seen[1] < 2.0 { 0.45 } else { 0.2 };
    (0..5)
        .find(|leg| (from..from + 0.45).contains(&lean(*leg)))
        .map_or(0, |leg| leg + 1)
}

fn before(height: f64, length: f64) -> Plant {
    Plant {
        obstacles: vec![Obstacle {
            front: 0.5,
            length,
            height,
        }],
        ..plant(0)
    }
}

#[test]
fn a_foot_on_the_box_ends_the_climb_and_nothing_else_does() -> Result<(), GaitError> {
    let reward = || Reward(vec![(Term::Arrival, 7.0)]);
    // Without a box, before one that is too high, and on a low one.
    let (total, plain) = go(&mut *legs(plant(0), reward(), 2000).start(1)?, 2000, runs)?;
    assert!(
        plain.travel > 1.0 && plain.arrived.is_none() && total == 0.0,
        "{plain:?}"
    );
    let (total, high) = go(
        &mut *legs(before(0.21, 0.21), reward(), 2000).start(1)?,
        2000,
        runs,
    )?;
    assert!(high.arrived.is_none() && total == 0.0, "{high:?}");
    let (total, low) = go(
        &mut *legs(before(0.03, 0.8), reward(), 2000).start(1)?,
        2000,
        runs,
    )?;
    assert!(low.arrived.is_some() && total == 7.0, "{low:?}");
    assert!(
        (0.5..1.3).contains(&low.travel) && low.time < 2.0,
        "{low:?}"
    );
    Ok(())
}

#[test]
fn no_valve_commands_throw_the_robot_about() -> Result<(), GaitError> {
    // Found by a learner: in the last of these milliseconds a step that was tried anew, longer, began with the acceleration
    // of an impulse in a short one, and the wheel turned at 22 rad/s.
    const COMMANDS: &str = "35555555555555110001133005005545555555555115555555255552555533333333315533335555555511414222\
                            22222414100";
    let task = legs(before(0.21, 0.21), rate(), COMMANDS.len());
    let mut episode = task.start(1)?;
    for command in COMMANDS.bytes() {
        episode.step(Act::Choice(usize::from(command - b'0')))?;
        let rate = episode.observation()[1];
        assert!(rate.abs() < 3.0, "{rate} rad/s");
    }
    Ok(())
}

#[test]
fn a_robot_that_jams_on_a_box_stays_where_it_is() -> Result<(), GaitError> {
    // Found by learners, a valve for each 50 ms: between box and ground feet slip and legs slide at once, and a way out of a
    // penetration of micrometres that held all of them was metres long.
    const COMMANDS: [&str; 4] = [
        "4133043114144510412320354542025055140155",
        "0132035404004551321531311205245510040023",
        "5453351400431011121410403045042423333323",
        "4503410133055413113430243315115450504042",
    ];
    for commands in COMMANDS {
        let mut episode = legs(before(0.21, 0.21), rate(), 2000).start(1)?;
        let mut last = episode.outcome();
        for command in commands.bytes() {
            for _ in 0..50 {
                episode.step(Act::Choice(usize::from(command - b'0')))?;
                let now = episode.outcome();
                let way = now.travel - last.travel;
                assert!(
                    way.abs() < 0.02,
                    "{way} m in 1 ms, at {} s: {commands}",
                    now.time
                );
                last = now;
            }
        }
        assert!(!last.broken && last.travel.abs() < 0.6, "{last:?}");
    }
    Ok(())
}

/// Ends a run where it has come so far.
struct Until(f64);

impl Run for Until {
    fn row(&mut self, row: &Row<'_>) {
        self.0 = row.axle[0];
    }
    fn footfall(&mut self, _: &Footfall) {}
    fn goes_on(&mut self) -> bool {
        self.0 < 1.6
    }
}

#[test]
fn strides_are_those_of_the_robots_controller() -> Result<(), GaitError> {
    // One firing angle and one opening time, at every rate.
    let law = Smooth {
        firing_angle: [0.4, 0.4, 5.0],
        valve_open: [0.05, 0.05, 5.0],
    };
    let mut setup = Setup::new(quiet(), law.program(), 2.5);
    setup.zone = -0.3;
    let by_controller = run(&setup, &mut Until(0.0))?.time_to_1_6_m;
    let task = Task {
        seconds: 2.5,
        ..Task::default()
    };
    let stride = Stride::new(Plant::new(quiet()), rate(), task, 99)?;
    let mut episode = stride.start(1)?;
    let over = |step: Step| step.is_over();
    while !over(episode.step(Act::Values(&[0.4, 0.05]))?) {}
    let outcome = episode.outcome();
    let (Some(ours), Some(theirs)) = (outcome.arrived, by_controller) else {
        panic!("{outcome:?} {by_controller:?}");
    };
    assert!((ours - theirs).abs() < 2e-3, "{ours} {theirs}");
    assert!(outcome.firings >= 3);
    Ok(())
}

#[test]
fn a_box_on_the_way_is_seen_and_in_the_way() -> Result<(), GaitError> {
    let task = Task {
        goal: 1.2,
        seconds: 2.0,
        ..Task::default()
    };
    let outcome = |height: f64| {
        let stride = Stride::new(before(height, 0.21), rate(), task, 99)?;
        assert_eq!(stride.observed().len(), 5);
        let mut episode = stride.start(1)?;
        assert!((episode.observation()[4] - 0.5).abs() < 0.01);
        loop {
            let step = episode.step(Act::Values(&[0.4, 0.05]))?;
            let (seen, came) = (episode.observation()[4], episode.outcome().travel);
            assert!((seen + came - 0.5).abs() < 0.01, "{seen} {came}");
            if step.is_over() {
                return Ok::<Outcome, GaitError>(episode.outcome());
            }
        }
    };
    assert!(outcome(0.01)?.arrived.is_some());
    assert!(outcome(0.35)?.arrived.is_none());
    // A single stride.
    let short = Stride::new(plant(0), rate(), Task::default(), 1)?;
    assert!(short.start(1)?.step(Act::Values(&[0.4, 0.05]))?.truncated);
    Ok(())
}

#[test]
fn choices_on_a_grid_are_values() -> Result<(), GaitError> {
    let stride = || Stride::new(plant(0), rate(), Task::default(), 99);
    let grid = Gridded::new(Box::new(stride()?), &[3, 2])?;
    assert_eq!(grid.actions().choices(), Some(6));
    let Actions::Values(axes) = stride()?.actions().clone() else {
        panic!("a stride has values");
    };
    let middle = f64::midpoint(axes[0].low, axes[0].high);
    let mut values = stride()?.start(5)?;
    let mut choices = grid.start(5)?;
    for _ in 0..4 {
        let by_value = values.step(Act::Values(&[middle, axes[1].high]))?;
        assert_eq!(by_value, choices.step(Act::Choice(3))?);
        if by_value.is_over() {
            break;
        }
    }
    assert_eq!(values.outcome(), choices.outcome());
    assert!(choices.step(Act::Choice(6)).is_err());
    assert!(Gridded::new(Box::new(stride()?), &[3]).is_err());
    assert!(Gridded::new(Box::new(legs(plant(0), rate(), 9)), &[3]).is_err());
    Ok(())
}

#[test]
fn what_cannot_be_done_is_refused() -> Result<(), GaitError> {
    let stride = Stride::new(plant(0), rate(), Task::default(), 99)?;
    let mut episode = stride.start(1)?;
    for bad in [
        [-0.31, 0.05],
        [1.0, 0.05],
        [0.2, -0.01],
        [0.2, 0.11],
        [f64::NAN, 0.05],
    ] {
        assert!(episode.step(Act::Values(&bad)).is_err(), "{bad:?}");
    }
    assert!(episode.step(Act::Choice(0)).is_err());
    let short = legs(plant(0), rate(), 1);
    let mut episode = short.start(1)?;
    assert!(episode.step(Act::Choice(6)).is_err());
    assert!(episode.step(Act::Choice(0))?.truncated);
    assert!(episode.step(Act::Choice(0)).is_err());
    Ok(())
}

/// A robot whose gyro is exact.
fn quiet() -> Robot {
    let mut quiet = robot();
    if let Some(sensors) = &mut quiet.sensors {
        sensors.gyro_noise = 0.0;
    }
    quiet
}

/// Travel (m) of a run by `learnt` for so many seconds, and its firings.
fn travel_by(learnt: Learnt, seconds: f64) -> Result<(f64, usize), GaitError> {
    let mut setup = Setup::new(quiet(), Program::Learnt(learnt), seconds);
    setup.zone = -0.3;
    let summary = run(&setup, &mut ())?;
    Ok((summary.travel, summary.firings))
}

/// A table without any sense, over `bins`, of so many choices.
fn table(bins: &Bins, count: usize, decides: Decides) -> Learnt {
    let choices = (0..bins.states()).map(|state| (1 + state * 7 + state / 31) % count);
    Learnt {
        axes: bins.axes().iter().map(Bin::steps).collect(),
        choices: choices
            .map(|choice| u8::try_from(choice).unwrap_or(0))
            .collect(),
        decides,
    }
}

/// An episode by a table, and its travel.
fn episode_by(task: &dyn Environment, learnt: &Learnt) -> Result<Outcome, GaitError> {
    let mut episode = task.start(1)?;
    loop {
        let choice = learnt.choice(episode.observation());
        if episode.step(Act::Choice(usize::from(choice)))?.is_over() {
            return Ok(episode.outcome());
        }
    }
}

#[test]
fn a_table_runs_as_it_was_learnt() -> Result<(), GaitError> {
    let learnt = table(&Bins::of_table_6_1(), 6, Decides::Legs);
    let task = legs(Plant::new(quiet()), rate(), 700);
    let ours = episode_by(&task, &learnt)?;
    let (travel, _) = travel_by(learnt, 0.7)?;
    assert!(
        ours.travel.abs() > 0.01 && (travel - ours.travel).abs() < 1e-9,
        "{travel} {ours:?}"
    );

    let period = Task::default().period;
    let learnt = table(&Bins::of_table_6_3(), 2, Decides::Zone { period });
    let course = Task {
        seconds: 0.7,
        ..Task::default()
    };
    let ours = episode_by(&Zone::new(Plant::new(quiet()), rate(), course)?, &learnt)?;
    let (travel, _) = travel_by(learnt, 0.7)?;
    assert!(
        ours.travel.abs() > 0.01 && (travel - ours.travel).abs() < 1e-9,
        "{travel} {ours:?}"
    );

    let bin = |from, to, count| Bin { from, to, count };
    let bins = Bins::new(vec![
        bin(-5.0, 20.0, 20),
        bin(-0.3, 1.0, 5),
        bin(0.0, 4.0, 7),
        bin(-0.2, 0.2, 3),
    ])?;
    let firings: Vec<[f64; 2]> = (0..6).map(|k| [0.1 * f64::from(k), 0.05]).collect();
    let stride = Stride::new(Plant::new(quiet()), rate(), course, 99)?;
    let decides = Decides::Stride {
        firings: firings.clone(),
        front: None,
    };
    let learnt = table(&bins, 6, decides);
    let mut episode = stride.start(1)?;
    loop {
        let choice = learnt.choice(episode.observation());
        if episode
            .step(Act::Values(&firings[usize::from(choice)]))?
            .is_over()
        {
            break;
        }
    }
    let ours = episode.outcome();
    let (travel, fired) = travel_by(learnt, 0.7)?;
    assert!((travel - ours.travel).abs() < 1e-9, "{travel} {ours:?}");
    assert!(fired == ours.firings && fired > 0, "{fired} {ours:?}");
    Ok(())
}
