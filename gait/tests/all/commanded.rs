//! Commands to the valves as they are logged: they alone drive the robot to the same place.

use proptest::prelude::*;
use rand_pcg::Pcg64;
use saltus_controller::run::Steps;
use saltus_gait::space::{Gait, Roll, Stable, Steered, roll};
use saltus_gait::{
    Centre, Command, Decides, Footfall, GaitError, Learnt, Lines, Logged, Program, Row, Run, Setup,
    Smooth, Surroundings, World, run,
};
use saltus_robot::Robot;
use saltus_sim_check::{Rig, Settings, Sim};

/// What the rows of a run say of its valves.
struct Cycle {
    time: f64,
    /// The leg that is fired, and its valve opening time (s), where that is known.
    fired: Option<(usize, f64)>,
    /// For how long (s) of the cycle each valve is open.
    open: Vec<f64>,
}

/// The rows of a run, the log of its instruments, and where it ends.
struct Follow {
    cycles: Vec<Cycle>,
    logged: Logged,
    coordinates: Vec<f64>,
}

impl Run for Follow {
    fn row(&mut self, row: &Row<'_>) {
        self.logged.row(row);
        let open = row.outputs.iter();
        let fired = row
            .action
            .leg
            .map(|leg| (leg as usize, row.action.valve_open));
        self.cycles.push(Cycle {
            time: row.time,
            fired,
            open: open
                .map(|output| output.within(row.time, row.period))
                .collect(),
        });
        self.coordinates.clear();
        self.coordinates.extend_from_slice(row.coordinates);
    }

    fn footfall(&mut self, _: &Footfall) {}
}

/// When (s) valve `leg` is open, from and to, in the log of the instruments: a column of 0 and 1.
fn logged(follow: &Follow, leg: usize) -> Vec<[f64; 2]> {
    let mut all: Vec<[f64; 2]> = Vec::new();
    let mut since = None;
    let rows = follow.logged.time.iter().zip(&follow.logged.values[leg]);
    for (time, value) in rows {
        match (since, *value == 1.0) {
            (None, true) => since = Some(*time),
            (Some(from), false) => {
                all.push([from, *time]);
                since = None;
            }
            _ => {}
        }
    }
    all.extend(since.map(|from| [from, f64::INFINITY]));
    all
}

/// The same in the rows, whose cycles have a `period` (s).
fn in_rows(follow: &Follow, leg: usize, period: f64) -> Vec<[f64; 2]> {
    let mut all: Vec<[f64; 2]> = Vec::new();
    let mut goes_on = false;
    for Cycle { time, open, .. } in &follow.cycles {
        let open = open[leg];
        if open > 0.0 {
            match all.last_mut().filter(|_| goes_on) {
                Some(last) => last[1] = time + open,
                None => all.push([*time, time + open]),
            }
        }
        goes_on = open == period;
    }
    if let Some(last) = all.last_mut().filter(|_| goes_on) {
        last[1] = f64::INFINITY;
    }
    all
}

/// Where a robot of `setup` is at the begin of the last of `cycles`, if nobody decides and its valves do what the rows say.
fn driven(setup: &Setup, cycles: &[Cycle]) -> Result<Vec<f64>, GaitError> {
    let surroundings = Surroundings::new(&setup.robot, &[], &setup.disturbances)?;
    let q = surroundings.rig.rest(0)?;
    let v = vec![0.0; surroundings.rig.mechanism.tree.velocities()];
    let mut sensors = setup.sensors();
    let late = usize::from(sensors.output_delay_cycles > 0.5);
    sensors.output_delay_cycles = 0.0;
    let random = Pcg64::new(0, 0);
    let mut world = World::new(&surroundings, sensors, setup.stepping, (&q, &v), random)?;
    let holds = |cycle: &Cycle| cycle.fired.is_some_and(|(_, open)| open.is_infinite());
    let is_held = cycles.iter().any(holds);
    for (k, cycle) in cycles[..cycles.len() - 1].iter().enumerate() {
        let command = if is_held {
            Command::Hold(cycle.open.iter().position(|open| *open > 0.0))
        } else {
            k.checked_sub(late).and_then(|k| cycles[k].fired).into()
        };
        world.command(command)?;
        world.go_on(|_| ())?;
    }
    Ok(world.sim().coordinates().to_vec())
}

/// Drives a second robot by the rows of a run of `setup` alone; the longest opening (s). Both logs say the same.
fn replayed(setup: &Setup) -> Result<f64, GaitError> {
    let mut follow = Follow {
        cycles: Vec::new(),
        logged: Logged::new(&setup.robot),
        coordinates: Vec::new(),
    };
    run(setup, &mut follow)?;
    let there = driven(setup, &follow.cycles)?;
    assert_eq!(there, follow.coordinates, "the same place, to the bit");
    let period = setup.sensors().period;
    let end = period * follow.cycles.len() as f64;
    let mut longest = 0.0_f64;
    for leg in 0..setup.robot.body.legs as usize {
        let (logged, in_rows) = (logged(&follow, leg), in_rows(&follow, leg, period));
        assert_eq!(logged.len(), in_rows.len(), "{logged:?} {in_rows:?}");
        for (a, b) in logged.iter().flatten().zip(in_rows.iter().flatten()) {
            assert!(a == b || (a - b).abs() < 1e-9, "{logged:?} {in_rows:?}");
        }
        let spans = logged.iter().map(|[from, to]| to.min(end) - from);
        longest = spans.fold(longest, f64::max);
    }
    Ok(longest)
}

/// A table of random choices that `decides` something, over `axes`.
fn learnt(axes: &[(f64, f64, u16)], choices: u8, decides: Decides, seed: u64) -> Program {
    let axes: Vec<Steps<f64>> = (axes.iter())
        .map(|&(from, to, count)| Steps { from, to, count })
        .collect();
    let states: usize = axes.iter().map(|it| usize::from(it.count)).product();
    let mut state = seed.wrapping_mul(2).wrapping_add(1);
    let choice = |_| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        u8::try_from((state >> 33) % u64::from(choices)).unwrap_or(0)
    };
    Program::Learnt(Learnt {
        choices: (0..states).map(choice).collect(),
        axes,
        decides,
    })
}

/// Every gait and policy, by its number.
fn program(gait: usize, seed: u64) -> Program {
    let angle = (-3.2, 3.2);
    match gait {
        0 => Program::Fixed { firing_angle: 0.1 },
        1 => Program::OpenLoop {
            first: 0.35,
            last: 0.0,
            slope: 2.1,
            centre: Centre::Printed(1.0),
        },
        2 => Program::ClosedLoop(Lines::One {
            first: 0.35,
            last: -0.1,
            at: 13.3,
        }),
        3 => Smooth::QUICK.program(),
        4 => {
            let wide = [
                (-60.0, 60.0, 1),
                (0.0, 1.0, 2),
                (0.0, 1e8, 1),
                (0.0, 1.0, 1),
                (0.0, 10.0, 1),
            ];
            let axes = [
                &[(angle.0, angle.1, 20), (-20.0, 20.0, 2), (-1.0, 1.0, 1)],
                &wide[..],
            ]
            .concat();
            learnt(&axes, 6, Decides::Legs, seed)
        }
        5 => {
            let axes = [(angle.0, angle.1, 24), (-20.0, 20.0, 4)];
            learnt(&axes, 2, Decides::Zone { period: 0.005 }, seed)
        }
        _ => {
            let axes = [
                (-20.0, 20.0, 5),
                (-0.3, 1.0, 2),
                (-5.0, 5.0, 2),
                (-1.0, 1.0, 1),
            ];
            let firings = vec![[0.3, 0.04], [0.5, 0.06], [0.1, 0.0], [0.0, 0.1]];
            let decides = Decides::Stride {
                firings,
                front: None,
            };
            learnt(&axes, 4, decides, seed)
        }
    }
}

fn setup(gait: usize, seed: u64, late: bool, valve_open: f64) -> Setup {
    let mut robot = crate::robot("rats-run");
    if let Some(sensors) = &mut robot.sensors {
        sensors.output_delay_cycles = f64::from(u8::from(late));
    }
    let seconds = 1.2;
    let mut setup = if gait == 7 {
        let law = vec![[0.9, 0.55, 0.05], [1.4, 0.5, 0.05], [4.0, 0.0, 0.05]];
        Setup::holding(&robot, law, &[[0.0, 2.0]], seconds).expect("a boom")
    } else {
        Setup::new(robot, program(gait, seed), seconds)
    };
    if gait != 0 && gait != 7 {
        setup.zone = -0.3;
    }
    setup.seed = seed;
    setup.valve_open = valve_open;
    setup
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// Of every gait and of random policies, whose valves may be open for longer than until the leg fires again.
    #[test]
    fn the_log_alone_drives_a_robot_to_the_same_place(
        gait in 0_usize..8,
        seed in 0_u64..1000,
        late in any::<bool>(),
        valve_open in prop_oneof![0.02..0.06_f64, Just(0.04), 0.3..0.9_f64],
    ) {
        match replayed(&setup(gait, seed, late, valve_open)) {
            // What random choices try may be a motion without a solution.
            Ok(_) | Err(GaitError::Sim(_)) => {}
            Err(error) => prop_assert!(false, "gait {gait}: {error}"),
        }
    }
}

/// Policies that hold valves hold them for longer than a cycle, and the log says so.
#[test]
fn what_a_policy_holds_open_is_open_in_the_log() {
    for gait in [4, 5] {
        let longest = (0..8).map(|seed| replayed(&setup(gait, seed, false, 0.04)));
        let longest = longest.flatten().fold(0.0, f64::max);
        assert!(longest > 0.01, "{gait}: {longest} s");
    }
}

/// A leg that fires again while its valve is open: it is open to the end of the second firing.
#[test]
fn a_valve_that_is_fired_again_stays_open() -> Result<(), GaitError> {
    let robot = crate::robot("rats-run");
    let surroundings = Surroundings::new(&robot, &[], &[])?;
    let q = surroundings.rig.rest(0)?;
    let v = vec![0.0; surroundings.rig.mechanism.tree.velocities()];
    let supply = |fired: &[(usize, f64)]| -> Result<f64, GaitError> {
        let sensors = robot.sensors.unwrap_or_default();
        let stepping = saltus_sim_check::Stepping::USUAL;
        let mut world = World::new(&surroundings, sensors, stepping, (&q, &v), Pcg64::new(0, 0))?;
        for cycle in 0..200 {
            let fire = fired.iter().find(|it| it.0 == cycle).map(|it| (0, it.1));
            world.command(fire.into())?;
            world.go_on(|_| ())?;
        }
        Ok(world.sim().account(0).supplied)
    };
    let once = supply(&[(0, 0.1)])?;
    let twice = supply(&[(0, 0.04), (20, 0.08)])?;
    let shorter = supply(&[(0, 0.1), (20, 0.04)])?;
    assert!(
        (twice - once).abs() < 1e-12 && (shorter - once).abs() < 1e-12,
        "{once} {twice} {shorter} kg"
    );
    Ok(())
}

/// In space the rows name up to two legs and their opening times.
#[test]
fn in_space_the_rows_alone_drive_a_robot_to_the_same_place() -> Result<(), GaitError> {
    let robot = Robot::builtin("rats-twelve").expect("a built-in robot");
    let disc = Roll::new(robot, 1.5);
    let mut stable = disc.clone();
    stable.gait = Gait::Stable(Stable::default());
    let mut steered = disc.clone();
    steered.gait = Gait::Steered(Steered::new(vec![[5.0, 0.0]]));
    for setup in [disc, stable, steered] {
        let mut rows = Vec::new();
        let mut end = Vec::new();
        roll(&setup, |ball| {
            assert!(ball.fired.len() <= 2, "{:?}", ball.fired);
            rows.push(ball.fired.clone());
            end = [&ball.place[..], &ball.attitude].concat();
            true
        })?;
        assert!(rows.iter().any(|fired| !fired.is_empty()));
        let (rest, facing) = setup.facing()?;
        let rig = Rig::new(&setup.robot, &[])?;
        let mut q = rig.stand_on(&rest, &facing.ahead(&rest))?;
        q[2] -= rig.foot_gaps(&q).into_iter().fold(f64::INFINITY, f64::min);
        let v = vec![0.0; rig.mechanism.tree.velocities()];
        let settings = Settings {
            stepping: setup.stepping,
            most_steps: usize::MAX,
            ..Settings::default()
        };
        let mut sim = Sim::new(&rig.mechanism, &q, &v, settings)?;
        sim.release_legs()?;
        let period = setup.robot.sensors.unwrap_or_default().period;
        for (cycle, fired) in rows[..rows.len() - 1].iter().enumerate() {
            for firing in fired {
                sim.fire(firing.leg as usize, firing.open)?;
            }
            sim.run((cycle + 1) as f64 * period, &[])?;
        }
        let far = sim
            .coordinates()
            .iter()
            .zip(&end)
            .map(|(a, b)| (a - b).abs());
        let far = far.fold(0.0, f64::max);
        assert!(far < 1e-9, "{far}");
    }
    Ok(())
}
