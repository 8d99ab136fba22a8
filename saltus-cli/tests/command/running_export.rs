//! The exported C of every gait against Rust.

use std::fmt::Write as _;
use std::num::Wrapping;

use saltus::controller::run::{Readings, Runner};
use saltus::gait::{GaitError, Program, Setup, Smooth};

use crate::common::Folder;
use crate::meaning::run_with;

#[test]
fn what_means_nothing_is_refused() {
    let folder = Folder::new("export-gaits-bad");
    for (line, parts) in [
        (
            "export gait smooth --valve-open 30ms --out x",
            &["unexpected argument '--valve-open'"][..],
        ),
        ("export gait curve --out x", &["--knots", "RATE:ANGLE:TIME"]),
        (
            "export gait fixed --aim quick --out x",
            &["unexpected argument '--aim'"],
        ),
        (
            "export gait curve --knots 0:1.2:40ms --out x",
            &["--knots", "1.2", "active zone"],
        ),
    ] {
        let run = folder.run(&line.split(' ').collect::<Vec<_>>());
        assert_eq!(run.code, Some(2), "{line}: {}", run.out);
        for part in parts {
            assert!(run.err.contains(part), "{line}: {}", run.err);
        }
        assert!(!folder.path("x").exists(), "{line}");
    }
}

/// A wheel that speeds up, rocks back now and then, and slips under its encoder.
struct Wheel(Wrapping<u32>, i32);

impl Wheel {
    fn next(&mut self, k: i32) -> Readings {
        let mut word = || {
            self.0 = self.0 * Wrapping(2_891_336_453) + Wrapping(12345);
            (self.0 >> 8).0.cast_signed()
        };
        let speed = k / 400 - 20 * i32::from(k % 700 > 600);
        self.1 += speed + word() % 3;
        Readings {
            wheel: self.1 / 8,
            radius: self.1 / 32,
            fine_gyro: speed * 3217 + word() % 400,
            coarse_gyro: speed * 1229 + word() % 400,
            ..Readings::default()
        }
    }
}

const CYCLES: i32 = 4000;

/// The same in C; every bit of what is decided.
const LOOP: &str = r#"
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include "running_tables.h"
static uint32_t state = 1;
static int32_t word(void) { state = state * 2891336453u + 12345u; return (int32_t)(state >> 8); }
static uint64_t bits(saltus_real x) { uint64_t b; memcpy(&b, &x, sizeof b); return b; }
int main(void) {
    saltus_runner runner;
    saltus_runner_start(&runner, &running_gait, 3, 0, 1);
    saltus_runner_demand(&runner, 1.5);
    int32_t place = 0;
    for (int32_t k = 0; k < CYCLES; k++) {
        int32_t speed = k / 400 - 20 * (k % 700 > 600);
        place += speed + word() % 3;
        saltus_readings now;
        memset(&now, 0, sizeof now);
        now.wheel = place / 8;
        now.radius = place / 32;
        now.fine_gyro = speed * 3217 + word() % 400;
        now.coarse_gyro = speed * 1229 + word() % 400;
        saltus_action a;
        saltus_runner_step(&runner, &now, &a);
        printf("%d %" PRIx64 " %" PRIx64 " %" PRIx64 "\n", (int)a.leg, bits(a.valve_open), bits(a.rate), bits(a.firing_angle));
    }
    return 0;
}
"#;

fn in_rust(setup: &Setup) -> Result<(String, usize), GaitError> {
    setup.flashed(|gait| {
        let mut runner = Runner::new(*gait, 3, 0, true);
        runner.demand(1.5);
        let (mut wheel, mut text, mut fired) = (Wheel(Wrapping(1), 0), String::new(), 0);
        for k in 0..CYCLES {
            let a = runner.step(&wheel.next(k));
            let leg = a.leg.map_or(-1, u32::cast_signed);
            fired += usize::from(a.leg.is_some());
            let [open, rate, angle] = [a.valve_open, a.rate, a.firing_angle].map(f64::to_bits);
            let _ = writeln!(text, "{leg} {open:x} {rate:x} {angle:x}");
        }
        (text, fired)
    })
}

#[test]
fn every_gait_is_exported_to_the_bit() {
    let folder = Folder::new("export-gaits");
    let robot = || saltus::resolve("rats-run", &[]).unwrap();
    let with = |program: Program, zone: f64| {
        let mut setup = Setup::new(robot(), program, 1.0);
        setup.zone = zone;
        setup
    };
    let knots = vec![[0.0, 0.5, 0.05], [4.0, 0.1, 0.04], [9.0, -0.2, 0.03]];
    let main = LOOP.replace("CYCLES", &CYCLES.to_string());
    for (flags, setup) in [
        ("smooth", with(Smooth::QUICK.program(), -0.3)),
        (
            "smooth --aim sparing",
            with(Smooth::SPARING.program(), -0.3),
        ),
        (
            "curve --knots 0:0.5:50ms,4:0.1:40ms,9:-0.2:30ms --zone -0.25",
            with(Program::Curve(knots), -0.25),
        ),
        ("speed", Setup::at_speeds(&robot(), &[], 1.0, 2).unwrap()),
    ] {
        let line = format!("export gait {flags} --robot rats-run --real double --out out");
        folder.done(&line, 0);
        let Some(said) = run_with(&folder, "out/saltus_running.c", &main, &[]) else {
            return;
        };
        let (should, fired) = in_rust(&setup).unwrap();
        assert!(fired >= 3, "{flags}: {fired}");
        assert!(said == should, "{flags}: C and Rust disagree");
    }
}
