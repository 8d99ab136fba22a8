//! `saltus law`: the linear law of the firing angle over the approach rate.

use clap::Args;
use saltus::on_plant::{Confirmed, OnPlant, for_table};
use saltus::planner::{self, Corrected, LawPoint, Nearest, Roots, TableRequest};
use saltus::{Planner, Robot};
use serde_json::{Value, json};

use super::Status;
use super::common::{Common, PlantFlags};
use super::proof::Proof;
use super::target::{Kind, TargetFlags};
use super::terms::Terms;
use crate::error::CliError;
use crate::output::{self, Column, Format, Table as Rows, columns, digits};
use crate::plot::line::{Line, Mark};
use crate::plot::palette::shade;
use crate::plot::sheet::{Panel, Sheet};
use crate::progress::Progress;
use crate::quantity;

/// Fit the linear law α_f = A ω + B that reaches a distance or a clearance
#[derive(Args, Debug)]
#[command(after_help = "`saltus law --help` explains the output.", after_long_help = LONG_HELP)]
pub(crate) struct Law {
    #[command(flatten)]
    target: TargetFlags,

    /// Miss (m) up to which the law counts as valid
    #[arg(long, value_name = "LENGTH", value_parser = quantity::extent, allow_hyphen_values = true, default_value = "0.01")]
    tolerance: f64,

    #[command(flatten)]
    plant: PlantFlags,

    #[command(flatten)]
    common: Common,
}

const LONG_HELP: &str = "\
Examples:
  saltus law --omega 3:6:5 --distance 0.8
  saltus law --omega 3:6:5 --distance 1 --landing-height 0
  saltus law --omega 3:6:13 --distance 0.6 --plant rats-boom
  saltus law --omega 3:6:61 --distance 0.4,0.6,0.8 --tolerance 2cm --plot law.png

Values: a number, start:stop:count (both ends included), or several of these with commas.
Suffixes: rad/s, deg/s; rad, deg; s, ms; m, cm, mm.

The law is fitted by least squares to the least firing angle of each approach rate that reaches the \
target; then the jump that it fires at each of these rates is simulated. Valid is the longest run of \
rates whose jumps miss the target by --tolerance at most.

With --plant the law is that robot's, as for `saltus table`; its misses are those of the multi-body \
simulation (JSON: \"correction\" says how it was corrected: {\"simulated_jumps\", \"is_exact\" (the plant jumps as the planar model says), \"confirmed\" (jumps that were flown), \"dropped\", \"miss_greatest_m\"}; columns plant and plant_sha256 follow).

CSV columns, one row for each target: distance_m (or clearance_m), slope_s (A), intercept_rad (B), \
residual_greatest_rad, residual_rms_rad (fitted less exact angle), miss_greatest_m, miss_rms_m (reached \
less wanted; empty if one of the jumps fails), valid_from_rad_s, valid_to_rad_s, rates (fitted), \
rates_out_of_reach, status (feasible; partly where some rates are out of reach; infeasible where fewer \
than the two rates that a line takes reach it; no-landing where jumps never come down to the landing height; no-jump where no angle takes off), nearest_distance_m (or nearest_clearance_m), nearest_omega_rad_s and \
nearest_alpha_f_rad (where infeasible: the nearest that is reached, the target itself where one rate alone reaches it). \
Then, as for `saltus table`: valve_open_s, start_lean_rad (empty: the firing angle), landing_height_m, robot, robot_sha256, saltus_version. Numbers have 17 significant digits.

JSON: {\"command\": \"law\", \"robot\": NAME, \"robot_sha256\", \"saltus_version\", \"landing_height_m\", \"start_lean_rad\" (or \"firing\"), \"valve_open_s\", \"measure\", \"tolerance_m\", \"laws\": [{the columns, \"points\": [{omega_rad_s, alpha_f_exact_rad, alpha_f_law_rad, residual_rad, \
miss_m}]}]}.

The exit code is 1 if a target is infeasible.";

/// The columns of a kind of target; a row is what was found, and the tolerance (m).
fn columns<'a>(kind: Kind) -> [Column<(&'a Found, f64)>; 15] {
    let [target, nearest] = match kind {
        Kind::Distance => ["distance_m", "nearest_distance_m"],
        Kind::Clearance => ["clearance_m", "nearest_clearance_m"],
    };
    columns! {
        target, "", |(one, _)| one.target;
        "slope_s", "", |(one, _)| one.of_law(|law| law.slope);
        "intercept_rad", "", |(one, _)| one.of_law(|law| law.intercept);
        "residual_greatest_rad", "", |(one, _)| one.of_law(|law| law.residuals().0);
        "residual_rms_rad", "", |(one, _)| one.of_law(|law| law.residuals().1);
        "miss_greatest_m", "", |(one, _)| one.of_law(|law| law.misses().0);
        "miss_rms_m", "", |(one, _)| one.of_law(|law| law.misses().1);
        "valid_from_rad_s", "", |(one, most)| one.valid(*most).map(|(from, _)| from);
        "valid_to_rad_s", "", |(one, most)| one.valid(*most).map(|(_, to)| to);
        "rates", "", |(one, _)| one.of_law(|law| law.points.len());
        "rates_out_of_reach", "", |(one, _)| one.of_law(|law| law.out_of_reach.len());
        "status", "", |(one, _)| one.status();
        nearest, "", |(one, _)| one.near(|near| near.at.value);
        "nearest_omega_rad_s", "", |(one, _)| one.near(|near| near.rate);
        "nearest_alpha_f_rad", "", |(one, _)| one.near(|near| near.at.firing_angle);
    }
}

/// The law of one target, or how near one gets to it.
struct Found {
    target: f64,
    law: Option<planner::Law>,
    nearest: Option<Near>,
    /// Whether any jump takes off.
    takes_off: bool,
}

impl Found {
    /// Flies the law on the plant. A law of which no jump takes off there is none.
    fn confirm(&mut self, plant: &OnPlant, request: &TableRequest) -> Confirmed {
        let Some(law) = &mut self.law else {
            return Confirmed::default();
        };
        let confirmed = plant.confirm_law(request, law);
        let flies = |point: &LawPoint| point.value.is_some_and(f64::is_finite);
        if !law.points.iter().any(flies) {
            (self.law, self.nearest, self.takes_off) = (None, None, false);
        }
        confirmed
    }
}

/// The rate (rad/s) that gets nearest to a target without a law, and how.
struct Near {
    rate: f64,
    /// Whether it reaches the target: a line takes two rates that do.
    reaches: bool,
    at: Nearest,
}

impl Law {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        self.common.ready()?;
        let (robot, plant) = self.plant.on_plant(&self.common.robot)?;
        let request = self.target.request(Roots::Least, &robot)?;
        let (planner, found, proof) = {
            let _progress = Progress::new("law", 0);
            let (planner, correction) = for_table(robot, plant.as_ref(), &request)?;
            let mut found = find(&planner, &request)?;
            let proof = plant.as_ref().zip(correction).map(|(plant, correction)| {
                let confirmed = found.iter_mut().map(|one| one.confirm(plant, &request));
                let confirmed = confirmed.fold(Confirmed::default(), Confirmed::and);
                Proof::new(plant, correction, confirmed)
            });
            (planner, found, proof)
        };
        let terms = self.target.terms(planner.robot());
        let terms = terms.on(plant.as_ref().map(OnPlant::robot));
        let rows = self.rows(&found, &terms);
        let report = match self.common.format() {
            Format::Csv => rows.csv(),
            Format::Json => self.json(&rows, &found, &terms, proof.as_ref()),
            Format::Text => self.text(&found, &terms, proof.as_ref(), planner.robot()),
        };
        let drawing = || self.drawing(&found, &terms, planner.robot());
        self.common.write(report, drawing)?;
        Ok(Status::of(found.iter().all(|one| one.law.is_some())))
    }

    fn rows(&self, found: &[Found], terms: &Terms) -> Rows {
        let found = found.iter().map(|one| (one, self.tolerance));
        let table = Rows::of(&columns(self.target.kind()), found.clone());
        // A law's stances start at angles of their own, or at one lean.
        terms.told(table, found.map(|_| terms.start_lean))
    }

    fn json(&self, rows: &Rows, found: &[Found], terms: &Terms, proof: Option<&Proof>) -> String {
        let mut laws = rows.json();
        for (object, one) in laws.iter_mut().zip(found) {
            let points: Vec<Value> = one
                .law
                .iter()
                .flat_map(|law| &law.points)
                .map(point_json)
                .collect();
            object.insert("points".into(), points.into());
        }
        let mut document = terms.json("law");
        document.insert("measure".into(), json!(self.target.kind().name()));
        document.insert("tolerance_m".into(), json!(self.tolerance));
        document.insert("laws".into(), json!(laws));
        if let Some(proof) = proof {
            document.insert("correction".into(), proof.json());
        }
        output::json(&document.into())
    }

    fn text(&self, found: &[Found], terms: &Terms, proof: Option<&Proof>, robot: &Robot) -> String {
        let head = format!(
            "{}: firing angle α_f (rad) over approach rate ω (rad/s)",
            robot.name
        );
        let proof = proof.map_or_else(String::new, Proof::line);
        let mut text = format!("{head}\n  {}\n{proof}", terms.line());
        for one in found {
            let title = format!(
                "{} {} m: ",
                self.target.kind().name(),
                digits(one.target, 5)
            );
            text.push_str(&title);
            text.push_str(&match &one.law {
                Some(law) => self.law_text(law),
                None => nothing_text(one),
            });
        }
        text
    }

    fn law_text(&self, law: &planner::Law) -> String {
        let sign = if law.intercept < 0.0 { '-' } else { '+' };
        let ((residual, residual_rms), (miss, miss_rms)) = (law.residuals(), law.misses());
        let mut lines = vec![
            format!(
                "α_f = {} s · ω {sign} {} rad",
                digits(law.slope, 5),
                digits(law.intercept.abs(), 5)
            ),
            format!(
                "  residual   {} rad at most, {} rad RMS",
                digits(residual, 3),
                digits(residual_rms, 3)
            ),
            format!(
                "  miss       {} m at most, {} m RMS",
                digits(miss, 3),
                digits(miss_rms, 3)
            ),
        ];
        lines.push(match law.valid_range(self.tolerance) {
            Some((from, to)) => format!(
                "  valid      from {} to {} rad/s, within {} m",
                digits(from, 5),
                digits(to, 5),
                digits(self.tolerance, 5)
            ),
            None => format!(
                "  valid      nowhere within {} m",
                digits(self.tolerance, 5)
            ),
        });
        lines.push(format!(
            "  fitted to  {} rates, {} more are out of reach",
            law.points.len(),
            law.out_of_reach.len()
        ));
        lines.join("\n") + "\n"
    }

    fn drawing(&self, found: &[Found], terms: &Terms, robot: &Robot) -> Result<Sheet, CliError> {
        const MOST: usize = 12;
        if found.len() > MOST {
            let allowed = format!("used with {MOST} targets at most, not {}", found.len());
            return Err(CliError::flag("--plot", "", allowed));
        }
        let laws: Vec<(f64, &planner::Law)> = found
            .iter()
            .filter_map(|one| Some((one.target, one.law.as_ref()?)))
            .collect();
        let (mut angles, mut residuals) = (Vec::new(), Vec::new());
        for (i, (target, law)) in laws.iter().enumerate() {
            let line = |mark, of: fn(&LawPoint) -> f64| {
                let points = law.points.iter().map(|p| (p.rate, of(p)));
                Line::new(mark, shade(i, laws.len()), points)
            };
            let label = format!(
                "{} m: A = {} s, B = {} rad",
                digits(*target, 4),
                digits(law.slope, 4),
                digits(law.intercept, 4)
            );
            angles.push(line(Mark::Solid, |p| p.fitted).called(label.replace('-', "−")));
            angles.push(line(Mark::Dots, |p| p.exact));
            residuals.push(line(Mark::Dots, |p| 1e3 * (p.fitted - p.exact)));
        }
        let panel = |title: String, y, lines| Panel {
            title,
            x: "approach rate ω (rad/s)",
            y,
            lines,
            ..Panel::default()
        };
        let head = match found.first() {
            Some(one) if laws.is_empty() => nothing_text(one).trim_end().to_owned(),
            _ => "dots exact, lines fitted".to_owned(),
        };
        Ok(Sheet {
            title: format!(
                "{}: linear law of the firing angle for a {}, {}",
                robot.name,
                self.target.kind().name(),
                terms.landing_title()
            ),
            panels: vec![
                panel(head, "firing angle α_f (rad)", angles),
                panel("fitted less exact".into(), "residual (mrad)", residuals),
            ],
            ..Sheet::default()
        })
    }
}

fn find(planner: &Planner<Corrected>, request: &TableRequest) -> Result<Vec<Found>, CliError> {
    let laws = planner.laws(request)?;
    let mut found = Vec::with_capacity(laws.len());
    for (law, &target) in laws.into_iter().zip(&request.targets) {
        let (nearest, takes_off) = if law.is_none() {
            nearest(planner, request, target)?
        } else {
            (None, true)
        };
        found.push(Found {
            target,
            law,
            nearest,
            takes_off,
        });
    }
    Ok(found)
}

impl Found {
    fn of_law<T>(&self, of: fn(&planner::Law) -> T) -> Option<T> {
        self.law.as_ref().map(of)
    }

    fn near(&self, of: fn(&Near) -> f64) -> Option<f64> {
        self.nearest.as_ref().map(of)
    }

    /// The rates (rad/s) from and to which the law misses by `most` (m) at most.
    fn valid(&self, most: f64) -> Option<(f64, f64)> {
        self.law.as_ref()?.valid_range(most)
    }

    fn status(&self) -> &'static str {
        match (&self.law, &self.nearest) {
            (Some(law), _) if law.out_of_reach.is_empty() => "feasible",
            (Some(_), _) => "partly",
            (None, Some(_)) => "infeasible",
            (None, None) if self.takes_off => "no-landing",
            (None, None) => "no-jump",
        }
    }
}

/// The rate that gets nearest to `target`, and whether any jump takes off.
fn nearest(
    planner: &Planner<Corrected>,
    request: &TableRequest,
    target: f64,
) -> Result<(Option<Near>, bool), CliError> {
    let table = planner.table(&TableRequest {
        targets: vec![target],
        ..request.clone()
    })?;
    let reached = table.cells.iter().filter_map(|cell| {
        let exact = cell.entries.first();
        let exact = exact.map(|entry| Nearest {
            value: entry.value,
            firing_angle: entry.jump.launch.firing_angle,
        });
        Some(Near {
            rate: cell.rate,
            reaches: exact.is_some(),
            at: exact.or(cell.nearest)?,
        })
    });
    let gap = |near: &Near| (near.at.value - target).abs();
    let takes_off = table.cells.iter().any(|cell| cell.takes_off);
    Ok((reached.min_by(|a, b| gap(a).total_cmp(&gap(b))), takes_off))
}

fn nothing_text(one: &Found) -> String {
    let Some(Near { rate, reaches, at }) = &one.nearest else {
        return if one.takes_off {
            "no-landing: the robot takes off, but at none of these rates does it come down to the \
             landing height\n"
                .into()
        } else {
            "no-jump: the robot does not take off at any of these rates\n".into()
        };
    };
    let place = format!(
        "ω = {} rad/s, α_f = {} rad",
        digits(*rate, 5),
        digits(at.firing_angle, 5)
    );
    if *reaches {
        format!(
            "infeasible: a line takes two rates that reach it, and there is one alone: {place}\n"
        )
    } else {
        format!(
            "infeasible: no rate reaches it; the nearest is {} m at {place}\n",
            digits(at.value, 5)
        )
    }
}

fn point_json(point: &LawPoint) -> Value {
    json!({
        "omega_rad_s": point.rate,
        "alpha_f_exact_rad": point.exact,
        "alpha_f_law_rad": point.fitted,
        "residual_rad": point.residual(),
        "miss_m": point.miss(),
    })
}
