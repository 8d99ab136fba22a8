//! Tables as Rust: one constant.

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
        ];
        if let Some(on) = &self.confirmed {
            lines.push(format!(
                "They hold on the robot {}, whose file's SHA-256 begins {}: in the multi-body \
                 simulation {} jumps at these rates and distances land within {}.",
                on.name.escape_default(),
                on.hash,
                on.jumps,
                mm(on.miss)
            ));
        }
        lines.extend([
            String::new(),
            format!(
                "Numbers: {}. CRC-32 of the tables: {:08X}.",
                R::C_TYPE,
                self.crc()
            ),
            self.rate_line(),
        ]);
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
        let about: String = self.about().iter().map(|line| comment(line)).collect();
        let (real, robot) = (R::RUST_TYPE, self.name.escape_default());
        let (kind, rule) = self.rust_rule();
        let (map_rates, angles) = (axis(&self.rates), axis(&self.angles));
        let [rates, limits, constants] = self.rust_numbers();
        let rule_nodes = match &self.nodes {
            Nodes::Table(table) => nodes("RULE_NODES", table),
            Nodes::Curve(curve) => nodes("RULE_NODES", curve),
        };
        let (rule_open, map_open) = (
            cells("RULE_OPEN", &self.open),
            cells("MAP_OPEN", &self.map_open),
        );
        let map_nodes = nodes("MAP_NODES", &self.map_nodes);
        format!(
            "{about}
#![allow(clippy::all, clippy::pedantic, unreachable_pub)]

use saltus_controller::{{Axis, Controller, {kind}, LiftOffMap, Limits, Rates, Robot, Rule}};

/// What the robot {robot} decides by.
pub const {name}: Controller<'static, {real}> = Controller {{
    rule: Rule::{rule},
    map: LiftOffMap {{ rates: {map_rates}, angles: {angles}, nodes: &MAP_NODES, open: &MAP_OPEN }},
    rates: {rates},
    robot: {constants},
    limits: {limits},
}};
{rule_nodes}{rule_open}{map_nodes}{map_open}"
        )
    }

    /// The rule's type, and the rule.
    fn rust_rule(&self) -> (&'static str, String) {
        let rates = axis(&self.rates);
        let (of, kind, distance) = match self.nodes {
            Nodes::Table(_) => {
                let distances = axis(&self.distances);
                ("Table", "FiringTable", format!("distances: {distances}"))
            }
            Nodes::Curve(_) => {
                let distance = self.distances.first.digits();
                ("Curve", "FiringCurve", format!("distance: {distance}"))
            }
        };
        let rule = format!(
            "{of}({kind} {{ rates: {rates}, {distance}, nodes: &RULE_NODES, open: &RULE_OPEN }})"
        );
        (kind, rule)
    }

    /// Rates, limits and robot.
    fn rust_numbers(&self) -> [String; 3] {
        let (c, l, r) = (&self.counted, &self.limits, &self.robot);
        let rates = fields(&[
            ("least", c.least.digits()),
            ("greatest", c.greatest.digits()),
            ("reference_lean", c.reference_lean.digits()),
            ("at_firing", c.at_firing.to_string()),
        ]);
        let limits = fields(&[
            ("period", l.period.digits()),
            ("extra_delay", l.extra_delay.digits()),
            ("newton_steps", l.newton_steps.to_string()),
            ("least_valve_open", l.least_valve_open.digits()),
            ("greatest_valve_open", l.greatest_valve_open.digits()),
            ("effort", l.effort.digits()),
        ]);
        let robot = fields(&[
            ("radius", r.radius.digits()),
            ("gravity", r.gravity.digits()),
            ("pendulum", r.pendulum.digits()),
            ("stride", r.stride.digits()),
            ("valve_open", r.valve_open.digits()),
            ("landing_height", r.landing_height.digits()),
        ]);
        [
            format!("Rates {{ {rates} }}"),
            format!("Limits {{ {limits} }}"),
            format!("Robot {{ {robot} }}"),
        ]
    }
}

/// A line of the head.
fn comment(line: &str) -> String {
    format!("{}\n", format!("//! {line}").trim_end())
}

fn fields(of: &[(&str, String)]) -> String {
    let each: Vec<String> = of
        .iter()
        .map(|(name, value)| format!("{name}: {value}"))
        .collect();
    each.join(", ")
}

fn axis<R: Number>(a: &Axis<R>) -> String {
    let [first, last, per_unit] = [a.first, a.last, a.per_unit].map(Number::digits);
    format!(
        "Axis {{ first: {first}, last: {last}, per_unit: {per_unit}, count: {} }}",
        a.count
    )
}

fn nodes<R: Number, const N: usize>(name: &str, nodes: &[[R; N]]) -> String {
    let (real, count) = (R::RUST_TYPE, nodes.len());
    let row = |node: &[R; N]| {
        let list: Vec<String> = node.iter().map(|x| x.digits()).collect();
        format!("    [{}],\n", list.join(", "))
    };
    let rows: String = nodes.iter().map(row).collect();
    format!("\nstatic {name}: [[{real}; {N}]; {count}] = [\n{rows}];\n")
}

fn cells(name: &str, open: &[u8]) -> String {
    let list: Vec<String> = open.iter().map(u8::to_string).collect();
    let (count, list) = (open.len(), list.join(", "));
    format!("\nstatic {name}: [u8; {count}] = [{list}];\n")
}
