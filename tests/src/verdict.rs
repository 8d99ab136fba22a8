//! Whether a diagnosis says what was hidden.

use saltus_diagnosis::{Diagnosis, Reported};

use crate::lab::Effect;

/// The causes, each with its rivals; a term without an id that does as well is `unknown`.
pub fn sets(d: &Diagnosis) -> Vec<Vec<&'static str>> {
    d.findings
        .iter()
        .map(|f| {
            let rivals = f.rivals.iter().map(|r| r.id);
            let unlisted = f.unlisted.iter().map(|_| "unknown");
            std::iter::once(f.best.id)
                .chain(rivals)
                .chain(unlisted)
                .collect()
        })
        .collect()
}

fn number(r: &Reported) -> String {
    let end = |end: Option<f64>| end.map_or("open".into(), |x| format!("{x:.3e}"));
    let interval = r
        .interval
        .map(|i| format!(" ({} to {})", end(i.low), end(i.high)));
    format!(
        "{} {:.4e} ± {:.1e}{}",
        r.name,
        r.value,
        r.error,
        interval.unwrap_or_default()
    )
}

/// What is said, in a line.
pub fn say(d: &Diagnosis) -> String {
    let mut all: Vec<String> = d
        .findings
        .iter()
        .zip(sets(d))
        .map(|(f, set)| {
            let column = f.best.column.as_deref().unwrap_or("");
            let values: Vec<String> = f.best.reported.iter().map(number).collect();
            format!("{} {column} [{}]", set.join("|"), values.join(", "))
        })
        .collect();
    if let Some(u) = &d.unknown {
        let term = d.term.as_ref().map(|t| {
            let numbers: Vec<String> = t.reported.iter().map(number).collect();
            format!(": {} {}", t.id, numbers.join(", "))
        });
        all.push(format!(
            "unknown in {} {}{}",
            u.channel,
            u.phase,
            term.unwrap_or_default()
        ));
    }
    if all.is_empty() {
        "none".into()
    } else {
        all.join(" + ")
    }
}

/// Whether the effects are named and nothing else is: each alone or in a set of three at most.
pub fn names(d: &Diagnosis, truth: &[Effect]) -> bool {
    // Two effects may be of one cause with something beside it; one, or none, may not.
    truth.iter().all(|effect| is_named(d, effect))
        && (truth.len() > 1 || (d.findings.len() == truth.len() && d.unknown.is_none()))
}

/// Whether an effect is named, alone or in a set of three at most.
pub fn is_named(d: &Diagnosis, effect: &Effect) -> bool {
    sets(d)
        .iter()
        .any(|set| set.len() <= 3 && set.contains(&effect.id))
}

/// Whether a cause is named without rivals that is not hidden, and no `unknown` is said.
pub fn is_alone_and_wrong(d: &Diagnosis, truth: &[Effect]) -> bool {
    let is_hidden = |id: &str| truth.iter().any(|effect| effect.id == id);
    let sets = sets(d);
    d.unknown.is_none()
        && sets
            .iter()
            .any(|set| matches!(set[..], [id] if !is_hidden(id)))
}
