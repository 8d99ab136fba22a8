//! What every command takes: the robot, and where the answer goes.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::Args;
use saltus::experiment::{self, Folder};
use saltus::on_plant::OnPlant;
use saltus::verify::Verification;
use saltus::{Launch, Robot};

use super::recorded::Beside;
use crate::error::CliError;
use crate::input;
use crate::output::{Files, Format, message, reachable, reachable_folder};
use crate::plot::PlotFile;
use crate::plot::sheet::Sheet;
use crate::progress::Progress;
use crate::range::{Values, frictions};
use crate::session;

/// The robot where none is named.
const USUAL: &str = "rats-planar";

/// Which robot.
#[derive(Args, Debug)]
#[command(next_help_heading = "Robot and output")]
pub(crate) struct RobotFlags {
    /// Robot: a built-in one (rats-planar, rats-boom, rats-run, spring-hopper, table-hopper) or a TOML file
    /// [default: rats-planar]
    #[arg(long, value_name = "NAME|FILE")]
    robot: Option<String>,

    /// Override a parameter of the robot by its dotted key, as in leg.stroke_m=0.05; may be
    /// repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

impl RobotFlags {
    /// The robot that is named.
    pub(crate) fn name(&self) -> Option<&str> {
        self.robot.as_deref()
    }

    /// That robot, `name` where none is named, with these overrides.
    pub(crate) fn or(self, name: Option<String>, overrides: Vec<String>) -> RobotFlags {
        RobotFlags {
            robot: self.robot.or(name),
            overrides,
        }
    }

    /// How it is changed.
    pub(crate) fn overrides(&self) -> &[String] {
        &self.overrides
    }

    /// The robot with its overrides, `usual` where none is named; none without either.
    pub(crate) fn robot_if_any(&self, usual: Option<String>) -> Result<Option<Robot>, CliError> {
        let name = self.robot.clone().or(usual);
        name.map(|name| robot(&name, &self.overrides)).transpose()
    }

    /// The robot with its overrides.
    pub(crate) fn robot(&self) -> Result<Robot, CliError> {
        self.robot_or(USUAL)
    }

    /// The robot with its overrides, the built-in `usual` where none is named.
    pub(crate) fn robot_or(&self, usual: &str) -> Result<Robot, CliError> {
        robot(self.robot.as_deref().unwrap_or(usual), &self.overrides)
    }

    /// The robot with its overrides, which may move in space.
    pub(crate) fn any_robot(&self) -> Result<Robot, CliError> {
        self.any_robot_or(USUAL)
    }

    /// The same, the built-in `usual` where none is named.
    pub(crate) fn any_robot_or(&self, usual: &str) -> Result<Robot, CliError> {
        any_robot(self.robot.as_deref().unwrap_or(usual), &self.overrides)
    }

    /// The robot with its overrides, for the planar model: says what of it that model leaves out, and
    /// that jumps do not empty its tank.
    pub(crate) fn planned_robot(&self) -> Result<Robot, CliError> {
        let robot = self.emptying_robot()?;
        if robot.tank.is_some_and(|tank| tank.volume.is_finite()) {
            message(&format!(
                "note: robot {}: each jump of this command starts with a full tank; `saltus \
                 filling` empties it",
                robot.name
            ));
        }
        Ok(robot)
    }

    /// The robot with its overrides, for the planar model, where its tank empties.
    pub(crate) fn emptying_robot(&self) -> Result<Robot, CliError> {
        let robot = self.robot()?;
        let ignored = robot.beyond_the_plane();
        if !ignored.is_empty() {
            let ignored = left_out_words(&ignored);
            message(&format!(
                "note: robot {}: the planar model of this command leaves out {ignored}; `saltus \
                 verify` simulates it",
                robot.name
            ));
        }
        Ok(robot)
    }
}

/// Keys that the planar model leaves out, with what of them it leaves out if that is not all.
pub(crate) fn left_out_words(keys: &[String]) -> String {
    let words = |key: &String| match key.as_str() {
        "leg.mass_kg" => "leg.mass_kg (legs that move in the wheel)".to_owned(),
        "boom.length_m" => "boom.length_m (the arc of the boom)".to_owned(),
        _ => key.clone(),
    };
    let all: Vec<String> = keys.iter().map(words).collect();
    all.join(", ")
}

/// The robot that jumps, where it is not the one planned for.
#[derive(Args, Debug)]
#[command(next_help_heading = "The robot that jumps")]
pub(crate) struct PlantFlags {
    /// Robot that jumps, where it is not the one planned for: a built-in one or a TOML file
    #[arg(long, value_name = "NAME|FILE")]
    plant: Option<String>,

    /// Override a parameter of the robot that jumps; may be repeated
    #[arg(long = "plant-set", value_name = "KEY=VALUE")]
    plant_overrides: Vec<String>,
}

impl PlantFlags {
    /// The robot that jumps, if a flag names or changes one.
    pub(crate) fn robot(&self, common: &RobotFlags) -> Result<Option<Robot>, CliError> {
        match (&self.plant, self.plant_overrides.is_empty()) {
            (Some(name), _) => robot(name, &self.plant_overrides).map(Some),
            (None, true) => Ok(None),
            (None, false) => {
                let all = [common.overrides.as_slice(), &self.plant_overrides].concat();
                let named = common.robot.as_deref().unwrap_or(USUAL);
                robot(named, &all).map(Some)
            }
        }
    }

    /// The robot that is planned for, and the plant on which the answers have to hold, if there is
    /// one; without, says what of the robot the planar model leaves out.
    pub(crate) fn on_plant(
        &self,
        common: &RobotFlags,
    ) -> Result<(Robot, Option<OnPlant>), CliError> {
        if self.plant.is_none() && self.plant_overrides.is_empty() {
            return Ok((common.planned_robot()?, None));
        }
        let (planned, plant) = self.always(common)?;
        Ok((planned, Some(plant)))
    }

    /// The robot that is planned for, and the plant: itself, where no flag says otherwise.
    pub(crate) fn always(&self, common: &RobotFlags) -> Result<(Robot, OnPlant), CliError> {
        let planned = common.robot()?;
        let plant = match self.robot(common)? {
            Some(plant) => plant,
            None => planned.clone(),
        };
        let on_plant = OnPlant::new(&planned, &plant).map_err(|error| {
            let name = self.plant.as_deref().unwrap_or(&plant.name);
            CliError::content(name, error)
        })?;
        Ok((planned, on_plant))
    }
}

/// Most legs of a wheel: each is a body of the simulation.
const MOST_LEGS: u32 = 1000;

/// The robot `name`, built in or in a file, with `overrides`, which moves in its plane; what looks like a slip of unit is
/// said.
pub(crate) fn robot(name: &str, overrides: &[String]) -> Result<Robot, CliError> {
    let robot = any_robot(name, overrides)?;
    if robot.space.is_some() {
        let reason = "body.shape = sphere: must be wheel for this command; a robot in space rolls by `saltus run`; \
                      `saltus export mjcf`, `urdf` and `gait disc-stable` write it for other programs";
        return Err(CliError::content(name, reason));
    }
    Ok(robot)
}

/// The same, which may move in space.
pub(crate) fn any_robot(name: &str, overrides: &[String]) -> Result<Robot, CliError> {
    let mut robot = match session::file(name) {
        Some(text) => saltus::robot::resolve_text(&text, name, overrides)?,
        None => saltus::robot::resolve_from(name, overrides, &input::note)?,
    };
    input::spared()?;
    // Titles are one line.
    let words = robot
        .name
        .split(|c: char| c.is_whitespace() || c.is_control())
        .filter(|word| !word.is_empty());
    robot.name = words.collect::<Vec<_>>().join(" ");
    if robot.body.legs > MOST_LEGS {
        let reason = format!(
            "body.legs = {}: must be a whole number from 1 to {MOST_LEGS}",
            robot.body.legs
        );
        return Err(CliError::content(name, reason));
    }
    for odd in robot.implausible() {
        message(&format!("warning: robot {}: {odd}", robot.name));
    }
    Ok(robot)
}

/// The experiment in data folders, with all that the files say of it.
pub(crate) fn read_folders(folders: &[PathBuf]) -> Result<Folder, CliError> {
    for file in folders.iter().flat_map(|folder| experiment::files(folder)) {
        input::note(&file);
    }
    input::spared()?;
    let progress = Progress::new("rows", 0);
    Ok(experiment::read_all(folders, &|n| progress.advance(n))?)
}

/// Says on standard error that `given`, a flag with a valve opening time, has no effect on `robot`,
/// if its leg has no valve.
pub(crate) fn note_valve(robot: &Robot, given: Option<&str>) {
    if let (Some(given), false) = (given, robot.leg.drive.has_valve()) {
        message(&format!(
            "note: the leg of {} has no valve: {given} has no effect",
            robot.name
        ));
    }
}

/// The valve opening time (s) of a launch; of a leg without a valve none.
pub(crate) fn opening(robot: &Robot, launch: &Launch) -> Option<f64> {
    let has_valve = robot.leg.drive.has_valve();
    has_valve.then_some(launch.valve_open)
}

/// Options of every command that reports.
#[derive(Args, Debug)]
#[command(next_help_heading = "Robot and output")]
pub(crate) struct Common {
    #[command(flatten)]
    pub(crate) robot: RobotFlags,

    #[command(flatten)]
    pub(crate) plot: PlotOption,

    #[command(flatten)]
    output: OutputFlags,
}

/// How the answer is written.
#[derive(Args, Debug)]
#[command(next_help_heading = "Robot and output")]
pub(crate) struct FormatFlag {
    /// Format of the report; without it as --out's ending says (.json, .csv), else text
    #[arg(long, value_enum)]
    format: Option<Format>,
}

/// The file to which the answer goes.
#[derive(Args, Debug)]
#[command(next_help_heading = "Robot and output")]
pub(crate) struct OutFile {
    /// Write to this file instead of standard output
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// The folder to which several files go.
#[derive(Args, Debug)]
#[command(next_help_heading = "Robot and output")]
pub(crate) struct OutFolder {
    /// Write the files into this folder, which is made if it is not there
    #[arg(long, short, value_name = "FOLDER")]
    out: PathBuf,
}

/// Where the answer goes.
#[derive(Args, Debug)]
pub(crate) struct OutputFlags {
    #[command(flatten)]
    format: FormatFlag,

    #[command(flatten)]
    out: OutFile,
}

/// The option of commands that draw by chance.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Seed {
    /// Seed of what is drawn by chance
    #[arg(long, value_name = "SEED", default_value_t = 1, allow_negative_numbers = true, value_parser = seed)]
    pub(crate) seed: u64,
}

/// Parser of a flag.
pub(crate) fn seed(text: &str) -> Result<u64, String> {
    let wrong = |_| format!("must be a whole number from 0 to {}", u64::MAX);
    text.trim().parse().map_err(wrong)
}

/// The option of commands with much to compute.
#[derive(Args, Debug)]
pub(crate) struct Threads {
    /// Threads to work with; the answer does not depend on it [default: as many as the machine has]
    #[arg(long, value_name = "COUNT", value_parser = threads, help_heading = "Robot and output")]
    threads: Option<NonZeroUsize>,
}

impl Threads {
    /// Most threads that are of use.
    const MOST: usize = 256;

    /// How many.
    pub(crate) fn count(&self) -> NonZeroUsize {
        let most = NonZeroUsize::MIN.saturating_add(Threads::MOST - 1);
        self.threads
            .or_else(|| std::thread::available_parallelism().ok())
            .unwrap_or(NonZeroUsize::MIN)
            .min(most)
    }
}

/// Which runs with drawn errors have to pass.
#[derive(Args, Debug)]
#[command(next_help_heading = "Errors")]
pub(crate) struct ErrorFlags {
    /// Share of the runs with drawn errors that have to pass
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true, value_parser = share)]
    pub(crate) share: Option<f64>,

    /// Runs with errors drawn from the robot's [errors]
    #[arg(long, value_name = "COUNT", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(0..=100_000))]
    samples: Option<u32>,

    /// Friction coefficients of the ground, which take turns [default: the robot's own]
    #[arg(long, value_name = "COEFFICIENTS", allow_negative_numbers = true, value_parser = frictions)]
    friction: Option<Values>,

    #[command(flatten)]
    seed: Seed,

    #[command(flatten)]
    threads: Threads,
}

impl ErrorFlags {
    pub(crate) fn seed(&self) -> u64 {
        self.seed.seed
    }

    /// The runs: so many with errors drawn, of which this share has to pass, where no flags say
    /// otherwise.
    pub(crate) fn verification(&self, samples: usize, share: f64) -> Verification {
        let ground = self.friction.as_ref();
        Verification {
            samples: self.samples.map_or(samples, |count| count as usize),
            seed: self.seed.seed,
            frictions: ground.map_or(vec![None], |them| them.iter().copied().map(Some).collect()),
            share: self.share.unwrap_or(share),
            threads: self.threads.count().get(),
            ..Verification::default()
        }
    }
}

/// Parser of a flag.
fn share(text: &str) -> Result<f64, String> {
    let share = text.trim().parse().ok();
    share
        .filter(|share| (0.0..=1.0).contains(share))
        .ok_or_else(|| "must be a share from 0 to 1, as in 0.95".into())
}

/// The option of commands with something to see.
#[derive(Args, Debug)]
#[command(next_help_heading = "Robot and output")]
pub(crate) struct PlotOption {
    /// Draw the answer to this file, .svg or .png
    #[arg(long, value_name = "FILE.svg|FILE.png", value_parser = PlotFile::parse)]
    plot: Option<PlotFile>,
}

impl PlotOption {
    /// Whether a plot is asked for.
    pub(crate) fn is_set(&self) -> bool {
        self.plot.is_some()
    }

    /// The file to draw to, if one is asked for.
    pub(crate) fn path(&self) -> Option<&Path> {
        self.plot.as_ref().map(PlotFile::path)
    }

    /// Adds the plot to `files`, if one is asked for.
    pub(crate) fn add_to(
        &self,
        files: &mut Files,
        drawing: impl FnOnce() -> Result<Sheet, CliError>,
    ) -> Result<(), CliError> {
        if let Some(plot) = &self.plot {
            files.add("--plot", plot.path(), plot.draw(&drawing()?)?);
        }
        Ok(())
    }
}

impl Common {
    /// Refuses files that cannot be written, before long work.
    pub(crate) fn ready(&self) -> Result<(), CliError> {
        self.output.ready(&self.plot)
    }

    /// Writes the report and the plot, if one is asked for: both or neither.
    pub(crate) fn write(
        &self,
        report: String,
        drawing: impl FnOnce() -> Result<Sheet, CliError>,
    ) -> Result<(), CliError> {
        self.write_with(report, drawing, None)
    }

    /// The same with more files: the flag, the name and the contents of each.
    pub(crate) fn write_with<'a>(
        &self,
        report: String,
        drawing: impl FnOnce() -> Result<Sheet, CliError>,
        more: impl IntoIterator<Item = Beside<'a>>,
    ) -> Result<(), CliError> {
        let output = &self.output;
        output.write_with(report, &self.plot, drawing, more)
    }
}

impl std::ops::Deref for Common {
    type Target = OutputFlags;
    fn deref(&self) -> &OutputFlags {
        &self.output
    }
}

impl FormatFlag {
    /// The format, where the flag asks for one.
    pub(crate) fn asked(&self) -> Option<Format> {
        self.format
    }
}

impl OutFile {
    /// Refuses a file that cannot be written, before long work.
    pub(crate) fn ready(&self) -> Result<(), CliError> {
        let file = self.out.as_deref().filter(|out| *out != Path::new("-"));
        reachable("--out", file)
    }

    /// Writes `text`.
    pub(crate) fn write(&self, text: String) -> Result<(), CliError> {
        let mut files = Files::default();
        files.report(self.out.as_deref(), text);
        files.write()
    }
}

impl OutFolder {
    pub(crate) fn path(&self) -> &Path {
        &self.out
    }

    /// Refuses a folder that cannot be written, before long work.
    pub(crate) fn ready(&self) -> Result<(), CliError> {
        reachable_folder(&self.out)
    }

    /// Writes `texts`, by their names, and prints what heads them.
    pub(crate) fn write<'a>(
        &self,
        texts: impl IntoIterator<Item = (&'a str, String)>,
        about: &[String],
    ) -> Result<(), CliError> {
        std::fs::create_dir_all(&self.out).map_err(|error| CliError::write(&self.out, error))?;
        let mut files = Files::default();
        for (name, text) in texts {
            files.add("--out", &self.out.join(name), text.into_bytes());
        }
        files.report(None, about.join("\n") + "\n");
        files.write()
    }
}

impl OutputFlags {
    /// The format asked for.
    pub(crate) fn format(&self) -> Format {
        let by_name = || self.out().and_then(Format::of_file);
        self.format.asked().or_else(by_name).unwrap_or(Format::Text)
    }

    /// Where the answer goes, if not to standard output.
    pub(crate) fn out(&self) -> Option<&Path> {
        self.out.out.as_deref()
    }

    /// Refuses a file whose ending stands for a format that reports do not have, unless a flag
    /// names the format.
    pub(crate) fn check(&self) -> Result<(), CliError> {
        let Some(out) = self.out().filter(|_| self.format.asked().is_none()) else {
            return Ok(());
        };
        let Some(ending) = out.extension() else {
            return Ok(());
        };
        let ending = ending.to_string_lossy().to_ascii_lowercase();
        if Format::ENDINGS.iter().any(|(known, _)| *known == ending) {
            return Ok(());
        }
        let known = Format::ENDINGS.map(|(known, _)| format!(".{known}"));
        let allowed = format!(
            "a name that ends in {} or in nothing, or beside --format",
            known.join(", ")
        );
        Err(CliError::flag("--out", out.display(), allowed))
    }

    /// Refuses a report and a plot that cannot be written, before long work.
    pub(crate) fn ready(&self, plot: &PlotOption) -> Result<(), CliError> {
        self.report_ready()?;
        reachable("--plot", plot.path())
    }

    /// Refuses a report that cannot be written, before long work.
    pub(crate) fn report_ready(&self) -> Result<(), CliError> {
        self.check()?;
        self.out.ready()
    }

    /// Writes the report alone.
    pub(crate) fn write_report(&self, report: String) -> Result<(), CliError> {
        self.out.write(report)
    }

    /// Writes the report, the plot, if one is asked for, and more files, of each the flag, the name and the
    /// contents: all or none.
    pub(crate) fn write_with<'a, T: Into<Vec<u8>>>(
        &self,
        report: String,
        option: &PlotOption,
        drawing: impl FnOnce() -> Result<Sheet, CliError>,
        more: impl IntoIterator<Item = (&'static str, &'a Path, T)>,
    ) -> Result<(), CliError> {
        let mut files = Files::default();
        option.add_to(&mut files, drawing)?;
        for (flag, path, contents) in more {
            files.add(flag, path, contents.into());
        }
        files.report(self.out(), report);
        files.write()
    }
}

/// Parser of a flag.
fn threads(text: &str) -> Result<NonZeroUsize, String> {
    text.trim()
        .parse()
        .map_err(|_| "must be a whole number, 1 or more".into())
}

/// Parser of a flag.
pub(crate) fn page_file(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_page = path
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("html"));
    if is_page {
        Ok(path)
    } else {
        Err("the name must end in .html".into())
    }
}
