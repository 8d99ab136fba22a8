//! What was found, in words and in numbers.

use saltus::diagnosis::{
    Alone, Candidate, Channel, Diagnosis, Finding, Gain, Kind, Misstated, PhaseResidual, Point,
    Reported, Unknown, outliers, residuals,
};
use saltus::experiment::Folder;
use saltus::study::Worth;
use serde_json::{Map, Value, json};

use super::blocks::{self, Block, Charts, Lead};
use super::known;
use super::replan::Replan;
use super::steps::{Step, left_out, newly_left_out, steps};
use super::words::{estimate, interval, misstated, slip_of};
use super::{Found, MOST};
use crate::cli::common::left_out_words;
use crate::output::{Column, Table, cells, columns, digits, joined, split, unit, with_unit};

/// What is reported of a diagnosis.
pub(super) struct Report<'a> {
    pub(super) found: &'a Found<'a>,
    /// What is left by channel and phase, by the model as it is.
    pub(super) before: Vec<PhaseResidual>,
    /// The same by the model with all causes.
    pub(super) after: Vec<PhaseResidual>,
    /// Readings that are slips of an instrument.
    pub(super) outliers: Vec<Point>,
}

impl<'a> Report<'a> {
    pub(super) fn of(found: &'a Found<'a>) -> Report<'a> {
        let kind = found.kind.as_ref();
        let settings = |name: &String| {
            let run = found
                .folder
                .experiment
                .runs
                .iter()
                .find(|run| run.name == *name);
            run.map(|run| {
                run.settings
                    .iter()
                    .map(|(key, x)| (key.clone(), *x))
                    .collect()
            })
            .unwrap_or_default()
        };
        let conditions: Vec<Vec<(String, f64)>> =
            kind.logs().iter().map(|log| settings(&log.name)).collect();
        let of = |model, fitness| residuals(kind, model, fitness, &conditions);
        let diagnosis = &found.diagnosis;
        Report {
            found,
            before: of(&diagnosis.before, &diagnosis.fitness.0),
            after: of(&diagnosis.after, &diagnosis.fitness.1),
            outliers: outliers(kind, &diagnosis.after, &diagnosis.fitness.1),
        }
    }

    pub(super) fn is_well(&self) -> bool {
        self.found.diagnosis.findings.is_empty() && self.found.diagnosis.unknown.is_none()
    }

    /// How many times as much as stated the data scatter, at most.
    fn excess(&self) -> f64 {
        let wrong = self.found.misstated.iter();
        wrong.map(|w| w.seen / w.stated).fold(1.0, f64::max)
    }

    /// Whether the data scatter so much more than is stated that a finding could hide in it.
    pub(super) fn scatters(&self) -> bool {
        const FAR: f64 = 10.0;
        self.excess() >= FAR
    }

    /// The outcome in a sentence.
    pub(super) fn headline(&self) -> String {
        let diagnosis = &self.found.diagnosis;
        if self.is_well() {
            let within = if self.found.misstated.is_empty() {
                "the noise"
            } else {
                "what they scatter"
            };
            if self.scatters() {
                return format!(
                    "The stated noise is wrong: the data scatter {} times as much. Nothing else \
                     can be seen within that.",
                    digits(self.excess(), 2)
                );
            }
            let but = match self.outliers.len() {
                0 => String::new(),
                1 => ", but for one reading that is an outlier".to_owned(),
                count => format!(", but for {count} readings that are outliers"),
            };
            return format!(
                "Nothing is wrong: the simulation explains the data within {within}{but}."
            );
        }
        let said = |f: &Finding| {
            let (name, what) = (f.best.title(), f.best.meaning());
            let mut rivals: Vec<String> = f.rivals.iter().map(Candidate::title).collect();
            rivals.extend(
                f.unlisted
                    .as_ref()
                    .map(|_| "something that is not on the list".to_owned()),
            );
            let rivals = if rivals.is_empty() {
                rivals.join("")
            } else {
                format!(", or else {}", rivals.join(" or "))
            };
            let against = known::far(&f.best).map_or("", |_| ", against what is known");
            format!("{name} ({what}{against}){rivals}")
        };
        let of = |lead: &str, is_identifiable: bool| {
            let findings = diagnosis
                .findings
                .iter()
                .filter(|f| f.is_identifiable == is_identifiable);
            let causes: Vec<String> = findings.map(said).collect();
            (!causes.is_empty()).then(|| format!("{lead}: {}", causes.join("; ")))
        };
        let causes: Vec<String> = [of("Found", true), of("Not identifiable", false)]
            .into_iter()
            .flatten()
            .collect();
        match (causes.is_empty(), &diagnosis.unknown) {
            (false, None) => format!("{}.", causes.join(". ")),
            (false, Some(_)) => format!("{}; and something unknown.", causes.join(". ")),
            (true, _) => "Unknown: something is wrong that no listed cause explains.".into(),
        }
    }

    /// Columns whose stated noise is far from what the data scatter, each in a sentence.
    pub(super) fn misstated(&self) -> Vec<String> {
        self.found.misstated.iter().map(misstated).collect()
    }

    /// Which readings are outliers, in a sentence; none where none is.
    fn slips_of_instruments(&self) -> Option<String> {
        /// Outliers that are named.
        const NAMED: usize = 6;
        let Folder {
            experiment, rows, ..
        } = &self.found.folder;
        let is_whole = experiment
            .runs
            .iter()
            .map(|run| run.time.len())
            .sum::<usize>()
            == *rows;
        let said = |point: &Point| {
            let column = &self.found.kind.channels()[point.channel].name;
            let log = &self.found.kind.logs()[point.run].name;
            let run = experiment.runs.iter().find(|run| run.name == *log);
            let row = run.and_then(|run| run.time.iter().position(|time| *time == point.time));
            let place = match row.filter(|_| is_whole) {
                Some(row) => format!("row {}", row + 1),
                None => with_unit(point.time, 4, "s"),
            };
            format!(
                "{log}, {place}: {column} is {} σ off",
                digits(point.residual, 2)
            )
        };
        let named: Vec<String> = self.outliers.iter().take(NAMED).map(said).collect();
        let more = match self.outliers.len().saturating_sub(NAMED) {
            0 => String::new(),
            more => format!("; and {more} more"),
        };
        (!named.is_empty()).then(|| {
            format!(
                "Outliers, which are alone and hardly count: {}{more}.",
                named.join("; ")
            )
        })
    }

    /// What the finding means where the data do not tell how strong it is.
    pub(super) const OPEN: &'static str = "Not identifiable: a stronger effect predicts the same \
        readings, so the data tell neither its size nor which of the causes it is.";

    /// What an unknown effect means, if there is one.
    pub(super) fn unknown(&self) -> Option<String> {
        let unknown = self.found.diagnosis.unknown.as_ref()?;
        Some(format!(
            "{} No cause on the list explains it, alone or with others: the machine or \
             an instrument does something that is not on the list. Parameters found beside it may \
             be bent to it.{}",
            is_left(unknown),
            self.term().unwrap_or_default(),
        ))
    }

    /// That more causes may be at work than were looked for, if what is left is not noise.
    pub(super) fn stopped(&self) -> Option<String> {
        let (diagnosis, settings) = (&self.found.diagnosis, &self.found.settings);
        let most = settings.most.unwrap_or_else(|| self.found.kind.most());
        let is_noise = diagnosis
            .fitness
            .1
            .is_noise
            .iter()
            .all(|is_noise| *is_noise);
        (diagnosis.findings.len() >= most && most < usize::from(MOST) && !is_noise).then(|| {
            format!(
                "The search ended at {most} {}, and what is left is not noise: --most {MOST} looks \
                 for more.",
                if most == 1 { "cause" } else { "causes" }
            )
        })
    }

    /// The term that describes what is unknown.
    fn term(&self) -> Option<String> {
        let term = self.found.diagnosis.term.as_ref()?;
        Some(format!(
            " It behaves like this term: {}; data left out of the fit are predicted better with \
             it.",
            Self::acts_like(term)
        ))
    }

    /// A term without an id with its number.
    fn acts_like(term: &Candidate) -> String {
        let Some(c) = term.reported.first() else {
            return String::new();
        };
        let unit = c
            .name
            .strip_prefix("c_")
            .map_or(String::new(), |unit| format!(" ({unit})"));
        format!("{}, c = {}{unit}", term.id, estimate(c.value, c.error, ""))
    }

    pub(super) fn phase(&self, residual: &PhaseResidual) -> &'static str {
        (self.found.folder.experiment.kind.spec().phase)(residual.phase)
    }

    /// What the model with all causes leaves of the same channel and phase.
    pub(super) fn after(&self, before: &PhaseResidual) -> Option<&PhaseResidual> {
        self.after
            .iter()
            .find(|r| r.channel == before.channel && r.phase == before.phase)
    }

    /// The readings in use, as a sentence.
    pub(super) fn size(&self) -> String {
        let logs = self.found.kind.logs();
        let readings: usize = logs.iter().map(|log| log.readings.len()).sum();
        let runs = if logs.len() == 1 { "run" } else { "runs" };
        format!(
            "{} {runs}, {} rows, {readings} readings used",
            logs.len(),
            self.found.folder.rows
        )
    }

    /// What the best cause alone leaves on data left out, beside what all leave, as a sentence; none
    /// where one cause or none was found.
    pub(super) fn alone(&self) -> Option<String> {
        let diagnosis = &self.found.diagnosis;
        let alone = diagnosis.alone.as_ref()?;
        let of = |(gain, rms): (&Gain, &f64)| {
            let (name, unit) = split(&gain.channel);
            let [all, one] = [gain.rms.1, *rms].map(|x| with_unit(x, 3, unit));
            format!("{one} of {name}, all together {all}")
        };
        let each: Vec<String> = diagnosis.gains.iter().zip(&alone.rms).map(of).collect();
        Some(format!(
            "The cause that explains most by itself, {}, leaves there {}.",
            alone.cause.title(),
            each.join("; ")
        ))
    }

    /// What is the same in all runs and nobody states, as a sentence; none where there is nothing such.
    pub(super) fn estimated(&self) -> Option<String> {
        let common = &self.found.diagnosis.common;
        let said =
            |r: &Reported| format!("{} = {}", r.name, estimate(r.value, r.error, unit(&r.name)));
        let all: Vec<String> = common.iter().map(said).collect();
        let all = all.join(", ");
        (!common.is_empty())
            .then(|| format!("Nobody states {all}: this is estimated from the data."))
    }

    /// What is estimated in each run beside its start, as a sentence; none where there is nothing such. Nothing
    /// that changes it alone can be a finding.
    fn of_runs(&self) -> Option<String> {
        let kind = self.found.kind.as_ref();
        let mut all: Vec<(String, f64, f64)> = Vec::new();
        for (run, values) in self.found.diagnosis.after.unknowns.iter().enumerate() {
            for (spec, value) in kind.unknowns(run).iter().zip(values) {
                match all.iter_mut().find(|of| of.0 == spec.name) {
                    Some((_, low, high)) => (*low, *high) = (low.min(*value), high.max(*value)),
                    None if spec.name.contains("start") => {}
                    None => all.push((spec.name.clone(), *value, *value)),
                }
            }
        }
        let said = |(name, low, high): &(String, f64, f64)| {
            let [low, high] = [*low, *high].map(|end| with_unit(end, 3, unit(name)));
            if low == high {
                return format!("{name} ({low})");
            }
            format!("{name} ({low} to {high})")
        };
        let all: Vec<String> = all.iter().map(said).collect();
        (!all.is_empty()).then(|| {
            format!(
                "Estimated in each run, and so not judged: {}.",
                all.join(", ")
            )
        })
    }

    /// Parameters as they are reported, where errors are known with them.
    pub(super) fn parameters(&self, candidate: &Candidate) -> Vec<(String, String)> {
        if candidate.reported.is_empty() {
            let said = |(n, x): &(String, f64)| (n.clone(), with_unit(*x, 4, unit(n)));
            return candidate.values.iter().map(said).collect();
        }
        let said = |(k, r): (usize, &Reported)| {
            let unit = unit(&r.name);
            let interval = r.interval.map_or(String::new(), |i| {
                format!("; 95 %: {}", interval(i, r.error, unit))
            });
            let disagree = if r.runs_disagree {
                "; runs disagree"
            } else {
                ""
            };
            let slip = slip_of(self.found.kind.as_ref(), candidate, k)
                .map_or(String::new(), |slip| format!("; {slip}"));
            (
                r.name.clone(),
                estimate(r.value, r.error, unit) + &interval + disagree + &slip,
            )
        };
        candidate.reported.iter().enumerate().map(said).collect()
    }

    /// Parameters of a cause of `finding`: of one that is not identifiable, their limits alone.
    pub(super) fn parameters_of(
        &self,
        finding: &Finding,
        candidate: &Candidate,
    ) -> Vec<(String, String)> {
        if finding.is_identifiable {
            return self.parameters(candidate);
        }
        let said = |r: &Reported| {
            let limits = r
                .interval
                .map(|limits| interval(limits, r.error, unit(&r.name)));
            (
                r.name.clone(),
                limits.unwrap_or_else(|| "not bounded by these data".into()),
            )
        };
        candidate.reported.iter().map(said).collect()
    }

    /// Parameters of a finding that the data do not fix, as a sentence.
    pub(super) fn undetermined(&self, finding: &Finding) -> Option<String> {
        let direction = finding.undetermined.as_ref()?;
        let names = &self.found.kind.causes()[finding.best.cause].parameters;
        let moved: Vec<&str> = names
            .iter()
            .zip(direction)
            .filter(|(_, part)| part.abs() > 0.1)
            .map(|(p, _)| p.name.as_str())
            .collect();
        Some(match moved.as_slice() {
            [] => return None,
            [one] => format!("Not determined: {one}; the data are the same whatever it is."),
            several => format!(
                "Not determined: {} one by one; they can change together without being seen in \
                 the data.",
                several.join(", ")
            ),
        })
    }

    /// Why rivals are rivals.
    pub(super) const RIVALS: &'static str = "Put in its place, each predicts these data about as \
        well, so that they alone cannot tell which it is; runs under other conditions could.";

    /// What misfit means.
    pub(super) const ODDS: &'static str = "Odds are how many times as probable the data are with \
        the cause as without any: a 3 stands for 1000 to 1.";

    /// What the marks of the residuals mean.
    pub(super) const MARKS: &'static str = "Noise has mean 0 σ, rms 1 σ and lag-1 correlation 0 \
        (of each residual with the next one). After: with the causes found. Not noise: large (rms \
        beyond the stated noise), smooth (residuals follow each other), differs by run (means of \
        the runs differ). Small parts of it can be the instruments'.";

    /// How often something is claimed of nothing.
    pub(super) const CLAIMS: &'static str = "Data without an effect are said to have one in about \
        1 % of cases (docs/diagnosis.md).";

    /// Channels whose noise follows itself, each in a sentence.
    pub(super) fn following(&self) -> Vec<String> {
        let follows = &self.found.diagnosis.fitness.1.follows;
        let channels = self.found.kind.channels().iter().zip(follows);
        let of = |(channel, follows): (&Channel, &f64)| {
            (*follows > 0.0).then(|| {
                format!(
                    "The noise of {} follows itself: each reading repeats {} of the one before. \
                     Errors and intervals allow for it.",
                    channel.name,
                    digits(*follows, 2)
                )
            })
        };
        channels.filter_map(of).collect()
    }

    /// What it means that runs disagree, where it is said of a parameter.
    pub(super) fn disagree(&self) -> Option<&'static str> {
        let findings = &self.found.diagnosis.findings;
        let named = findings
            .iter()
            .flat_map(|f| f.rivals.iter().chain([&f.best]));
        named.flat_map(|c| &c.reported).any(|r| r.runs_disagree).then_some(
            "Where runs disagree, they ask for different parameters, more than chance allows: error \
             and interval are then by how far a value moves as each run in turn is left out.",
        )
    }

    /// Every cause alone, the one with the greatest gain first.
    pub(super) fn tried(&self) -> Vec<&Candidate> {
        let mut all: Vec<&Candidate> = self.found.diagnosis.tried.iter().collect();
        all.sort_by(|a, b| b.log_odds.total_cmp(&a.log_odds));
        all
    }

    /// What there is to say of causes that are not among those tried, if there are some.
    pub(super) fn silent(&self) -> Option<String> {
        let silent = self
            .found
            .kind
            .causes()
            .len()
            .saturating_sub(self.found.diagnosis.tried.len());
        (silent > 0).then(|| format!("Left out, as far less probable: {silent} of the causes."))
    }

    /// For people.
    pub(super) fn text(&self) -> String {
        let headline = [Block::Words(Lead::Below, self.headline())];
        blocks::text(&headline) + &blocks::text(&self.blocks())
    }

    /// What is reported below the headline.
    pub(super) fn blocks(&self) -> Vec<Block> {
        use Lead::{Apart, Below, In};
        let diagnosis = &self.found.diagnosis;
        let words = |lead, text: Option<String>| text.map(|text| Block::Words(lead, text));
        let below = |text| Block::Words(Below, text);
        let mut all: Vec<Block> = self.misstated().into_iter().map(below).collect();
        all.extend(diagnosis.findings.iter().map(|it| self.finding(it)));
        all.extend(words(Apart, self.estimated()));
        all.extend(words(Apart, self.of_runs()));
        let unknown = self.unknown().map(|text| vec![Block::Words(In, text)]);
        all.extend(unknown.map(|words| Block::Card("unknown".into(), words)));
        all.extend(words(Apart, self.slips_of_instruments()));
        all.extend(words(Apart, self.stopped()));
        all.extend(words(Apart, self.worth()));
        let replan = self.found.replan.iter().flat_map(Replan::lines);
        let replan = replan.enumerate();
        all.extend(replan.map(|(k, line)| Block::Words(if k == 0 { Apart } else { Below }, line)));
        all.extend([
            Block::Charts(Charts::Measured),
            Block::Heading(
                "Error of prediction on data that were left out of the fit (root mean square)",
            ),
            Block::Table(self.gains(), 1),
        ]);
        all.extend(words(In, self.alone()));
        all.extend([
            Block::Heading(
                "What the simulation leaves: measured less predicted, in standard deviations of the \
                 noise (σ)",
            ),
            Block::Charts(Charts::Residuals),
            Block::Table(self.residual_lines(), 2),
        ]);
        all.extend(
            self.conditions()
                .into_iter()
                .map(|text| Block::Words(In, text)),
        );
        all.push(Block::Words(In, Self::MARKS.into()));
        all.push(Block::Heading(
            "Every cause alone: how much more probable it makes the data",
        ));
        if !diagnosis.tried.is_empty() {
            all.push(Block::Table(self.tried_lines(), 1));
        }
        all.extend(words(In, self.silent()));
        all.push(Block::Words(In, Self::ODDS.into()));
        let hash = &self.found.folder.hash;
        all.push(Block::Words(
            Apart,
            format!("{}; hash of the data {hash}", self.size()),
        ));
        all.extend(self.following().into_iter().map(below));
        all.extend(words(Below, self.disagree().map(str::to_owned)));
        all.push(below(Self::CLAIMS.into()));
        let notes = self.found.folder.notes.iter();
        all.extend(notes.map(|note| below(format!("note: {note}"))));
        all.push(Block::Heading("What to do next"));
        all.push(Block::Steps(steps(self.found)));
        all
    }

    /// A cause that was found.
    fn finding(&self, finding: &Finding) -> Block {
        let into = |text| Block::Words(Lead::In, text);
        let parameters = self.parameters_of(finding, &finding.best).into_iter();
        let parameters = parameters.map(|(name, value)| vec![name, value]);
        let mut all = vec![Block::List(parameters.collect())];
        let open = (!finding.is_identifiable).then(|| Self::OPEN.to_owned());
        all.extend(open.map(into));
        all.extend(self.undetermined(finding).map(into));
        all.extend(self.held_out(finding).map(into));
        if !finding.rivals.is_empty() || finding.unlisted.is_some() {
            all.push(into("It could as well be".into()));
            let line = |rival: &Candidate| {
                vec![format!("  {}", rival.title()), self.rival(finding, rival)]
            };
            all.push(Block::List(finding.rivals.iter().map(line).collect()));
            let unlisted = finding.unlisted.as_ref().map(Self::unlisted);
            all.extend(unlisted.map(|text| into(format!("{text}."))));
            all.push(into(Self::RIVALS.into()));
            all.extend(Self::less_likely(finding).map(into));
        }
        all.extend(
            known::against(self.found.kind.as_ref(), finding)
                .into_iter()
                .map(into),
        );
        all.extend(next_of(finding).map(into));
        Block::Card(finding.best.title(), all)
    }

    /// What the extended robot is worth to the planner.
    pub(super) fn worth(&self) -> Option<String> {
        let worth = self.found.worth.as_ref()?;
        let [before, after] = worth.rms()?;
        let law = |law: Option<(f64, f64)>| {
            law.map_or("no law".into(), |(a, b)| {
                format!("{} s ω + {} rad", digits(a, 4), digits(b, 4))
            })
        };
        let changed = left_out_words(&newly_left_out(self.found));
        let left_out = left_out_words(&left_out(self.found));
        let (distance, rates) = (worth.distance, worth.rows.len());
        let [before, after] = [
            (before, digits(1e3 * before, 3)),
            (after, digits(1e3 * after, 3)),
        ];
        if !changed.is_empty() && (before.0 - after.0).abs() < 1e-2 * before.0 {
            return Some(format!(
                "Firing tables for {distance} m stay as they were: the planner has no term for \
                 {changed}. Jumps of the corrected robot land {} mm off the target (root mean \
                 square over {rates} approach rates); `saltus verify` simulates them.",
                after.1
            ));
        }
        let rest = if left_out.is_empty() {
            String::new()
        } else {
            format!(" What is left is due to {left_out}, for which the planner has no term.")
        };
        Some(format!(
            "Firing table for {distance} m (to where the wheel touches) at {rates} approach \
             rates: jumps of the corrected robot land {} mm off the target (root mean square) \
             with the table of the robot as believed, and {} mm with a table of its own.{rest} \
             Linear law before: {}; after: {}.",
            before.1,
            after.1,
            law(worth.laws[0]),
            law(worth.laws[1]),
        ))
    }

    /// By how much data left out of the fit are predicted better, as a sentence; none where that is
    /// not known.
    pub(super) fn held_out(&self, finding: &Finding) -> Option<String> {
        let parameters = self.found.kind.causes()[finding.best.cause]
            .parameters
            .len();
        finding.held_out.is_finite().then(|| {
            let by = digits(finding.held_out.abs(), 4);
            if finding.held_out < 0.0 {
                return format!(
                    "On data left out of the fit the misfit of all runs together rises by {by} \
                     with it."
                );
            }
            format!(
                "On data left out of the fit the misfit falls by {by} with it; chance \
                makes it fall by about {parameters}."
            )
        })
    }

    /// The parameters of a rival, in words.
    pub(super) fn rival(&self, finding: &Finding, rival: &Candidate) -> String {
        let is = if finding.is_identifiable { " =" } else { "" };
        let said = self.parameters_of(finding, rival);
        said.iter()
            .map(|(name, value)| format!("{name}{is} {value}"))
            .collect::<Vec<_>>()
            .join(", ")
    }

    /// A term without an id that is a rival, in words.
    pub(super) fn unlisted(term: &Candidate) -> String {
        format!(
            "something that is not on the list and acts like this term: {}",
            Self::acts_like(term)
        )
    }

    /// What is behind the rivals, as a sentence.
    pub(super) fn less_likely(finding: &Finding) -> Option<String> {
        let names: Vec<String> = finding.less_likely.iter().map(Candidate::title).collect();
        (!names.is_empty()).then(|| format!("Less likely, but not excluded: {}.", names.join(", ")))
    }

    /// Gain by channel: a header, then lines.
    pub(super) fn gains(&self) -> Vec<Vec<String>> {
        let mut lines = vec![cells(
            "channel|before|after|noise|after/before (95 % interval)",
        )];
        for gain in &self.found.diagnosis.gains {
            let (name, unit) = split(&gain.channel);
            lines.push(vec![
                name.to_owned(),
                with_unit(gain.rms.0, 3, unit),
                with_unit(gain.rms.1, 3, unit),
                with_unit(gain.noise, 3, unit),
                ratio(gain),
            ]);
        }
        lines
    }

    /// Residuals by channel and phase: a header, then lines.
    pub(super) fn residual_lines(&self) -> Vec<Vec<String>> {
        let changes = !self.found.diagnosis.findings.is_empty();
        let before = if changes {
            "before: mean (σ)"
        } else {
            "mean (σ)"
        };
        let mut header = cells(&format!("channel|phase|readings|{before}|rms (σ)|lag-1"));
        if changes {
            header.extend(cells("after: mean (σ)|rms (σ)|lag-1"));
        }
        header.extend(cells("rms|not noise because"));
        let mut lines = vec![header];
        for before in &self.before {
            // With the causes found a run need not have that phase.
            let last = self.after(before);
            let (name, unit) = split(&self.found.kind.channels()[before.channel].name);
            let mut line = vec![
                name.to_owned(),
                self.phase(before).to_owned(),
                before.count.to_string(),
            ];
            line.extend(numbers(before));
            if changes {
                line.extend(last.map_or_else(|| cells("–|–|–"), numbers));
            }
            line.push(last.map_or("–".into(), |last| with_unit(last.rms_in_unit(), 3, unit)));
            let faults = last.map_or_else(String::new, |last| last.faults.join(", "));
            line.push(if faults.is_empty() {
                "–".to_owned()
            } else {
                format!("* {faults}")
            });
            lines.push(line);
        }
        lines
    }

    /// Conditions that go with what differs between runs, in sentences.
    fn conditions(&self) -> Vec<String> {
        const STRONG: f64 = 0.7;
        let differ = |r: &&PhaseResidual| r.faults.contains(&"differs by run");
        let mut all = Vec::new();
        for residual in self.after.iter().filter(differ) {
            let (name, _) = split(&self.found.kind.channels()[residual.channel].name);
            for (condition, c) in residual.conditions.iter().filter(|(_, c)| c.abs() > STRONG) {
                let phase = self.phase(residual);
                let c = digits(*c, 2);
                let go = format!("the runs' means go with {condition}");
                all.push(format!("{name} in {phase}: {go} (correlation {c})."));
            }
        }
        all
    }

    /// Every cause alone: a header, then lines.
    pub(super) fn tried_lines(&self) -> Vec<Vec<String>> {
        let mut lines = vec![cells("cause|odds, powers of ten|with")];
        for c in self.tried() {
            let said: Vec<String> = self
                .parameters(c)
                .iter()
                .map(|(n, x)| format!("{n} = {x}"))
                .collect();
            let name = c.title();
            lines.push(vec![
                name,
                digits(c.log_odds / std::f64::consts::LN_10, 3),
                said.join(", "),
            ]);
        }
        lines
    }

    fn entry(&self, candidate: &Candidate) -> Map<String, Value> {
        let kind = self.found.kind.as_ref();
        let cause = &kind.causes()[candidate.cause];
        let reported = || candidate.reported.iter();
        let named = |of: &dyn Fn(usize, &Reported) -> Option<Value>| -> Map<String, Value> {
            let of = |(k, r)| Some((Reported::clone(r).name, of(k, r)?));
            reported().enumerate().filter_map(of).collect()
        };
        let disagree = reported().filter(|r| r.runs_disagree);
        let disagree: Vec<&String> = disagree.map(|r| &r.name).collect();
        let intervals = named(&|_, r| r.interval.map(|i| json!([i.low, i.high])));
        let entries = [
            ("id", Some(json!(cause.id))),
            ("column", cause.column.as_ref().map(|column| json!(column))),
            (
                "parameters",
                Some(named(&|_, r| Some(json!(r.value))).into()),
            ),
            (
                "standard_errors",
                Some(named(&|_, r| Some(json!(r.error))).into()),
            ),
            (
                "slips",
                Some(named(&|k, _| Some(json!(slip_of(kind, candidate, k)?))).into()),
            ),
            (
                "runs_disagree",
                (!disagree.is_empty()).then(|| json!(disagree)),
            ),
            (
                "intervals_95",
                (!intervals.is_empty()).then(|| intervals.into()),
            ),
            ("log_odds", Some(json!(candidate.log_odds))),
        ];
        let present = entries.into_iter();
        present
            .filter_map(|(key, value)| Some((key.to_owned(), value?)))
            .collect()
    }

    fn tried_entry(&self, candidate: &Candidate) -> Map<String, Value> {
        let mut entry = self.entry(candidate);
        entry.remove("standard_errors");
        let values = candidate.values.iter().cloned();
        entry.insert("parameters".into(), values.collect());
        entry
    }

    fn finding_entry(&self, finding: &Finding) -> Value {
        let ids = |all: &[Candidate]| all.iter().map(|it| it.id).collect::<Vec<_>>();
        let mut rivals = ids(&finding.rivals);
        rivals.extend(finding.unlisted.as_ref().map(|_| "unknown"));
        let kind = self.found.kind.as_ref();
        let candidates = finding.rivals.iter().map(|r| self.entry(r));
        let more = json!({
            "rivals": rivals,
            "less_likely": ids(&finding.less_likely),
            "unlisted": finding.unlisted.as_ref().map(|term| term_json(kind, term)),
            "held_out_loss_falls_by": finding.held_out,
            "undetermined": finding.undetermined,
            "identifiable": finding.is_identifiable,
            "candidates": candidates.collect::<Vec<_>>(),
            "contradicting": known::json(&finding.contradicting),
        });
        joined([self.entry(&finding.best).into(), more])
    }

    fn residual_entry(&self, residual: &PhaseResidual) -> Value {
        json!({
            "channel": self.found.kind.channels()[residual.channel].name,
            "phase": self.phase(residual),
            "readings": residual.count,
            "mean": residual.mean_in_unit(),
            "rms": residual.rms_in_unit(),
            "mean_sigma": residual.mean,
            "rms_sigma": residual.rms,
            "lag_1_correlation": residual.lag,
            "correlation_with": residual.conditions.iter().cloned().collect::<Value>(),
            "p_level": residual.level,
            "p_whiteness": residual.whiteness,
            "p_runs": residual.runs,
            "is_noise": residual.is_noise(),
        })
    }

    /// What is left of each channel, for programs.
    fn noise(&self) -> Value {
        let left = &self.found.diagnosis.fitness.1;
        let channels = self.found.kind.channels().iter().enumerate();
        let of = |(c, channel): (usize, &Channel)| {
            let entry = json!({
                "of_stated": left.noise[c],
                "follows": left.follows[c],
                "model_error_sigma": left.own_error[c],
                "is_noise": left.is_noise[c],
            });
            (channel.name.clone(), entry)
        };
        channels.map(of).collect()
    }

    /// For programs.
    pub(super) fn json(&self) -> Value {
        let Found {
            folder,
            kind,
            diagnosis,
            ..
        } = self.found;
        let mut causes: Vec<Value> = diagnosis
            .findings
            .iter()
            .map(|f| self.finding_entry(f))
            .collect();
        if let Some(unknown) = &diagnosis.unknown {
            causes.push(json!({
                "id": "unknown",
                "rivals": [],
                "parameters": {},
                "standard_errors": {},
                "channel": unknown.channel,
                "phase": unknown.phase,
                "rms": unknown.rms,
                "term": diagnosis.term.as_ref().map(|t| term_json(self.found.kind.as_ref(), t)),
            }));
        }
        let gain = |g: &Gain| {
            let entry = json!({
                "rms_before": g.rms.0,
                "rms_after": g.rms.1,
                "noise": g.noise,
                "ratio_low": g.ratio.0,
                "ratio_high": g.ratio.1,
            });
            (g.channel.clone(), entry)
        };
        let residuals = |all: &[PhaseResidual]| {
            all.iter()
                .map(|r| self.residual_entry(r))
                .collect::<Vec<_>>()
        };
        let tried: Vec<Map<String, Value>> = diagnosis
            .tried
            .iter()
            .map(|c| self.tried_entry(c))
            .collect();
        json!({
            "command": "diagnose",
            "data": { "hash": folder.hash, "rows": folder.rows, "runs": kind.logs().len(), "notes": folder.notes },
            "causes": causes,
            "estimated": diagnosis.common.iter().map(estimated_json).collect::<Map<_, _>>(),
            "gain": diagnosis.gains.iter().map(gain).collect::<Map<String, Value>>(),
            "residuals": { "before": residuals(&self.before), "after": residuals(&self.after) },
            "alone": diagnosis.alone.as_ref().map(|alone| self.alone_entry(alone)),
            "noise": self.noise(),
            "tried": tried,
            "next_experiment": next_json(diagnosis),
            "worth": self.found.worth.as_ref().map(worth_json),
            "replan": self.found.replan.as_ref().map(Replan::json),
            "planner_leaves_out": left_out(self.found),
            "misstated_noise": self.found.misstated.iter().map(misstated_json).collect::<Vec<_>>(),
            "next_steps": steps(self.found).iter().map(Step::json).collect::<Vec<_>>(),
        })
    }

    /// The best cause alone, and what it leaves of each channel.
    fn alone_entry(&self, alone: &Alone) -> Value {
        let names = self.found.kind.channels().iter().map(|c| c.name.clone());
        let rms: Value = names.zip(alone.rms.iter().copied()).collect();
        json!({ "id": alone.cause.id, "column": alone.cause.column, "held_out_rms": rms })
    }

    /// Before and after, channel by channel.
    pub(super) fn csv(&self) -> String {
        let columns: [Column<&Gain>; 4] = columns! {
            "channel", "", |it| it.channel.clone();
            "rms_before", "", |it| it.rms.0;
            "rms_after", "", |it| it.rms.1;
            "noise", "", |it| it.noise;
        };
        Table::of(&columns, &self.found.diagnosis.gains).csv()
    }
}

/// Mean, root mean square and correlation with the next.
fn numbers(residual: &PhaseResidual) -> Vec<String> {
    let number = |x: f64| match format!("{x:.2}") {
        _ if !x.is_finite() => "–".to_owned(),
        _ if x.abs() >= 1e4 => digits(x, 3),
        // No negative zero.
        text if text == "-0.00" => "0.00".to_owned(),
        text => text,
    };
    vec![
        number(residual.mean),
        number(residual.rms),
        number(residual.lag),
    ]
}

/// Which experiment would tell the rivals of a finding apart.
pub(super) fn next_of(finding: &Finding) -> Option<String> {
    let next = finding.next.as_ref()?;
    let pairs: Vec<String> = next
        .apart
        .iter()
        .map(|(a, b)| format!("{a} from {b}"))
        .collect();
    let count = 1
        + finding.rivals.len()
        + finding.less_likely.len()
        + usize::from(finding.unlisted.is_some());
    let tells = if pairs.is_empty() {
        "may help to tell them apart".into()
    } else if pairs.len() > 3 {
        format!(
            "tells {} of the {} pairs of them apart",
            pairs.len(),
            count * (count - 1) / 2
        )
    } else {
        format!("tells {}", pairs.join(", "))
    };
    let (channel, _) = split(&next.channel);
    let sigmas = digits(next.sigmas, 3);
    Some(format!(
        "Next experiment: {}. In {channel} they differ by up to {sigmas} σ, which {tells}.",
        next.what
    ))
}

fn next_json(diagnosis: &Diagnosis) -> Value {
    let all: Vec<Value> = diagnosis
        .findings
        .iter()
        .filter_map(|finding| {
            let next = finding.next.as_ref()?;
            let apart: Vec<[&str; 2]> = next.apart.iter().map(|(a, b)| [*a, *b]).collect();
            Some(json!({"what": next.what, "channel": next.channel, "sigmas": next.sigmas, "tells_apart": apart}))
        })
        .collect();
    all.into_iter().next().unwrap_or(Value::Null)
}

/// Where most is left, and how much, as a sentence.
fn is_left(unknown: &Unknown) -> String {
    let (channel, unit) = split(&unknown.channel);
    let lead = if unknown.phase.ends_with("third") {
        "the"
    } else {
        "the phase"
    };
    format!(
        "What is left in {channel} is not noise, most of all in {lead} {}: {} {unit} root mean square.",
        unknown.phase,
        digits(unknown.rms, 3),
    )
}

fn term_json(kind: &dyn Kind, term: &Candidate) -> Value {
    let numbers = term.reported.iter();
    let numbers: Value = numbers
        .map(|r| (r.name.clone(), vec![r.value, r.error]))
        .collect();
    json!({"term": kind.causes()[term.cause].id, "value_and_standard_error": numbers})
}

/// What is estimated beside the causes: its name, and value with standard error.
fn estimated_json(r: &Reported) -> (String, Value) {
    let entry = json!({ "value": r.value, "standard_error": r.error });
    (r.name.clone(), entry)
}

fn misstated_json(wrong: &Misstated) -> Value {
    json!({"column": wrong.column, "stated": wrong.stated, "seen": wrong.seen})
}

/// 95 % interval of the error after over that before.
pub(super) fn ratio(gain: &Gain) -> String {
    let (low, high) = gain.ratio;
    if low.is_finite() && high.is_finite() {
        format!("{} to {}", digits(low, 3), digits(high, 3))
    } else {
        "–".to_owned()
    }
}

fn worth_json(worth: &Worth) -> Value {
    let row = |r: &saltus::study::Row| json!({"omega_rad_s": r.rate, "alpha_f_rad": r.angles, "land_error_m": r.errors});
    json!({
        "distance_m": worth.distance,
        "land_error_rms_m": worth.rms(),
        "laws": worth.laws.map(|law| law.map(|(a, b)| json!({"slope_s": a, "intercept_rad": b}))),
        "rows": worth.rows.iter().map(row).collect::<Vec<_>>(),
    })
}
