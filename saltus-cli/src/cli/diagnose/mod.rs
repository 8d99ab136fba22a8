//! `saltus diagnose`: what measured data say is wrong with the simulation.

mod bars;
mod inject;
mod known;
mod page;
mod power;
mod replan;
mod report;
mod sheet;
mod steps;
pub(super) mod words;

use std::path::{Path, PathBuf};

use clap::Args;
use saltus::Robot;
use saltus::diagnosis::{Diagnosis, Kind, Known, Misstated, Settings, Sort};
use saltus::experiment::{self, Folder};
use saltus::study::{self, Study, Worth};

use self::inject::InjectFlags;
use self::power::PowerFlags;
use self::replan::{Replan, ReplanFlags};
use self::report::Report;
use super::Status;
use super::common::{OutputFlags, PlotOption, page_file, read_folders, robot};
use crate::error::CliError;
use crate::output::{Format, reachable};
use crate::progress::Progress;

/// Compare measured data with the simulation: name the wrong cause, its size, and what its
/// correction gains
#[derive(Args, Debug)]
#[command(after_help = "`saltus diagnose --help` explains data and output.", after_long_help = LONG_HELP)]
pub(crate) struct Diagnose {
    /// Data folders of one kind: an experiment.toml and a CSV file for each run
    #[arg(
        value_name = "FOLDER",
        required_unless_present_any = ["inject", "power"],
        conflicts_with_all = ["inject", "power"]
    )]
    folders: Vec<PathBuf>,

    /// Robot that the operator believes was measured, in place of the folder's: a built-in one or a
    /// TOML file
    #[arg(long, value_name = "NAME|FILE", help_heading = "Robot and output")]
    robot: Option<String>,

    /// Override a parameter of the robot by its dotted key; may be repeated
    #[arg(
        long = "set",
        value_name = "KEY=VALUE",
        help_heading = "Robot and output"
    )]
    overrides: Vec<String>,

    /// How often data without an effect may be said to have one
    #[arg(long, value_name = "SHARE", value_parser = level, default_value = "0.05", help_heading = "What is claimed")]
    false_alarms: f64,

    /// Error of the simulation itself, in standard deviations of a reading: what is smaller and
    /// smooth is shown, and not claimed [default: 0.1; with a robot 0.4]
    #[arg(long, value_name = "SIGMAS", value_parser = sigmas, help_heading = "What is claimed")]
    model_error: Option<f64>,

    /// What is known apart from the data: a parameter with a standard deviation, in the unit of its
    /// name; may be repeated. Takes the place of what [known] of the folder says of it
    #[arg(
        long,
        value_name = "NAME=VALUE±SD",
        value_parser = knowledge,
        help_heading = "What is claimed"
    )]
    known: Vec<Known>,

    /// Most effects that are looked for at the same time [default: 3; of the kind tank-leg 6]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u8).range(1..=6))]
    #[arg(help_heading = "What is claimed")]
    most: Option<u8>,

    /// Seed of what is drawn by chance
    #[arg(
        long,
        value_name = "NUMBER",
        default_value_t = 1,
        help_heading = "What is claimed"
    )]
    seed: u64,

    /// Write the robot with what was found switched on, on which every other command works
    #[arg(long, value_name = "FILE.toml", help_heading = "Robot and output")]
    extend: Option<PathBuf>,

    /// Write a page with charts to hand on, in one file
    #[arg(long, value_name = "FILE.html", value_parser = page_file, help_heading = "Robot and output")]
    report: Option<PathBuf>,

    #[command(flatten)]
    plot: PlotOption,

    #[command(flatten)]
    replan: ReplanFlags,

    #[command(flatten)]
    power: PowerFlags,

    #[command(flatten)]
    inject: InjectFlags,

    #[command(flatten)]
    output: OutputFlags,
}

const LONG_HELP: &str = "\
Examples:
  saltus diagnose logs/monday --report monday.html
  saltus diagnose logs/monday --extend monday.toml --replan box.toml --report monday.html
  saltus diagnose hopper/static hopper/dynamic-1 --format json
  saltus diagnose drops/tennis-ball --known gravity=9.81±0.02 --known y_m.gain=1±0.003
  saltus diagnose --power plan.toml
  saltus diagnose --power plan.toml --effect air-drag=0.02 --effect mass=2.9 --propose 12
  saltus diagnose --inject coulomb-friction=25 --out synthetic
  saltus diagnose --inject encoder-scale=wheel_angle_rad:1.02 --inject axle-friction=0.3 --kind jump --out both

Every cause on the list is an effect that the simulation leaves out, or a number that it may have wrong. \
They are added one at a time while data that were left out of the fit are predicted better by it than \
chance explains. Rivals are causes that the data cannot tell from the one named. The cause \"unknown\": \
something is left that is not noise and that no cause on the list explains. \"Not identifiable\": the data tell that something holds or \
drives the machine, but neither which of its rivals nor how strong it is; it then says what to measure.

The text says what was found, how well data left out of the fit are predicted before and after, what is \
left in each channel and phase of the runs and whether that is noise, what every cause alone would \
explain, and what to do next. --report writes the same as a page with charts, --plot the residuals before and after.

With --replan a plan for the course is made for the robot as believed, and one for the robot as measured, each with \
margins by which 95 % of drawn jumps hold on that robot. Both are flown on the robot of --plant (without it on the robot as measured) with \
errors that made neither plan, and the report says how many runs pass. The page plays them.

JSON: {\"causes\": [{\"id\", \"column\" (of a sensor), \"parameters\": {name: value}, \"standard_errors\": {name: value}, \
\"intervals_95\": {name: [low, high]: by profile likelihood, null where an end is beyond what physics allows, as is the standard error of a parameter that rests at such a bound; not of a parameter \
that depends on several of the fit}, \"runs_disagree\": [names of parameters about which runs disagree; absent if none], \"rivals\": [ids, two at most], \"less_likely\": [ids that are not excluded either], \"candidates\": [the rivals with their parameters], \"contradicting\": [causes that would do as well and contradict what is known, with the standard deviations that it would take], \"unlisted\" (null, or a term without an id \
that does as well; then a rival is \"unknown\"), \"undetermined\" (null, or a direction of \
the parameters that the data do not tell), \"identifiable\" (false: the data do not limit how strong it is), \"slips\": {name: what slip of unit it equals}, \"loss_falls_by\", \"held_out_loss_falls_by\"}], \"estimated\": {name: {\"value\", \"standard_error\"}: of what nobody states of the machine}, \"alone\": null or, where several causes were found, the one that explains most by itself: {\"id\", \"column\", \"held_out_rms\": {channel: in its unit}}, \"gain\": {channel: \
{\"rms_before\", \"rms_after\", \"noise\" (all in the channel's unit), \"ratio_low\", \"ratio_high\" (95 % interval of after/before)}}, \
\"residuals\": {\"before\": [{\"channel\", \"phase\", \"readings\", \"mean\", \"rms\" (in the channel's unit), \
\"mean_sigma\", \"rms_sigma\" (in standard deviations of the noise), \"lag_1_correlation\" (of each with the \
next), \"correlation_with\": {condition: of the runs' means}, \"p_level\", \"p_whiteness\", \"p_runs\" (how \
likely noise is so large, so smooth, so different between runs), \"is_noise\"}], \"after\": […]}, \"left\" (null, or what the causes leave, where it is much: {\"channel\", \"phase\", \"rms\" in the channel's unit}), \"small\" (null, or what is visible where nothing is claimed: {\"channel\", \"rms\" (in the channel's unit), \"rms_sigma\", \"causes\": [ids that would explain it]}), \"tried\": \
[{\"id\", \"parameters\", \"loss_falls_by\"}: every cause alone], \"data\": {\"hash\", \"rows\", \"runs\", \"notes\"}, \
\"false_alarm_level\", \"next_experiment\": null or {\"what\", \"channel\", \"sigmas\", \"tells_apart\": [[id, id]]}, \
\"worth\": null or {\"distance_m\", \"land_error_rms_m\": [before, after], \"laws\": [{\"slope_s\", \"intercept_rad\"}: of the robot as believed, as measured], \"rows\": [{\"omega_rad_s\", \"alpha_f_rad\", \"land_error_m\": [before, after]}]}, \"replan\": null or {\"course\", \"plant\", \"believed\" and \"measured\" (absent if the robot is as believed): {\"plan\" (false: none crosses the course), \"runs\", \"runs_passed\", \"land_error_mean_m\", \"land_error_sd_m\", \"missed_most\"}}, \"planner_leaves_out\": [keys of \
the corrected robot that only `saltus verify` has], \"misstated_noise\": [{\"column\", \"stated\", \"seen\"}], \"next_steps\": [{\"what\", \"command\" (or null)}]}. The entry with the id \
\"unknown\" has \"channel\", \"phase\", \"rms\" and \"term\" (null, or the term that describes it). The loss is the sum of squared residuals in standard deviations, \
outliers counted less; noise makes it fall by about 1 for each parameter.

CSV columns, one row for each channel: channel, rms_before, rms_after, noise.

With --power no data are needed: plan.toml says what will be measured, and the answer is how often a diagnosis of that would \
name each effect (alone or with two rivals at most), how often nothing, and what it would be taken for. Keys of a plan: kind, robot, \
runs (how many; of outcomes jumps), [noise], [resolution] and [known] as in experiment.toml; [[jump]] of the kinds jump and outcomes, in the \
place of runs: approach_rate_rad_s, firing_angle_rad, valve_open_s, of jump supply_pressure_gauge_psi, and repeat. \
Without --effect every cause is tried at two sizes: those that all readings together show by 6 and by 12 standard deviations of \
noise and of the model's own error (--model-error). --propose gives the jumps of a grid that tell the \
effects apart best. An example:
  kind = \"outcomes\"
  robot = \"rats-boom\"
  noise = { distance_mm = 3, apex_mm = 2 }
  [[jump]]
  approach_rate_rad_s = 4.5
  firing_angle_rad = 0.05
  valve_open_s = 0.08
  repeat = 6

JSON with --power: {\"command\", \"kind\", \"robot\", \"runs\", \"experiments_drawn\", \"effects\": [{\"id\", \"column\", \"parameters\", \"seen_by_sigmas\", \"named\", \"alone\", \"nothing\" (shares), \
\"others\": {id: share}}], \"never_seen\": [ids], \"proposed\" (null without --propose): {\"jumps\": [{approach_rate_rad_s, firing_angle_rad, valve_open_s, supply_pressure_gauge_pa}], \"effects\"}}. CSV: cause (the id), column, parameter, value, seen_by_sigmas, named, alone, nothing; one row for each parameter of an effect.

JSON with --inject: {\"command\", \"kind\", \"seed\", \"runs\", \"rows\", \"causes\": [{\"id\", \"column\", \"parameters\"}]}. CSV: cause, column, parameter, value.

With --inject there is nothing to diagnose: data are made with effects hidden in them, in the folder --out, and the report says \
what they are; the folder does not. CAUSE is an id, VALUE its parameter in the unit of its name, several with commas; of a sensor \
COLUMN:VALUE. A CAUSE that the kind does not have is answered with a list of those that it has.

Runs are CSV or MCAP files (of rosbag2, too, by a mapping of topics to columns). docs/logs.md has the format of the data: columns, units, zeros and signs, keys, and an example of each kind.

The exit code is 0 if nothing is wrong, 1 if something is, or if the data scatter ten times as much as their stated noise.";

fn level(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x <= 0.5 => Ok(x),
        _ => Err("a share above 0, at most 0.5".into()),
    }
}

fn knowledge(text: &str) -> Result<Known, String> {
    let read = || {
        let (name, rest) = text.split_once('=')?;
        let (value, error) = ["±", "+/-", "+-"]
            .iter()
            .find_map(|sign| rest.split_once(sign))?;
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        let (value, error) = (number(value)?, number(error).filter(|x| *x > 0.0)?);
        let name = Some(name.trim().to_owned()).filter(|name| !name.is_empty())?;
        Some(Known { name, value, error })
    };
    read().ok_or_else(|| {
        "must be NAME=VALUE±SD (or +- or +/-), with a standard deviation above 0, such as \
         gravity=9.81±0.02"
            .into()
    })
}

fn sigmas(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if (0.0..=100.0).contains(&x) => Ok(x),
        _ => Err("a number from 0 to 100".into()),
    }
}

/// Data with their model, and what was found.
struct Found {
    folder: Folder,
    robot: Option<Robot>,
    kind: Box<dyn Kind>,
    diagnosis: Diagnosis,
    settings: Settings,
    /// Columns whose noise is stated far from what the data scatter.
    misstated: Vec<Misstated>,
    /// The robot with what was found.
    extended: Option<Robot>,
    /// What knowing it is worth to the planner.
    worth: Option<Worth>,
    /// What it is worth on a course.
    replan: Option<Replan>,
    /// The words with which the command was told its data and where the robot goes.
    asked: steps::Asked,
}

impl Diagnose {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        self.alone()?;
        if self.inject.is_set() {
            return self.inject.run(&self);
        }
        self.output.check()?;
        self.output.ready(&self.plot)?;
        if let Some(plan) = self.power.plan() {
            return self.power.run(plan, &self);
        }
        reachable("--extend", self.extend.as_deref())?;
        reachable("--report", self.report.as_deref())?;
        let mut folder = read_folders(&self.folders)?;
        let robot = self.robot_of(&folder)?;
        if let (Some(path), None) = (&self.extend, &robot) {
            let kind = folder.experiment.kind.spec().id;
            let allowed = format!("left out: data of kind {kind} are about no robot");
            return Err(CliError::flag("--extend", path.display(), allowed));
        }
        experiment::plausible(&folder, robot.as_ref())?;
        let settings = folder.settings(&self.settings());
        let asked_plan = self.replan.asked(robot.as_ref(), self.seed)?;
        let progress = Progress::new("fits", 0);
        let study = study::study(&folder.experiment, robot.as_ref(), &settings, &|_| {
            progress.advance(1);
        });
        drop(progress);
        let study = study.map_err(|error| CliError::content(folder.path.display(), error))?;
        let extended = study.extended();
        let worth = robot
            .as_ref()
            .zip(extended.as_ref())
            .and_then(|(b, e)| study::worth(b, e));
        let corrected = self.corrected(&study, extended.as_ref(), &folder.hash);
        let replan = asked_plan.zip(robot.as_ref());
        let replan = replan
            .map(|(asked, robot)| asked.replan(robot, &study))
            .transpose()?;
        let Study {
            kind,
            diagnosis,
            misstated,
            unused,
        } = study;
        let note = |name: String| format!("known {name} is not used: no cause of this kind has it");
        folder.notes.extend(unused.into_iter().map(note));
        folder.notes.extend(kind.notes());
        if let (Some(path), None) = (&self.extend, &corrected) {
            let path = path.display();
            let why = "nothing was found that is a property of a robot";
            folder.notes.push(format!("{path} is not written: {why}"));
        }
        let asked = steps::Asked {
            folders: self.folders.clone(),
            robot: self.robot.clone(),
            overrides: self.overrides.clone(),
            extend: self.extend.clone(),
        };
        let found = Found {
            folder,
            robot,
            kind,
            diagnosis,
            settings,
            misstated,
            extended,
            worth,
            replan,
            asked,
        };
        self.tell(&found, corrected)
    }

    /// Refuses flags that mean nothing beside --inject or --power, and what is known twice.
    fn alone(&self) -> Result<(), CliError> {
        let (inject, power) = (self.inject.is_set(), self.power.plan().is_some());
        let given = [
            ("--extend", self.extend.is_some(), inject || power),
            ("--report", self.report.is_some(), inject || power),
            ("--replan", self.replan.is_set(), inject || power),
            ("--plot", self.plot.is_set(), inject || power),
            ("--known", !self.known.is_empty(), inject),
            ("--model-error", self.model_error.is_some(), inject),
        ];
        if let Some((flag, ..)) = given.into_iter().find(|(_, set, idle)| *set && *idle) {
            let beside = if inject { "--inject" } else { "--power" };
            let allowed = format!("left out beside {beside}, which diagnoses no data");
            return Err(CliError::flag(flag, "", allowed));
        }
        for (k, known) in self.known.iter().enumerate() {
            if self.known[..k].iter().any(|other| other.name == known.name) {
                return Err(CliError::flag("--known", &known.name, "given once"));
            }
        }
        Ok(())
    }

    /// What the flags choose.
    fn settings(&self) -> Settings {
        Settings {
            false_alarms: self.false_alarms,
            most: self.most.map(usize::from),
            seed: self.seed,
            discrepancy: self.model_error,
            known: self.known.clone(),
            ..Settings::default()
        }
    }

    /// Writes what was found, and the file of the corrected robot, if there is one.
    fn tell(
        &self,
        found: &Found,
        corrected: Option<(&'static str, &Path, String)>,
    ) -> Result<Status, CliError> {
        let report = Report::of(found);
        let text = match self.output.format() {
            Format::Text => report.text(),
            Format::Json => crate::output::json(&report.json()),
            Format::Csv => report.csv(),
        };
        let page = match self.report.as_deref() {
            Some(file) => Some(("--report", file, page::html(&report, &self.folders)?)),
            None => None,
        };
        self.output.write_with(
            text,
            &self.plot,
            || Ok(sheet::sheet(&report)),
            corrected.into_iter().chain(page),
        )?;
        Ok(if report.is_well() && !report.scatters() {
            Status::Done
        } else {
            Status::No
        })
    }

    /// The robot that was measured, as the flags or else the folder say; none where the kind is
    /// about none.
    fn robot_of(&self, folder: &Folder) -> Result<Option<Robot>, CliError> {
        let kind = folder.experiment.kind;
        if let (Some(name), Sort::Machine | Sort::Walk | Sort::TankLeg) = (&self.robot, kind) {
            let allowed = format!(
                "left out: data of kind {} are of the machine that [rig] describes",
                kind.spec().id
            );
            return Err(CliError::flag("--robot", name, allowed));
        }
        let name = self.robot.clone().or_else(|| folder.robot_name());
        name.map(|name| robot(&name, &self.overrides)).transpose()
    }

    /// The file of the extended robot, where it is asked for and there is one.
    fn corrected(
        &self,
        study: &Study,
        extended: Option<&Robot>,
        hash: &str,
    ) -> Option<(&'static str, &Path, String)> {
        let path = self.extend.as_deref()?;
        let text = study.robot_file(extended?, hash);
        Some(("--extend", path, text))
    }
}
