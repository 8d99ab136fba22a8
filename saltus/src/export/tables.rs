//! Tables from the planner, and how far they are from it.

use std::ops::RangeInclusive;

use hmac_sha256::Hash;
use saltus_controller::{
    Axis, Controller, FiringCurve, FiringTable, LiftOffMap, Limits, MAP_NODE, Rates, Robot, Rule,
};
use saltus_lagrangian::Launch;
use saltus_numeric::{Dual, Scalar, refused};
use saltus_planner::{JumpFlight, JumpModel, Planner};

use super::layout::{Firing, Flown, Layout, Start};
use super::numbers::Number;
use super::request::{ExportError, Request, spread};
use crate::on_plant::OnPlant;

/// How far answers from tables are from the planner's own jumps, over all open cells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Misses {
    /// Greatest distance (m) between where a jump lands that the table fires, and the distance
    /// asked for.
    pub table: f64,
    /// Greatest error (m) of a landing that the lift-off map predicts.
    pub map: f64,
    /// Jumps that were looked at.
    pub jumps: usize,
}

/// What the tables fire, flown on the robot that they were made for.
#[derive(Clone, Debug, PartialEq)]
pub struct Confirmed {
    /// That robot's name.
    pub name: String,
    /// The first 64 bits of the SHA-256 of its file.
    pub hash: String,
    /// Jumps that were flown.
    pub jumps: usize,
    /// Greatest distance (m) between where one of them lands and what was asked for.
    pub miss: f64,
}

/// Tables in the numbers of the controller.
#[derive(Clone, Debug)]
pub struct Tables<R> {
    pub(super) rates: Axis<R>,
    /// One node for a curve.
    pub(super) distances: Axis<R>,
    pub(super) nodes: Nodes<R>,
    pub(super) open: Vec<u8>,
    pub(super) angles: Axis<R>,
    pub(super) map_nodes: Vec<[R; MAP_NODE]>,
    pub(super) map_open: Vec<u8>,
    pub(super) counted: Rates<R>,
    pub(super) robot: Robot<R>,
    pub(super) limits: Limits<R>,
    pub(super) tolerance: f64,
    /// The least error (m) for which a cell of the firing table was closed.
    least_closed: Option<f64>,
    pub(super) misses: Misses,
    pub(super) confirmed: Option<Confirmed>,
    pub(super) name: String,
    pub(super) hash: String,
    /// Whether the leg has a valve, so that opening times matter.
    pub(super) has_valve: bool,
}

/// Firing angles at the nodes.
#[derive(Clone, Debug)]
pub(super) enum Nodes<R> {
    /// Over rates and distances.
    Table(Vec<[R; 4]>),
    /// Over rates, for one distance.
    Curve(Vec<[R; 2]>),
}

impl<R: Number> Nodes<R> {
    /// Every number in its place.
    pub(super) fn numbers(&self) -> &[R] {
        match self {
            Nodes::Table(nodes) => nodes.as_flattened(),
            Nodes::Curve(nodes) => nodes.as_flattened(),
        }
    }

    pub(super) fn name(&self) -> &'static str {
        match self {
            Nodes::Table(_) => "firing table",
            Nodes::Curve(_) => "firing curve",
        }
    }
}

/// Jumps looked at along each side of a cell.
const LOOKS: usize = 5;

impl<R: Number> Tables<R> {
    /// The tables of `request` for the planner's robot, each cell held against the planner's own
    /// jumps.
    ///
    /// # Errors
    /// [`ExportError`] for numbers outside their domain, a robot with drag, or tables without an
    /// open cell.
    pub fn new(
        planner: &Planner<dyn JumpModel>,
        request: &Request,
    ) -> Result<Tables<R>, ExportError> {
        check(planner, request)?;
        let Layout {
            start,
            rates,
            angles,
            firing,
        } = Layout::new::<R>(planner, request)?;
        let robot = planner.robot();
        let (nodes, open) = nodes_and_cells(rates, request.distances, &firing);
        let mut tables = Tables {
            rates: axis(rates),
            distances: axis(request.distances),
            nodes,
            open,
            angles: axis((angles.0, angles.1, request.angles)),
            map_nodes: Vec::new(),
            map_open: Vec::new(),
            counted: start.rates(request),
            robot: constants(planner, request),
            limits: limits(request),
            tolerance: request.tolerance,
            least_closed: None,
            misses: Misses::default(),
            confirmed: None,
            name: robot.name.clone(),
            hash: fingerprint(robot),
            has_valve: robot.leg.drive.has_valve(),
        };
        let flown = Flown {
            planner,
            start,
            valve_open: request.valve_open,
        };
        tables.fill_map(&flown)?;
        let (jumps, map) = tables.close_map(&flown, &looks())?;
        let (more, table) = tables.close_table(&flown, None)?;
        let jumps = jumps + more;
        tables.misses = Misses { table, map, jumps };
        tables.check_open()?;
        Ok(tables)
    }

    /// That there is something to decide by.
    fn check_open(&self) -> Result<(), ExportError> {
        let tables = [
            (self.nodes.name(), &self.open, self.least_closed),
            ("lift-off map", &self.map_open, None),
        ];
        match tables
            .into_iter()
            .find(|(_, open, _)| open.iter().all(|cell| *cell == 0))
        {
            Some((what, _, least)) => Err(ExportError::Empty {
                what,
                tolerance: self.tolerance,
                least,
            }),
            None => Ok(()),
        }
    }

    /// A controller that decides by them.
    pub fn controller(&self) -> Controller<'_, R> {
        let (rates, open) = (self.rates, &self.open);
        let rule = match &self.nodes {
            Nodes::Table(nodes) => Rule::Table(FiringTable {
                rates,
                distances: self.distances,
                nodes,
                open,
            }),
            Nodes::Curve(nodes) => Rule::Curve(FiringCurve {
                rates,
                distance: self.distances.first,
                nodes,
                open,
            }),
        };
        let map = LiftOffMap {
            rates,
            angles: self.angles,
            nodes: &self.map_nodes,
            open: &self.map_open,
        };
        Controller {
            rule,
            map,
            rates: self.counted,
            robot: self.robot,
            limits: self.limits,
        }
    }

    /// Flies them on the robot that they were made for. Cells that miss by more than the
    /// tolerance are closed. What is left is flown at the rates and distances of `request` and half
    /// way between them, wherever there is an answer.
    ///
    /// # Errors
    /// [`ExportError`] where a jump cannot be computed, or no cell is left.
    pub fn confirm(&mut self, plant: &OnPlant, request: &Request) -> Result<(), ExportError> {
        let truth = plant.planner(self.robot.landing_height.wide());
        let flown = Flown {
            planner: &truth,
            start: Start::of(&self.counted),
            valve_open: request.valve_open,
        };
        let (least, greatest, _) = request.rates;
        self.close_table(&flown, Some(&(least..=greatest)))?;
        self.close_map(&flown, &[(0.5, 0.5)])?;
        self.check_open()?;
        let height = self.robot.landing_height;
        let (mut jumps, mut miss) = (0, 0.0_f64);
        for (launch, distance) in self.answers(request) {
            let landing = truth.jump(&launch)?.distance(height.wide());
            let off = |landing: f64| (landing - distance).abs();
            (jumps, miss) = (jumps + 1, miss.max(landing.map_or(f64::INFINITY, off)));
        }
        self.confirmed = Some(Confirmed {
            name: plant.robot().name.clone(),
            hash: fingerprint(plant.robot()),
            jumps,
            miss,
        });
        Ok(())
    }

    /// Flies what the rule fires all over its cells, and closes those that miss; of a program's `rates` only in the middle
    /// and at the corners, where they are among these. Gives how many jumps were flown, and the greatest miss (m) that is
    /// left.
    fn close_table(
        &mut self,
        flown: &Flown<'_>,
        rates: Option<&RangeInclusive<f64>>,
    ) -> Result<(usize, f64), ExportError> {
        const CORNERS: [(f64, f64); 5] =
            [(0.5, 0.5), (0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)];
        let mut places = if rates.is_some() {
            CORNERS.into()
        } else {
            looks()
        };
        if self.distances.count == 1 {
            // One distance is looked at once.
            places.dedup_by_key(|(s, _)| *s);
        }
        let height = self.robot.landing_height.wide();
        let (mut jumps, mut greatest) = (0, 0.0_f64);
        for cell in 0..self.open.len() {
            if self.open[cell] == 0 {
                continue;
            }
            let mut worst = 0.0_f64;
            for &place in &places {
                let fired = self.fired(cell, place);
                worst = worst.max(match (fired, rates) {
                    (Some([rate, angle, _]), Some(rates))
                        if !rates.contains(&flown.launch(rate, angle).rate) =>
                    {
                        continue;
                    }
                    (Some([rate, angle, distance]), _) => {
                        flown.miss(rate, angle, distance, height)?
                    }
                    (None, Some(_)) => continue,
                    (None, None) => f64::INFINITY,
                });
                jumps += 1;
            }
            if worst > self.tolerance {
                self.open[cell] = 0;
                let least = self.least_closed.unwrap_or(f64::INFINITY).min(worst);
                self.least_closed = Some(least).filter(|least| least.is_finite());
            } else {
                greatest = greatest.max(worst);
            }
        }
        Ok((jumps, greatest))
    }

    /// Rate (rad/s), firing angle (rad) and distance (m) of what the controller fires at a place in a cell, Newton steps and
    /// all; none where it fires nothing.
    fn fired(&self, cell: usize, (s, t): (f64, f64)) -> Option<[f64; 3]> {
        let columns = self.distances.count.max(2) - 1;
        let rate = between(&self.rates, cell / columns, s);
        let distance = if self.distances.count > 1 {
            between(&self.distances, cell % columns, t)
        } else {
            self.distances.first.wide()
        };
        let mut controller = self.controller();
        // Cells are over the rate at the reference lean.
        controller.rates.at_firing = false;
        let height = self.robot.landing_height;
        let angle = controller.firing_angle(R::of(rate), R::of(distance), height);
        Some([rate, angle.ok()?.wide(), distance])
    }

    /// Holds the landings that the map predicts at `places` within its cells against the jumps flown, and closes the cells
    /// that miss. Gives how many jumps were flown, and the greatest miss (m) that is left.
    fn close_map(
        &mut self,
        flown: &Flown<'_>,
        places: &[(f64, f64)],
    ) -> Result<(usize, f64), ExportError> {
        let columns = self.angles.count - 1;
        let (mut jumps, mut greatest) = (0, 0.0_f64);
        for cell in 0..self.map_open.len() {
            if self.map_open[cell] == 0 {
                continue;
            }
            let mut worst = 0.0_f64;
            for (s, t) in places {
                let rate = between(&self.rates, cell / columns, *s);
                let angle = between(&self.angles, cell % columns, *t);
                worst = worst.max(self.mapped(flown, rate, angle)?);
                jumps += 1;
            }
            if worst > self.tolerance {
                self.map_open[cell] = 0;
            } else {
                greatest = greatest.max(worst);
            }
        }
        Ok((jumps, greatest))
    }

    /// The launches that a program gets at the rates and distances of `request` and half way
    /// between them, each with its distance (m).
    fn answers(&self, request: &Request) -> Vec<(Launch, f64)> {
        let halves = |(first, last, count): (f64, f64, usize)| spread((first, last, 2 * count - 1));
        let controller = self.controller();
        let mut all = Vec::new();
        for rate in halves(request.rates) {
            for distance in halves(request.distances) {
                let height = self.robot.landing_height;
                let angle = controller.firing_angle(R::of(rate), R::of(distance), height);
                let Ok(angle) = angle.map(Number::wide) else {
                    continue;
                };
                let launch = Launch {
                    rate,
                    lean: request.start_lean.unwrap_or(angle),
                    firing_angle: angle,
                    valve_open: request.valve_open,
                };
                all.push((launch, distance));
            }
        }
        all
    }

    /// What the robot made of them for which they were made, if that is not the planar one.
    pub fn confirmed(&self) -> Option<&Confirmed> {
        self.confirmed.as_ref()
    }

    /// How far they are from the planner.
    pub fn misses(&self) -> Misses {
        self.misses
    }

    /// Bytes that firing table and lift-off map take.
    pub fn bytes(&self) -> [usize; 2] {
        [
            size_of_val(self.nodes.numbers()) + self.open.len(),
            size_of_val(self.map_nodes.as_slice()) + self.map_open.len(),
        ]
    }

    /// Open cells and all cells of the firing table and of the lift-off map.
    pub fn cells(&self) -> [(usize, usize); 2] {
        [&self.open, &self.map_open]
            .map(|open| (open.iter().map(|cell| usize::from(*cell)).sum(), open.len()))
    }

    /// CRC-32 (IEEE 802.3) over the bytes of the tables, least byte first: nodes and cells of the
    /// table, then of the map.
    pub fn crc(&self) -> u32 {
        let mut hasher = crc32fast::Hasher::new();
        let mut number = |x: &R| hasher.update(x.bytes().as_ref());
        self.nodes.numbers().iter().for_each(&mut number);
        self.map_nodes.iter().flatten().for_each(&mut number);
        hasher.update(&self.open);
        hasher.update(&self.map_open);
        hasher.finalize()
    }

    /// Lift-offs at the nodes, with exact derivatives; the mixed one by differences of these. Of a
    /// flight that is no parabola they are those of the parabola that stands for it.
    fn fill_map(&mut self, flown: &Flown<'_>) -> Result<(), ExportError> {
        let (rates, angles) = (nodes_of(&self.rates), nodes_of(&self.angles));
        let mut found: Vec<Option<[[f64; 4]; 4]>> = Vec::with_capacity(rates.len() * angles.len());
        for &rate in &rates {
            for &angle in &angles {
                let launch = flown.launch(rate, angle);
                let jump = flown.planner.sensitive_jump(&launch)?;
                let height = self.robot.landing_height.wide();
                let state = jump.flight.as_ref().and_then(|flight| {
                    let ([x, y], [vx, vy]) = (jump.stance.axle, jump.stance.axle_rates);
                    if flight.is_parabola() {
                        return Some([x, y, vx, vy]);
                    }
                    stand_in([x, y], flight, self.robot.gravity.wide(), height)
                });
                found.push(state.map(|state| state.map(|x| flown.with_slopes(rate, &launch, x))));
            }
        }
        let (dr, da) = (rates[1] - rates[0], angles[1] - angles[0]);
        let at = |i: usize, j: usize| found[i * angles.len() + j];
        for i in 0..rates.len() {
            for j in 0..angles.len() {
                let mut node = [R::ZERO; MAP_NODE];
                if let Some(four) = at(i, j) {
                    for (k, value) in four.iter().enumerate() {
                        let slope_by_angle = |i: usize| at(i, j).map(|four| four[k][2] * da);
                        let mixed = difference(i, rates.len(), slope_by_angle);
                        let [value, by_rate, by_angle, by_valve] = *value;
                        let row = [value, by_rate * dr, by_angle * da, mixed, by_valve];
                        for (kind, x) in row.into_iter().enumerate() {
                            node[4 * kind + k] = R::of(x);
                        }
                    }
                }
                self.map_nodes.push(node);
            }
        }
        self.map_open = cells(rates.len(), angles.len(), |i, j| at(i, j).is_some());
        Ok(())
    }

    /// How far (m) a jump lands from where the map predicts; infinite where it predicts nothing.
    fn mapped(&self, flown: &Flown<'_>, rate: f64, angle: f64) -> Result<f64, ExportError> {
        let map = self.controller().map;
        let predicted = map
            .at(R::of(rate), R::of(angle))
            .and_then(|l| l.landing(self.robot.gravity, self.robot.landing_height));
        predicted.map_or(Ok(f64::INFINITY), |landing| {
            let height = self.robot.landing_height.wide();
            flown.miss(rate, angle, landing.value.wide(), height)
        })
    }
}

impl Request {
    /// Height (m) of the wheel's centre at the landing.
    pub(super) fn landing_height(&self, planner: &Planner<dyn JumpModel>) -> f64 {
        self.landing_height.unwrap_or(planner.robot().body.radius)
    }
}

/// The first 64 bits of the SHA-256 of the robot as a file, in hexadecimal digits: two robots with
/// one fingerprint are one.
pub fn fingerprint(robot: &saltus_robot::Robot) -> String {
    let digest = Hash::hash(robot.to_toml().as_bytes());
    let [a, b, c, d, e, f, g, h, ..] = digest;
    format!("{:016x}", u64::from_be_bytes([a, b, c, d, e, f, g, h]))
}

pub(super) fn check(
    planner: &Planner<dyn JumpModel>,
    request: &Request,
) -> Result<(), ExportError> {
    let drag = planner.robot().environment.drag;
    if drag > 0.0 {
        return Err(ExportError::Drag { drag });
    }
    let (angle, several) = ("between -pi/2 and pi/2 rad", "from 2 to 1000");
    let upright = |x: f64| x.abs() < std::f64::consts::FRAC_PI_2;
    let up_to = |x: f64, most: f64| x > 0.0 && x <= most;
    let nodes = |n: usize, least: usize| (least..=1000).contains(&n);
    let (r, d, open) = (request.rates, request.distances, request.valve_open);
    let (v, w) = request.valve_range.unwrap_or((open, open));
    let (a, b) = request.firing_angles.unwrap_or((0.0, 0.1));
    let (lean, height) = (
        request.start_lean.unwrap_or(0.0),
        request.landing_height(planner),
    );
    let (period, delay, steps) = (request.period, request.extra_delay, request.newton_steps);
    let (effort, tolerance) = (request.effort, request.tolerance);
    let wider = d.1 <= 1e3 && (d.1 > d.0) == (d.2 > 1);
    let wrong = refused! {
        "least approach rate (rad/s)", r.0, (0.0..=1e3).contains(&r.0) => "from 0 to 1000 rad/s";
        "greatest approach rate (rad/s)", r.1, r.1 > r.0 && r.1 <= 1e3
            => "above the least, to 1000 rad/s";
        "nodes over approach rates", r.2 as f64, nodes(r.2, 2) => several;
        "least distance (m)", d.0, d.0.abs() <= 1e3 => "from -1000 to 1000 m";
        "greatest distance (m)", d.1, wider => "above the least, to 1000 m";
        "nodes over distances", d.2 as f64, nodes(d.2, 1) => "from 1 to 1000";
        "least firing angle (rad)", a, upright(a) => angle;
        "greatest firing angle (rad)", b, upright(b) && b > a => "above the least, below pi/2 rad";
        "nodes over firing angles", request.angles as f64, nodes(request.angles, 2) => several;
        "landing height (m)", height, height.abs() <= 1e3 => "from -1000 to 1000 m";
        "valve opening time (s)", open, up_to(open, 1e3) => "above 0, to 1000 s";
        "least valve opening time (s)", v, up_to(v, open) => "above 0, to the valve opening time";
        "greatest valve opening time (s)", w, w >= open && w <= 1e3
            => "from the valve opening time to 1000 s";
        "start lean (rad)", lean, upright(lean) => angle;
        "control period (s)", period, up_to(period, 1.0) => "above 0, to 1 s";
        "extra delay (s)", delay, delay.abs() <= 1.0 => "from -1 to 1 s";
        "Newton steps", f64::from(steps), steps <= 3 => "from 0 to 3";
        "effort (m^2/s^2)", effort, up_to(effort, 1e6) => "above 0, to 1000000";
        "tolerance (m)", tolerance, up_to(tolerance, 1e3) => "above 0, to 1000 m";
        "threads", request.threads as f64, request.threads > 0 => "at least 1";
    };
    wrong.map_or(Ok(()), |(name, value, allowed)| {
        Err(ExportError::Input {
            name,
            value,
            allowed,
        })
    })
}

fn axis<R: Number>((first, last, count): (f64, f64, usize)) -> Axis<R> {
    Axis::new(R::of(first), R::of(last), count)
}

/// Lift-off of the parabola that starts at the `axle` (m), rises as high as `flight` and comes down
/// to `height` (m) where that does; none where there is none.
fn stand_in(
    [x, y]: [Dual<4>; 2],
    flight: &JumpFlight<Dual<4>>,
    gravity: f64,
    height: f64,
) -> Option<[Dual<4>; 4]> {
    let apex = flight.apex_height();
    let landing = flight.range_to_height(Dual::of(height)).ok()?;
    let (up, down) = (apex - y, apex - Dual::of(height));
    if up.value <= 0.0 || down.value <= 0.0 {
        return None;
    }
    let rise = (up * Dual::of(2.0 * gravity)).sqrt();
    let fall = (down * Dual::of(2.0 * gravity)).sqrt();
    let time = (rise + fall) / Dual::of(gravity);
    Some([x, y, (landing - x) / time, rise])
}

/// The nodes as the controller has them, after rounding.
fn nodes_of<R: Number>(axis: &Axis<R>) -> Vec<f64> {
    let (first, last) = (axis.first.wide(), axis.last.wide());
    (0..axis.count)
        .map(|i| first + (last - first) * i as f64 / (axis.count - 1) as f64)
        .collect()
}

/// A place `part` of the way through cell `cell`, rounded as the controller's numbers are.
fn between<R: Number>(axis: &Axis<R>, cell: usize, part: f64) -> f64 {
    let (first, last) = (axis.first.wide(), axis.last.wide());
    let x = first + (last - first) * (cell as f64 + part) / (axis.count - 1) as f64;
    R::of(x).wide().clamp(first, last)
}

/// Parts of a cell to look at.
fn looks() -> Vec<(f64, f64)> {
    let part = |k: usize| (k as f64 + 0.5) / LOOKS as f64;
    (0..LOOKS * LOOKS)
        .map(|k| (part(k / LOOKS), part(k % LOOKS)))
        .collect()
}

/// For each cell of `rows` × `columns` nodes: 1 if all its corners are known.
fn cells(rows: usize, columns: usize, known: impl Fn(usize, usize) -> bool) -> Vec<u8> {
    let cell = |i: usize, j: usize| {
        known(i, j) && known(i + 1, j) && known(i, j + 1) && known(i + 1, j + 1)
    };
    (0..rows - 1)
        .flat_map(|i| (0..columns.saturating_sub(1)).map(move |j| (i, j)))
        .map(|(i, j)| u8::from(cell(i, j)))
        .collect()
}

/// Derivative at node `i` of `count` by nodes: central where both neighbours are known, else to the
/// one that is.
fn difference(i: usize, count: usize, f: impl Fn(usize) -> Option<f64>) -> f64 {
    let before = i.checked_sub(1).and_then(&f);
    let after = (i + 1 < count).then(|| f(i + 1)).flatten();
    match (before, f(i), after) {
        (Some(a), _, Some(b)) => 0.5 * (b - a),
        (Some(a), Some(b), None) | (None, Some(a), Some(b)) => b - a,
        _ => 0.0,
    }
}

/// The nodes of the rule, and its open cells.
fn nodes_and_cells<R: Number>(
    (r0, r1, rows): (f64, f64, usize),
    (d0, d1, columns): (f64, f64, usize),
    firing: &[Firing],
) -> (Nodes<R>, Vec<u8>) {
    let dr = (r1 - r0) / (rows - 1) as f64;
    let at = |i: usize, j: usize| firing[i * columns + j];
    let value = |i: usize, j: usize| at(i, j).map(|f| f[0]);
    // Slopes times spacing, limited along either axis.
    let by_rate =
        |i: usize, j: usize| at(i, j).map(|f| limited(f[1] * dr, i, rows, |i| value(i, j)));
    if columns < 2 {
        let node = |i| [value(i, 0), by_rate(i, 0)].map(|x| R::of(x.unwrap_or(0.0)));
        let open = (0..rows - 1).map(|i| u8::from(at(i, 0).is_some() && at(i + 1, 0).is_some()));
        return (Nodes::Curve((0..rows).map(node).collect()), open.collect());
    }
    let dd = (d1 - d0) / (columns - 1) as f64;
    let by_distance =
        |i: usize, j: usize| at(i, j).map(|f| limited(f[2] * dd, j, columns, |j| value(i, j)));
    let node = |i: usize, j: usize| {
        let Some([angle, ..]) = at(i, j) else {
            return [R::ZERO; 4];
        };
        // The mixed derivative from both sides.
        let mixed = 0.5
            * (difference(i, rows, |i| by_distance(i, j))
                + difference(j, columns, |j| by_rate(i, j)));
        [
            angle,
            by_rate(i, j).unwrap_or(0.0),
            by_distance(i, j).unwrap_or(0.0),
            mixed,
        ]
        .map(R::of)
    };
    let nodes = (0..rows)
        .flat_map(|i| (0..columns).map(move |j| (i, j)))
        .map(|(i, j)| node(i, j))
        .collect();
    (
        Nodes::Table(nodes),
        cells(rows, columns, |i, j| at(i, j).is_some()),
    )
}

/// A slope at node `i` made so that the cubics on both its sides are monotone wherever the nodes
/// are: of the nodes' sign and at most three times the lesser of the neighbouring secants; 0 where
/// these differ in sign.
///
/// Source: Fritsch and Carlson 1980, the square [0, 3]² of their region of monotonicity.
fn limited(slope: f64, i: usize, count: usize, value: impl Fn(usize) -> Option<f64>) -> f64 {
    let here = value(i);
    let secant = |from: Option<f64>, to: Option<f64>| Some(to? - from?);
    let before = i.checked_sub(1).and_then(|k| secant(value(k), here));
    let after = (i + 1 < count)
        .then(|| secant(here, value(i + 1)))
        .flatten();
    [before, after]
        .into_iter()
        .flatten()
        .fold(slope, |slope, secant| {
            if slope * secant <= 0.0 {
                0.0
            } else {
                slope.signum() * slope.abs().min(3.0 * secant.abs())
            }
        })
}

fn constants<R: Number>(planner: &Planner<dyn JumpModel>, request: &Request) -> Robot<R> {
    let robot = planner.robot();
    let (radius, gravity, pendulum) = (robot.body.radius, robot.axle_gravity(), planner.pendulum());
    let stride = 2.0 * radius * (std::f64::consts::PI / f64::from(robot.body.legs)).sin();
    Robot {
        radius: R::of(radius),
        gravity: R::of(gravity),
        pendulum: R::of(pendulum),
        stride: R::of(stride),
        valve_open: R::of(request.valve_open),
        landing_height: R::of(request.landing_height(planner)),
    }
}

fn limits<R: Number>(request: &Request) -> Limits<R> {
    let (least, greatest) = request
        .valve_range
        .unwrap_or((request.valve_open, request.valve_open));
    Limits {
        period: R::of(request.period),
        extra_delay: R::of(request.extra_delay),
        newton_steps: request.newton_steps,
        least_valve_open: R::of(least),
        greatest_valve_open: R::of(greatest),
        effort: R::of(request.effort),
    }
}
