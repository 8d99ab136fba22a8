//! What a motion costs: in proportion to its time, and no worse than its bodies.

use std::time::Instant;

use saltus_sim_check::{Joint, Mechanism, Settings, Sim, SimError, Tree, Vec3};

use crate::bodies::{body, diagonal, down, free_body, spinning};

/// Twenty and eighty swings of a pendulum: the same steps again and again.
#[test]
fn evaluations_grow_in_proportion_to_time() -> Result<(), SimError> {
    let mut tree = Tree::default();
    tree.add(body(
        "bob",
        None,
        Joint::Revolute(Vec3::y()),
        Vec3::zeros(),
        1.3,
        Vec3::new(0.0, 0.0, -0.7),
        diagonal(0.01, 0.01, 0.01),
    ))?;
    let mechanism = Mechanism::new(tree, down());
    let effort = |time: f64| -> Result<usize, SimError> {
        let mut sim = Sim::new(&mechanism, &[2.0], &[0.0], Settings::default())?;
        sim.run(time, &[])?;
        Ok(sim.effort().1)
    };
    let (short, long) = (effort(50.0)?, effort(200.0)?);
    let ratio = long as f64 / short as f64;
    println!("{short} evaluations for 50 s, {long} for 200 s: {ratio:.4} times as many");
    // Less than a swing of the short run, 1/20, is start and end.
    assert!((ratio - 4.0).abs() < 0.05, "{ratio}");
    Ok(())
}

/// The same of a tumbling body whose legs all swing: not periodic, so that the ratio is only
/// near 4.
#[test]
fn twelve_legs_cost_in_proportion_to_time() -> Result<(), SimError> {
    let mechanism = free_body(12)?;
    let (q, v) = spinning(12);
    let mut sim = Sim::new(&mechanism, &q, &v, Settings::default())?;
    sim.run(0.5, &[])?;
    let first = sim.effort().1;
    sim.run(2.0, &[])?;
    let ratio = sim.effort().1 as f64 / first as f64;
    println!("twelve legs: {first} evaluations for 0.5 s, {ratio:.3} times as many for 2 s");
    assert!((3.6..4.4).contains(&ratio), "{ratio}");
    Ok(())
}

/// Twelve legs have 18 freedoms, five have 11: (18/11)² of work in the matrices, (18/11)³ in their
/// factors, at most.
#[test]
fn twelve_legs_cost_at_most_four_times_five() -> Result<(), SimError> {
    let few = free_body(5)?;
    let many = free_body(12)?;
    let seconds = |mechanism: &Mechanism, legs: usize| -> Result<f64, SimError> {
        let (q, v) = spinning(legs);
        let began = Instant::now();
        let mut sim = Sim::new(mechanism, &q, &v, Settings::default())?;
        sim.run(0.5, &[])?;
        Ok(began.elapsed().as_secs_f64() / 0.5)
    };
    // The least of many short runs, in turns, is what a busy machine disturbs least.
    let (mut least_few, mut least_many) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..100 {
        least_few = least_few.min(seconds(&few, 5)?);
        least_many = least_many.min(seconds(&many, 12)?);
    }
    println!(
        "{:.2} ms a second for five legs, {:.2} ms for twelve: {:.2} times",
        least_few * 1e3,
        least_many * 1e3,
        least_many / least_few
    );
    assert!(least_many < 4.0 * least_few, "{}", least_many / least_few);
    Ok(())
}
