//! Tables as Rust: one constant.

use std::fmt::Write;

use saltus_controller::Axis;

use super::numbers::Number;
use super::tables::Tables;

impl<R: Number> Tables<R> {
    /// What heads every file: the robot, what the tables hold, and how exact they are.
    pub fn about(&self) -> Vec<String> {
        let [table, map] = self.bytes();
        let [(open, all), (map_open, map_all)] = self.cells();
        let range = |a: &Axis<R>, unit: &str| format!("{} to {} {unit}, {} nodes", a.first, a.last, a.count);
        let mm = |x: f64| format!("{:.3} mm", 1e3 * x);
        let mut lines = vec![
            format!(
                "Firing decisions for the robot {}, whose file's SHA-256 begins {}.",
                self.name.escape_default(),
                self.hash
            ),
            format!("Written by saltus {}; to change it, write it anew.", env!("CARGO_PKG_VERSION")),
            String::new(),
            format!("Numbers: {}. CRC-32 of the tables: {:08X}.", R::C_TYPE, self.crc()),
            format!(
                "Approach rate at a lean of {} rad: {}.",
                self.robot.start_lean,
                range(&self.rates, "rad/s")
            ),
        ];
        match &self.law {
            Some(law) => {
                lines.push(format!("Distance: {} m, by the law alpha_f = A omega + B.", law.distance));
            }
            None => lines
                .push(format!("Distance: {}; {open} of {all} cells are open.", range(&self.distances, "m"))),
        }
        lines.extend([
            format!("Landing height {} m, valve open for {} s.", self.robot.landing_height, self.robot.valve_open),
            format!("Lift-off map: firing angle {}; {map_open} of {map_all} cells are open.", range(&self.angles, "rad")),
            format!(
                "Against the planner, over all open cells ({} jumps): what is fired lands within {}, what the map predicts within {}.",
                self.misses.jumps,
                mm(self.misses.table),
                mm(self.misses.map)
            ),
            format!("Size: firing table {table} bytes, lift-off map {map} bytes."),
        ]);
        lines
    }

    /// A Rust source with the constant `name`, a `saltus_controller::Controller<'static, f32>` or `f64`.
    pub fn rust(&self, name: &str) -> String {
        let mut text = String::new();
        for line in self.about() {
            put(&mut text, format_args!("//! {line}").to_string().trim_end());
        }
        let real = R::RUST_TYPE;
        put(&mut text, "\n#![allow(clippy::all, clippy::pedantic, unreachable_pub)]\n");
        put(&mut text, "use saltus_controller::{Axis, Controller, LiftOffMap, Limits, Robot, Rule};");
        put(
            &mut text,
            if self.law.is_some() {
                "use saltus_controller::Law;\n"
            } else {
                "use saltus_controller::FiringTable;\n"
            },
        );
        put(&mut text, &format!("/// What the robot {} decides by.", self.name.escape_default()));
        put(&mut text, &format!("pub const {name}: Controller<'static, {real}> = Controller {{"));
        let rates = axis(&self.rates);
        match &self.law {
            Some(law) => put(
                &mut text,
                &format!(
                    "    rule: Rule::Law(Law {{ slope: {}, intercept: {}, least_rate: {}, greatest_rate: {}, distance: {} }}),",
                    law.slope.digits(),
                    law.intercept.digits(),
                    law.least_rate.digits(),
                    law.greatest_rate.digits(),
                    law.distance.digits()
                ),
            ),
            None => put(
                &mut text,
                &format!(
                    "    rule: Rule::Table(FiringTable {{ rates: {rates}, distances: {}, nodes: &TABLE_NODES, open: &TABLE_OPEN }}),",
                    axis(&self.distances)
                ),
            ),
        }
        put(
            &mut text,
            &format!(
                "    map: LiftOffMap {{ rates: {rates}, angles: {}, nodes: &MAP_NODES, open: &MAP_OPEN }},",
                axis(&self.angles)
            ),
        );
        let r = &self.robot;
        put(
            &mut text,
            &format!(
                "    robot: Robot {{ radius: {}, gravity: {}, pendulum: {}, start_lean: {}, stride: {}, valve_open: {}, landing_height: {} }},",
                r.radius.digits(),
                r.gravity.digits(),
                r.pendulum.digits(),
                r.start_lean.digits(),
                r.stride.digits(),
                r.valve_open.digits(),
                r.landing_height.digits()
            ),
        );
        let l = &self.limits;
        put(
            &mut text,
            &format!(
                "    limits: Limits {{ period: {}, extra_delay: {}, newton_steps: {}, least_valve_open: {}, greatest_valve_open: {}, effort: {} }},\n}};",
                l.period.digits(),
                l.extra_delay.digits(),
                l.newton_steps,
                l.least_valve_open.digits(),
                l.greatest_valve_open.digits(),
                l.effort.digits()
            ),
        );
        if self.law.is_none() {
            nodes(&mut text, "TABLE_NODES", &self.nodes);
            cells(&mut text, "TABLE_OPEN", &self.open);
        }
        nodes(&mut text, "MAP_NODES", &self.map_nodes);
        cells(&mut text, "MAP_OPEN", &self.map_open);
        text
    }
}

fn put(text: &mut String, line: &str) {
    text.push_str(line);
    text.push('\n');
}

fn axis<R: Number>(a: &Axis<R>) -> String {
    let [first, last, per_unit] = [a.first, a.last, a.per_unit].map(Number::digits);
    format!("Axis {{ first: {first}, last: {last}, per_unit: {per_unit}, count: {} }}", a.count)
}

fn nodes<R: Number, const N: usize>(text: &mut String, name: &str, nodes: &[[R; N]]) {
    // Writing to a string does not fail.
    let _ = write!(text, "\nstatic {name}: [[{}; {N}]; {}] = [\n", R::RUST_TYPE, nodes.len());
    for node in nodes {
        let list: Vec<String> = node.iter().map(|x| x.digits()).collect();
        let _ = writeln!(text, "    [{}],", list.join(", "));
    }
    text.push_str("];\n");
}

fn cells(text: &mut String, name: &str, open: &[u8]) {
    let list: Vec<String> = open.iter().map(u8::to_string).collect();
    let _ = write!(text, "\nstatic {name}: [u8; {}] = [{}];\n", open.len(), list.join(", "));
}
