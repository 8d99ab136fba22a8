//! Section 5.2.3, figures 5.10 and 5.11 in the multi-body simulation: from rest over the box.

use std::f64::consts::TAU;

use saltus::chart::{COLORS, Chart, Ink};
use saltus::gait::{Crossing, CrossingPlan, Draw, Footfall, Obstacle, Row, Run, Setup, run};
use saltus::resolve;
use saltus_controller::run::Leap;

use crate::obstacle::SIDE;
use crate::runner::{chart, stacked};
use crate::{Outcome, Section, VALVE_OPEN, claim};

/// Supply pressure (psi): at the thesis' 120 psi no firings from rest are known that clear the box.
const PSI: f64 = 160.0;
/// Front of the box from the axle at rest (m).
const FRONT: f64 = 1.3;
/// Firing angles (rad) and valve opening times (s) of the first three legs, and A (s) and B (rad) of the
/// fourth one: found by `saltus jump --obstacle 0.21x0.21@1.3 --set
/// leg.supply_pressure_gauge_psi=160`.
const FIRST: [[f64; 2]; 3] = [[0.0425, 0.0535], [0.3330, 0.0572], [-0.0477, 0.0556]];
const LINE: [f64; 2] = [-0.0432, 0.3845];
/// The axes of figure 5.11: time (s), place and height of the centre (m).
const TIMES: (f64, f64) = (0.0, 0.7);
const PLACES: (f64, f64) = (0.0, 2.0);
const HEIGHTS: (f64, f64) = (0.1, 0.6);
/// Time (s) from pose to pose.
const POSES: f64 = 0.09;

/// What the figures show of a run.
struct Film {
    legs: usize,
    /// Bars of a pose (m): rods and struts.
    sizes: [f64; 3],
    places: Vec<(f64, f64)>,
    heights: Vec<(f64, f64)>,
    poses: Vec<Vec<[(f64, f64); 2]>>,
    /// Which leg, from when, for how long (s).
    firings: Vec<(u32, f64, f64)>,
    touch_downs: Vec<f64>,
}

impl Run for Film {
    fn row(&mut self, row: &Row<'_>) {
        let [x, z] = row.axle;
        self.places.push((row.time, x));
        self.heights.push((row.time, z));
        if let Some(leg) = row.action.leg {
            self.firings.push((leg, row.time, row.action.valve_open));
        }
        if row.time + 1e-9 >= self.poses.len() as f64 * POSES {
            let [inner, outer, strut] = self.sizes;
            let place = |leg: usize, out: f64| {
                let lean = row.lean - TAU * leg as f64 / self.legs as f64;
                (x - out * lean.sin(), z - out * lean.cos())
            };
            let bars = (0..self.legs).flat_map(|leg| {
                let out = row.extensions[leg];
                [
                    [place(leg, inner), place(leg, outer + out)],
                    [place(leg, strut), place((leg + 1) % self.legs, strut)],
                ]
            });
            self.poses.push(bars.collect());
        }
    }

    fn footfall(&mut self, footfall: &Footfall) {
        self.touch_downs.push(footfall.time);
    }
}

fn plan() -> CrossingPlan {
    CrossingPlan {
        first: FIRST.to_vec(),
        leap: Leap {
            after: 3,
            slope: LINE[0],
            level: LINE[1],
            least: -0.3,
            most: 0.6,
            valve_open: VALVE_OPEN,
            shock: 10024,
        },
    }
}

pub(crate) fn section() -> Outcome<Section> {
    let robot = resolve(
        "rats-run",
        &[format!("leg.supply_pressure_gauge_psi={PSI}")],
    )?;
    let struts = robot.struts.ok_or("no struts")?;
    let crossing = Crossing {
        robot: robot.clone(),
        draw: Draw::default(),
        obstacle: Obstacle {
            front: FRONT,
            length: SIDE,
            height: SIDE,
        },
        firings: FIRST.len(),
        by_rate: true,
        sought_on: 1,
        generations: 1,
        seed: 1,
    };
    let mut film = Film {
        legs: robot.body.legs as usize,
        sizes: [struts.distance, robot.body.radius, struts.distance],
        places: Vec::new(),
        heights: Vec::new(),
        poses: Vec::new(),
        firings: Vec::new(),
        touch_downs: Vec::new(),
    };
    let setup = Setup {
        seconds: 1.6,
        ..crossing.setup(&plan(), robot, 1, true)
    };
    let summary = run(&setup, &mut film)?;
    let at = |time: f64| film.places.iter().find(|p| p.0 >= time).map(|p| p.1);
    let before = |firing: &(u32, f64, f64)| at(firing.1).is_some_and(|x| x < FRONT);
    let jumps = film.firings.iter().rposition(before).ok_or("no jump")?;
    let jump = film.firings[jumps];
    let beyond = FRONT + SIDE;
    let landed = landing(&film, jump.1, beyond).ok_or("no landing beyond the box")?;
    let touched = summary
        .bumps
        .iter()
        .any(|bump| bump.2 > 0 && bump.0 <= landed);
    claim(
        !touched && summary.clearances[0] > 0.0,
        "figures 5.10, 5.11: the box is not touched",
    )?;
    claim(jumps == 1, "the second leg jumps")?;
    let text = format!(
        "## From rest over the box (5.2.3, figures 5.10 and 5.11)\n\nThe thesis' robot starts from \
         rest. Three legs accelerate it and the fourth one jumps over the box. Here `rats-run` does it in the \
         multi-body simulation, with {PSI} psi in place of the thesis' 120 psi, and with \
         the front of the box {FRONT} m from the axle at rest. From rest and so near, no firings were \
         found that clear the box at 120 psi ([running.md](running.md), \"Over a box\"). The thesis does \
         not give the firing angles of the first legs. `saltus jump` sought firings of three legs \
         that accelerate and of a fourth one that jumps. Those that it found do not follow the thesis: the first \
         leg throws the robot forwards, and the second one already jumps over the box.\n\n\
         ![Poses of the robot over the box](thesis/crossing.svg)\n\n![Place and height of the \
         centre, and the valves](thesis/crossing-time.svg)\n\nThe robot does not touch the box: its feet, \
         rods and struts stay {:.0} mm away. The second leg fires at {:.2} s, and a foot lands behind the box \
         at {:.2} s; the thesis' axes end at {} s. Between the first leg and the second one the \
         robot rolls slowly over its foot. In figure 5.11 the fourth valve is open about twice as long as \
         the others; here the valve of the jump is open for {:.0} ms.\n",
        1e3 * summary.clearances[0],
        jump.1,
        landed,
        TIMES.1,
        1e3 * jump.2,
    );
    Ok(Section {
        text,
        drawings: vec![
            ("crossing.svg", poses(&film, landed)),
            ("crossing-time.svg", over_time(&film, landed)),
        ],
    })
}

/// When a foot comes down after the jump at `fired` (s), its axle beyond `place` (m).
fn landing(film: &Film, fired: f64, place: f64) -> Option<f64> {
    let at = |time: f64| film.places.iter().find(|p| p.0 >= time).map(|p| p.1);
    let mut after = film.touch_downs.iter().copied().filter(|t| *t > fired);
    after.find(|time| at(*time).is_some_and(|x| x > place))
}

/// Figure 5.10: the robot over the box, to scale.
fn poses(film: &Film, until: f64) -> String {
    let mut chart = Chart::to_scale(760.0, ("x (m)", (-0.3, 2.5)), ("y (m)", (-0.03, 0.85)));
    chart.block(Ink::Solid("#d9d4c0"), (FRONT, 0.0), (FRONT + SIDE, SIDE));
    chart.line(Ink::Solid(COLORS[6]), &[(-0.3, 0.0), (2.5, 0.0)]);
    for (k, pose) in film.poses.iter().enumerate() {
        if k as f64 * POSES > until + POSES {
            break;
        }
        for bar in pose {
            chart.line(Ink::Solid(COLORS[k % 3]), bar);
        }
    }
    let path = film.places.iter().zip(&film.heights);
    let path = path.take_while(|(place, _)| place.0 <= until);
    let path: Vec<(f64, f64)> = path.map(|(place, height)| (place.1, height.1)).collect();
    chart.line(Ink::Dotted(COLORS[6]), &path);
    chart.key(
        Ink::Dotted(COLORS[6]),
        &format!("centre; a pose every {:.0} ms", 1e3 * POSES),
    );
    chart.file()
}

/// Figure 5.11: place and height of the centre and the valves over time, on the thesis' axes.
fn over_time(film: &Film, until: f64) -> String {
    let end = (10.0 * until).ceil() / 10.0;
    let line = |points: &[(f64, f64)]| {
        let points = points.iter().copied().take_while(|p| p.0 <= end);
        vec![(Ink::Solid(COLORS[0]), points.collect())]
    };
    let place = chart(262.0, end, ("x (m)", PLACES), &line(&film.places));
    let mut height = chart(262.0, end, ("y (m)", HEIGHTS), &line(&film.heights));
    height.key(
        Ink::Solid(COLORS[6]),
        &format!("the thesis' axes; its time ends at {} s", TIMES.1),
    );
    let mut valves = Chart::new(
        (760.0, 222.0),
        ("time (s)", (0.0, end)),
        ("firing", (0.0, 5.0)),
    );
    let early = film.firings.iter().take_while(|firing| firing.1 <= end);
    for (k, (_, from, open)) in early.enumerate().take(FIRST.len() + 1) {
        let row = k as f64 + 0.75;
        valves.block(
            Ink::Solid(COLORS[k % 3]),
            (*from, row),
            (from + open, row + 0.5),
        );
    }
    stacked(&[(262.0, place), (262.0, height), (222.0, valves)])
}
