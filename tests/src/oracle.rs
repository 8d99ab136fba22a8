//! An independent integrator of the reference model with every named term: classical Runge–Kutta
//! steps of one fixed length, in the letters of the thesis, each event found by halving the step
//! that meets it.
//!
//! It shares with the product the description of a robot and nothing else, and is slow on purpose:
//! no closed forms, no change of variables, no step control. [`solve_twice`] says how far it can be
//! trusted.

use std::f64::consts::{FRAC_PI_2, PI};

use saltus_lagrangian::Launch;
use saltus_robot::{Cylinder, Drive, ForceTable, Gas, Robot};

/// How a stance ended, and what flowed through it.
#[derive(Clone, Copy, Debug)]
pub struct End {
    /// Name of the outcome.
    pub outcome: &'static str,
    /// When the leg was fired (s); NaN where it was not.
    pub time_fire: f64,
    /// When the stance ended (s).
    pub time: f64,
    /// Lean φ = π/2 − α (rad).
    pub lean: f64,
    /// ω = −α̇ (rad/s).
    pub rate: f64,
    /// d (m).
    pub extension: f64,
    /// ḋ (m/s).
    pub extension_rate: f64,
    /// P (Pa).
    pub pressure: f64,
    /// Work of the drive (J).
    pub drive: f64,
    /// Work against friction, springs and cushion (J).
    pub losses: f64,
}

impl End {
    /// The numbers of the end, for comparisons: time, lean, rate, extension and its rate, pressure,
    /// work, losses.
    pub fn numbers(&self) -> [f64; 8] {
        [
            self.time,
            self.lean,
            self.rate,
            self.extension,
            self.extension_rate,
            self.pressure,
            self.drive,
            self.losses,
        ]
    }
}

/// α, α̇, d, ḋ, P, work of the drive, losses.
type State = [f64; 7];
const ALPHA: usize = 0;
const ALPHA_DOT: usize = 1;
const D: usize = 2;
const D_DOT: usize = 3;
const P: usize = 4;
const DRIVE: usize = 5;
const LOSSES: usize = 6;

/// An event: it happens where the number turns positive.
type Event<'a> = &'a dyn Fn(&State) -> f64;

/// What is switched on.
#[allow(clippy::struct_excessive_bools, reason = "each is a switch of its own")]
#[derive(Clone, Copy)]
struct Mode {
    energized: bool,
    extending: bool,
    port: bool,
    cushion: bool,
}

struct Oracle<'a> {
    robot: &'a Robot,
    /// Length of a step (s).
    step: f64,
    time: f64,
    y: State,
}

/// The stance of `robot` after `launch`, by steps of `step` (s).
pub fn solve(robot: &Robot, launch: &Launch, step: f64) -> End {
    let mut y = [0.0; 7];
    (y[ALPHA], y[ALPHA_DOT]) = (FRAC_PI_2 - launch.lean, -launch.rate);
    y[P] = robot.environment.ambient.0;
    let mut oracle = Oracle {
        robot,
        step,
        time: 0.0,
        y,
    };
    oracle.run(launch)
}

/// [`solve`] with `step` and with half of it: the finer end, and by how much each number moved. The
/// method is of fourth order where the model is smooth, so that what is left is less than that.
pub fn solve_twice(robot: &Robot, launch: &Launch, step: f64) -> (End, [f64; 8]) {
    let (coarse, fine) = (solve(robot, launch, step), solve(robot, launch, 0.5 * step));
    let (a, b) = (coarse.numbers(), fine.numbers());
    (fine, std::array::from_fn(|i| (a[i] - b[i]).abs()))
}

/// Normal force over the weight on a foot whose leg is held at d = 0: 1 + m ÿ/weight, with y = r_s
/// sin α.
pub fn held_normal(robot: &Robot, lean: f64, rate: f64) -> f64 {
    let ((m, weight), i, r) = (at_axle(robot), robot.body.inertia, robot.body.radius);
    let (sin, cos) = (FRAC_PI_2 - lean).sin_cos();
    let acceleration = -weight * r * cos / (i + m * r * r);
    1.0 + m * r * (acceleration * cos - rate * rate * sin) / weight
}

impl Oracle<'_> {
    fn run(&mut self, launch: &Launch) -> End {
        let held = Mode {
            energized: false,
            extending: false,
            port: false,
            cushion: false,
        };
        let robot = self.robot;
        let early = |y: &State| -held_normal(robot, FRAC_PI_2 - y[ALPHA], -y[ALPHA_DOT]);
        let fallen = |y: &State| (y[ALPHA] - FRAC_PI_2).abs() - FRAC_PI_2;

        // 1. Pivot.
        if early(&self.y) > 0.0 {
            return self.end("early-lift-off", f64::NAN);
        }
        if launch.lean < launch.firing_angle {
            let reached = |y: &State| FRAC_PI_2 - y[ALPHA] - launch.firing_angle;
            let stopped = |y: &State| y[ALPHA_DOT];
            if launch.rate <= 0.0 && launch.lean <= 0.0 {
                return self.end("stall", f64::NAN);
            }
            match self.advance(held, f64::INFINITY, &[&reached, &stopped, &early]) {
                Some(0) => {}
                Some(2) => return self.end("early-lift-off", f64::NAN),
                _ => return self.end("stall", f64::NAN),
            }
        }
        let fire = self.time;
        let open = fire + robot.leg.delay;
        // A released spring is not caught again.
        let closes = !matches!(robot.leg.drive, Drive::Spring { .. });
        let is_heard = launch.valve_open >= robot.leg.least_pulse;
        let close = if closes {
            open + launch.valve_open
        } else {
            f64::INFINITY
        };

        // 2. The valve's delay.
        match self.advance(held, open, &[&early, &fallen]) {
            Some(0) => return self.end("early-lift-off", fire),
            Some(_) => return self.end("no-break-away", fire),
            None => {}
        }

        // 3. Filling until break-away: (P − P_a) A − F_f + m ω² r_s − weight cos φ > 0.
        let filling = Mode {
            energized: true,
            ..held
        };
        let ((m, weight), r) = (at_axle(robot), robot.body.radius);
        let excess = |y: &State| {
            force(robot, filling, y).1 + m * y[ALPHA_DOT] * y[ALPHA_DOT] * r
                - weight * y[ALPHA].sin()
        };
        if closes && (launch.valve_open <= 0.0 || !is_heard) {
            return self.end("no-break-away", fire);
        }
        if excess(&self.y) <= 0.0 {
            match self.advance(filling, close, &[&excess, &early, &fallen]) {
                Some(0) => {}
                Some(1) => return self.end("early-lift-off", fire),
                _ => return self.end("no-break-away", fire),
            }
        }

        // 4. Extension.
        let outcome = self.extend(close);
        let upright = fallen(&self.y) < 0.0;
        self.end(if upright { outcome } else { "fall-back" }, fire)
    }

    fn extend(&mut self, close: f64) -> &'static str {
        let robot = self.robot;
        let mut mode = Mode {
            energized: true,
            extending: true,
            port: false,
            cushion: false,
        };
        let port = match &robot.leg.drive {
            Drive::Pneumatic(cylinder) => cylinder.exhaust_port.map(|port| port.position),
            _ => None,
        };
        let cushion = robot
            .leg
            .cushion
            .map(|cushion| robot.leg.stroke - cushion.length);
        loop {
            if force(robot, mode, &self.y).1 <= 0.0 {
                return "force";
            }
            let at = |x: Option<f64>, passed: bool| {
                move |y: &State| match x {
                    Some(x) if !passed => y[D] - x,
                    _ => -1.0,
                }
            };
            let (port_reached, cushion_reached) = (at(port, mode.port), at(cushion, mode.cushion));
            let stroke = |y: &State| y[D] - robot.leg.stroke;
            let slack = |y: &State| -force(robot, mode, y).1;
            let halted = |y: &State| -y[D_DOT];
            let until = if mode.energized { close } else { f64::INFINITY };
            match self.advance(
                mode,
                until,
                &[&stroke, &slack, &halted, &port_reached, &cushion_reached],
            ) {
                Some(0) => return "stroke",
                Some(1) => return "force",
                Some(2) => return "fall-back",
                Some(3) => mode.port = true,
                Some(_) => mode.cushion = true,
                None => mode.energized = false,
            }
        }
    }

    /// Steps until an event, whose number is returned, or to the time `until`.
    fn advance(&mut self, mode: Mode, until: f64, events: &[Event]) -> Option<usize> {
        loop {
            let h = self.step.min(until - self.time);
            if h <= 0.0 {
                return None;
            }
            let next = self.stepped(mode, h);
            let Some((event, fraction)) = self.first(mode, h, &next, events) else {
                let last = h >= until - self.time;
                self.time = if last { until } else { self.time + h };
                self.y = next;
                continue;
            };
            self.y = self.stepped(mode, fraction * h);
            self.time += fraction * h;
            return Some(event);
        }
    }

    /// The event that turns positive first within a step to `next`, and after which fraction of it.
    fn first(&self, mode: Mode, h: f64, next: &State, events: &[Event]) -> Option<(usize, f64)> {
        let mut first: Option<(usize, f64)> = None;
        for (i, event) in events
            .iter()
            .enumerate()
            .filter(|(_, event)| event(next) > 0.0)
        {
            let (mut low, mut high) = (0.0, 1.0);
            // Fifty halvings reach round-off.
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if event(&self.stepped(mode, middle * h)) > 0.0 {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            if first.is_none_or(|(_, fraction)| high < fraction) {
                first = Some((i, high));
            }
        }
        first
    }

    /// The state a step of length `h` on.
    fn stepped(&self, mode: Mode, h: f64) -> State {
        let along = |k: &State, h: f64| std::array::from_fn(|i| self.y[i] + h * k[i]);
        let f = |y: &State| derivative(self.robot, mode, y);
        let k1 = f(&self.y);
        let k2 = f(&along(&k1, 0.5 * h));
        let k3 = f(&along(&k2, 0.5 * h));
        let k4 = f(&along(&k3, h));
        std::array::from_fn(|i| self.y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
    }

    fn end(&self, outcome: &'static str, time_fire: f64) -> End {
        let y = &self.y;
        End {
            outcome,
            time_fire,
            time: self.time,
            lean: FRAC_PI_2 - y[ALPHA],
            rate: -y[ALPHA_DOT],
            extension: y[D],
            extension_rate: y[D_DOT],
            pressure: y[P],
            drive: y[DRIVE],
            losses: y[LOSSES],
        }
    }
}

/// Mass (kg) that moves with the axle and weight (N) that hangs on it: moments of the boom about
/// its base, over its length.
fn at_axle(robot: &Robot) -> (f64, f64) {
    let (m, g) = (robot.body.mass, robot.environment.gravity);
    let Some(boom) = robot.boom else {
        return (m, m * g);
    };
    let length = boom.length;
    let (mut inertia, mut torque) = (
        boom.mass * length * length / 3.0,
        boom.mass * g * length / 2.0,
    );
    if let Some(counterweight) = boom.counterweight {
        inertia += counterweight.mass * counterweight.distance * counterweight.distance;
        torque -= counterweight.mass * g * counterweight.distance;
    }
    (m + inertia / (length * length), m * g + torque / length)
}

/// The equations of motion of thesis §5.2.1 and of the chamber of §4.3.1.
fn derivative(robot: &Robot, mode: Mode, y: &State) -> State {
    let ((m, weight), i) = (at_axle(robot), robot.body.inertia);
    let big_r = robot.body.radius + y[D];
    let (sin, cos) = y[ALPHA].sin_cos();
    let (drive, total) = force(robot, mode, y);
    let mut dy = [0.0; 7];
    dy[ALPHA] = y[ALPHA_DOT];
    dy[ALPHA_DOT] = (-weight * big_r * cos - 2.0 * m * y[ALPHA_DOT] * y[D_DOT] * big_r)
        / (i + m * big_r * big_r);
    if mode.extending {
        dy[D] = y[D_DOT];
        dy[D_DOT] = total / m + y[ALPHA_DOT] * y[ALPHA_DOT] * big_r - weight / m * sin;
        dy[DRIVE] = drive * y[D_DOT];
        dy[LOSSES] = (drive - total) * y[D_DOT];
    }
    if let Drive::Pneumatic(cylinder) = &robot.leg.drive {
        dy[P] = pressure_rate(robot, cylinder, mode, y);
    }
    dy
}

/// Axial force (N): of the drive alone, and of the whole leg.
fn force(robot: &Robot, mode: Mode, y: &State) -> (f64, f64) {
    let leg = &robot.leg;
    let (d, speed) = (y[D], y[D_DOT]);
    let on = |f: f64| if mode.energized { f } else { 0.0 };
    let mut seal = 0.0;
    let drive = match &leg.drive {
        Drive::Pneumatic(cylinder) => {
            let gauge = y[P] - robot.environment.ambient.0;
            seal = cylinder.seal_friction * gauge.abs();
            gauge * PI / 4.0 * cylinder.bore * cylinder.bore
        }
        Drive::Spring {
            stiffness,
            compression,
        } => on(stiffness * (compression - d)),
        Drive::Constant { force } => on(*force),
        Drive::Table(table) => on(table_force(table, d, speed)),
    };
    let mut total = drive - leg.viscous_friction * speed - leg.coulomb_friction - seal;
    if let Some(spring) = leg.return_spring {
        total -= spring.stiffness * d + spring.preload;
    }
    if let (true, Some(cushion)) = (mode.cushion, leg.cushion) {
        total -= cushion.stiffness * (d - (leg.stroke - cushion.length)) + cushion.damping * speed;
    }
    (drive, total)
}

/// Ṗ (Pa/s) = n R T/V ṁ − n P/V A ḋ.
fn pressure_rate(robot: &Robot, cylinder: &Cylinder, mode: Mode, y: &State) -> f64 {
    let gas = cylinder.gas;
    let n = cylinder.polytropic_exponent.unwrap_or(gas.heat_ratio);
    let area = PI / 4.0 * cylinder.bore * cylinder.bore;
    let volume = cylinder.dead_volume + area * y[D];
    let ambient = robot.environment.ambient.0;
    let valve =
        cylinder.discharge_coefficient * PI * cylinder.orifice_radius * cylinder.orifice_radius;
    let q =
        |area: f64, from: f64, to: f64| area / cylinder.temperature.sqrt() * orifice(gas, from, to);
    let mut inflow = if mode.energized {
        let supply = cylinder.supply.0 + ambient;
        let most = q(valve, supply, y[P]);
        // The supply falls by as much as its flow asks; the flow that fits lies between none and
        // that without a fall.
        let (mut low, mut high) = (0.0, most);
        if cylinder.supply_droop > 0.0 {
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let fits = q(valve, supply - cylinder.supply_droop * middle, y[P]) > middle;
                if fits { low = middle } else { high = middle }
            }
        }
        high
    } else {
        q(valve, ambient, y[P])
    };
    inflow -= q(cylinder.leak_area, y[P], ambient);
    if let (true, Some(port)) = (mode.port, cylinder.exhaust_port) {
        inflow -= q(port.area, y[P], ambient);
    }
    let speed = if mode.extending { y[D_DOT] } else { 0.0 };
    n * gas.constant * cylinder.temperature / volume * inflow - n * y[P] / volume * area * speed
}

/// q(P_u, P_d) √T/(C_f A_v), negative backwards.
fn orifice(gas: Gas, up: f64, down: f64) -> f64 {
    if down > up {
        return -orifice(gas, down, up);
    }
    let (k, r) = (gas.heat_ratio, gas.constant);
    let ratio = down / up;
    if ratio <= (2.0 / (k + 1.0)).powf(k / (k - 1.0)) {
        up * (k / r).sqrt() * (2.0 / (k + 1.0)).powf((k + 1.0) / (2.0 * (k - 1.0)))
    } else {
        let c2 = (2.0 * k / (r * (k - 1.0))).sqrt();
        up * c2 * ratio.powf(1.0 / k) * (1.0 - ratio.powf((k - 1.0) / k)).max(0.0).sqrt()
    }
}

/// Force (N) of a table: cubic through the grid, along d in the four columns around the speed, then
/// along the speed.
fn table_force(table: &ForceTable, d: f64, speed: f64) -> f64 {
    let columns = table.speeds.len();
    let along: Vec<f64> = (0..columns)
        .map(|j| {
            let column: Vec<f64> = (0..table.extensions.len())
                .map(|i| table.forces[i * columns + j])
                .collect();
            cubic(&table.extensions, &column, d)
        })
        .collect();
    cubic(&table.speeds, &along, speed)
}

/// The cubic Hermite interpolant through (`x`, `f`) with the slope between the neighbours at each
/// point; constant outside.
fn cubic(x: &[f64], f: &[f64], at: f64) -> f64 {
    let last = x.len() - 1;
    if at <= x[0] {
        return f[0];
    }
    if at >= x[last] {
        return f[last];
    }
    let k = (0..last).rfind(|&k| x[k] <= at).unwrap_or(0);
    let slope = |i: usize| {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
        (f[b] - f[a]) / (x[b] - x[a])
    };
    let h = x[k + 1] - x[k];
    let t = (at - x[k]) / h;
    let (a, b) = (f[k], f[k + 1]);
    let (sa, sb) = (slope(k) * h, slope(k + 1) * h);
    a + t * (sa + t * (3.0 * (b - a) - 2.0 * sa - sb + t * (2.0 * (a - b) + sa + sb)))
}
