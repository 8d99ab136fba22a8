//! The whole robot against the reference jumps: two derivations of one jump.

use saltus_robot::{Drive, Robot};
use saltus_sim_check::{End, Launch, Outcome, Plan, Rig, SimError};

/// The columns of the reference rows, by name.
struct Rows {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Rows {
    fn read() -> Rows {
        let text = include_str!("../../../tests/reference/jumps.csv");
        let mut lines = text
            .lines()
            .map(|line| line.split(',').map(String::from).collect::<Vec<_>>());
        Rows {
            names: lines.next().unwrap_or_default(),
            rows: lines.collect(),
        }
    }

    fn text<'a>(&self, row: &'a [String], name: &str) -> &'a str {
        let column = self
            .names
            .iter()
            .position(|n| n == name)
            .expect("a column of the reference");
        &row[column]
    }

    fn launch(&self, row: &[String]) -> Launch {
        Launch {
            rate: self.number(row, "omega0_rad_s"),
            lean: self.number(row, "phi0_rad"),
            firing_angle: self.number(row, "alpha_f_rad"),
            valve_open: self.number(row, "valve_open_s"),
        }
    }

    fn number(&self, row: &[String], name: &str) -> f64 {
        self.text(row, name).parse().expect("a number")
    }
}

#[test]
fn massless_legs_on_rigid_ground_jump_as_the_reference() -> Result<(), SimError> {
    let rig = Rig::new(&Robot::rats_planar(), &[])?;
    let rows = Rows::read();
    let (mut worst, mut count) = (0.0_f64, 0);
    let began = std::time::Instant::now();
    for row in &rows.rows {
        let n = |name: &str| rows.number(row, name);
        if rows.text(row, "outcome") != "stroke" {
            continue;
        }
        let launch = rows.launch(row);
        let plan = Plan {
            sample: 0.02,
            ..Plan::default()
        };
        let report = rig.jump(&launch, &plan)?;
        assert_eq!(report.end, End::Landed, "{launch:?}");
        let l = report.lift_off.expect("it landed");
        assert_eq!(l.outcome, Outcome::Stroke, "{launch:?}");
        let pairs = [
            ("t_fire_s", l.time_fire),
            ("t_liftoff_s", l.time),
            ("phi_rad", l.lean),
            ("omega_rad_s", l.rate),
            ("d_m", l.extension),
            ("pressure_pa", l.pressure),
            ("x_m", l.axle[0]),
            ("y_m", l.axle[1]),
            ("vx_m_s", l.axle_rates[0]),
            ("vy_m_s", l.axle_rates[1]),
            ("apex_m", report.apex),
            ("land_rs_m", report.landing),
            ("land_0_m", report.landing_at),
        ];
        for (name, found) in pairs {
            let error = (found - n(name)).abs() / n(name).abs().max(0.01);
            assert!(
                error < 1e-4,
                "{name}: {found} for {} in {launch:?}",
                n(name)
            );
            worst = worst.max(error);
        }
        assert!(report.residual.abs() < 1e-8, "{}", report.residual);
        count += 1;
    }
    println!(
        "{count} jumps, worst {worst:.1e}, {:.2} ms each",
        began.elapsed().as_secs_f64() * 1e3 / f64::from(count)
    );
    assert!(count > 50);
    Ok(())
}

/// What a ground that gives takes and keeps is in the ledger too.
#[test]
fn the_energy_ledger_closes_on_ground_that_gives() -> Result<(), SimError> {
    let mut robot = Robot::builtin("rats-boom").expect("a built-in robot");
    (robot.ground.static_friction, robot.ground.kinetic_friction) = (1.0, 1.0);
    for (stiffness, damping) in [(1e5, 0.0), (1e5, 300.0), (1e6, 1000.0)] {
        (robot.ground.stiffness, robot.ground.damping) = (Some(stiffness), damping);
        let launch = Launch {
            rate: 5.0,
            lean: -0.3,
            firing_angle: -0.1,
            valve_open: 0.1,
        };
        let report = Rig::new(&robot, &[])?.jump(&launch, &Plan::default())?;
        println!(
            "{stiffness:.0e} N/m, {damping} N s/m: {:.1e} J unexplained",
            report.residual
        );
        assert!(report.residual.abs() < 1e-6, "{}", report.residual);
    }
    Ok(())
}

/// Jumps that end before the stroke does. The reference ends the stance where the leg's axial force
/// F comes to 0, the simulation there or where the normal force does, N = F cos φ − T sin φ,
/// whichever is first. The tangential T = I ω̇/R stays finite where F vanishes, so that leaning
/// forward N comes to 0 before F. Ground that cannot pull makes the simulation the right one, by
/// 1.3 ms, 0.1 mm of apex and 1.5 mm of landing at most. Leaning back, the two are one.
#[test]
fn jumps_that_end_by_force_end_where_the_ground_would_have_to_pull() -> Result<(), SimError> {
    let rig = Rig::new(&Robot::rats_planar(), &[])?;
    let rows = Rows::read();
    let mut worst = [[0.0_f64; 3]; 2];
    let mut count = 0;
    for row in &rows.rows {
        let n = |name: &str| rows.number(row, name);
        if rows.text(row, "outcome") != "force" {
            continue;
        }
        let launch = rows.launch(row);
        let report = rig.jump(
            &launch,
            &Plan {
                sample: 0.02,
                ..Plan::default()
            },
        )?;
        assert_eq!(report.end, End::Landed, "{launch:?}");
        let l = report.lift_off.expect("it landed");
        assert_eq!(l.outcome, Outcome::Force, "{launch:?}");
        let differences = [
            l.time - n("t_liftoff_s"),
            report.apex - n("apex_m"),
            report.landing_at - n("land_0_m"),
        ];
        assert!(
            differences[0] < 1e-7,
            "{} s later in {launch:?}",
            differences[0]
        );
        let leans_forward = usize::from(n("phi_rad") > 0.01);
        let worst = &mut worst[leans_forward];
        *worst = std::array::from_fn(|k| worst[k].max(differences[k].abs()));
        count += 1;
    }
    println!(
        "{count} jumps differ by {worst:?} in s, m of apex and m of landing: leaning back, forward"
    );
    assert_eq!(count, 64);
    let [back, forward] = worst;
    assert!(back.iter().all(|x| *x < 1e-6), "{back:?}");
    assert!(
        forward[0] < 1.4e-3 && forward[1] < 1.2e-4 && forward[2] < 1.6e-3,
        "{forward:?}"
    );
    Ok(())
}

/// A spring that is longer than it is loose does not pull: what it gives is all that it held, ½ k
/// c², though the leg goes on.
#[test]
fn a_spring_past_its_free_length_is_slack() -> Result<(), SimError> {
    let mut robot = Robot::builtin("spring-hopper").expect("a built-in robot");
    let (stiffness, compression) = (20_000.0, 0.03);
    robot.leg.drive = Drive::Spring {
        stiffness,
        compression,
    };
    (robot.leg.body.mass, robot.leg.body.center) = (0.05, 0.1);
    let launch = Launch {
        rate: 0.0,
        lean: 0.0,
        firing_angle: 0.0,
        valve_open: 0.1,
    };
    let report = Rig::new(&robot, &[])?.jump(&launch, &Plan::default())?;
    assert_eq!(report.end, End::Landed);
    let extension = report
        .samples
        .iter()
        .map(|s| s.extension)
        .fold(0.0, f64::max);
    assert!(extension > 2.0 * compression, "{extension}");
    let stored = 0.5 * stiffness * compression * compression;
    assert!(
        (report.ledger.drive - stored).abs() < 1e-6,
        "{} J of {stored} J",
        report.ledger.drive
    );
    Ok(())
}
