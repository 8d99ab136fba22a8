//! Tables as Rust: one constant.

use std::fmt::Write;

use saltus_controller::{Axis, Rates, Robot};

use super::numbers::Number;
use super::tables::{Nodes, Tables};

impl<R: Number> Tables<R> {
    /// What heads every file: the robot, what the tables hold, and how exact they are.
    pub fn about(&self) -> Vec<String> {
        let [table, map] = self.bytes();
        let [(open, all), (map_open, map_all)] = self.cells();
        let range = |a: &Axis<R>, unit: &str| {
            format!("{} to {} {unit}, {} nodes", a.first, a.last, a.count)
        };
        let mm = |x: f64| format!("{:.3} mm", 1e3 * x);
        let mut lines = vec![
            format!(
                "Firing decisions for the robot {}, whose file's SHA-256 begins {}.",
                self.name.escape_default(),
                self.hash
            ),
            format!(
                "Written by saltus {}; to change it, write it anew.",
                env!("CARGO_PKG_VERSION")
            ),
            String::new(),
            format!(
                "Numbers: {}. CRC-32 of the tables: {:08X}.",
                R::C_TYPE,
                self.crc()
            ),
            self.rate_line(),
        ];
        let spread = if self.distances.count > 1 {
            range(&self.distances, "m")
        } else {
            format!("{} m alone", self.distances.first)
        };
        lines.push(format!(
            "Distance: {spread}. Firing angles over {}; {open} of {all} cells are open.",
            range(&self.rates, "rad/s")
        ));
        let valve = if self.has_valve {
            format!("Valve open for {} s.", self.robot.valve_open)
        } else {
            "The leg has no valve: opening times have no effect.".into()
        };
        lines.extend([
            format!("A distance goes from the foot to {}.", self.landing()),
            valve,
            format!(
                "Lift-off map: firing angle {}; {map_open} of {map_all} cells are open.",
                range(&self.angles, "rad")
            ),
            format!(
                "Against the planner, over all open cells ({} jumps): what is fired lands within \
                 {}, what the map predicts within {}.",
                self.misses.jumps,
                mm(self.misses.table),
                mm(self.misses.map)
            ),
            format!(
                "A cell that misses by more than {} is closed.",
                mm(self.tolerance)
            ),
            format!(
                "Size: {} {table} bytes, lift-off map {map} bytes.",
                self.nodes.name()
            ),
        ]);
        lines
    }

    /// Where approach rates count.
    fn rate_line(&self) -> String {
        let Rates {
            least,
            greatest,
            reference_lean,
            at_firing,
        } = self.counted;
        let range = format!("Approach rate: {least} to {greatest} rad/s");
        if at_firing {
            format!(
                "{range}, counted at the firing angle. Inside, tables are over the rate at a lean \
                 of {reference_lean} rad."
            )
        } else {
            format!("{range}, counted at the start lean, {reference_lean} rad.")
        }
    }

    /// Where a distance ends.
    fn landing(&self) -> String {
        let Robot {
            landing_height,
            radius,
            ..
        } = self.robot;
        if landing_height == radius {
            return format!("where the wheel touches (landing height {landing_height} m)");
        }
        format!(
            "where the wheel's centre is {landing_height} m above the foothold; the wheel touches \
             where it is {radius} m"
        )
    }

    /// A Rust source with the constant `name`, a `saltus_controller::Controller<'static, f32>` or
    /// `f64`.
    pub fn rust(&self, name: &str) -> String {
        let mut text = String::new();
        for line in self.about() {
            put(&mut text, format_args!("//! {line}").to_string().trim_end());
        }
        let real = R::RUST_TYPE;
        put(
            &mut text,
            "\n#![allow(clippy::all, clippy::pedantic, unreachable_pub)]\n",
        );
        let rule_type = match self.nodes {
            Nodes::Table(_) => "FiringTable",
            Nodes::Curve(_) => "FiringCurve",
        };
        put(
            &mut text,
            &format!(
                "use saltus_controller::{{Axis, Controller, {rule_type}, LiftOffMap, Limits, \
                 Rates, Robot, Rule}};\n"
            ),
        );
        put(
            &mut text,
            &format!(
                "/// What the robot {} decides by.",
                self.name.escape_default()
            ),
        );
        put(
            &mut text,
            &format!("pub const {name}: Controller<'static, {real}> = Controller {{"),
        );
        let rates = axis(&self.rates);
        let rule = match self.nodes {
            Nodes::Table(_) => format!(
                "Table(FiringTable {{ rates: {rates}, distances: {}, nodes: &RULE_NODES, open: \
                 &RULE_OPEN }})",
                axis(&self.distances)
            ),
            Nodes::Curve(_) => format!(
                "Curve(FiringCurve {{ rates: {rates}, distance: {}, nodes: &RULE_NODES, open: \
                 &RULE_OPEN }})",
                self.distances.first.digits()
            ),
        };
        put(&mut text, &format!("    rule: Rule::{rule},"));
        put(
            &mut text,
            &format!(
                "    map: LiftOffMap {{ rates: {rates}, angles: {}, nodes: &MAP_NODES, open: \
                 &MAP_OPEN }},",
                axis(&self.angles)
            ),
        );
        let c = &self.counted;
        put(
            &mut text,
            &format!(
                "    rates: Rates {{ least: {}, greatest: {}, reference_lean: {}, at_firing: {} \
                 }},",
                c.least.digits(),
                c.greatest.digits(),
                c.reference_lean.digits(),
                c.at_firing
            ),
        );
        let r = &self.robot;
        put(
            &mut text,
            &format!(
                "    robot: Robot {{ radius: {}, gravity: {}, pendulum: {}, stride: {}, \
                 valve_open: {}, landing_height: {} }},",
                r.radius.digits(),
                r.gravity.digits(),
                r.pendulum.digits(),
                r.stride.digits(),
                r.valve_open.digits(),
                r.landing_height.digits()
            ),
        );
        let l = &self.limits;
        put(
            &mut text,
            &format!(
                "    limits: Limits {{ period: {}, extra_delay: {}, newton_steps: {}, \
                 least_valve_open: {}, greatest_valve_open: {}, effort: {} }},\n}};",
                l.period.digits(),
                l.extra_delay.digits(),
                l.newton_steps,
                l.least_valve_open.digits(),
                l.greatest_valve_open.digits(),
                l.effort.digits()
            ),
        );
        match &self.nodes {
            Nodes::Table(table) => nodes(&mut text, "RULE_NODES", table),
            Nodes::Curve(curve) => nodes(&mut text, "RULE_NODES", curve),
        }
        cells(&mut text, "RULE_OPEN", &self.open);
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
    format!(
        "Axis {{ first: {first}, last: {last}, per_unit: {per_unit}, count: {} }}",
        a.count
    )
}

fn nodes<R: Number, const N: usize>(text: &mut String, name: &str, nodes: &[[R; N]]) {
    // Writing to a string does not fail.
    let _ = write!(
        text,
        "\nstatic {name}: [[{}; {N}]; {}] = [\n",
        R::RUST_TYPE,
        nodes.len()
    );
    for node in nodes {
        let list: Vec<String> = node.iter().map(|x| x.digits()).collect();
        let _ = writeln!(text, "    [{}],", list.join(", "));
    }
    text.push_str("];\n");
}

fn cells(text: &mut String, name: &str, open: &[u8]) {
    let list: Vec<String> = open.iter().map(u8::to_string).collect();
    let _ = write!(
        text,
        "\nstatic {name}: [u8; {}] = [{}];\n",
        open.len(),
        list.join(", ")
    );
}
