//! The learners on tasks whose answers are known.
//!
//! Source: Sutton and Barto, Reinforcement Learning, 2nd edition, examples 6.2, 6.5, 6.6.

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use saltus_gait::GaitError;
use saltus_gait::learn::{
    Act, Actions, Algorithm, Axis, Bin, Bins, Environment, Episode, Outcome, Rates, Schedule, Seen,
    Step, Tabular, Training, greedy, train,
};

/// From a state and an action: the next state, the reward, and whether it is the end.
type Moves = fn(usize, usize, &mut Pcg64) -> (usize, f64, bool);

/// A task of numbered states.
struct Numbered {
    observed: Vec<Axis>,
    actions: Actions,
    start: usize,
    longest: usize,
    moves: Moves,
}

impl Numbered {
    fn new((states, actions): (usize, usize), start: usize, moves: Moves) -> Numbered {
        let high = states as f64 - 0.5;
        Numbered {
            observed: vec![Axis {
                name: "state",
                unit: "1",
                low: -0.5,
                high,
            }],
            actions: Actions::Choices((0..actions).map(|k| k.to_string()).collect()),
            start,
            longest: 10_000,
            moves,
        }
    }

    fn bins(&self) -> Bins {
        let Axis { low, high, .. } = self.observed[0];
        let count = whole(high - low);
        let bin = Bin {
            from: low,
            to: high,
            count,
        };
        Bins::new(vec![bin]).expect("legal")
    }

    fn training(&self, algorithm: Algorithm, rates: Rates, schedule: Schedule) -> Training<'_> {
        Training {
            environment: self,
            bins: self.bins(),
            algorithm,
            rates,
            schedule,
        }
    }
}

impl Environment for Numbered {
    fn observed(&self) -> &[Axis] {
        &self.observed
    }

    fn actions(&self) -> &Actions {
        &self.actions
    }

    fn start(&self, seed: u64) -> Result<Box<dyn Episode>, GaitError> {
        Ok(Box::new(Going {
            random: Pcg64::new(u128::from(seed), 5),
            state: [self.start as f64],
            left: self.longest,
            moves: self.moves,
        }))
    }
}

struct Going {
    random: Pcg64,
    state: [f64; 1],
    left: usize,
    moves: Moves,
}

impl Episode for Going {
    fn observation(&self) -> &[f64] {
        &self.state
    }

    fn step(&mut self, act: Act<'_>) -> Result<Step, GaitError> {
        let action = act.choice(99)?;
        let (next, reward, terminated) =
            (self.moves)(whole(self.state[0]), action, &mut self.random);
        self.state = [next as f64];
        self.left -= 1;
        Ok(Step {
            reward,
            terminated,
            truncated: self.left == 0,
        })
    }

    fn outcome(&self) -> Outcome {
        Outcome::default()
    }
}

/// A whole number ≥ 0.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn whole(x: f64) -> usize {
    x.round() as usize
}

fn unit(random: &mut Pcg64) -> f64 {
    Uniform::new(0.0, 1.0).map_or(0.0, |it| it.sample(random))
}

fn rates(alpha: f64, gamma: f64, lambda: f64) -> Rates {
    Rates {
        alpha,
        gamma,
        lambda,
    }
}

fn schedule(epsilon: f64, episodes: usize) -> Schedule {
    Schedule {
        epsilon,
        decay: 1.0,
        episodes,
    }
}

/// Mean over seeds, and its standard error.
fn mean(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

#[test]
fn a_random_walk_has_its_values() -> Result<(), GaitError> {
    // Five states, either way with equal chance, 1 at the right end: the values are 1/6 to 5/6.
    let walk = Numbered::new((7, 1), 3, |state, _, random| {
        let next = if unit(random) < 0.5 {
            state - 1
        } else {
            state + 1
        };
        (next, f64::from(u8::from(next == 6)), next == 0 || next == 6)
    });
    for algorithm in Algorithm::ALL {
        let training = walk.training(algorithm, rates(0.01, 1.0, 0.8), schedule(0.0, 2000));
        let tables = (0..40).map(|seed| {
            let mut table = training.table()?;
            train(&training, &mut table, (seed, 0), |_, _, _| true)?;
            Ok(table)
        });
        let tables: Vec<Tabular> = tables.collect::<Result<_, GaitError>>()?;
        for state in 1..6 {
            let values: Vec<f64> = tables.iter().map(|table| table.value(state, 0)).collect();
            let (value, error) = mean(&values);
            let exact = state as f64 / 6.0;
            assert!(
                (value - exact).abs() < 3.0 * error,
                "{algorithm:?} {state}: {value} ± {error}"
            );
        }
    }
    Ok(())
}

/// A step on a grid of `width` × `height`: up, down, right, left.
fn moved(state: usize, action: usize, [width, height]: [usize; 2]) -> (usize, usize) {
    let (x, y) = (state % width, state / width);
    match action {
        0 => (x, (y + 1).min(height - 1)),
        1 => (x, y.saturating_sub(1)),
        2 => ((x + 1).min(width - 1), y),
        _ => (x.saturating_sub(1), y),
    }
}

/// Along the lower edge of 12 × 4 fields is a cliff, between the start and the goal.
fn cliff(state: usize, action: usize, _: &mut Pcg64) -> (usize, f64, bool) {
    match moved(state, action, [12, 4]) {
        (11, 0) => (11, -1.0, true),
        (1..=10, 0) => (0, -100.0, false),
        (x, y) => (y * 12 + x, -1.0, false),
    }
}

#[test]
fn beside_a_cliff_sarsa_is_careful_and_q_is_not() -> Result<(), GaitError> {
    let task = Numbered {
        longest: 2000,
        ..Numbered::new((48, 4), 0, cliff)
    };
    let mut online = Vec::new();
    for algorithm in [Algorithm::Sarsa, Algorithm::Q] {
        let training = task.training(algorithm, rates(0.1, 1.0, 0.0), schedule(0.1, 3000));
        let (mut last, mut learnt) = (Vec::new(), Vec::new());
        for seed in 0..12 {
            let mut table = training.table()?;
            let mut late = 0.0;
            train(&training, &mut table, (seed, 0), |episode, score, _| {
                late += if episode >= 2000 {
                    score.total / 1000.0
                } else {
                    0.0
                };
                true
            })?;
            last.push(late);
            learnt.push(greedy(&training, &table, (seed, 0))?.total);
        }
        let sure = learnt.iter().filter(|total| **total > -100.0).count();
        let best = learnt.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        online.push(mean(&last));
        match algorithm {
            // The way along the edge has 13 steps, the one farthest from it 17.
            Algorithm::Q => assert!(learnt.iter().all(|total| *total == -13.0), "{learnt:?}"),
            _ => assert!(sure >= 10 && best <= -15.0, "{learnt:?}"),
        }
    }
    let ((sarsa, a), (q, b)) = (online[0], online[1]);
    assert!(
        sarsa - q > 3.0 * (a * a + b * b).sqrt(),
        "{sarsa} ± {a}, {q} ± {b}"
    );
    Ok(())
}

/// Wind from below in the columns of 10 × 7 fields.
fn windy(state: usize, action: usize, _: &mut Pcg64) -> (usize, f64, bool) {
    const WIND: [usize; 10] = [0, 0, 0, 1, 1, 1, 2, 2, 1, 0];
    let (x, y) = moved(state, action, [10, 7]);
    let y = (y + WIND[state % 10]).min(6);
    let goal = (x, y) == (7, 3);
    (y * 10 + x, -1.0, goal)
}

#[test]
fn in_the_wind_all_find_the_shortest_way() -> Result<(), GaitError> {
    let task = Numbered::new((70, 4), 30, windy);
    for algorithm in Algorithm::ALL {
        let training = Training {
            schedule: Schedule {
                epsilon: 0.3,
                decay: 0.998,
                episodes: 3000,
            },
            ..task.training(algorithm, rates(0.2, 1.0, 0.5), schedule(0.1, 1))
        };
        let found: Result<Vec<f64>, GaitError> = (0..5)
            .map(|seed| {
                let mut table = training.table()?;
                train(&training, &mut table, (seed, 0), |_, _, _| true)?;
                Ok(greedy(&training, &table, (seed, 0))?.total)
            })
            .collect();
        let found = found?;
        let shortest = found.iter().filter(|total| **total == -15.0).count();
        assert!(shortest >= 4, "{algorithm:?}: {found:?}");
    }
    Ok(())
}

/// Ten states, three actions, each with two ways on.
fn woven(state: usize, action: usize, random: &mut Pcg64) -> (usize, f64, bool) {
    let (likely, next) = ways(state, action);
    let to = if unit(random) < likely {
        next[0]
    } else {
        next[1]
    };
    (to, gain(state, action), false)
}

fn ways(state: usize, action: usize) -> (f64, [usize; 2]) {
    let likely = 0.5 + 0.1 * (action as f64);
    (
        likely,
        [
            (3 * state + action + 1) % 10,
            (7 * state + 2 * action + 4) % 10,
        ],
    )
}

fn gain(state: usize, action: usize) -> f64 {
    1.0 + ((state * 3 + action * 5) % 7) as f64
}

#[test]
fn q_learning_comes_to_the_exact_values() -> Result<(), GaitError> {
    const GAMMA: f64 = 0.8;
    let mut exact = [[0.0; 3]; 10];
    for _ in 0..400 {
        let best = exact.map(|row: [f64; 3]| row.into_iter().fold(f64::MIN, f64::max));
        for (state, row) in exact.iter_mut().enumerate() {
            for (action, value) in row.iter_mut().enumerate() {
                let (likely, [a, b]) = ways(state, action);
                *value =
                    gain(state, action) + GAMMA * (likely * best[a] + (1.0 - likely) * best[b]);
            }
        }
    }
    let task = Numbered {
        longest: 400_000,
        ..Numbered::new((10, 3), 0, woven)
    };
    // First in great steps, then in small ones.
    let mut values = None;
    for alpha in [0.1, 0.003] {
        let training = task.training(Algorithm::Q, rates(alpha, GAMMA, 0.0), schedule(1.0, 3));
        let mut table = training.table()?;
        if let Some(values) = values {
            table = table.with_values(values)?;
        }
        train(&training, &mut table, (1, 0), |_, _, _| true)?;
        values = Some(table.values().to_vec());
    }
    for (found, exact) in values.unwrap_or_default().iter().zip(exact.as_flattened()) {
        assert!((found / exact - 1.0).abs() < 0.01, "{found} {exact}");
    }
    Ok(())
}

#[test]
fn traces_that_are_listed_give_the_values_of_a_full_table() -> Result<(), GaitError> {
    const STATES: usize = 12;
    for algorithm in [Algorithm::SarsaLambda, Algorithm::QLambda] {
        let mut table = Tabular::new(algorithm, rates(0.3, 0.9, 0.8), (STATES, 3))?;
        let mut random = Pcg64::new(7, 7);
        let (mut dense, mut trace) = ([[0.0; 3]; STATES], [[0.0; 3]; STATES]);
        let mut draw = |below: f64| whole((unit(&mut random) * below).floor());
        let (mut state, mut action) = (0, 0);
        for step in 0..3000 {
            let reward = draw(5.0) as f64 - 2.0;
            let next = (step % 50 != 49).then(|| (draw(12.0), draw(3.0)));
            table.learn(&Seen {
                state,
                action,
                reward,
                next,
            });
            // As the thesis writes it, over all states and actions.
            let best = |row: &[f64; 3]| row.iter().copied().fold(f64::MIN, f64::max);
            let after = next.map_or(0.0, |(s, a)| match algorithm {
                Algorithm::SarsaLambda => dense[s][a],
                _ => best(&dense[s]),
            });
            let delta = reward + 0.9 * after - dense[state][action];
            trace[state][action] += 1.0;
            // Q_{t-1}, the table before the update, says whether the next action is greedy.
            let goes_on = next.is_some_and(|(s, a)| {
                algorithm == Algorithm::SarsaLambda || dense[s][a] >= best(&dense[s])
            });
            for (row, e) in dense.iter_mut().zip(&trace) {
                for (value, e) in row.iter_mut().zip(e) {
                    *value += 0.3 * delta * e;
                }
            }
            let fade = if goes_on { 0.9 * 0.8 } else { 0.0 };
            trace.iter_mut().flatten().for_each(|e| *e *= fade);
            if next.is_none() {
                table.begin();
            }
            (state, action) = next.unwrap_or_else(|| (draw(12.0), draw(3.0)));
        }
        for (found, exact) in table.values().iter().zip(dense.as_flattened()) {
            assert!(
                (found - exact).abs() < 1e-12 * exact.abs().max(1.0),
                "{found} {exact}"
            );
        }
    }
    Ok(())
}

#[test]
fn learning_goes_on_where_it_was_left() -> Result<(), GaitError> {
    let task = Numbered::new((70, 4), 30, windy);
    let training = task.training(Algorithm::QLambda, rates(0.2, 1.0, 0.5), schedule(0.2, 40));
    let mut whole = training.table()?;
    train(&training, &mut whole, (3, 0), |_, _, _| true)?;
    let mut parts = training.table()?;
    train(&training, &mut parts, (3, 0), |episode, _, _| episode < 16)?;
    let mut again = training.table()?.with_values(parts.values().to_vec())?;
    train(&training, &mut again, (3, 17), |_, _, _| true)?;
    assert_eq!(whole.values(), again.values());
    Ok(())
}

#[test]
fn bad_numbers_are_refused() {
    let task = Numbered::new((70, 4), 30, windy);
    let bad = [
        rates(-0.1, 1.0, 0.5),
        rates(0.1, 1.1, 0.5),
        rates(0.1, 1.0, f64::NAN),
    ];
    for rates in bad {
        assert!(
            task.training(Algorithm::Q, rates, schedule(0.1, 1))
                .table()
                .is_err()
        );
    }
    for schedule in [schedule(1.1, 1), schedule(0.1, 0), schedule(f64::NAN, 1)] {
        let training = task.training(Algorithm::Q, rates(0.1, 1.0, 0.5), schedule);
        assert!(training.table().is_err());
    }
    assert!(Tabular::new(Algorithm::Q, rates(0.1, 0.9, 0.0), (1 << 26, 6)).is_err());
}
