//! The verdicts of `saltus::verify` on random courses, against a judge of its own: everything from
//! the raw simulated path, with other interpolation, other geometry and other bookkeeping.
//!
//! `SALTUS_RUNS=50 cargo test --release -p saltus-tests verdicts -- --include-ignored` draws 50 runs with errors
//! for each course in place of 2.

#![allow(clippy::unwrap_used, clippy::panic)]

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use saltus::planner::course::{Course, Obstacle, Span};
use saltus::planner::{Crossing, CrossingAnswer};
use saltus::sim_check::{Report, Sample};
use saltus::verify::{
    Attempt, Demand, Demands, Disturbance, Flight, Judgement, Plant, Route, Stage, Starts,
};
use saltus::{Launch, Planner, Robot};

/// Courses that the planner plans, one in so many; the others are made by hand.
const PLANNED: usize = 10;
/// What a demand may be missed by (m, and as a friction coefficient), as documented.
const ROUND_OFF: f64 = 1e-5;
const FRICTION_ROUND_OFF: f64 = 1e-3;

/// A source of random numbers.
struct Dice(Pcg64);

impl Dice {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        Uniform::new(low, high).unwrap().sample(&mut self.0)
    }

    fn chance(&mut self, share: f64) -> bool {
        self.within(0.0, 1.0) < share
    }

    /// 0 as often as not, else a number up to `most`.
    fn some(&mut self, most: f64) -> f64 {
        if self.chance(0.5) {
            0.0
        } else {
            self.within(0.0, most)
        }
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// A span around `x` whose ends are up to `reach` away, on either side of it or not.
    fn around(&mut self, x: f64, reach: f64) -> Span {
        let low = x - self.within(-0.2 * reach, reach);
        Span::new(low, (x + self.within(-0.2 * reach, reach)).max(low + 1e-3))
    }
}

/// What is demanded, as the judge knows it.
struct Given {
    /// For each jump: surface landed on, landing wanted, axle above the foothold at the landing.
    jumps: Vec<[f64; 3]>,
    start: [f64; 2],
    boxes: Vec<[f64; 3]>,
    avoid: Vec<[f64; 2]>,
    zones: Vec<Option<[f64; 2]>>,
    goal: [f64; 2],
    clearance: f64,
    edge: f64,
    leg_out: f64,
    roll: f64,
    tolerance: f64,
    friction: f64,
}

/// A course made by hand about the jumps that the planner's model makes.
#[expect(clippy::too_many_lines, reason = "one course")]
fn by_hand(planner: &Planner, dice: &mut Dice) -> (Route, Given) {
    let radius = planner.robot().body.radius;
    let mut demands = Demands {
        clearance: dice.some(0.04),
        leg_out: dice.some(0.1),
        edge_margin: dice.some(0.04),
        roll: dice.some(0.08),
        friction: dice.chance(0.4).then(|| dice.within(0.25, 0.9)),
        ..Demands::within(dice.within(0.01, 0.08))
    };
    let mut stages: Vec<Stage> = Vec::new();
    let mut foot = [
        dice.within(-1.0, 1.0),
        if dice.chance(0.2) { 0.1 } else { 0.0 },
    ];
    let jumps = 1
        + usize::from(dice.chance(0.7))
        + usize::from(dice.chance(0.5))
        + usize::from(dice.chance(0.3));
    while stages.len() < jumps {
        let firing_angle = dice.within(-0.25, 0.2);
        let lean = if dice.chance(0.7) {
            firing_angle
        } else {
            firing_angle - 0.1
        };
        let launch = Launch {
            rate: dice.within(4.0, 6.0),
            lean,
            firing_angle,
            valve_open: dice.within(0.03, 0.1),
        };
        let flown = planner.jump(&launch).unwrap();
        let surface = if dice.chance(0.3) {
            dice.within(0.03, 0.15)
        } else {
            0.0
        };
        let landing_height = radius + surface - foot[1];
        let Some(distance) = flown.distance(landing_height).filter(|d| *d > 0.35) else {
            continue;
        };
        let landing = foot[0] + distance;
        if surface > 0.0 {
            let (before, behind) = (dice.within(0.02, 0.2), dice.within(0.02, 0.2));
            demands.obstacles.push([
                landing - before.min(0.4 * distance),
                landing + behind,
                surface,
            ]);
        } else if dice.chance(0.6) {
            let front = foot[0] + dice.within(0.25, 0.6) * distance;
            let back = (front + dice.within(0.03, 0.2)).min(landing - 0.02);
            demands
                .obstacles
                .push([front, back, dice.within(0.02, 0.25)]);
        }
        if dice.chance(0.5) {
            let low = landing + dice.within(-0.15, 0.05);
            demands
                .avoid
                .push(Span::new(low, low + dice.within(0.02, 0.1)));
        }
        demands
            .zones
            .push(dice.chance(0.4).then(|| dice.around(landing, 0.1)));
        stages.push(Stage {
            launch,
            foot,
            landing_height,
            surface: Some(surface),
            apex: f64::NAN,
            landing,
            wanted: landing,
        });
        foot = [landing + demands.roll, surface];
    }
    let last = stages[jumps - 1].landing;
    demands.goal = dice.chance(0.7).then(|| dice.around(last, 0.08));
    let given = Given {
        jumps: stages
            .iter()
            .map(|s| [s.surface.unwrap(), s.wanted, s.landing_height])
            .collect(),
        start: stages[0].foot,
        boxes: demands.obstacles.clone(),
        avoid: demands.avoid.iter().map(|a| [a.low, a.high]).collect(),
        zones: demands
            .zones
            .iter()
            .map(|zone| zone.map(|z| [z.low, z.high]))
            .collect(),
        goal: demands
            .goal
            .map_or([f64::NEG_INFINITY, f64::INFINITY], |g| [g.low, g.high]),
        clearance: demands.clearance,
        edge: demands.edge_margin,
        leg_out: demands.leg_out,
        roll: demands.roll,
        tolerance: demands.tolerance,
        friction: demands.friction.unwrap_or(f64::INFINITY),
    };
    (Route { stages, demands }, given)
}

/// A course that the planner plans; none where it finds no plan.
fn by_planner(planner: &Planner, dice: &mut Dice) -> Option<(Route, Given)> {
    let jumps = 1 + usize::from(dice.chance(0.5));
    let start = dice.within(-1.0, 1.0);
    let far = start + 0.85 * jumps as f64;
    let goal = Span::new(far - dice.within(0.02, 0.1), far + dice.within(0.02, 0.1));
    let solid = Obstacle {
        center: start + dice.within(0.38, 0.5),
        width: 0.1,
        height: dice.within(0.03, 0.15),
    };
    let low = solid.span().high + dice.within(0.05, 0.1);
    let course = Course {
        id: "random".into(),
        start,
        start_height: 0.0,
        jumps,
        goal,
        obstacles: vec![solid],
        no_landing: vec![Span::new(low, low + 0.05)],
    };
    let crossing = Crossing {
        clearance: dice.some(0.02),
        edge_margin: dice.some(0.03),
        zones: vec![
            dice.chance(0.5)
                .then(|| Span::new(start + 0.6, start + 1.1));
            jumps
        ],
        ..Crossing::new(course, dice.within(4.8, 5.5))
    };
    let CrossingAnswer::Plan(plan) = planner.cross(&crossing).unwrap() else {
        return None;
    };
    let tolerance = dice.within(0.01, 0.08);
    let radius = planner.robot().body.radius;
    let given = Given {
        jumps: plan
            .jumps
            .iter()
            .map(|jump| {
                [
                    jump.landing[1],
                    jump.landing[0],
                    radius + jump.landing[1] - jump.foot[1],
                ]
            })
            .collect(),
        start: [start, 0.0],
        boxes: vec![[solid.center - 0.05, solid.center + 0.05, solid.height]],
        avoid: vec![[low, low + 0.05]],
        zones: crossing
            .zones
            .iter()
            .map(|zone| zone.map(|z| [z.low, z.high]))
            .collect(),
        goal: [goal.low, goal.high],
        clearance: crossing.clearance,
        edge: crossing.edge_margin,
        leg_out: 0.0,
        roll: 0.0,
        tolerance,
        friction: f64::INFINITY,
    };
    Some((Route::of(&crossing, &plan, radius, tolerance), given))
}

/// The path between samples: cubics through the four nearest, `STEPS` to a sample.
fn fine(samples: &[&Sample]) -> Vec<(f64, [f64; 2])> {
    const STEPS: usize = 24;
    let mut path = Vec::new();
    for (i, pair) in samples.windows(2).enumerate() {
        let first = (i.max(1) - 1).min(samples.len().saturating_sub(4));
        let near = &samples[first..samples.len().min(first + 4)];
        for step in 0..STEPS {
            let t = pair[0].time + (pair[1].time - pair[0].time) * step as f64 / STEPS as f64;
            path.push((t, through(near, t)));
        }
    }
    path.extend(samples.last().map(|s| (s.time, s.axle)));
    path
}

/// Neville's scheme.
fn through(samples: &[&Sample], t: f64) -> [f64; 2] {
    [0, 1].map(|k| {
        let mut row: Vec<f64> = samples.iter().map(|s| s.axle[k]).collect();
        for level in 1..row.len() {
            for i in 0..row.len() - level {
                let (a, b) = (samples[i].time, samples[i + level].time);
                row[i] = ((t - b) * row[i] + (a - t) * row[i + 1]) / (a - b);
            }
        }
        row[0]
    })
}

/// Time and place at which a flight comes down through `height` (m above the foothold); none where
/// it does not.
fn landing(flight: &[&Sample], height: f64) -> Option<(f64, f64)> {
    let top = (0..flight.len()).max_by(|&a, &b| flight[a].axle[1].total_cmp(&flight[b].axle[1]))?;
    let rises_to = fine(flight)
        .iter()
        .map(|(_, axle)| axle[1])
        .fold(f64::MIN, f64::max);
    if rises_to < height {
        return None;
    }
    let below = (top..flight.len()).find(|&i| flight[i].axle[1] < height);
    // The simulation may end at the landing, between two samples: the last ones are carried on.
    let end = below.unwrap_or(flight.len());
    let near = &flight[end.saturating_sub(3)..flight.len().min(end + 1)];
    let (mut from, mut to) = (
        flight[end - 1].time,
        below.map_or(flight[end - 1].time + 2e-3, |i| flight[i].time),
    );
    for _ in 0..80 {
        let middle = f64::midpoint(from, to);
        if through(near, middle)[1] > height {
            from = middle;
        } else {
            to = middle;
        }
    }
    Some((from, through(near, from)[0]))
}

/// Signed distance (m) from a point to a box without a lower end.
fn to_box([x, y]: [f64; 2], [front, back, top]: [f64; 3]) -> f64 {
    let (dx, dy) = (x - x.clamp(front, back), (y - top).max(0.0));
    if dx != 0.0 || dy > 0.0 {
        (dx * dx + dy * dy).sqrt()
    } else {
        -(x - front).min(back - x).min(top - y)
    }
}

/// What the judge finds of one jump: a demand and whether it holds, where it is demanded; the
/// landing (m along the course).
struct Found {
    verdicts: Vec<(Demand, bool)>,
    landing: Option<f64>,
    foothold: bool,
}

#[expect(clippy::too_many_lines, reason = "one judgement")]
fn judge(given: &Given, jump: usize, foot: [f64; 2], report: &Report, radius: f64) -> Found {
    let [surface, wanted, height] = given.jumps[jump];
    let lift_off = report.lift_off.map_or(f64::INFINITY, |l| l.time);
    let mut samples: Vec<&Sample> = report.samples.iter().collect();
    samples.dedup_by(|b, a| b.time - a.time < 1e-9);
    let start = samples
        .iter()
        .position(|s| s.time >= lift_off - 1e-12)
        .unwrap_or(samples.len());
    let (stance, flight) = (
        &samples[..samples.len().min(start + 1)],
        &samples[start.min(samples.len())..],
    );
    let landed = if flight.is_empty() {
        None
    } else {
        landing(flight, height)
    };
    let mut verdicts = vec![(Demand::Touchdown, landed.is_some())];
    let place = landed.map(|(_, x)| foot[0] + x);
    let mut foothold = false;
    if let Some(x) = place {
        let last = jump + 1 == given.jumps.len();
        let is_in =
            |x: f64, [low, high]: [f64; 2], slack: f64| x >= low - slack && x <= high + slack;
        let ground = |x: f64| {
            let on_top = given
                .boxes
                .iter()
                .any(|b| b[2] == surface && is_in(x, [b[0], b[1]], ROUND_OFF));
            let free = given
                .boxes
                .iter()
                .all(|b| !(x > b[0] + ROUND_OFF && x < b[1] - ROUND_OFF));
            if surface > 0.0 { on_top } else { free }
        };
        let grounded = ground(x) && (last || ground(x + given.roll));
        verdicts.push((Demand::Ground, grounded));
        let kept = given.boxes.iter().map(|b| {
            let outside = (b[0] - x).max(x - b[1]);
            if b[2] == surface && is_in(x, [b[0], b[1]], ROUND_OFF) {
                -outside
            } else {
                outside
            }
        });
        if given.edge > 0.0 && !given.boxes.is_empty() {
            verdicts.push((
                Demand::Edge,
                kept.fold(f64::INFINITY, f64::min) >= given.edge - ROUND_OFF,
            ));
        }
        let dry = given
            .avoid
            .iter()
            .all(|a| !(x > a[0] + ROUND_OFF && x < a[1] - ROUND_OFF));
        if !given.avoid.is_empty() {
            verdicts.push((Demand::Avoid, dry));
        }
        verdicts.extend(given.zones[jump].map(|zone| (Demand::Zone, is_in(x, zone, ROUND_OFF))));
        if last && given.goal[0].is_finite() {
            verdicts.push((Demand::Goal, is_in(x, given.goal, ROUND_OFF)));
        }
        verdicts.push((
            Demand::Tolerance,
            (x - wanted).abs() <= given.tolerance + ROUND_OFF,
        ));
        foothold = grounded && dry;
    }
    let stands_on =
        |b: &[f64; 3], x: f64, y: f64| b[2] == y && x >= b[0] - ROUND_OFF && x <= b[1] + ROUND_OFF;
    let in_the_way = |b: &&[f64; 3]| !stands_on(b, foot[0], foot[1]);
    let end = landed.map_or(f64::INFINITY, |(time, _)| time);
    let mut air: Vec<(f64, [f64; 2])> = fine(flight)
        .into_iter()
        .filter(|(t, _)| *t <= end)
        .collect();
    air.extend(landed.map(|(t, x)| (t, [x, height])));
    let out = radius + report.lift_off.map_or(0.0, |l| l.extension);
    // Inside what is demanded in flight by, and from the nearest box in the stance.
    let (mut clear, mut stance_clear) = (f64::INFINITY, f64::INFINITY);
    for b in given.boxes.iter().filter(in_the_way) {
        let kept = if place.is_some_and(|x| stands_on(b, x, surface)) {
            0.0
        } else {
            given.clearance
        };
        let b = [b[0] - foot[0], b[1] - foot[0], b[2] - foot[1]];
        for (t, axle) in &air {
            let reach = if *t <= lift_off + given.leg_out && given.leg_out > 0.0 {
                out
            } else {
                radius
            };
            clear = clear.min(to_box(*axle, b) - reach - kept);
        }
        for (_, axle) in fine(stance) {
            stance_clear = stance_clear.min(to_box(axle, b) - radius);
        }
    }
    if clear.is_finite() {
        verdicts.push((Demand::Clearance, clear >= -ROUND_OFF));
    }
    if stance_clear.is_finite() {
        verdicts.push((Demand::Stance, stance_clear >= -ROUND_OFF));
    }
    if given.friction.is_finite() {
        verdicts.push((
            Demand::Friction,
            report.friction_needed <= given.friction + FRICTION_ROUND_OFF,
        ));
    }
    Found {
        verdicts,
        landing: place,
        foothold,
    }
}

/// How many jumps were judged, and how many of them failed, by demand.
#[derive(Default)]
struct Tally {
    jumps: usize,
    failed: usize,
    not_started: usize,
    missed: [usize; Demand::ALL.len()],
}

/// Holds a run against the judge.
fn compare(
    given: &Given,
    attempts: &[Attempt],
    starts: Starts,
    radius: f64,
    case: &str,
    tally: &mut Tally,
) {
    let mut foot = Some(given.start);
    for (jump, attempt) in attempts.iter().enumerate() {
        let case = format!("{case}, jump {jump}");
        if starts == Starts::Planned && jump > 0 {
            let [surface, wanted, _] = given.jumps[jump - 1];
            foot = Some([wanted + given.roll, surface]);
        }
        tally.jumps += 1;
        let Flight::Flown(flown) = &attempt.flight else {
            assert!(
                matches!(attempt.flight, Flight::NotStarted) && foot.is_none(),
                "{case}: {attempt:?}"
            );
            assert!(!attempt.passes(), "{case}");
            tally.not_started += 1;
            continue;
        };
        let here = foot.unwrap_or_else(|| panic!("{case}: nothing to stand on"));
        // The judge's own landings differ by its interpolation, a nanometre a jump.
        assert!(
            (here[0] - attempt.foot[0]).abs() < 1e-7 && here[1] == attempt.foot[1],
            "{case}"
        );
        let found = judge(given, jump, here, &flown.report, radius);
        for demand in Demand::ALL {
            let theirs = attempt.judgement(demand).map(Judgement::holds);
            let ours = found
                .verdicts
                .iter()
                .find(|(d, _)| *d == demand)
                .map(|(_, holds)| *holds);
            assert_eq!(
                theirs, ours,
                "{case}: {demand:?} of {:?}",
                attempt.judgements
            );
            tally.missed[demand as usize] += usize::from(ours == Some(false));
        }
        let passes = found.verdicts.iter().all(|(_, holds)| *holds);
        assert_eq!(attempt.passes(), passes, "{case}");
        assert_eq!(attempt.reasons().is_empty(), passes, "{case}");
        tally.failed += usize::from(!passes);
        let next = found.landing.filter(|_| found.foothold);
        foot = next.map(|x| [x + given.roll, given.jumps[jump][0]]);
    }
}

#[test]
fn drawn_jumps_are_judged_as_an_independent_judge_does() {
    // Each demand is missed at least once.
    check_courses(30, 1);
}

#[test]
#[ignore = "nightly: 15 s"]
fn every_drawn_jump_is_judged_as_an_independent_judge_does() {
    check_courses(200, 3);
}

/// Judges runs on `courses` courses, which must miss each demand `misses` times.
fn check_courses(courses: usize, misses: usize) {
    let runs = std::env::var("SALTUS_RUNS").map_or(2, |runs| runs.parse().unwrap());
    let mut dice = Dice(Pcg64::seed_from_u64(14));
    let planner = Planner::new(Robot::rats_planar());
    let boom = Robot::builtin("rats-boom").unwrap();
    let plants = [
        Plant::new(planner.robot().clone(), 1e-8),
        Plant::new(boom, 1e-8),
    ];
    let mut tally = Tally::default();
    for course in 0..courses {
        let (route, given) = if course < courses / PLANNED {
            loop {
                if let Some(planned) = by_planner(&planner, &mut dice) {
                    break planned;
                }
            }
        } else {
            by_hand(&planner, &mut dice)
        };
        let plant = &plants[usize::from(dice.chance(0.3))];
        let plant = if dice.chance(0.2) {
            plant.on_friction(dice.within(0.2, 0.7))
        } else {
            plant.clone()
        };
        let starts = if dice.chance(0.2) {
            Starts::Planned
        } else {
            Starts::Chained
        };
        for run in 0..=runs {
            let factor = if run == 0 { 0.0 } else { 1.0 };
            let mut disturbance = || {
                let normal = std::array::from_fn(|_| factor * dice.normal());
                Disturbance::drawn(&planner.robot().errors, normal)
            };
            let errors: Vec<Disturbance> = route.stages.iter().map(|_| disturbance()).collect();
            let attempts = plant.run(&route, &errors, starts);
            let case = format!("course {course}, run {run}");
            compare(
                &given,
                &attempts,
                starts,
                plant.robot().body.radius,
                &case,
                &mut tally,
            );
        }
    }
    let Tally {
        jumps,
        failed,
        not_started,
        missed,
    } = tally;
    println!(
        "{jumps} jumps: {failed} fail, {not_started} not started; misses of each demand {missed:?}"
    );
    // Courses on which everything fails, or nothing, would show little; each demand is missed
    // somewhere.
    assert!(
        failed > jumps / 5 && jumps - failed - not_started > jumps / 10,
        "{failed} and {not_started} of {jumps}"
    );
    let rare = [Demand::Touchdown as usize, Demand::Stance as usize];
    for (i, count) in missed.iter().enumerate() {
        assert!(
            *count >= misses || rare.contains(&i),
            "{:?}: {count}",
            Demand::ALL[i]
        );
    }
}
