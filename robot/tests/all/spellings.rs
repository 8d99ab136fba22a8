//! The ways to say one thing: units, files and lists, overrides.

use std::path::Path;

use saltus_robot::{
    Cushion, Cylinder, Drive, ExhaustPort, Gas, GaugePressure, Ground, ReturnSpring, Robot,
    Sensors, resolve,
};

/// `rats-planar` with `overrides`.
#[track_caller]
fn rats_with(overrides: &[&str]) -> Robot {
    let overrides: Vec<String> = overrides.iter().map(|&text| text.into()).collect();
    resolve("rats-planar", &overrides).unwrap_or_else(|error| panic!("{error}"))
}

/// `rats-planar` with its cylinder changed.
fn rats_with_cylinder(change: impl Fn(&mut Cylinder)) -> Robot {
    let mut robot = Robot::rats_planar();
    match &mut robot.leg.drive {
        Drive::Pneumatic(cylinder) => change(cylinder),
        other => panic!("{other:?}"),
    }
    robot
}

#[test]
fn units_of_one_quantity_agree_to_the_last_bit() {
    let check = |spellings: &[&str]| {
        let robots: Vec<Robot> = spellings.iter().map(|&text| rats_with(&[text])).collect();
        assert!(
            robots.windows(2).all(|pair| pair[0] == pair[1]),
            "{spellings:?}"
        );
        assert_ne!(robots[0], Robot::rats_planar(), "{spellings:?}");
    };
    check(&[
        "body.mass_kg=2.6",
        "body.mass_g=2600",
        "body.mass_g=2_600.0",
        "body.mass_g=0.26e4",
    ]);
    check(&["body.wheel_radius_m=0.2417", "body.wheel_radius_mm=241.7"]);
    check(&[
        "leg.stroke_m=0.0617",
        "leg.stroke_mm=61.7",
        "leg.stroke_mm=+61.7",
    ]);
    check(&["leg.valve_delay_s=0.0113", "leg.valve_delay_ms=11.3"]);
    check(&["leg.dead_volume_m3=5.7e-6", "leg.dead_volume_cm3=5.7"]);
    check(&[
        "leg.supply_pressure_gauge_pa=830000",
        "leg.supply_pressure_gauge_kpa=830",
        "leg.supply_pressure_gauge_bar=8.3",
        "leg.supply_pressure_absolute_pa=931325",
        "leg.supply_pressure_absolute_kpa=931.325",
    ]);
    check(&["leg.leak_area_m2=1.3e-7", "leg.leak_area_mm2=0.13"]);
    check(&[
        "leg.seal_friction_n_per_pa=1.7e-6",
        "leg.seal_friction_mm2=1.7",
    ]);
    check(&[
        "environment.ambient_pressure_pa=98765",
        "environment.ambient_pressure_kpa=98.765",
    ]);
    check(&[
        "errors.firing_angle_rad=0.017453292519943295",
        "errors.firing_angle_deg=1",
    ]);
    check(&[
        "leg.gas=nitrogen",
        "leg.gas=\"nitrogen\"",
        "leg.gas={heat_ratio=1.4,molar_mass_kg_mol=0.0280134}",
        "leg.gas={heat_ratio=1.4,molar_mass_g_mol=28.0134}",
    ]);
    check(&["body.legs=3", "body.legs=0x3"]);
}

#[test]
fn an_override_changes_what_it_names() {
    let psi = 6_894.757_293_168;
    let check = |overrides: &[&str], change: &dyn Fn(&mut Cylinder)| {
        assert_eq!(
            rats_with(overrides),
            rats_with_cylinder(change),
            "{overrides:?}"
        );
    };
    check(&[], &|_| ());
    check(&["leg.supply_pressure_gauge_psi=100"], &|c| {
        c.supply = GaugePressure(100.0 * psi);
    });
    check(&[" leg . supply_pressure_gauge_psi = 100 "], &|c| {
        c.supply = GaugePressure(100.0 * psi);
    });
    check(&["leg.supply_pressure_gauge_bar=7"], &|c| {
        c.supply = GaugePressure(7e5);
    });
    check(&["leg.supply_pressure_absolute_pa=701325"], &|c| {
        c.supply = GaugePressure(6e5);
    });
    // The later one wins, in whichever unit.
    check(&["leg.bore_m=0.02", "leg.bore_mm=25"], &|c| c.bore = 0.025);
    check(&["leg.bore_mm=25", "leg.bore_m=0.02"], &|c| c.bore = 0.02);
    check(&["leg.gas=co2"], &|c| c.gas = Gas::CO2);
    check(&["leg.gas='carbon dioxide'"], &|c| c.gas = Gas::CO2);
    check(&["leg.gas=helium"], &|c| c.gas = Gas::HELIUM);
    let described = "leg.gas={heat_ratio=1.289, molar_mass_g_mol=44.0095}";
    check(&[described], &|c| c.gas = Gas::CO2);
    // One quantity, whichever way it is given: the later one wins.
    check(&[described, "leg.gas.constant_j_per_kg_k=200"], &|c| {
        c.gas = Gas {
            heat_ratio: 1.289,
            constant: 200.0,
        };
    });
    check(
        &[
            "leg.gas={heat_ratio=1.094, constant_j_per_kg_k=200}",
            "leg.gas.molar_mass_kg_mol=0.14606",
        ],
        &|c| c.gas = Gas::of_molar_mass(0.14606, 1.094),
    );
    check(
        &[
            "leg.gas={heat_ratio=1.3, constant_j_per_kg_k=200}",
            "leg.gas.heat_ratio=1.2",
        ],
        &|c| {
            c.gas = Gas {
                heat_ratio: 1.2,
                constant: 200.0,
            };
        },
    );
    check(&["leg.polytropic_exponent=1.2"], &|c| {
        c.polytropic_exponent = Some(1.2);
    });
    check(&["leg.supply_droop_pa_s_per_kg=2e6"], &|c| {
        c.supply_droop = 2e6;
    });
    check(&["leg.exhaust_port={position_mm=50, area_mm2=3}"], &|c| {
        c.exhaust_port = Some(ExhaustPort {
            position: 0.05,
            area: 3e-6,
        });
    });
    // −0 is off with the same bits as 0.
    check(&["leg.leak_area_m2=-0.0"], &|c| {
        assert_eq!(c.leak_area.to_bits(), 0);
    });
}

#[test]
fn overrides_add_optional_tables() {
    let robot = rats_with(&[
        "leg.return_spring.stiffness_n_per_m=50",
        "leg.return_spring.preload_n=2",
        "leg.cushion.length_mm=5",
        "leg.cushion.stiffness_n_per_mm=2",
        "leg.cushion.damping_n_s_per_m=3",
        "environment.drag_per_m=0.01",
        "name=my own rats",
    ]);
    assert_eq!(
        robot.leg.return_spring,
        Some(ReturnSpring {
            stiffness: 50.0,
            preload: 2.0
        })
    );
    assert_eq!(
        robot.leg.cushion,
        Some(Cushion {
            length: 0.005,
            stiffness: 2000.0,
            damping: 3.0
        })
    );
    assert_eq!(robot.environment.drag, 0.01);
    assert_eq!(robot.name, "my own rats");
}

/// Sensors are as the thesis' in all that a file leaves out, and a table without a key is not the
/// same as none.
#[test]
fn sensors_are_by_default_those_of_the_thesis() {
    let sensors = |overrides: &[&str]| rats_with(overrides).sensors;
    assert_eq!(sensors(&[]), None);
    assert_eq!(sensors(&["sensors={}"]), Some(Sensors::default()));
    assert_eq!(
        sensors(&[
            "sensors.gyro_noise_rad_s=0.1",
            "sensors.fine_accelerometer_range_g=4",
            "sensors.converter_bits=12",
        ]),
        Some(Sensors {
            gyro_noise: 0.1,
            fine_accelerometer_range: 4.0 * 9.80665,
            converter_bits: 12.0,
            ..Sensors::default()
        })
    );
    let robot = rats_with(&["sensors={}"]);
    let read = Robot::parse(&robot.to_toml(), "robot.toml", Path::new("."));
    assert_eq!(read.expect("sound"), robot);
}

/// Table 3.1, in the units of the makers.
#[test]
fn table_3_1_of_the_thesis_is_the_default() {
    let stated = [
        "sensors.wheel_counts=800",
        "sensors.radius_counts=1600",
        "sensors.pivot_counts=1600",
        "sensors.fine_gyro_range_deg_s=573",
        "sensors.coarse_gyro_range_deg_s=1500",
        "sensors.fine_accelerometer_range_g=2",
        "sensors.coarse_accelerometer_range_g=50",
        "sensors.converter_bits=16",
        "sensors.period_ms=1",
    ];
    assert_eq!(rats_with(&stated).sensors, Some(Sensors::default()));
}

/// A foot that slips resists as much as one that does not yet, unless the file says otherwise.
#[test]
fn ground_friction() {
    let ground = |overrides: &[&str]| rats_with(overrides).ground;
    let plain = Ground::default();
    assert_eq!(ground(&["ground.static_friction=inf"]), plain);
    assert_eq!(ground(&["ground.slope_rad=-0.0"]).slope.to_bits(), 0);
    let rough = ground(&["ground.static_friction=0.8"]);
    assert_eq!(
        rough,
        Ground {
            static_friction: 0.8,
            kinetic_friction: 0.8,
            ..plain
        }
    );
    let rough = ground(&["ground.static_friction=0.8", "ground.kinetic_friction=0.6"]);
    assert_eq!(
        rough,
        Ground {
            static_friction: 0.8,
            kinetic_friction: 0.6,
            ..plain
        }
    );
    let late = ground(&["ground.kinetic_friction=0.6"]);
    assert_eq!(
        late,
        Ground {
            kinetic_friction: 0.6,
            ..plain
        }
    );
}

#[test]
fn an_override_replaces_a_whole_leg() {
    let robot = rats_with(&[
        "leg={kind='constant', stroke_mm=60, release_delay_ms=0, viscous_friction_n_s_per_m=0, coulomb_friction_n=0}",
        "leg.force_n=300",
    ]);
    assert_eq!(robot.leg.drive, Drive::Constant { force: 300.0 });
}

#[test]
fn an_override_replaces_a_force_table_by_a_file_and_back() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots");
    let file = folder.join("table-hopper-force.csv");
    let listed = "leg.table={extensions_m=[0,0.05],speeds_m_s=[0,1],forces_n=[[4,3],[2,1]]}";
    let from_list = resolve("table-hopper", &[listed.into()]).expect("sound");
    let Drive::Table(table) = &from_list.leg.drive else {
        panic!("{:?}", from_list.leg.drive)
    };
    assert_eq!(table.forces, [4.0, 3.0, 2.0, 1.0]);
    let from_file = resolve(
        "table-hopper",
        &[listed.into(), format!("leg.file={}", file.display())],
    )
    .expect("sound");
    assert_eq!(Some(from_file), Robot::builtin("table-hopper"));
}

/// Rows and columns of a force table may come in any order.
#[test]
fn a_force_table_is_a_set_of_rows() {
    let folder = std::env::temp_dir().join(format!("saltus-robot-{}-order", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a writable temporary folder");
    let read = |csv: &str| {
        let file = folder.join("force.csv");
        std::fs::write(&file, csv).expect("a writable temporary folder");
        resolve("table-hopper", &[format!("leg.file={}", file.display())])
            .expect("sound")
            .leg
            .drive
    };
    let tidy = read("extension_m,speed_m_s,force_n\n0,0,4\n0,1,3\n0.05,0,2\n0.05,1,1\n");
    let untidy = read(
        "# made up\nforce_n, speed_m_s, extension_m\r\n\n1,1,5e-2\r\n4,-0,0\n3,1,0\n# \
         last\n2,0,0.050",
    );
    std::fs::remove_dir_all(&folder).expect("the folder made above");
    assert_eq!(tidy, untidy);
}
