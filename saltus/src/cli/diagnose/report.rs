//! What was found, in words and in numbers.

use std::fmt::Write;

use saltus::diagnosis::Candidate;
use serde_json::{Map, Value, json};

use super::Found;
use crate::output::digits;

/// What is reported of a diagnosis.
pub(super) struct Report<'a>(&'a Found);

impl<'a> Report<'a> {
    pub(super) fn of(found: &'a Found) -> Report<'a> {
        Report(found)
    }

    fn id(&self, cause: usize) -> String {
        self.0.kind.causes()[cause].id.to_owned()
    }

    fn column(&self, cause: usize) -> Option<&str> {
        self.0.kind.causes()[cause].column.as_deref()
    }

    /// For people.
    pub(super) fn text(&self) -> String {
        let Found { folder, kind, diagnosis, settings, .. } = self.0;
        let mut out = String::new();
        let readings: usize = kind.logs().iter().map(|l| l.readings.len()).sum();
        let _ = writeln!(
            out,
            "{} runs, {} rows read, {readings} readings used; data {}",
            kind.logs().len(),
            folder.rows,
            folder.hash
        );
        for note in &folder.notes {
            let _ = writeln!(out, "note: {note}");
        }
        let _ = writeln!(out);
        if diagnosis.findings.is_empty() && diagnosis.unknown.is_none() {
            let _ = writeln!(
                out,
                "Nothing is wrong: the simulation explains the data within the noise (false alarms: {} %).",
                digits(100.0 * settings.false_alarms, 3)
            );
        }
        for finding in &diagnosis.findings {
            self.candidate(&mut out, "Cause", &finding.best);
            if !finding.rivals.is_empty() {
                let _ = writeln!(out, "  The data cannot tell it from:");
                for rival in &finding.rivals {
                    self.candidate(&mut out, "    or", rival);
                }
            }
            let _ = writeln!(
                out,
                "  The loss of data left out falls by {}.",
                digits(finding.held_out, 4)
            );
        }
        if let Some(unknown) = &diagnosis.unknown {
            let _ = writeln!(
                out,
                "Unknown: what is left in {} is not noise, most of all in {} ({} rms).",
                unknown.channel,
                unknown.phase,
                digits(unknown.rms, 3)
            );
        }
        let _ = writeln!(out, "\nPredicted on data left out (rms):");
        for gain in &diagnosis.gains {
            let _ = writeln!(
                out,
                "  {:<20} {:>10} before, {:>10} after, noise {:>10}; after/before {} to {} (95 %)",
                gain.channel,
                digits(gain.rms.0, 4),
                digits(gain.rms.1, 4),
                digits(gain.noise, 3),
                digits(gain.ratio.0, 3),
                digits(gain.ratio.1, 3)
            );
        }
        let _ = writeln!(out, "\nEvery cause alone (by how much the loss falls):");
        for c in diagnosis.tried.iter().take(12) {
            self.candidate(&mut out, "  ", c);
        }
        let (before, after) = &diagnosis.fitness;
        let _ = writeln!(out, "inflation {:.3} squares {:.1} -> {:.1}; level {:?} smooth {:?} alarm {:.2}", diagnosis.inflation, before.squares, after.squares, after.level, after.smooth, after.alarm);
        out
    }

    fn candidate(&self, out: &mut String, lead: &str, candidate: &Candidate) {
        let column = self.column(candidate.cause).map_or(String::new(), |c| format!(" of {c}"));
        let _ = write!(out, "{lead} {}{column}", self.id(candidate.cause));
        for (name, value, error) in &candidate.reported {
            let _ = write!(out, ", {name} = {} ± {}", digits(*value, 5), digits(*error, 2));
        }
        let _ = writeln!(out, " (loss falls by {})", digits(candidate.gain, 5));
    }

    fn entry(&self, candidate: &Candidate) -> Map<String, Value> {
        let mut entry = Map::new();
        entry.insert("id".into(), json!(self.id(candidate.cause)));
        if let Some(column) = self.column(candidate.cause) {
            entry.insert("column".into(), json!(column));
        }
        let (mut values, mut errors) = (Map::new(), Map::new());
        for (name, value, error) in &candidate.reported {
            values.insert(name.clone(), json!(value));
            errors.insert(name.clone(), json!(error));
        }
        entry.insert("parameters".into(), Value::Object(values));
        entry.insert("standard_errors".into(), Value::Object(errors));
        entry.insert("loss_falls_by".into(), json!(candidate.gain));
        entry
    }

    /// For programs.
    pub(super) fn json(&self) -> Value {
        let Found { folder, kind, diagnosis, settings, .. } = self.0;
        let mut causes: Vec<Value> = diagnosis
            .findings
            .iter()
            .map(|finding| {
                let mut entry = self.entry(&finding.best);
                let rivals: Vec<String> = finding.rivals.iter().map(|r| self.id(r.cause)).collect();
                entry.insert("rivals".into(), json!(rivals));
                entry.insert("held_out_loss_falls_by".into(), json!(finding.held_out));
                entry.insert("undetermined".into(), json!(finding.undetermined));
                let candidates: Vec<Value> =
                    finding.rivals.iter().map(|r| Value::Object(self.entry(r))).collect();
                entry.insert("candidates".into(), json!(candidates));
                Value::Object(entry)
            })
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
            }));
        }
        let gain: Map<String, Value> = diagnosis
            .gains
            .iter()
            .map(|g| {
                let entry = json!({
                    "rms_before": g.rms.0,
                    "rms_after": g.rms.1,
                    "noise": g.noise,
                    "ratio_low": g.ratio.0,
                    "ratio_high": g.ratio.1,
                });
                (g.channel.clone(), entry)
            })
            .collect();
        json!({
            "command": "diagnose",
            "data": { "hash": folder.hash, "rows": folder.rows, "runs": kind.logs().len(), "notes": folder.notes },
            "causes": causes,
            "gain": gain,
            "false_alarm_level": settings.false_alarms,
        })
    }

    /// Before and after, channel by channel.
    pub(super) fn csv(&self) -> String {
        let mut out = String::from("channel,rms_before,rms_after,noise\n");
        for g in &self.0.diagnosis.gains {
            let _ = writeln!(out, "{},{:e},{:e},{:e}", g.channel, g.rms.0, g.rms.1, g.noise);
        }
        out
    }
}
