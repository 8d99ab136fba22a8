//! `saltus diagnose`: what measured data say is wrong with the simulation.

mod blocks;
mod check;
mod evidence;
mod known;
mod page;
mod replan;
mod report;
mod steps;
pub(super) mod words;

use std::path::{Path, PathBuf};

use clap::Args;
use saltus::Robot;
use saltus::diagnosis::{Diagnosis, Kind, Known, Misstated, Settings, Sort};
use saltus::experiment::{self, Folder};
use saltus::on_plant::OnPlant;
use saltus::study::{self, Study, Worth};

use self::evidence::{Data, Evidence};
use self::replan::{Course, Replan};
use self::report::Report;
use super::Status;
use super::common::{OutputFlags, PlantFlags, RobotFlags, Seed, page_file, read_folders};
use crate::error::CliError;
use crate::input;
use crate::output::{Files, Format, json, reachable};
use crate::progress::Progress;

/// Compare measured data with the simulation: name the wrong cause, its size, and what its
/// correction gains
#[derive(Args, Debug)]
#[command(
    after_help = "`saltus diagnose --help` explains data and output.",
    after_long_help = LONG_HELP,
    mut_arg("robot", |robot| robot.help("Robot that the operator believes was measured, in place of the folder's: a built-in one or a TOML file")),
    mut_arg("plant", |plant| plant.requires("replan").help("Robot that jumps both plans: a built-in one or a TOML file [default: the robot as measured]")),
    mut_arg("plant_overrides", |overrides| overrides.requires("plant"))
)]
pub(crate) struct Diagnose {
    /// Data folders of one kind: an experiment.toml and a CSV file for each run
    #[arg(value_name = "FOLDER", required = true)]
    folders: Vec<PathBuf>,

    #[command(flatten)]
    claims: Claims,

    /// Course to plan for the robot as believed and for the robot as measured: says how many jumps
    /// of each plan pass
    #[arg(long, value_name = "COURSE.toml")]
    replan: Option<PathBuf>,

    #[command(flatten)]
    plant: PlantFlags,

    #[command(flatten)]
    robot: RobotFlags,

    /// Write the robot with what was found switched on, on which every other command works
    #[arg(long, value_name = "FILE.toml", help_heading = "Robot and output")]
    extend: Option<PathBuf>,

    /// Write the evidence of the answer as JSON: hashes of the data, options, and every set of causes
    /// that competed, with its odds
    #[arg(long, value_name = "FILE", help_heading = "Robot and output")]
    evidence: Option<PathBuf>,

    /// Compute the evidence in this file again, from the same data with its options, and compare
    #[arg(long, value_name = "FILE", help_heading = "Robot and output", conflicts_with_all = DECIDED)]
    check: Option<PathBuf>,

    /// Write a page with charts to hand on, in one file
    #[arg(long, value_name = "FILE.html", value_parser = page_file, help_heading = "Robot and output")]
    report: Option<PathBuf>,

    #[command(flatten)]
    output: OutputFlags,
}

/// Flags that mean nothing beside `--check`: its file has what decides an answer, and no report is made.
const DECIDED: [&str; 10] = [
    "model_error",
    "known",
    "most",
    "seed",
    "overrides",
    "replan",
    "plant",
    "extend",
    "report",
    "evidence",
];

/// Most effects that `--most` takes.
const MOST: u8 = 6;

/// What a diagnosis goes by beside its data.
#[derive(Args, Debug)]
#[command(next_help_heading = "What is claimed")]
pub(super) struct Claims {
    /// Error of the simulation itself, in standard deviations of a reading: what is smaller and
    /// smooth is not claimed [default: 0.1; with a robot 0.4]
    #[arg(long, value_name = "SIGMAS", allow_negative_numbers = true, value_parser = sigmas)]
    model_error: Option<f64>,

    /// What is known apart from the data: a parameter with a standard deviation, in the unit of its
    /// name; may be repeated. Takes the place of what [known] of the folder says of it
    #[arg(long, value_name = "NAME=VALUE±SD", value_parser = knowledge)]
    known: Vec<Known>,

    /// Most effects that are looked for at the same time [default: 3; of the kind tank-leg 6]
    #[arg(long, value_name = "COUNT", allow_negative_numbers = true, value_parser = clap::value_parser!(u8).range(1..=i64::from(MOST)))]
    most: Option<u8>,

    #[command(flatten)]
    seed: Seed,
}

impl Claims {
    /// What the flags choose.
    pub(super) fn settings(&self) -> Result<Settings, CliError> {
        for (k, known) in self.known.iter().enumerate() {
            if self.known[..k].iter().any(|other| other.name == known.name) {
                return Err(CliError::flag("--known", &known.name, "given once"));
            }
        }
        Ok(Settings {
            most: self.most.map(usize::from),
            seed: self.seed.seed,
            discrepancy: self.model_error,
            known: self.known.clone(),
            ..Settings::default()
        })
    }
}

const LONG_HELP: &str = "\
Examples:
  saltus diagnose logs/monday --report monday.html
  saltus diagnose logs/monday --extend monday.toml --replan box.toml --report monday.html
  saltus diagnose hopper/static hopper/dynamic-1 --format json
  saltus diagnose drops/tennis-ball --known gravity=9.81±0.02 --known y_m.gain=1±0.003
  saltus diagnose logs/monday --evidence monday.json
  saltus diagnose logs/monday --check monday.json

Every cause on the list is an effect that the simulation leaves out, or a number that it may have wrong. \
Sets of them are weighed by how probable the data are with each: what explains no more than chance does is not \
claimed. Rivals are causes that the data cannot tell from the one named: less than 7 to 1. The cause \"unknown\": \
something is left that is not noise and that no cause on the list explains. \"Not identifiable\": the data tell that something holds or \
drives the machine, but neither which of its rivals nor how strong it is; it then says what to measure.

The text says what was found, how well data left out of the fit are predicted before and after, what is \
left in each channel and phase of the runs and whether that is noise, what every cause alone would \
explain, and what to do next. --report writes the same as a page with charts.

With --replan a plan for the course is made for the robot as believed, and one for the robot as measured, each with \
margins by which 95 % of drawn jumps hold on that robot. Both are flown on the robot of --plant (without it on the robot as measured) with \
errors that made neither plan, and the report says how many of 200 runs pass.

JSON: {\"causes\": [{\"id\", \"column\" (of a sensor), \"parameters\": {name: value}, \"standard_errors\": {name: value}, \
\"intervals_95\": {name: [low, high]: by profile likelihood, null where an end is beyond what physics allows, as is the standard error of a parameter that rests at such a bound; not of a parameter \
that depends on several of the fit}, \"runs_disagree\": [names of parameters about which runs disagree; absent if none], \"rivals\": [ids, two at most], \"less_likely\": [ids that are not excluded either], \"candidates\": [the rivals with their parameters], \"contradicting\": [causes that would do as well and contradict what is known, with the standard deviations that it would take], \"unlisted\" (null, or a term without an id \
that does as well; then a rival is \"unknown\"), \"undetermined\" (null, or a direction of \
the parameters that the data do not tell), \"identifiable\" (false: the data do not limit how strong it is), \"slips\": {name: what slip of unit it equals}, \"log_odds\", \"held_out_loss_falls_by\"}], \"estimated\": {name: {\"value\", \"standard_error\"}: of what nobody states of the machine}, \"alone\": null or, where several causes were found, the one that explains most by itself: {\"id\", \"column\", \"held_out_rms\": {channel: in its unit}}, \"gain\": {channel: \
{\"rms_before\", \"rms_after\", \"noise\" (all in the channel's unit), \"ratio_low\", \"ratio_high\" (95 % interval of after/before)}}, \
\"residuals\": {\"before\": [{\"channel\", \"phase\", \"readings\", \"mean\", \"rms\" (in the channel's unit), \
\"mean_sigma\", \"rms_sigma\" (in standard deviations of the noise), \"lag_1_correlation\" (of each with the \
next), \"correlation_with\": {condition: of the runs' means}, \"p_level\", \"p_whiteness\", \"p_runs\" (how \
likely noise is so large, so smooth, so different between runs), \"is_noise\"}], \"after\": […]}, \"noise\": {channel: {\"of_stated\": noise in terms of the stated or estimated one, \"follows\": correlation of each reading's noise with the one before, \"model_error_sigma\": error of the simulation itself in standard deviations, \"is_noise\"}}, \"tried\": \
[{\"id\", \"parameters\", \"log_odds\"}: every cause alone], \"data\": {\"hash\", \"rows\", \"runs\", \"notes\"}, \
\"next_experiment\": null or {\"what\", \"channel\", \"sigmas\", \"tells_apart\": [[id, id]]}, \
\"worth\": null or {\"distance_m\", \"land_error_rms_m\": [before, after], \"laws\": [{\"slope_s\", \"intercept_rad\"}: of the robot as believed, as measured], \"rows\": [{\"omega_rad_s\", \"alpha_f_rad\", \"land_error_m\": [before, after]}]}, \"replan\": null or {\"course\", \"plant\", \"believed\" and \"measured\" (absent if the robot is as believed): null if no plan crosses the course, or {\"runs\", \"runs_passed\", \"land_error_mean_m\", \"land_error_sd_m\", \"missed_most\"}}, \"planner_leaves_out\": [keys of \
the corrected robot that only `saltus verify` has], \"misstated_noise\": [{\"column\", \"stated\", \"seen\"}], \"next_steps\": [{\"what\", \"command\" (or null)}]}. The entry with the id \
\"unknown\" has \"channel\", \"phase\", \"rms\" and \"term\" (null, or the term that describes it). \"log_odds\" is the natural logarithm of how many times as probable the data are with the cause. \
\"held_out_loss_falls_by\" is of the sum of squared residuals in standard deviations, outliers counted less; noise makes it fall by about 1 for each parameter.

CSV columns, one row for each channel: channel, rms_before, rms_after, noise.

--evidence writes what the answer rests on: {\"evidence_format\": 1, \"saltus_version\", \"data\": [{\"folder\", \"sha256\": {file: of its bytes}}], \
\"kind\", \"robot\", \"robot_sha256\", \"options\": {\"robot\", \"set\", \"model_error\", \"known\", \"most\", \"seed\": no set depends on it, it draws intervals of the gain}, \
\"answer\": {\"causes\", \"unknown\" (whether something is), \"noise\"}, \"sets\": [{\"causes\": [{\"id\", \"column\", \"parameters\"}], \
\"log_odds\" (of the set, beside no cause), \"log_odds_unlisted\" (the same where something that is not on the list is at work, too), \"is_answer\"}: every set that was fitted, the most probable first]}.

--check makes that diagnosis again, with the options in the file, and compares the bytes of the data, the robot, the answer (parameters within 0.1 standard errors), and the odds \
of every set (within 0.05 nats and 0.1 % of what it is behind the best; sets that are less probable than the best by 1000 to 1 need not be in both). --robot beside it says where the file of that robot is now. \
Its JSON: {\"check\", \"holds\", \"differences\": [sentences], \"sets\": null or {\"count\", \"agreeing\", \"log_odds_differ_by\" (greatest, nats)}, \"notes\"}.

Runs are CSV or MCAP files (of rosbag2, too, by a mapping of topics to columns). docs/logs.md has the format of the data: columns, units, zeros and signs, keys, and an example of each kind.

The exit code is 0 if nothing is wrong, 1 if something is, or if the data scatter ten times as much as their stated noise; with --check 0 if the evidence holds, 1 if not.";

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
struct Found<'a> {
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
    /// The flags.
    asked: &'a Diagnose,
}

/// The diagnosis of a folder; says how far it is.
fn studied(folder: &Folder, robot: Option<&Robot>, settings: &Settings) -> Result<Study, CliError> {
    let progress = Progress::new("diagnosis", 0);
    let study = study::study(&folder.experiment, robot, settings, &|stage| {
        progress.note(&format!("{:.0} %, {}", 100.0 * stage.share, stage.doing));
    });
    drop(progress);
    study.map_err(|error| CliError::content(folder.path.display(), error))
}

impl Diagnose {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        self.output.report_ready()?;
        reachable("--extend", self.extend.as_deref())?;
        reachable("--report", self.report.as_deref())?;
        reachable("--evidence", self.evidence.as_deref())?;
        if let Some(file) = &self.check {
            let file = file.clone();
            return check::run(self, &file);
        }
        let mut folder = read_folders(&self.folders)?;
        let robot = self.robot_of(&folder)?;
        for (flag, path) in [("--extend", &self.extend), ("--replan", &self.replan)] {
            if let (Some(path), None) = (path, &robot) {
                let kind = folder.experiment.kind.spec().id;
                let allowed = format!("left out: data of kind {kind} are about no robot");
                return Err(CliError::flag(flag, path.display(), allowed));
            }
        }
        experiment::plausible(&folder, robot.as_ref())?;
        let settings = folder.settings(&self.claims.settings()?);
        let course = self.replan.as_deref().zip(robot.as_ref());
        let course = course.map(|(file, robot)| self.course(file, robot));
        let course = course.transpose()?;
        let data = self.evidence.as_ref().map(|_| Data::of(&self.folders));
        let data = data.transpose()?;
        let study = studied(&folder, robot.as_ref(), &settings)?;
        let evidence =
            data.map(|data| Evidence::of(&self, (&folder, data), robot.as_ref(), &study));
        let extended = study.extended();
        let both = robot.as_ref().zip(extended.as_ref());
        let worth = both.and_then(|(believed, found)| study::worth(believed, found));
        let corrected = self.corrected(&study, extended.as_ref(), &folder.hash);
        let replan = course.zip(robot.as_ref());
        let replan = replan.map(|((course, plant), robot)| {
            let jumper = plant.as_ref().or(extended.as_ref()).unwrap_or(robot);
            let robots = [Some(robot), extended.as_ref()];
            Replan::new(course, robots, jumper, settings.seed)
        });
        let replan = replan.transpose()?;
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
            asked: &self,
        };
        self.tell(&found, corrected, evidence.as_ref())
    }

    /// The course to plan anew, and the robot that jumps if a flag names one.
    fn course(&self, file: &Path, robot: &Robot) -> Result<(Course, Option<Robot>), CliError> {
        let plant = self.plant.robot(&self.robot)?;
        if let Some(plant) = &plant {
            OnPlant::new(robot, plant).map_err(|error| CliError::content(&plant.name, error))?;
        }
        let crossing = input::course(file)?;
        Ok(((file.display().to_string(), crossing), plant))
    }

    /// Writes what was found, and the files of the corrected robot and of the evidence, if there are such.
    fn tell(
        &self,
        found: &Found<'_>,
        corrected: Option<(&'static str, &Path, String)>,
        evidence: Option<&Evidence>,
    ) -> Result<Status, CliError> {
        let report = Report::of(found);
        let text = match self.output.format() {
            Format::Text => report.text(),
            Format::Json => json(&report.json()),
            Format::Csv => report.csv(),
        };
        let page = |file| ("--report", file, page::html(&report, &self.folders));
        let page = self.report.as_deref().map(page);
        let mut files = Files::default();
        let evidence = self.evidence.as_deref().zip(evidence);
        let evidence = evidence.map(|(file, it)| ("--evidence", file, json(&it.json())));
        for (flag, path, text) in corrected.into_iter().chain(page).chain(evidence) {
            files.add(flag, path, text.into_bytes());
        }
        files.report(self.output.out(), text);
        files.write()?;
        Ok(Status::of(report.is_well() && !report.scatters()))
    }

    /// The robot that was measured, as the flags or else the folder say; none where the kind is
    /// about none.
    fn robot_of(&self, folder: &Folder) -> Result<Option<Robot>, CliError> {
        let kind = folder.experiment.kind;
        if let (Some(name), Sort::Machine | Sort::Walk | Sort::TankLeg) = (self.robot.name(), kind)
        {
            let allowed = format!(
                "left out: data of kind {} are of the machine that [rig] describes",
                kind.spec().id
            );
            return Err(CliError::flag("--robot", name, allowed));
        }
        self.robot.robot_if_any(folder.robot_name())
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
