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
        // How it is printed is how it is written, but for paths and borrows; a line for each node.
        let constant = format!("{:?}", self.controller())
            .replace("rule: ", "rule: Rule::")
            .replace(": [", ": &[")
            .replace("], [", "],\n    [")
            .replace(" }, ", " },\n    ");
        let kind = match self.nodes {
            Nodes::Table(_) => "FiringTable",
            Nodes::Curve(_) => "FiringCurve",
        };
        format!(
            "{about}
#![allow(clippy::all, clippy::pedantic, unreachable_pub)]

use saltus_controller::{{Axis, Controller, {kind}, LiftOffMap, Limits, Rates, Robot, Rule}};

/// What the robot {robot} decides by.
pub const {name}: Controller<'static, {real}> = {constant};
"
        )
    }
}

/// A line of the head.
fn comment(line: &str) -> String {
    format!("{}\n", format!("//! {line}").trim_end())
}
