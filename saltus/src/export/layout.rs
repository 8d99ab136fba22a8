//! What tables are over: where their rates count, which range they take, and the firing angles at
//! their nodes.

use saltus_controller::Rates;
use saltus_lagrangian::Launch;
use saltus_numeric::Dual;
use saltus_planner::{
    Cell, FIRING_ANGLES, JumpModel, Measure, Planner, Roots, Sensitivity, Table, TableRequest,
};

use super::numbers::Number;
use super::request::{ExportError, Request, spread};

/// A node of the table before it is rounded: α_f and its slopes by ω and by distance.
pub(super) type Firing = Option<[f64; 3]>;

/// Where the rates of the tables count.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    /// The lean (rad).
    reference: f64,
    /// Whether stances start at the firing angle, and the program's rates count there: the
    /// reference then only names the energy of the pivoting robot. Else stances start at the
    /// reference.
    at_firing: bool,
}

/// The axes of the tables, and firing angles at their nodes.
pub(super) struct Layout {
    pub(super) start: Start,
    /// Least and greatest rate (rad/s) at the reference lean, and how many nodes.
    pub(super) rates: (f64, f64, usize),
    /// Least and greatest firing angle (rad) of the lift-off map.
    pub(super) angles: (f64, f64),
    /// Distances within rates.
    pub(super) firing: Vec<Firing>,
}

/// Jumps of the planner from the tables' rates.
pub(super) struct Flown<'a> {
    pub(super) planner: &'a Planner<dyn JumpModel>,
    pub(super) start: Start,
    pub(super) valve_open: f64,
}

/// How far (rad) the lift-off map goes beyond the firing angles of the table.
const BEYOND: f64 = 0.1;

impl Start {
    /// Where the rates of tables count.
    pub(super) fn of<R: Number>(counted: &Rates<R>) -> Start {
        Start {
            reference: counted.reference_lean.wide(),
            at_firing: counted.at_firing,
        }
    }

    pub(super) fn rates<R: Number>(self, request: &Request) -> Rates<R> {
        Rates {
            least: R::of(request.rates.0),
            greatest: R::of(request.rates.1),
            reference_lean: R::of(self.reference),
            at_firing: self.at_firing,
        }
    }
}

impl Layout {
    /// The layout for `request`.
    ///
    /// # Errors
    /// [`ExportError`] where the planner has no table, or nothing is reached.
    pub(super) fn new<R: Number>(
        planner: &Planner<dyn JumpModel>,
        request: &Request,
    ) -> Result<Layout, ExportError> {
        match request.start_lean {
            Some(lean) => Layout::from_lean(planner, request, lean),
            None => Layout::from_firing::<R>(planner, request),
        }
    }

    /// Stances that start at one lean.
    fn from_lean(
        planner: &Planner<dyn JumpModel>,
        request: &Request,
        lean: f64,
    ) -> Result<Layout, ExportError> {
        let start = Start {
            reference: lean,
            at_firing: false,
        };
        // A robot fired before its stance starts is fired there: no angle below the start lean is
        // one of its own.
        let limits = request
            .firing_angles
            .unwrap_or((lean, FIRING_ANGLES.1.max(lean + 0.1)));
        let table = planner.table(&table_request(planner, request, request.rates, limits))?;
        let firing: Vec<Firing> = table
            .cells
            .iter()
            .map(|cell| later(cell, planner, start))
            .collect();
        let angles = angle_range(
            request,
            lean,
            firing.iter().flatten().map(|[angle, ..]| *angle),
        )?;
        Ok(Layout {
            start,
            rates: request.rates,
            angles,
            firing,
        })
    }

    /// Stances that start at their firing angles.
    ///
    /// The reference lies as far back as the farthest angle forward or back, so that every robot
    /// that is fired has a rate there.
    fn from_firing<R: Number>(
        planner: &Planner<dyn JumpModel>,
        request: &Request,
    ) -> Result<Layout, ExportError> {
        let limits = request.firing_angles.unwrap_or(FIRING_ANGLES);
        let asked = planner.table(&table_request(planner, request, request.rates, limits))?;
        let fired: Vec<(f64, f64)> = fired(&asked).collect();
        let angles = angle_range(
            request,
            limits.0 - BEYOND,
            fired.iter().map(|(_, angle)| *angle),
        )?;
        let start = Start {
            reference: -R::of(angles.0.abs().max(angles.1)).wide(),
            at_firing: true,
        };
        let rates = energies(planner, request.rates, start, &fired);
        let upright = start.reference.abs();
        let limits = (limits.0.max(-upright), limits.1.min(upright));
        let by_energy = table_request(planner, request, rates, limits);
        let table = planner.table_by_energy(&by_energy, start.reference)?;
        let firing = table
            .cells
            .iter()
            .map(|cell| later(cell, planner, start))
            .collect();
        Ok(Layout {
            start,
            rates,
            angles,
            firing,
        })
    }
}

/// Rates (rad/s) at the reference lean that hold all that are `fired`, at the spacing of `asked` or
/// closer.
fn energies(
    planner: &Planner<dyn JumpModel>,
    asked: (f64, f64, usize),
    start: Start,
    fired: &[(f64, f64)],
) -> (f64, f64, usize) {
    let step = (asked.1 - asked.0) / (asked.2 - 1) as f64;
    let rates = || {
        fired
            .iter()
            .map(|&(rate, angle)| planner.pivoted(rate, angle, start.reference))
    };
    // A little more, for rounding.
    let margin = 1e-3 * step;
    let first = (rates().fold(f64::INFINITY, f64::min) - margin).max(0.0);
    let last = rates().fold(0.0, f64::max) + margin;
    // At most some thousands of nodes, of which a request has one.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let cells = ((last - first) / step).ceil().max(1.0) as usize;
    (first, last, cells + 1)
}

fn table_request(
    planner: &Planner<dyn JumpModel>,
    request: &Request,
    rates: (f64, f64, usize),
    firing_angles: (f64, f64),
) -> TableRequest {
    TableRequest {
        rates: spread(rates),
        measure: Measure::Distance {
            landing_height: request.landing_height(planner),
        },
        targets: spread(request.distances),
        valve_open: request.valve_open,
        start_lean: request.start_lean,
        firing_angles,
        roots: Roots::All,
        sensitivities: true,
        threads: request.threads,
    }
}

/// Rate (rad/s) and angle (rad) of each firing: the least angle from which firing later goes
/// farther.
fn fired(table: &Table) -> impl Iterator<Item = (f64, f64)> {
    table.cells.iter().filter_map(|cell| {
        let rises = |s: &[Sensitivity; 2]| s[0].by_firing_angle > 0.0;
        let entry = cell
            .entries
            .iter()
            .find(|entry| entry.sensitivity.as_ref().is_some_and(rises))?;
        Some((cell.rate, entry.jump.launch.firing_angle))
    })
}

/// The least firing angle of a cell from which firing later goes farther, with its slopes by the
/// cell's rate and by distance.
fn later(cell: &Cell, planner: &Planner<dyn JumpModel>, start: Start) -> Firing {
    cell.entries.iter().find_map(|entry| {
        let [distance, _] = entry.sensitivity?;
        let launch = &entry.jump.launch;
        let slopes = [distance.by_rate, distance.by_firing_angle];
        let [by_rate, by_angle] = start.chained(planner, cell.rate, launch, slopes);
        (by_angle > 0.0).then(|| [launch.firing_angle, -by_rate / by_angle, 1.0 / by_angle])
    })
}

impl Start {
    /// Slopes by the rate at the reference lean and by the firing angle, of those by the launch's
    /// rate and the firing angle.
    ///
    /// At the firing angle ω² = ω_r² + 2 c (cos φ_r − cos α), which both change.
    fn chained(
        self,
        planner: &Planner<dyn JumpModel>,
        rate: f64,
        launch: &Launch,
        [by_rate, by_angle]: [f64; 2],
    ) -> [f64; 2] {
        // At rest at its firing angle a robot has no slope by energy; its cells' neighbours do.
        if !self.at_firing || launch.rate == 0.0 {
            return [by_rate, by_angle];
        }
        let swing = planner.pendulum() * launch.firing_angle.sin() / launch.rate;
        [by_rate * rate / launch.rate, by_angle + by_rate * swing]
    }
}

impl Flown<'_> {
    /// The launch of a robot with `rate` (rad/s) at the reference lean that is fired at `angle`
    /// (rad).
    pub(super) fn launch(&self, rate: f64, angle: f64) -> Launch {
        let Start {
            reference,
            at_firing,
        } = self.start;
        if at_firing {
            Launch::at_firing(
                self.planner.pivoted(rate, reference, angle),
                angle,
                self.valve_open,
            )
        } else {
            Launch {
                rate,
                lean: reference,
                firing_angle: angle,
                valve_open: self.valve_open,
            }
        }
    }

    /// A number of that launch, with its slopes by the rate at the reference lean, the firing angle
    /// and the valve opening time.
    pub(super) fn with_slopes(&self, rate: f64, launch: &Launch, x: Dual<4>) -> [f64; 4] {
        let [by_rate, by_angle, by_valve, _] = x.slope;
        let [by_rate, by_angle] =
            self.start
                .chained(self.planner, rate, launch, [by_rate, by_angle]);
        [x.value, by_rate, by_angle, by_valve]
    }

    /// How far (m) from `distance` the jump lands; infinite where it does not.
    pub(super) fn miss(
        &self,
        rate: f64,
        angle: f64,
        distance: f64,
        height: f64,
    ) -> Result<f64, ExportError> {
        let landing = self
            .planner
            .jump(&self.launch(rate, angle))?
            .distance(height);
        Ok(landing.map_or(f64::INFINITY, |landing| (landing - distance).abs()))
    }
}

/// Firing angles (rad) of the lift-off map: those asked for, or the table's `angles` and a little
/// more, from `least` on.
fn angle_range(
    request: &Request,
    least: f64,
    angles: impl Iterator<Item = f64> + Clone,
) -> Result<(f64, f64), ExportError> {
    if let Some(range) = request.firing_angles {
        return Ok(range);
    }
    let (low, high) = (
        angles.clone().fold(f64::INFINITY, f64::min),
        angles.fold(f64::NEG_INFINITY, f64::max),
    );
    if low > high {
        let what = if request.distances.2 > 1 {
            "firing table"
        } else {
            "firing curve"
        };
        return Err(ExportError::Empty {
            what,
            tolerance: request.tolerance,
            least: None,
        });
    }
    Ok(((low - BEYOND).max(least), high + BEYOND))
}
