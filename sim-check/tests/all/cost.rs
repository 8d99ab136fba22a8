//! What a motion costs: in proportion to its time, and no worse than its bodies.

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

/// Seven legs more make the motion no stiffer: the integrator needs as many evaluations. What an
/// evaluation costs is the benchmarks' to say.
#[test]
fn twelve_legs_take_as_many_evaluations_as_five() -> Result<(), SimError> {
    let evaluations = |legs: usize| -> Result<usize, SimError> {
        let mechanism = free_body(legs)?;
        let (q, v) = spinning(legs);
        let mut sim = Sim::new(&mechanism, &q, &v, Settings::default())?;
        sim.run(0.5, &[])?;
        Ok(sim.effort().1)
    };
    let (few, many) = (evaluations(5)?, evaluations(12)?);
    println!("{few} evaluations with five legs, {many} with twelve");
    let ratio = many as f64 / few as f64;
    assert!((0.8..1.25).contains(&ratio), "{few} and {many}");
    Ok(())
}
