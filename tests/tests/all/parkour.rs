//! The 58 published problems: every plan is valid by the published rules, and none is slower than
//! the published one.

use saltus_planner::course::{Answer, Course, Obstacle, Plan, Settings, Span, plan};
use saltus_tests::parkour::{Hopper, published};

fn solved(course: &Course, settings: &Settings) -> Plan {
    match plan(&Hopper::default(), course, settings) {
        Ok(Answer::Plan(plan)) => plan,
        other => panic!("{}: {other:?}", course.id),
    }
}

/// The greatest violation of the published rules by jumps of time t, speed v and angle θ; infinite
/// where a yes or no fails. Written from the problem set's README alone.
fn violation(course: &Course, jumps: &[[f64; 3]]) -> f64 {
    let pose = 94_f64.to_radians();
    let [c, s] = [-0.17 * pose.cos(), -0.17 * pose.sin()];
    let psi = std::f64::consts::PI
        - pose
        - ((0.17_f64.powi(2) + 0.15 * 0.15 - 0.15 * 0.15) / (2.0 * 0.15 * 0.17)).acos();
    let knee = [-0.15 * psi.cos(), 0.15 * psi.sin()];
    let (mut x, mut z, mut worst) = (course.start, course.start_height, 0.0_f64);
    for &[t, v, angle] in jumps {
        let outside = |value: f64, low: f64, high: f64| (low - value).max(value - high);
        worst = worst.max(outside(t, 0.2, 3.0)).max(outside(v, 1.5, 2.7));
        worst = worst.max(outside(angle, 65_f64.to_radians(), 85_f64.to_radians()));
        let [px, pz] = [x + 0.19 * angle.cos() + c, z + 0.19 * angle.sin() + s];
        let height = |t: f64| pz + v * angle.sin() * t - 8.0665 / 2.0 * t * t;
        let (nx, nz) = (px + v * angle.cos() * t, height(t));
        let mut surface = 0.0;
        for o in &course.obstacles {
            let (front, back) = (o.center - o.width / 2.0, o.center + o.width / 2.0);
            if front <= nx && nx <= back {
                surface = o.height;
            }
            worst = worst
                .max(0.03 - (nx - front).abs())
                .max(0.03 - (nx - back).abs());
            let speed = v * angle.cos();
            if x < front && front < nx {
                worst = worst.max(o.height + 0.05 - height((front - px) / speed));
            }
            if x < back && back < nx {
                worst =
                    worst.max(o.height + 0.05 - knee[1] - height((back - px - knee[0]) / speed));
            }
        }
        for a in &course.no_landing {
            worst = worst.max((nx - a.low).min(a.high - nx));
        }
        worst = worst.max((nz - surface).abs());
        (x, z) = (nx, nz);
    }
    worst.max((x - course.goal.low).abs())
}

#[test]
fn every_plan_is_valid_and_none_is_slower() {
    let problems = published();
    assert_eq!(problems.len(), 58);
    for problem in problems {
        let course = problem.course;
        let plan = solved(&course, &Settings::default());
        let launches = plan.jumps.iter().map(|j| Hopper::default().launch(j));
        let jumps: Vec<_> = launches
            .map(|l| [l.flight_time, l.speed, l.angle])
            .collect();
        // The solver's feasibility is 1e-10, for landings and clearances in a row.
        let worst = violation(&course, &jumps);
        assert!(worst < 1e-9, "{}: {worst:e}", course.id);
        let total: f64 = jumps.iter().map(|j| j[0]).sum();
        // The published times have 8 digits, their landings a tolerance of 1e-6.
        assert!(total < problem.published + 1e-5, "{}: {total}", course.id);
    }
}

#[test]
fn a_longer_search_finds_nothing_better() {
    let proof = Settings {
        nodes: 20_000,
        ..Settings::default()
    };
    for problem in published() {
        let course = problem.course;
        let (quick, proven) = (
            solved(&course, &Settings::default()),
            solved(&course, &proof),
        );
        let id = &course.id;
        assert!(proven.complete, "{id}: {} to {}", proven.bound, proven.cost);
        // The gap of the search.
        assert!(
            quick.cost <= proven.cost + 5e-5 && proven.bound >= proven.cost - 5e-5,
            "{id}"
        );
    }
}

/// Least time of a jump from x to nx over launch angles, on a grid of them; infinite if none is
/// allowed.
fn fastest(course: &Course, x: f64, z: f64, nx: f64, surface: f64) -> [f64; 3] {
    let foot = [
        -0.17 * 94_f64.to_radians().cos(),
        -0.17 * 94_f64.to_radians().sin(),
    ];
    for step in 0..=800 {
        let angle = (65.0 + 0.025 * f64::from(step)).to_radians();
        let length = nx - x - 0.19 * angle.cos() - foot[0];
        let rise = surface - z - 0.19 * angle.sin() - foot[1];
        let t = ((length * angle.tan() - rise) * 2.0 / 8.0665).sqrt();
        let jump = [t, length / (t * angle.cos()), angle];
        let alone = Course {
            start: x,
            start_height: z,
            goal: Span::point(nx),
            ..course.clone()
        };
        if violation(&alone, &[jump]) < 1e-9 {
            return jump;
        }
    }
    [f64::INFINITY; 3]
}

fn surface(course: &Course, x: f64) -> f64 {
    let on = |o: &&Obstacle| (x - o.center).abs() <= o.width / 2.0;
    course.obstacles.iter().find(on).map_or(0.0, |o| o.height)
}

/// Times grow with the angle, so the first allowed one on its grid is the fastest; landings are on
/// a grid of 1 cm.
#[test]
fn brute_force_finds_nothing_better() {
    for id in [
        "static-09",
        "dynamic_1-10",
        "static-06",
        "two_rounds-06",
        "disturbances-03",
        "two_rounds-20",
        "static-02",
    ] {
        let problem = published().into_iter().find(|i| i.course.id == id);
        let course = problem.unwrap_or_else(|| panic!("{id}")).course;
        // Distances from the goal backwards, so that the last jump hits it.
        let steps = (0..)
            .map(|n| course.goal.low - 0.01 * f64::from(n))
            .take_while(|x| *x > course.start);
        let mut places: Vec<f64> = steps.chain([course.start]).collect();
        places.reverse();
        let mut cost = vec![f64::INFINITY; places.len()];
        cost[0] = 0.0;
        let from = |a: usize, x: f64| {
            let z = if a == 0 {
                course.start_height
            } else {
                surface(&course, x)
            };
            let to = |&nx: &f64| {
                if nx <= x || nx > x + 1.25 {
                    f64::INFINITY
                } else {
                    fastest(&course, x, z, nx, surface(&course, nx))[0]
                }
            };
            places.iter().map(to).collect::<Vec<_>>()
        };
        let jump_cost: Vec<_> = places
            .iter()
            .enumerate()
            .map(|(a, &x)| from(a, x))
            .collect();
        for _ in 0..course.jumps {
            let least = |b: usize| {
                (0..b)
                    .map(|a| cost[a] + jump_cost[a][b])
                    .fold(f64::INFINITY, f64::min)
            };
            cost = (0..places.len()).map(least).collect();
        }
        let plan = solved(&course, &Settings::default());
        let least = cost[places.len() - 1];
        // The gap of the search; and a grid of 1 cm and 0.025° comes within a tenth of a second.
        assert!(
            plan.cost <= least + 5e-5 && plan.cost > least - 0.1,
            "{id}: {} {}",
            plan.cost,
            least
        );
    }
}
