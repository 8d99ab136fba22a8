//! Bad courses, and a robot that cannot aim. The hopper of the tests across crates has the others.

use saltus_numeric::{Scalar, Single};

use super::*;

fn course(jumps: usize, goal: f64) -> Course {
    let (obstacles, no_landing) = (Vec::new(), Vec::new());
    Course {
        id: "test".into(),
        start: 0.0,
        start_height: 0.0,
        jumps,
        goal: Span::point(goal),
        obstacles,
        no_landing,
    }
}

#[test]
fn bad_values_are_named() {
    let check = |course: Course, key: &str| {
        let error = plan(&Thrower { target: 1.0 }, &course, &Settings::default())
            .expect_err(key)
            .to_string();
        assert!(
            error.contains("`test`") && error.contains(key) && error.contains("allowed"),
            "{error}"
        );
    };
    let box_of = |width, height| Obstacle {
        center: 1.0,
        width,
        height,
    };
    check(course(0, 1.0), "jumps = 0");
    check(course(1_000_000, 1.0), "jumps = 1000000");
    check(course(2, f64::NAN), "goal_x_m = NaN");
    check(
        Course {
            start: f64::INFINITY,
            ..course(2, 1.0)
        },
        "start_x_m = inf",
    );
    check(
        Course {
            start_height: -0.1,
            ..course(2, 1.0)
        },
        "start_height_m = -0.1",
    );
    check(
        Course {
            goal: Span::new(1.0, 0.5),
            ..course(2, 1.0)
        },
        "goal_x_m",
    );
    check(
        Course {
            obstacles: vec![box_of(-0.2, 0.1)],
            ..course(2, 1.0)
        },
        "obstacle 1.width_m = -0.2",
    );
    check(
        Course {
            obstacles: vec![box_of(0.2, f64::NAN)],
            ..course(2, 1.0)
        },
        "obstacle 1.height_m = NaN",
    );
    check(
        Course {
            obstacles: vec![box_of(0.2, 0.1); 2],
            ..course(2, 1.0)
        },
        "obstacle 1 and obstacle 2",
    );
    check(
        Course {
            no_landing: vec![Span::new(1.0, 1.0)],
            ..course(2, 1.0)
        },
        "no_landing 1.width_m = 0",
    );
}

/// A thrower from the ground: decides speed and angle, and cannot aim; wants a speed near 3 m/s and
/// a landing near its target, and its landings spread with the speed. It rolls 0.1 m before each
/// jump but the first.
struct Thrower {
    target: f64,
}

impl Thrower {
    fn flight<S: Single>(leap: &Leap, speed: S, angle: S) -> [S; 3] {
        let (sin, cos) = angle.sin_cos();
        let (up, ahead) = (speed * sin, speed * cos);
        let time =
            (up + (up * up - S::of(2.0 * 9.81 * (leap.to - leap.from))).sqrt()) * S::of(1.0 / 9.81);
        [up, ahead, time]
    }
}

impl Jumper for Thrower {
    fn decisions(&self, _: usize) -> [Span; 2] {
        [Span::new(1.0, 5.0), Span::new(0.5, 1.4)]
    }
    fn fly(
        &self,
        leap: &Leap,
        foot: Slope,
        [speed, angle]: [Slope; 2],
        margins: &mut Vec<Margin<Slope>>,
    ) -> Flight<Slope> {
        let [up, ahead, time] = Thrower::flight(leap, speed, angle);
        for e in &leap.edges {
            let t = (Slope::of(e.x) - foot) / ahead;
            let over = Slope::of(leap.from - e.top - 0.05) + up * t - t * t * Slope::of(9.81 / 2.0);
            margins.push(Margin {
                limit: Limit::Edge {
                    obstacle: e.obstacle,
                    side: e.side,
                },
                value: over,
            });
        }
        let landing = foot + ahead * time;
        let (effort, miss) = (speed - Slope::of(3.0), landing - Slope::of(self.target));
        Flight {
            landing,
            cost: effort * effort + miss * miss,
        }
    }
    fn deviation(&self, _: &Leap, [speed, _]: [f64; 2]) -> f64 {
        0.02 * speed
    }
    fn aim(&self, _: &Leap, _: f64, _: f64) -> [f64; 2] {
        [3.0, 0.9]
    }
    fn envelope(&self, _: &Leap, feet: Span, landings: Span, reach: Span) -> Option<Envelope> {
        let reach = reach.meet(Span::new(0.0, 2.6)).meet(landings - feet);
        (!reach.is_empty()).then(|| Envelope::level(reach, 0.0))
    }
    fn edge_margin(&self, _: f64) -> f64 {
        0.05
    }
    fn roll(&self, _: usize) -> f64 {
        0.1
    }
}

#[test]
fn a_jumper_that_cannot_aim_is_solved_choice_by_choice() {
    let boxes = vec![Obstacle {
        center: 0.7,
        width: 0.21,
        height: 0.21,
    }];
    let course = Course {
        goal: Span::new(0.9, 1.2),
        obstacles: boxes,
        ..course(1, 0.0)
    };
    let settings = Settings {
        resolution: f64::INFINITY,
        sigmas: 2.0,
        ..Settings::default()
    };
    let thrower = Thrower { target: 1.3 };
    let Ok(Answer::Plan(plan)) = plan(&thrower, &course, &settings) else {
        panic!()
    };
    assert_eq!(plan.report.status, sqp::Status::Converged);
    // The target is behind the zone: the landing keeps two deviations from the zone's end. 1e-9:
    // the solver's.
    let jump = &plan.jumps[0];
    assert!(
        (jump.landing + 2.0 * jump.deviation - 1.2).abs() < 1e-9,
        "{plan:?}"
    );
    assert!(plan.report.iterations < 10 && plan.complete, "{plan:?}");
}

#[test]
fn a_roll_moves_the_next_foothold() {
    let course = Course {
        goal: Span::new(2.0, 3.0),
        ..course(2, 0.0)
    };
    let settings = Settings {
        resolution: f64::INFINITY,
        ..Settings::default()
    };
    let Ok(Answer::Plan(plan)) = plan(&Thrower { target: 2.0 }, &course, &settings) else {
        panic!()
    };
    assert!((plan.jumps[1].foot - plan.jumps[0].landing - 0.1).abs() < 1e-15);
}

#[test]
fn the_program_of_a_choice_has_exact_derivatives() {
    use super::problem::{Choice, Problem};
    use super::sqp::{Evaluation, Nlp};
    let edge = |x, side| Edge {
        x,
        top: 0.1,
        obstacle: 0,
        side,
    };
    let leap = |jump, edges| Leap {
        jump,
        from: 0.0,
        to: 0.0,
        on: [None; 2],
        edges,
        beside: vec![],
        push: Push::Any,
    };
    let leaps = vec![
        leap(0, vec![]),
        leap(1, vec![edge(1.3, Side::Front), edge(1.4, Side::Back)]),
        leap(2, vec![]),
    ];
    let windows = vec![Span::new(0.2, 1.2), Span::new(1.5, 3.0), Span::point(3.0)];
    let choice = Choice {
        leaps,
        windows,
        grounds: vec![],
    };
    let thrower = Thrower { target: 3.0 };
    let course = course(3, 3.0);
    let problem = Problem::new(&thrower, &course, &choice, 1.0);
    let x = [2.9, 0.8, 3.1, 0.9, 3.2, 1.0];
    let evaluate = |x: &[f64]| {
        let mut at = Evaluation::default();
        problem.evaluate(x, &mut at);
        at
    };
    let exact = evaluate(&x);
    for i in 0..x.len() {
        let shifted = |h: f64| {
            let mut y = x;
            y[i] += h;
            evaluate(&y)
        };
        let (after, before) = (shifted(1e-6), shifted(-1e-6));
        // Truncation 1e-12, round-off 1e-16/1e-6.
        let agrees = |slope: f64, a: f64, b: f64| (slope - (a - b) / 2e-6).abs() < 1e-8;
        assert!(agrees(exact.gradient[i], after.cost, before.cost));
        for row in 0..exact.values.len() {
            assert!(
                agrees(
                    exact.jacobian[row * 6 + i],
                    after.values[row],
                    before.values[row]
                ),
                "row {row}, variable {i}"
            );
        }
    }
}
