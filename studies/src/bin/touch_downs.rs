//! States of running robots, and where Saltus' simulation has the next foot come down from each:
//! the one side of `tests/mujoco/run.py touch_downs`.
//!
//! ```text
//! cd studies && cargo run --release --bin touch_downs -- STATES.csv OURS.csv 200
//! ```
//!
//! Rows of STATES.csv: coordinates, velocities, chamber pressures, and when each valve itself is
//! open, in seconds from the state on; of OURS.csv: time, leg, speed of the axle along the travel
//! (m/s), lean (rad) and rate (rad/s) just before. Where nothing is given, five of these are printed.

use std::fmt::Write as _;

use saltus_gait::{
    Disturbance, Footfall, GaitError, Lines, Program, Row, Run, Setup, What, When, run,
};
use saltus_sim_check::Stepping;

/// Time (s) between states, and of a state before what counts as the next touch-down.
const APART: f64 = 0.0437;
const LEAST: f64 = 5e-3;
/// How high (m) a foot has been since the state when it comes down: not every foot that leaves the
/// ground by a hair has left it.
const HIGH: f64 = 0.02;
/// Cycle (s) of the controller: the state before a touch-down is no older than this.
const CYCLE: f64 = 1e-4;

struct State {
    time: f64,
    row: String,
    valves: Vec<Option<[f64; 2]>>,
}

struct Recorder {
    delay: f64,
    next: f64,
    open: Option<State>,
    /// Each leg's latest opening (s).
    openings: Vec<[f64; 2]>,
    last: [f64; 3],
    /// How high each foot has been since the state (m).
    highest: [f64; 5],
    /// Axle to foot, leg retracted (m), and the foot's radius (m).
    reach: [f64; 2],
    states: String,
    ours: String,
    count: usize,
}

impl Run for Recorder {
    fn row(&mut self, row: &Row<'_>) {
        if let Some(leg) = row.action.leg {
            let from = row.time + self.delay;
            self.openings[leg as usize] = [from, from + row.action.valve_open];
            if let Some(state) = &mut self.open {
                state.valves[leg as usize].get_or_insert(self.openings[leg as usize]);
            }
        }
        for leg in 0..5 {
            let lean = row.lean - leg as f64 * std::f64::consts::TAU / 5.0;
            let [radius, foot] = self.reach;
            let down = (radius - foot + row.extensions[leg]) * lean.cos() + foot;
            self.highest[leg] = self.highest[leg].max(row.axle[1] - down);
        }
        if self.open.is_none() && row.time >= self.next {
            self.highest = [0.0; 5];
            let numbers = row
                .coordinates
                .iter()
                .chain(row.velocities)
                .chain(row.pressures);
            let cells: Vec<String> = numbers.map(|x| format!("{x:e}")).collect();
            let still = |o: &[f64; 2]| (o[1] > row.time).then_some(*o);
            self.open = Some(State {
                time: row.time,
                row: cells.join(","),
                valves: self.openings.iter().map(still).collect(),
            });
            self.next = row.time + APART;
        }
        self.last = [row.axle_rates[0], row.lean, row.rate];
    }

    fn footfall(&mut self, fall: &Footfall) {
        let is_next =
            |state: &mut State| fall.time >= state.time + LEAST && self.highest[fall.leg] > HIGH;
        let Some(state) = self.open.take_if(is_next) else {
            return;
        };
        let valves = state.valves.iter().map(|valve| match valve {
            Some([from, until]) => format!("{:e},{:e}", from - state.time, until - state.time),
            None => ",".into(),
        });
        let valves: Vec<String> = valves.collect();
        let _ = writeln!(self.states, "{},{}", state.row, valves.join(","));
        let [speed, lean, rate] = self.last;
        let after = fall.time - state.time;
        let _ = writeln!(
            self.ours,
            "{after:e},{},{speed:e},{lean:e},{rate:e}",
            fall.leg
        );
        self.count += 1;
    }
}

fn header() -> String {
    let legs = |name: &str| {
        (0..5)
            .map(|k| format!("{name}{k}"))
            .collect::<Vec<_>>()
            .join(",")
    };
    let rates = (0..5)
        .map(|k| format!("d{k}_rate"))
        .collect::<Vec<_>>()
        .join(",");
    let valves: Vec<String> = (0..5)
        .map(|k| format!("open_from{k},open_until{k}"))
        .collect();
    format!(
        "psi,theta,phi,{},psi_rate,theta_rate,phi_rate,{rates},{},{}\n",
        legs("d"),
        legs("p"),
        valves.join(",")
    )
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (files, count) = match &arguments[..] {
        [] => (None, 5),
        [states, ours, count] => (Some([states, ours]), count.parse()?),
        _ => return Err("give STATES.csv, OURS.csv and how many".into()),
    };
    let mut robot = saltus_robot::resolve("rats-run", &["ground.across_friction=0".into()])?;
    let delay = robot.leg.delay;
    robot.sensors.get_or_insert_default().period = CYCLE;
    let mut recorder = Recorder {
        delay,
        next: 0.0,
        open: None,
        openings: Vec::new(),
        last: [0.0; 3],
        highest: [0.0; 5],
        reach: [robot.body.radius, robot.foot.radius],
        states: header(),
        ours: "touch_down_s,leg,travel_speed_m_s,phi,omega\n".into(),
        count: 0,
    };
    for seed in 0.. {
        if recorder.count >= count {
            break;
        }
        // A run that cannot go on by events has given states until then.
        if let Err(error) = one(&mut recorder, robot.clone(), seed) {
            eprintln!("run {seed}: {error}");
        }
    }
    match files {
        Some([states, ours]) => {
            std::fs::write(states, recorder.states)?;
            std::fs::write(ours, recorder.ours)?;
        }
        None => print!("{}", recorder.ours),
    }
    Ok(())
}

/// A run of 4 s, pushed for longer with each seed.
fn one(recorder: &mut Recorder, robot: saltus_robot::Robot, seed: u64) -> Result<(), GaitError> {
    let program = if seed.is_multiple_of(2) {
        Program::Fixed { firing_angle: 0.1 }
    } else {
        Program::ClosedLoop(Lines::Two {
            first: 0.35,
            slope: -0.01,
            switch: 5.0,
            last: -0.1,
            at: 13.3,
            jumps: false,
        })
    };
    let mut setup = Setup::new(robot, program, 4.0);
    setup.zone = -0.3;
    setup.seed = seed;
    setup.stepping = Stepping::Adaptive;
    let until = 0.7 + 0.05 * seed as f64;
    setup.disturbances.push(Disturbance {
        when: When::Time(0.5, until),
        what: What::Torque(5.0),
    });
    (recorder.next, recorder.open, recorder.openings) = (until, None, vec![[0.0; 2]; 5]);
    run(&setup, recorder).map(|_| ())
}
