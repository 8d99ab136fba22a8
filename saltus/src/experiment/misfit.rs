//! Whether the columns of a folder are those of another kind than it says.

use std::path::Path;

use saltus_diagnosis::Sort;
use saltus_diagnosis::spec::{Meaning, Spec};

use super::error::{cut, one_line};
use super::header::names;
use super::lines::Lines;
use super::manifest::within;

/// Which kinds the columns of the first run fit better than the kind that `manifest`, the bytes of the
/// folder's file, names; none where they fit that one as well, or cannot be read.
pub(super) fn other_kinds(manifest: &[u8], folder: &Path) -> Option<String> {
    let root: toml::Table = std::str::from_utf8(manifest).ok()?.parse().ok()?;
    let given = Sort::named(root.get("kind")?.as_str()?)?.spec();
    let file = root.get("run")?.get(0)?.get("file")?.as_str()?;
    let mut lines = Lines::open(&folder.join(within(file)?)).ok()?;
    let (_, header) = lines.next().ok()??;
    let columns = names(header, file).ok()?;
    let fits = |spec: &&Spec| Some((fit(spec, &columns)?, spec.id));
    let specs = Sort::ALL.map(Sort::spec);
    let best = specs.iter().filter_map(fits).map(|(fit, _)| fit).min()?;
    let strange = columns.iter().filter(|name| given.meaning(name).is_none());
    let better = match fit(given, &columns) {
        Some(own) => best < own,
        None => best.0 <= strange.count(),
    };
    if !better {
        return None;
    }
    let ids: Vec<&str> = specs
        .iter()
        .filter_map(fits)
        .filter(|(fit, _)| *fit == best)
        .map(|(_, id)| id)
        .collect();
    Some(format!(
        "the columns of {} ({}) are those of kind {}, and not of {}: is kind right?",
        one_line(file),
        cut(&columns.join(", ")),
        ids.join(" or "),
        given.id
    ))
}

/// How many of `columns` a kind does not know, and whether it knows any by the end of its name alone;
/// none where one that it needs is not there.
fn fit(spec: &Spec, columns: &[&str]) -> Option<(usize, bool)> {
    let meanings = columns.iter().map(|name| spec.meaning(name));
    let (known, strange): (Vec<_>, Vec<_>) = meanings.partition(Option::is_some);
    let known: Vec<Meaning> = known.into_iter().flatten().collect();
    let has = |name: &str| {
        known.iter().any(|meaning| match meaning {
            Meaning::Time(_) => name == "time_s",
            Meaning::Valve => name == "valve",
            Meaning::Column(own, _) => own.name == name,
        })
    };
    let optional = |name: &str| spec.channel(name).is_some_and(|own| own.optional);
    let needed = spec
        .columns()
        .into_iter()
        .filter(|name| !name.contains('*') && !optional(name));
    let is_complete = needed.into_iter().all(has);
    let mut measured = known.iter().filter_map(|meaning| match meaning {
        Meaning::Column(own, _) => Some(own.name),
        _ => None,
    });
    let is_plain = |name: &str| spec.channels.iter().any(|own| own.name == name);
    let is_any = measured.clone().next().is_some();
    (is_complete && is_any).then(|| (strange.len(), measured.any(|name| !is_plain(name))))
}
