//! The planar robot is the case of a ring of legs: a body that moves freely in space with its legs in one plane does, in that
//! plane, what the planar robot does.

use saltus_robot::space::Directions;
use saltus_robot::{Robot, Space};
use saltus_sim_check::{Rig, Settings, Sim, SimError, Stepping};

/// The robot of the thesis as it runs, on its wheel alone.
fn planar() -> Robot {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/rats-run.toml");
    let mut robot = saltus_robot::resolve(path, &[] as &[String]).unwrap_or_else(|e| panic!("{e}"));
    (robot.boom, robot.struts) = (None, None);
    robot
}

/// The same five legs and masses on a body that moves freely.
fn ring(planar: &Robot) -> Robot {
    let mut robot = planar.clone();
    let directions = (0..planar.body.legs).map(|k| planar.leg_direction(k));
    let mut inertia = planar.wheel_disc(0.0).inertia;
    for k in 0..planar.body.legs {
        let rod = planar.leg_rod(k);
        let square: f64 = rod.center.iter().map(|x| x * x).sum();
        for (i, row) in inertia.iter_mut().enumerate() {
            for (j, x) in row.iter_mut().enumerate() {
                let round = if i == j { square } else { 0.0 };
                *x += rod.inertia[i][j] + rod.mass * (round - rod.center[i] * rod.center[j]);
            }
        }
    }
    let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = inertia;
    robot.space = Some(Space {
        directions: Directions::List(directions.collect()),
        inertia: [xx, yy, zz, xy, xz, yz],
        ..Space::default()
    });
    robot
}

/// Coordinates and velocities of the planar robot as those of a free body.
fn in_space(q: &[f64], v: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let half = 0.5 * q[2];
    let mut free = vec![q[0], 0.0, q[1], half.cos(), 0.0, half.sin(), 0.0];
    free.extend_from_slice(&q[3..]);
    let mut rates = vec![v[0], 0.0, v[1], 0.0, v[2], 0.0];
    rates.extend_from_slice(&v[3..]);
    (free, rates)
}

/// How far the two are apart (m, rad, m/s, rad/s), whatever the sign of the quaternion.
fn apart(flat: &Sim<'_>, free: &Sim<'_>) -> f64 {
    let (q, v) = in_space(flat.coordinates(), flat.velocities());
    let (p, u) = (free.coordinates(), free.velocities());
    let sign = (0..4).map(|k| q[3 + k] * p[3 + k]).sum::<f64>().signum();
    let placed = q.iter().zip(p).enumerate();
    let placed = placed.map(|(k, (a, b))| {
        if (3..7).contains(&k) {
            sign * a - b
        } else {
            a - b
        }
    });
    let moving = v.iter().zip(u).map(|(a, b)| a - b);
    placed
        .chain(moving)
        .fold(0.0, |most, off| f64::max(most, off.abs()))
}

/// What fires when: the leg, and its valve opens at this time (s), for 40 ms.
type Firings = [(f64, usize)];

/// Both from the lean `lean` (rad) at the rate `rate` (rad/s); the greatest way apart until `end` (s), and the planar one's
/// highest axle (m) and travel (m).
fn compared(
    [lean, rate]: [f64; 2],
    firings: &Firings,
    end: f64,
    settings: Settings,
) -> Result<[f64; 3], SimError> {
    let robot = planar();
    let (flat_rig, free_rig) = (Rig::new(&robot, &[])?, Rig::new(&ring(&robot), &[])?);
    let (q, v) = flat_rig.stand(lean, rate)?;
    let mut flat = Sim::new(&flat_rig.mechanism, &q, &v, settings)?;
    let (q, v) = in_space(&q, &v);
    let mut free = Sim::new(&free_rig.mechanism, &q, &v, settings)?;
    for sim in [&mut flat, &mut free] {
        sim.release_legs()?;
    }
    let (mut most, mut height) = (0.0_f64, 0.0_f64);
    let mut next = firings.iter().peekable();
    for cycle in 0.. {
        let now = f64::from(cycle) * 5e-3;
        if now > end {
            break;
        }
        while let Some((_, leg)) = next.next_if(|(at, _)| *at <= now) {
            flat.fire(*leg, 0.04)?;
            free.fire(*leg, 0.04)?;
        }
        for sim in [&mut flat, &mut free] {
            sim.run(now + 5e-3, &[])?;
        }
        most = most.max(apart(&flat, &free));
        height = height.max(flat.coordinates()[1]);
    }
    Ok([most, height, flat.coordinates()[0]])
}

/// Within so little per step, or in steps of this length (s).
fn exact(tolerance: f64) -> Settings {
    Settings {
        tolerance,
        ..Settings::default()
    }
}

fn steps(length: f64) -> Settings {
    Settings {
        stepping: Stepping::Fixed(length),
        ..Settings::default()
    }
}

/// A quaternion and an angle have other round-off, and other errors of a step, which shrink with its tolerance.
#[test]
fn a_ring_of_legs_jumps_as_the_planar_robot() -> Result<(), SimError> {
    for start in [[0.1, 3.0], [0.25, 5.0], [-0.1, 8.0]] {
        let jump = |settings| compared(start, &[(0.0, 0)], 0.6, settings);
        for tolerance in [1e-10, 1e-13] {
            let [apart, height, travel] = jump(exact(tolerance))?;
            println!("{start:?} {tolerance:e}: {apart:.1e}");
            assert!(apart < 1e4 * tolerance, "{start:?} {tolerance}: {apart}");
            assert!(
                height > 0.35 && travel > 0.7,
                "{start:?}: {height} {travel}"
            );
        }
        let [coarse, fine] = [jump(steps(1e-3))?[0], jump(steps(2.5e-4))?[0]];
        println!("{start:?} {coarse:.1e} {fine:.1e}");
        assert!(
            coarse < 5e-4 && fine < 0.2 * coarse,
            "{start:?}: {coarse} {fine}"
        );
    }
    Ok(())
}

#[test]
fn a_ring_of_legs_strides_as_the_planar_robot() -> Result<(), SimError> {
    let firings = [(0.0, 0), (0.5, 1), (0.8, 2), (1.1, 3), (1.4, 4)];
    // Five firings and the impacts between them let what is apart grow.
    for (tolerance, within) in [(1e-10, 1e-6), (1e-13, 1e-8)] {
        let [apart, height, travel] = compared([0.1, 5.0], &firings, 1.6, exact(tolerance))?;
        println!("{tolerance:e}: {apart:.1e} {height} {travel}");
        assert!(apart < within, "{tolerance}: {apart}");
        assert!(height > 0.5 && travel > 1.2, "{height} {travel}");
    }
    Ok(())
}
