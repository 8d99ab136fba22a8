//! Plans with a share of drawn jumps asked for, on random courses, against a search by brute force in
//! the multi-body simulation.
//!
//!     cd studies && cargo run --release --bin courses [courses=40] [samples=200] [seed=1] [course=17]
//!
//! With `course` only that one is planned. With nothing given there are two courses, and 40 drawn runs of each plan. A course has one of:
//! a box, a ditch, a step to land on, a box and a ditch for two jumps. `rats-boom` jumps. A plan has to
//! pass on draws that it was not made by, as often as was asked but for two binomial deviations. Where
//! the share or a plan is said to be out of reach, firing angles and valve times over their whole range
//! are flown, and none may do better.

use std::ops::ControlFlow;

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64;
use saltus::on_plant::OnPlant;
use saltus::planner::course::Standing;
use saltus::robust::{self, Robust};
use saltus::verify::{Attempt, Demands, Disturbance, Plant, Route, Stage, Starts, Verification};
use saltus_lagrangian::Launch;
use saltus_numeric::parallel;
use saltus_planner::{Crossing, CrossingAnswer};
use saltus_robot::Robot;

/// Share of drawn runs that is asked for.
const SHARE: f64 = 0.9;
/// Error of each step of the brute force.
const ACCURACY: f64 = 1e-8;

fn number(name: &str, default: usize) -> usize {
    let given = |a: String| a.strip_prefix(&format!("{name}=")).map(str::to_owned);
    let text = std::env::args().find_map(given);
    text.map_or(default, |x| x.parse().expect("a number"))
}

/// A random course, as a file.
fn course(k: usize, random: &mut Pcg64) -> String {
    let mut between = |low: f64, high: f64| {
        let x: f64 = Uniform::new(low, high).expect("a range").sample(random);
        (1e3 * x).round() / 1e3
    };
    let rate = between(4.0, 6.0);
    let head = |from: f64, to: f64| {
        format!(
            "approach_rate_rad_s = {rate}\ngoal_from_x_m = {from}\ngoal_to_x_m = {to}\n\
             friction_coefficient = 0.8\nclearance_m = 0.005\n"
        )
    };
    match k % 4 {
        0 => {
            let (front, width) = (between(0.25, 0.4), between(0.05, 0.2));
            let from = front + width + between(0.15, 0.3);
            let to = from + between(0.08, 0.2);
            let height = between(0.05, 0.2);
            head(from, to)
                + &format!(
                    "[[obstacle]]\nfront_x_m = {front}\nwidth_m = {width}\nheight_m = {height}\n"
                )
        }
        1 => {
            let (from, width) = (between(0.3, 0.5), between(0.1, 0.4));
            let end = from + width;
            head(from - 0.1, end + between(0.08, 0.2))
                + &format!("[[avoid]]\nfrom_x_m = {from}\nto_x_m = {end}\n")
        }
        2 => {
            let (front, width) = (between(0.35, 0.55), between(0.2, 0.4));
            let height = between(0.03, 0.15);
            head(front, front + width)
                + &format!(
                    "[[obstacle]]\nfront_x_m = {front}\nwidth_m = {width}\nheight_m = {height}\n"
                )
        }
        _ => {
            let (front, height) = (between(0.25, 0.35), between(0.05, 0.15));
            let ditch = between(0.9, 1.1);
            let from = ditch + between(0.1, 0.25);
            let to = from + between(0.15, 0.3);
            format!("jumps = 2\nroll_m = 0.05\n{}", head(from, to))
                + &format!(
                    "[[obstacle]]\nfront_x_m = {front}\nwidth_m = 0.1\nheight_m = {height}\n"
                )
                + &format!("[[avoid]]\nfrom_x_m = {ditch}\nto_x_m = {from}\n")
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let is_short = std::env::args().len() == 1;
    let courses = number("courses", if is_short { 2 } else { 40 });
    let samples = number("samples", if is_short { 40 } else { 200 });
    let mut random = Pcg64::new(number("seed", 1) as u128, 9);
    let (robot, boom) = (built_in("rats-planar"), built_in("rats-boom"));
    let on_plant = OnPlant::new(&robot, &boom)?;
    let go_on = |_: &Standing| ControlFlow::Continue(());
    let (mut right, mut passing) = (0, 0);
    println!("| course | answer | share | brute force | |");
    println!("| --- | --- | --- | --- | --- |");
    for k in 0..courses {
        let text = course(k, &mut random);
        if number("course", k) != k {
            continue;
        }
        let crossing = saltus::course::parse(&text, "the course")?;
        let how = Verification {
            samples,
            seed: 77,
            tolerance: Some(f64::INFINITY),
            share: SHARE,
            ..Verification::default()
        };
        let deviation = (SHARE * (1.0 - SHARE) / samples as f64).sqrt();
        let brute = Brute::new(&boom, &robot, &crossing);
        let (answer, share) = match robust::plan(&robot, &on_plant, &crossing, &how, &go_on)? {
            Robust::Plan { held, .. } => {
                let CrossingAnswer::Plan(plan) = &held.crossed.answer else {
                    unreachable!("a plan that is held");
                };
                let launches: Vec<Launch> = plan.jumps.iter().map(|j| j.jump.launch).collect();
                ("plan", brute.share(&launches, samples, 12_345))
            }
            Robust::None(crossed) => match crossed.answer {
                CrossingAnswer::Undecided { .. } => ("undecided", 0.0),
                _ => ("infeasible", 0.0),
            },
        };
        let holds = share >= SHARE - 2.0 * deviation;
        let best = if holds {
            None
        } else {
            Some(brute.best(samples))
        };
        // What the brute force finds was chosen by its own draws.
        let is_right = holds
            || best.is_some_and(|best| best < (share + 3.0 * deviation).max(0.5 / samples as f64));
        right += usize::from(is_right);
        passing += usize::from(holds);
        if !is_right {
            eprintln!("course {k}:\n{text}");
        }
        println!(
            "| {k} {} | {answer} | {share:.3} | {} | {} |",
            ["box", "ditch", "step", "two jumps"][k % 4],
            best.map_or("–".to_owned(), |best| format!("{best:.3}")),
            if is_right { "" } else { "WRONG" }
        );
    }
    println!("\n{passing} of {courses} plans hold; {right} of {courses} answers are right");
    Ok(())
}

fn built_in(name: &str) -> Robot {
    Robot::builtin(name).unwrap_or_else(|| panic!("{name} is built in"))
}

/// Jumps of the simulation alone, judged by what the course demands.
struct Brute<'a> {
    plant: Plant,
    crossing: &'a Crossing,
    radius: f64,
}

impl<'a> Brute<'a> {
    fn new(plant: &Robot, robot: &Robot, crossing: &'a Crossing) -> Brute<'a> {
        Brute {
            plant: Plant::new(plant.clone(), ACCURACY),
            crossing,
            radius: robot.body.radius,
        }
    }

    /// The route of these launches. Only of a step the surface is not the ground.
    fn route(&self, launches: &[Launch]) -> Route {
        let course = &self.crossing.course;
        let boxes = course.obstacles.iter();
        let under = |x: f64| {
            let mut boxes = course.obstacles.iter();
            let found = boxes.find(|o| o.span().low <= x && x <= o.span().high);
            found.map_or(0.0, |o| o.height)
        };
        let goal = 0.5 * (course.goal.low + course.goal.high);
        let stage = |(k, launch): (usize, &Launch)| {
            let surface = if k + 1 == launches.len() {
                under(goal)
            } else {
                0.0
            };
            Stage {
                launch: *launch,
                foot: [0.0, 0.0],
                landing_height: self.radius + surface,
                surface: Some(surface),
                apex: f64::NAN,
                landing: f64::NAN,
                wanted: goal,
            }
        };
        Route {
            stages: launches.iter().enumerate().map(stage).collect(),
            demands: Demands {
                obstacles: boxes
                    .map(|o| [o.span().low, o.span().high, o.height])
                    .collect(),
                clearance: self.crossing.clearance,
                leg_out: self.crossing.leg_out,
                edge_margin: self.crossing.edge_margin,
                avoid: course.no_landing.clone(),
                zones: self.crossing.zones.clone(),
                goal: Some(course.goal),
                roll: self.crossing.roll,
                friction: self.crossing.friction,
                ..Demands::within(10.0)
            },
        }
    }

    fn passes(&self, launches: &[Launch], errors: &[Disturbance]) -> bool {
        let attempts = self
            .plant
            .run(&self.route(launches), errors, Starts::Chained);
        attempts.iter().all(Attempt::passes)
    }

    /// Share of runs with errors drawn that pass; none where the run without errors does not.
    fn share(&self, launches: &[Launch], samples: usize, seed: u128) -> f64 {
        if !self.passes(launches, &[]) {
            return 0.0;
        }
        let errors = &self.plant.robot().errors;
        let mut random = Pcg64::new(seed, 3);
        let mut drawn =
            || Disturbance::drawn(errors, [(); 4].map(|()| StandardNormal.sample(&mut random)));
        let runs: Vec<Vec<Disturbance>> = (0..samples)
            .map(|_| {
                let first = drawn();
                // The supply is that of the run.
                let rest = launches.iter().skip(1).map(|_| Disturbance {
                    supply: first.supply,
                    ..drawn()
                });
                std::iter::once(first)
                    .chain(rest.collect::<Vec<_>>())
                    .collect()
            })
            .collect();
        let passed = parallel::map(runs.len(), |k| self.passes(launches, &runs[k]));
        passed.iter().filter(|passed| **passed).count() as f64 / samples as f64
    }

    /// The greatest share that firing angles and valve times of a grid have; 0 where none passes
    /// without errors.
    fn best(&self, samples: usize) -> f64 {
        let jumps = self.crossing.course.jumps;
        let (angles, valves) = if jumps == 1 { (90, 17) } else { (15, 5) };
        let at = |span: saltus_planner::course::Span, k: usize, n: usize| {
            span.low + (span.high - span.low) * (k as f64 + 0.5) / n as f64
        };
        let cells = angles * valves;
        let launch = |jump: usize, cell: usize| {
            let angle = at(self.crossing.firing_angles, cell / valves, angles);
            let valve = at(self.crossing.valve_open, cell % valves, valves);
            let rates = &self.crossing.rates;
            Launch {
                rate: rates[jump.min(rates.len() - 1)],
                lean: angle,
                firing_angle: angle,
                valve_open: valve,
            }
        };
        let all = cells.pow(u32::try_from(jumps).expect("few jumps"));
        let of = |k: usize| -> Vec<Launch> {
            let cell = |jump: usize| (k / cells.pow(u32::try_from(jump).expect("few"))) % cells;
            (0..jumps).map(|jump| launch(jump, cell(jump))).collect()
        };
        let passes = parallel::map(all, |k| self.passes(&of(k), &[]));
        let found: Vec<usize> = (0..all).filter(|k| passes[*k]).collect();
        // A few runs say which may be best.
        let roughly = |k: &usize| (self.share(&of(*k), 20, 99), *k);
        let mut rough: Vec<(f64, usize)> = found.iter().map(roughly).collect();
        rough.sort_by(|a, b| b.0.total_cmp(&a.0));
        let best = rough
            .iter()
            .take(5)
            .map(|(_, k)| self.share(&of(*k), samples, 54_321));
        best.fold(0.0, f64::max)
    }
}
