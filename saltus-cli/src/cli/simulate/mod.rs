//! `saltus simulate`: what becomes of one jump, or of many.

mod batch;
mod compute;
mod family;
mod report;
mod text;

use std::path::PathBuf;

use clap::Args;
use saltus::lagrangian::{Batch, FINE};
use saltus::{Launch, Robot, StanceError};

use super::Status;
use super::common::{Common, Threads, note_valve};
use super::recorded::{Beside, McapOption};
use super::terms::{StartLean, VALVE_OPEN, start_lean};
use crate::error::CliError;
use crate::output::Format;
use crate::range::{Values, angles, rates, times};

/// Most jumps that one call without a batch makes.
const MOST_JUMPS: usize = 1_000_000;
/// Most jumps that a plot of trajectories shows.
const MOST_DRAWN: usize = 100;

/// Simulate one jump, or many
#[derive(Args, Debug)]
#[command(after_help = "`saltus simulate --help` explains the output.", after_long_help = LONG_HELP)]
pub(crate) struct Simulate {
    /// Approach rate(s) ω₀ (rad/s): how fast the robot leans forward at the start
    #[arg(long, value_name = "RATE", value_parser = rates, allow_hyphen_values = true)]
    omega: Option<Values>,

    /// Firing angle(s) α_f (rad): the lean at which the leg is fired; forward of the upright is
    /// positive
    #[arg(long, value_name = "ANGLE", value_parser = angles, allow_hyphen_values = true)]
    alpha_f: Option<Values>,

    /// Valve opening time(s) t_v (s): how long the drive is commanded; of no effect for a spring,
    /// which has no valve [default: 0.1]
    #[arg(long, value_name = "TIME", value_parser = times, allow_hyphen_values = true)]
    valve_open: Option<Values>,

    /// Where the stance starts and the approach rate counts: `firing`, at the firing angle, or at
    /// this lean φ₀ (rad) [default: firing]
    #[arg(long, value_name = "firing|ANGLE", value_parser = start_lean, allow_hyphen_values = true)]
    start_lean: Option<StartLean>,

    /// Read the launches from this CSV file: columns omega0_rad_s (or omega_rad_s), phi0_rad (or
    /// start_lean_rad), alpha_f_rad, valve_open_s; a table that `saltus table` wrote has them
    #[arg(long, value_name = "FILE.csv", conflicts_with_all = ["omega", "alpha_f", "valve_open", "start_lean"])]
    batch: Option<PathBuf>,

    #[command(flatten)]
    threads: Threads,

    #[command(flatten)]
    mcap: McapOption,

    #[command(flatten)]
    common: Common,
}

const LONG_HELP: &str = "\
Examples:
  saltus simulate --omega 5 --alpha-f -0.1
  saltus simulate --omega 5 --alpha-f -6deg --valve-open 25ms --set leg.stroke_m=0.05
  saltus simulate --omega 5 --alpha-f -0.25:0.05:7 --plot figure-5.9.svg
  saltus simulate --batch jumps.csv --out answers.csv
  saltus table --omega 3:6:31 --distance 0.6 --out table.csv && saltus simulate --batch table.csv

Values: a number, start:stop:count (both ends included), or several of these with commas; every \
combination is simulated.
Suffixes: rad/s, deg/s; rad, deg; s, ms.

Outcomes: stroke (lift-off at the end of the stroke), force (lift-off because the leg's force fell to 0); \
without a flight: stall (came to rest before the firing angle), no-break-away (the valve closed before \
the leg moved, or the robot fell over), early-lift-off (left the ground before the leg was fired), fall-back (the leg sank back).

CSV columns: omega0_rad_s, phi0_rad, alpha_f_rad, valve_open_s, outcome, t_fire_s, t_liftoff_s; at \
lift-off phi_rad (lean), omega_rad_s (lean rate), d_m, d_dot_m_s (extension and its rate), pressure_pa \
(chamber, absolute), x_m, y_m, vx_m_s, vy_m_s (wheel centre, from the foot); apex_m (greatest height of \
the centre), land_rs_m and land_0_m (where the centre comes down to the wheel's radius and to 0). Numbers \
have 17 significant digits; a cell is empty where there is no such thing (valve_open_s for a spring, which has no valve).

JSON: {\"command\": \"simulate\", \"robot\": NAME, \"jumps\": [{the columns, null where empty}]}. Without \
--batch, each jump also has \"contact\" {least_normal_n, least_normal_time_s, friction_needed, \
friction_needed_time_s} (friction_needed is null where the ground would have to pull) and \"energy\" \
{drive_j, losses_j, kinetic_j, potential_j}.

--mcap writes one jump, with its stance as it was integrated and its flight every 1 ms, the leg as it is at lift-off; \
docs/viewers.md lists the topics.

Rows of a table that are out of reach have no firing angle; a batch leaves them out.

A jump that does not take off is an answer: the exit code is 0.";

impl Simulate {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        self.common.ready()?;
        self.mcap.ready()?;
        let robot = self.common.robot.planned_robot()?;
        note_valve(&robot, self.valve_open.as_ref().map(|_| "--valve-open"));
        let (launches, lines) = self.launches(&robot)?;
        let drawn = self.common.plot.is_set();
        if drawn && launches.len() > MOST_DRAWN {
            let allowed = format!(
                "used with {MOST_DRAWN} jumps at most, not {}",
                launches.len()
            );
            return Err(CliError::flag("--plot", "", allowed));
        }
        if self.mcap.path().is_some() && launches.len() != 1 {
            let allowed = format!("used with one jump, not {}", launches.len());
            return Err(CliError::flag("--mcap", "", allowed));
        }
        let detail = compute::Detail {
            stance: self.batch.is_none(),
            path: drawn,
        };
        let answers = compute::simulate(&robot, &launches, detail, self.threads.count()).map_err(
            |failed| {
                self.failed(
                    &launches[failed.index],
                    lines.get(failed.index),
                    failed.source,
                )
            },
        )?;
        let report = match self.common.format() {
            Format::Csv => report::table(&answers, &robot).csv(),
            Format::Json => report::json(&answers, &robot),
            Format::Text => text::text(&answers, &robot),
        };
        let drawing = || Ok(family::family(&answers, &robot));
        let mcap = self.recorded(&answers, &robot)?;
        self.common.write_with(report, drawing, mcap)?;
        Ok(Status::Done)
    }

    /// The jump as an MCAP file, if one is asked for.
    fn recorded(
        &self,
        answers: &[compute::Answer],
        robot: &Robot,
    ) -> Result<Option<Beside<'_>>, CliError> {
        let [answer] = answers else {
            return Ok(None);
        };
        let launch = &answer.jump.launch;
        let trace = Batch::new(robot, FINE).stance().trace(launch);
        let trace = trace.map_err(|source| self.failed(launch, None, source))?;
        self.mcap.recorded(robot, None, |recording| {
            recording.course(&[])?;
            recording.planned(&trace, answer.jump.exact_flight(), launch.valve_open)
        })
    }

    /// The launches, and the lines of the batch on which they stand.
    fn launches(&self, robot: &Robot) -> Result<(Vec<Launch>, Vec<u64>), CliError> {
        match &self.batch {
            Some(path) => Ok(batch::load(path, robot)?
                .into_iter()
                .map(|(line, launch)| (launch, line))
                .unzip()),
            None => Ok((self.combinations(robot)?, Vec::new())),
        }
    }

    /// Every combination of the flags' values.
    fn combinations(&self, robot: &Robot) -> Result<Vec<Launch>, CliError> {
        let missing = |flag| CliError::Missing {
            flag,
            allowed: "a jump needs it, or give a --batch",
        };
        let rates = self.omega.as_ref().ok_or_else(|| missing("--omega"))?;
        let angles = self.alpha_f.as_ref().ok_or_else(|| missing("--alpha-f"))?;
        let times = self
            .valve_open
            .clone()
            .filter(|_| robot.leg.drive.has_valve());
        let times = times.unwrap_or_else(|| Values::from(VALVE_OPEN));
        let count = rates
            .len()
            .saturating_mul(angles.len())
            .saturating_mul(times.len());
        if count > MOST_JUMPS {
            let allowed = format!("{MOST_JUMPS} combinations at most, not {count}");
            return Err(CliError::flag(
                "--omega, --alpha-f, --valve-open",
                "",
                allowed,
            ));
        }
        let mut launches = Vec::with_capacity(count);
        for &rate in rates.iter() {
            for &firing_angle in angles.iter() {
                let lean = self
                    .start_lean
                    .and_then(StartLean::fixed)
                    .unwrap_or(firing_angle);
                launches.extend(times.iter().map(|&valve_open| Launch {
                    rate,
                    lean,
                    firing_angle,
                    valve_open,
                }));
            }
        }
        Ok(launches)
    }

    /// Why the jump of `launch`, on a line of the batch if there is one, could not be computed.
    fn failed(&self, launch: &Launch, line: Option<&u64>, source: StanceError) -> CliError {
        let jump = match (&self.batch, line) {
            (Some(path), Some(line)) => format!("{}:{line}", path.display()),
            _ => format!(
                "--omega {} --alpha-f {} --valve-open {}",
                launch.rate, launch.firing_angle, launch.valve_open
            ),
        };
        CliError::Jump { jump, source }
    }
}
