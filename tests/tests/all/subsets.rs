//! Diagnoses of subsets of the runs of a real set agree: an answer does not depend on the runs that were logged.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use saltus::experiment::read;
use saltus::study::{Study, study};
use saltus_diagnosis::{Experiment, Finding, Interval, Settings, Terms, kinds, left};
use saltus_tests::verdict;

/// Real sets of the repository, and of the folder that `SALTUS_DATA` names.
fn sets() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut all, mut seen) = (Vec::new(), BTreeSet::new());
    let more = std::env::var_os("SALTUS_DATA").map(PathBuf::from);
    if more.is_none() {
        eprintln!("SALTUS_DATA names no folder: sets outside the repository are left out");
    }
    for top in std::iter::once(root.join("reference")).chain(more) {
        let mut folders = vec![top.clone()];
        while let Some(folder) = folders.pop() {
            let inner = std::fs::read_dir(&folder)
                .expect("a folder")
                .map(|entry| entry.expect("an entry").path());
            folders.extend(inner.filter(|path| path.is_dir() && !path.ends_with("cases")));
            let name = folder
                .strip_prefix(&top)
                .expect("a folder in it")
                .to_owned();
            if folder.join("experiment.toml").is_file() && seen.insert(name) {
                all.push(folder);
            }
        }
    }
    all.sort();
    all
}

/// Subsets of two or more of `n` runs: all of them where they are few, else the pairs of neighbours, halves
/// and thirds.
fn subsets(n: usize) -> Vec<Vec<usize>> {
    const FEW: usize = 4;
    if n <= FEW {
        let of = |bits: u32| (0..n).filter(|k| bits >> k & 1 == 1).collect::<Vec<_>>();
        return (1..1 << n).map(of).filter(|runs| runs.len() > 1).collect();
    }
    let every = |step: usize, first: usize| (first..n).step_by(step).collect::<Vec<_>>();
    vec![
        vec![0, 1],
        vec![n - 2, n - 1],
        every(2, 0),
        every(2, 1),
        every(3, 0),
        every(3, 1),
        (0..n).collect(),
    ]
}

fn part(data: &Experiment, runs: &[usize]) -> Experiment {
    Experiment {
        runs: runs.iter().map(|k| data.runs[*k].clone()).collect(),
        ..data.clone()
    }
}

/// Whether a finding names, or lists as a rival, a cause on a column.
fn has(finding: &Finding, id: &str, column: Option<&str>) -> bool {
    let all = std::iter::once(&finding.best)
        .chain(&finding.rivals)
        .chain(&finding.less_likely);
    all.into_iter()
        .any(|c| c.id == id && c.column.as_deref() == column)
}

fn overlap(a: Interval, b: Interval) -> bool {
    let above =
        |low: Option<f64>, high: Option<f64>| low.zip(high).is_none_or(|(low, high)| low <= high);
    above(a.low, b.high) && above(b.low, a.high)
}

/// Fall of the mean square residual of the other runs, as a part of that without a cause, by an answer from
/// some runs: mean of all channels; 1 is a perfect prediction.
fn gain(data: &Experiment, others: &[usize], answer: &Study) -> Option<f64> {
    let rest = part(data, others);
    let kind = kinds::build(&rest, None).ok()?;
    let terms = &answer.diagnosis.after.terms;
    let none = Terms::off(kind.causes());
    let (before, after) = (left(kind.as_ref(), &none)?, left(kind.as_ref(), terms)?);
    let ratios: Vec<f64> = before
        .iter()
        .zip(&after)
        .map(|(b, a)| (a / b).powi(2))
        .collect();
    Some(1.0 - ratios.iter().sum::<f64>() / ratios.len() as f64)
}

/// Sets and runs whose answer is known to differ from others of the set, with what differs.
const APART: [(&str, &[usize], &str); 2] = [
    // Two steps of a leg alone do not tell dry from viscous friction: the latter stands for both.
    (
        "compass-leg/outer",
        &[0, 1],
        "viscous_friction_n_m_s_per_rad",
    ),
    // Four flights of which the scale of one axis seems off by a fifth.
    (
        "hopper-flights/disturbances",
        &[0, 3, 6, 9],
        "gravity_share",
    ),
];

fn is_apart(name: &str, runs: [&[usize]; 2], parameter: &str) -> bool {
    let is = |(set, own, what): &(&str, &[usize], &str)| {
        name.ends_with(set) && runs.contains(own) && *what == parameter
    };
    APART.iter().any(is)
}

/// Contradictions between two answers of a set: one names a cause without a rival, and the other neither has
/// that cause nor says `unknown`; or intervals of a parameter do not overlap.
fn contradictions(name: &str, [a, b]: [&(Vec<usize>, Study); 2]) -> Vec<String> {
    let mut all = Vec::new();
    let runs = [&a.0[..], &b.0[..]];
    for finding in
        a.1.diagnosis
            .findings
            .iter()
            .filter(|f| f.rivals.is_empty())
    {
        let (id, column) = (finding.best.id, finding.best.column.as_deref());
        let Some(there) = b.1.diagnosis.findings.iter().find(|f| has(f, id, column)) else {
            if b.1.diagnosis.unknown.is_none() {
                all.push(format!("{name}: {id} in {runs:?}"));
            }
            continue;
        };
        for own in finding.best.reported.iter().filter(|_| there.best.id == id) {
            let other = there
                .best
                .reported
                .iter()
                .find(|other| other.name == own.name);
            let both = own.interval.zip(other.and_then(|other| other.interval));
            if let Some((x, y)) = both
                && !overlap(x, y)
                && !is_apart(name, runs, &own.name)
            {
                all.push(format!("{name}: {} in {runs:?}: {x:?}, {y:?}", own.name));
            }
        }
    }
    all
}

/// Subsets of two or more runs do not contradict each other. In nine of ten subsets, the gain on the runs that
/// were left out is at least half of the best subset's gain. The gain of `air-chambers` is not compared: each
/// of its runs is of another chamber.
#[test]
#[ignore = "nightly: 6 min"]
fn subsets_of_real_runs_agree() {
    let (mut wrong, mut enough, mut poor) = (Vec::new(), 0, Vec::new());
    for folder in sets() {
        let name = folder.display().to_string();
        let data = read(&folder, &|_| ()).expect("data").experiment;
        let (n, settings) = (data.runs.len(), Settings::default());
        let mut told: Vec<(Vec<usize>, Study)> = Vec::new();
        let mut gains = Vec::new();
        for runs in subsets(n) {
            // A subset that is refused as an experiment has no answer.
            let Ok(found) = study(&part(&data, &runs), None, &settings, &|_| ()) else {
                continue;
            };
            let others: Vec<usize> = (0..n).filter(|k| !runs.contains(k)).collect();
            let gain = (!others.is_empty())
                .then(|| gain(&data, &others, &found))
                .flatten();
            println!(
                "{name} {runs:?}, gain {gain:?}: {}",
                verdict::say(&found.diagnosis)
            );
            gains.extend(gain.map(|gain| (runs.clone(), gain)));
            told.push((runs, found));
        }
        for a in &told {
            wrong.extend(told.iter().flat_map(|b| contradictions(&name, [a, b])));
        }
        let best = gains.iter().map(|gain| gain.1).fold(0.0, f64::max);
        for (runs, gain) in gains
            .into_iter()
            .filter(|_| !name.ends_with("air-chambers"))
        {
            if gain >= 0.5 * best {
                enough += 1;
            } else {
                poor.push(format!("{name} {runs:?}: {gain:.2} of {best:.2}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(poor.len() * 9 <= enough, "{enough} and {poor:#?}");
}
