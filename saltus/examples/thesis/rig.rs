//! Chapter 3: sensors and loop.

use std::f64::consts::PI;
use std::fmt::Write;

use saltus::robot::Sensors;
use saltus::{Robot, resolve};

use crate::{Outcome, Section, claim};

/// Table 3.1: counts a turn after quadrature, ranges (°/s, g); 3.2: bits; 3.3: period (s).
const WHEEL: f64 = 4.0 * 200.0;
const BOOM: f64 = 4.0 * 400.0;
const GYROS: (f64, f64) = (573.0, 1500.0);
const ACCELEROMETERS: (f64, f64) = (2.0, 50.0);
const BITS: f64 = 16.0;
const PERIOD: f64 = 1e-3;
/// Standard gravity (m/s²).
const GRAVITY: f64 = 9.80665;

/// A row: what, in the thesis, in `rats-run`, what the thesis leaves open.
type Cells = (&'static str, String, String, &'static str);

fn check(s: &Sensors) -> Outcome<()> {
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9 * b;
    claim(
        near(s.wheel_counts, WHEEL)
            && near(s.radius_counts, BOOM)
            && near(s.pivot_counts, BOOM)
            && near(s.fine_gyro_range * 180.0 / PI, GYROS.0)
            && near(s.coarse_gyro_range * 180.0 / PI, GYROS.1)
            && near(s.fine_accelerometer_range / GRAVITY, ACCELEROMETERS.0)
            && near(s.coarse_accelerometer_range / GRAVITY, ACCELEROMETERS.1)
            && near(s.converter_bits, BITS)
            && near(s.period, PERIOD),
        "rats-run has the sensors of table 3.1",
    )
}

fn encoders_and_gyros(s: &Sensors, radius: f64) -> Vec<Cells> {
    let (fine, coarse) = (s.fine_gyro_range, s.coarse_gyro_range);
    let degrees = |rate: f64| format!("± {:.0} °/s", rate * 180.0 / PI);
    vec![
        (
            "wheel encoder",
            "200 lines (table 3.1)".to_owned(),
            format!(
                "{} counts a turn, {:.1} mrad",
                s.wheel_counts,
                2e3 * PI / s.wheel_counts
            ),
            "–",
        ),
        (
            "radius and pivot encoders",
            "400 lines (table 3.1)".to_owned(),
            format!(
                "{} counts a turn, {:.1} mrad",
                s.radius_counts,
                2e3 * PI / s.radius_counts
            ),
            "figure 3.4 labels them \"200 line\"",
        ),
        (
            "fine gyro",
            format!("± {} °/s", GYROS.0),
            format!(
                "{}: at its end at {fine:.1} rad/s, {:.1} m/s",
                degrees(fine),
                fine * radius
            ),
            "noise, bandwidth and mounting",
        ),
        (
            "coarse gyro",
            format!("± {} °/s", GYROS.1),
            format!(
                "{}: at its end at {coarse:.1} rad/s, {:.1} m/s",
                degrees(coarse),
                coarse * radius
            ),
            "figure 3.4 gives it ± 573 °/s",
        ),
        (
            "noise of the gyros",
            "–".to_owned(),
            format!("{} rad/s at each sample", s.gyro_noise),
            "an assumption",
        ),
    ]
}

fn converter_and_loop(robot: &Robot, s: &Sensors) -> Vec<Cells> {
    let gravities = |x: f64| format!("± {:.0} g", x / GRAVITY);
    vec![
        (
            "accelerometers",
            format!("± {} g and ± {} g", ACCELEROMETERS.0, ACCELEROMETERS.1),
            format!(
                "{} and {}, {} m from the axle",
                gravities(s.fine_accelerometer_range),
                gravities(s.coarse_accelerometer_range),
                s.accelerometer_radius
            ),
            "where they are; which one finds the two feet that stand",
        ),
        (
            "converter",
            format!("{BITS} bits (3.2)"),
            format!("{} bits over the range of the sensor", s.converter_bits),
            "input range",
        ),
        (
            "loop",
            format!("{} kHz: read, compute, log, write (3.3)", 1e-3 / PERIOD),
            format!(
                "{} kHz, output {} cycles later",
                1e-3 / s.period,
                s.output_delay_cycles
            ),
            "the output is timed by software: 0 to 1 ms later; `sensors.output_delay_cycles`",
        ),
        (
            "filter of the rate",
            "FIR of fourth order (5.1.3)".to_owned(),
            "mean of 5 readings".to_owned(),
            "its weights; `--taps`",
        ),
        (
            "supply",
            "120 psi through a tether (3)".to_owned(),
            robot.leg.cylinder().map_or(String::new(), |c| {
                format!("{:.0} psi, no droop", c.supply.0 / 6894.757293168)
            }),
            "resistance of the tether; below",
        ),
    ]
}

pub(crate) fn section() -> Outcome<Section> {
    let robot = resolve("rats-run", &[])?;
    let radius = robot.body.radius;
    let s = robot.sensors.unwrap_or_default();
    check(&s)?;
    let mut rows = encoders_and_gyros(&s, radius);
    rows.extend(converter_and_loop(&robot, &s));
    let mut text = String::from(
        "## Sensors and loop (chapter 3)\n\nThe robot `rats-run` has the sensors of table 3.1 and \
         the loop of section 3.3. [running.md](running.md) says what each is used for.\n\n| | \
         thesis | `rats-run` | open in the thesis |\n| --- | --- | --- | --- |\n",
    );
    for (name, thesis, ours, open) in rows {
        writeln!(text, "| {name} | {thesis} | {ours} | {open} |")?;
    }
    text.push_str(
        "\nThe fine gyro is at its end before the robot has its final speed. Beyond it the \
         controller takes the coarse one.\n",
    );
    claim(
        s.fine_gyro_range * radius < 3.2 && s.coarse_gyro_range * radius > 3.2,
        "only the coarse gyro reaches 3.2 m/s",
    )?;
    Ok(Section {
        text,
        drawings: Vec::new(),
    })
}
