//! The campaign: hidden effects of every cause in every kind of experiment, and what the diagnosis
//! says of each.
//!
//!     cd studies && cargo run --release --bin campaign [kind=all] [what=clear,none] [seeds=2] [first=1] [cause=ID] [noise=untold] [discrepancy=0.4] [form=event]
//!
//! With nothing given it runs flights only; with `noise=untold` the folders do not say how much
//! their columns scatter; `discrepancy` adds a process to every column, in standard deviations of
//! a reading, that no cause explains: a smooth one, or with `form=event` steps at the valve's
//! commands, or at the start, that die away.
//!
//! | `what` | data | right |
//! | --- | --- | --- |
//! | `none` | no effect | no answer |
//! | `clear`, `subtle` | one cause of 6 to 12 σ, of 2 σ | its name |
//! | `two` | two causes of 6 to 12 σ | both names |
//! | `outside`, `outside-clear` | one effect off the list of 15 to 30 σ, of 6 to 12 σ | `unknown`, beside a cause or as its rival |
//! | `beside` | a cause of 6 to 12 σ and an effect off the list of 15 to 30 σ | its name and `unknown`, or `unknown` alone |
//! | `huge` | one cause of 100 to 1,000 σ | its name, `unknown`, or both |
//! | `ar` | no effect, noise with a lag-1 autocorrelation of 0.6 to 0.7 | no answer |
//! | `misstated` | no effect, noise stated five times too large or too small | no name |
//! | `precise` | columns whose span is 1e5 times their noise: no effect, and one cause of 6 to 12 σ | as without |

use std::collections::BTreeMap;
use std::time::Instant;

use saltus::study::{StudyError, study};
use saltus_diagnosis::{Candidate, Diagnosis, Interval, Kind, Settings, Sort, kinds};
use saltus_robot::Robot;
use saltus_tests::lab::{self, Case, Effect, Form, Rough, Size};
use saltus_tests::verdict;

/// What was hidden, and what was said.
#[derive(Default)]
struct Tally {
    sets: usize,
    right: usize,
    alone: usize,
    parameters: usize,
    within: usize,
    intervals: usize,
    inside: usize,
    /// Intervals that do not hold what is hidden.
    outside: Vec<String>,
    /// A cause named without rivals that is not hidden, and no `unknown` said.
    alone_wrong: usize,
    /// Right by `unknown` alone.
    abstained: usize,
    gains: usize,
    at_noise: usize,
    wrong: Vec<String>,
    /// Of each effect: how often it was hidden, named alone, named with rivals; and what was said
    /// else.
    by_effect: BTreeMap<String, (usize, usize, usize, Vec<String>)>,
}

fn option(name: &str) -> Option<String> {
    std::env::args().find_map(|a| a.strip_prefix(&format!("{name}=")).map(str::to_owned))
}

fn number(name: &str, default: u64) -> u64 {
    option(name).and_then(|x| x.parse().ok()).unwrap_or(default)
}

fn lists(name: &str, value: &str) -> bool {
    option(name).is_none_or(|list| list.split(',').any(|x| x.eq_ignore_ascii_case(value)))
}

/// A set of data of the campaign.
struct Set {
    what: &'static str,
    hidden: Vec<(&'static str, Size)>,
    rough: Rough,
}

/// The sets of a kind of experiment with this seed.
fn sets(sort: Sort, seed: u64) -> Vec<Set> {
    let (causes, outside) = (lab::causes_of(sort), lab::outside(sort));
    let seed_number = usize::try_from(seed).unwrap_or(0);
    let rough = Rough {
        discrepancy: option("discrepancy")
            .and_then(|x| x.parse().ok())
            .unwrap_or(0.0),
        form: match option("form").as_deref() {
            Some("event") => Form::Event,
            _ => Form::Smooth,
        },
        ..Rough::default()
    };
    let set = |what, hidden: &[_]| Set {
        what,
        hidden: hidden.to_vec(),
        rough,
    };
    let each = |what, ids: &[&'static str], size| -> Vec<Set> {
        ids.iter().map(|id| set(what, &[(*id, size)])).collect()
    };
    let of_noise = |what, rough| Set {
        rough,
        ..set(what, &[])
    };
    let mut all = vec![
        set("none", &[]),
        of_noise(
            "ar",
            Rough {
                autocorrelation: 0.6 + 0.1 * (0.618 * seed as f64).fract(),
                ..rough
            },
        ),
        of_noise(
            "misstated",
            Rough {
                stated: if seed.is_multiple_of(2) { 5.0 } else { 0.2 },
                ..rough
            },
        ),
        set("precise", &[]),
    ];
    all.extend(each("precise", causes, Size::Clear));
    for set in all.iter_mut().filter(|set| set.what == "precise") {
        set.rough.precision = Some(1e5);
    }
    all.extend(each("clear", causes, Size::Clear));
    all.extend(each("subtle", causes, Size::Subtle));
    all.extend(each("huge", causes, Size::Huge));
    all.extend(each("outside", outside, Size::Large));
    all.extend(each("outside-clear", outside, Size::Clear));
    all.extend(causes.iter().enumerate().map(|(k, id)| {
        let unlisted = outside[(seed_number + k) % outside.len()];
        set("beside", &[(id, Size::Clear), (unlisted, Size::Large)])
    }));
    for k in 0..4 {
        let n = causes.len();
        let a = (seed_number * 7 + k * 5) % n;
        let b = (a + 1 + (seed_number * 3 + k * 2) % (n - 1)) % n;
        let pair = [a, b].map(|i| (causes[i], Size::Clear));
        // A flight's change by three names.
        let is_fall = |id| ["gravity", "counterweight", "encoder-scale"].contains(&id);
        if sort != Sort::Flight || !pair.iter().all(|(id, _)| is_fall(*id)) {
            all.push(set("two", &pair));
        }
    }
    let is_asked = |set: &Set| {
        let cause = set.hidden.first().filter(|_| set.what != "two");
        lists("what", set.what) && cause.is_none_or(|(id, _)| lists("cause", id))
    };
    all.into_iter().filter(is_asked).collect()
}

fn main() {
    let (first, seeds) = (number("first", 1), number("seeds", 1));
    let mut table: BTreeMap<(String, String), Tally> = BTreeMap::new();
    for sort in lab::SORTS {
        let name = sort.spec().id.to_owned();
        let wanted = option("kind").unwrap_or_else(|| "flight".into());
        if wanted != "all" && !wanted.split(',').any(|x| x == name) {
            continue;
        }
        for seed in first..first + seeds {
            for set in sets(sort, seed) {
                one(&mut table, &name, sort, &set, seed);
            }
        }
    }
    print(&table);
}

/// Tables of the counts.
fn print(table: &BTreeMap<(String, String), Tally>) {
    println!(
        "\n| kind | hidden | sets | right | % | named alone | parameters within 2 errors | in 95 \
         % interval | rms at most 1.1 noise |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for ((kind, what), t) in table {
        println!(
            "| {kind} | {what} | {} | {} | {:.0} | {} | {} of {} | {} of {} | {} of {} |",
            t.sets,
            t.right,
            100.0 * t.right as f64 / t.sets as f64,
            t.alone,
            t.within,
            t.parameters,
            t.inside,
            t.intervals,
            t.at_noise,
            t.gains
        );
    }
    println!("\n| kind | hidden | effect | sets | alone | with rivals | otherwise |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    for ((kind, what), t) in table
        .iter()
        .filter(|((_, what), _)| what != "none" && what != "two")
    {
        for (effect, (sets, alone, rivals, other)) in &t.by_effect {
            println!(
                "| {kind} | {what} | {effect} | {sets} | {alone} | {rivals} | {} |",
                other.join("; ")
            );
        }
    }
    totals(table);
    for ((kind, what), t) in table {
        for wrong in &t.wrong {
            println!("{kind} {what}: {wrong}");
        }
        for outside in &t.outside {
            println!("{kind} {what}, outside its interval: {outside}");
        }
    }
}

/// Coverage of intervals and names that are wrong, over every set of every kind.
fn totals(table: &BTreeMap<(String, String), Tally>) {
    let mut rows: BTreeMap<&str, [usize; 6]> = BTreeMap::new();
    let mut all = [0; 6];
    let add = |to: &mut [usize; 6], from: &[usize; 6]| {
        to.iter_mut().zip(from).for_each(|(to, from)| *to += from);
    };
    for ((_, what), t) in table {
        let counts = [
            t.sets,
            t.right,
            t.abstained,
            t.alone_wrong,
            t.inside,
            t.intervals,
        ];
        add(rows.entry(what).or_default(), &counts);
        add(&mut all, &counts);
    }
    println!(
        "\n| hidden | sets | right | of them by unknown alone | named alone and wrong | in 95 % interval |"
    );
    println!("| --- | --- | --- | --- | --- | --- |");
    for (what, [sets, right, abstained, wrong, inside, intervals]) in
        rows.into_iter().chain([("all", all)])
    {
        let share = 100.0 * inside as f64 / intervals.max(1) as f64;
        println!(
            "| {what} | {sets} | {right} | {abstained} | {wrong} | {inside} of {intervals} \
             ({share:.0} %) |"
        );
    }
}

/// Noise of its own for every set: one unlucky draw is one set.
fn draw_of(what: &str, hidden: &[(&str, Size)]) -> u64 {
    let names = hidden.iter().flat_map(|(id, _)| id.bytes());
    let all = names.chain(what.bytes());
    all.fold(1, |hash, b| hash.wrapping_mul(31) + u64::from(b))
}

fn one(
    table: &mut BTreeMap<(String, String), Tally>,
    name: &str,
    sort: Sort,
    Set {
        what,
        hidden,
        rough,
    }: &Set,
    seed: u64,
) {
    let start = Instant::now();
    let draw = draw_of(what, hidden);
    let mut case = lab::make_rough(sort, hidden, &Rough { draw, ..*rough }, seed);
    if *what == "huge" && case.truth[0].sigmas < 100.0 {
        return;
    }
    if lists("noise", "untold") && option("noise").is_some() {
        case.experiment.noise.fill(None);
    }
    let made = start.elapsed().as_secs_f64();
    let robot = case.robot.as_deref().and_then(Robot::builtin);
    let study = study(
        &case.experiment,
        robot.as_ref(),
        &Settings::default(),
        &|_| (),
    );
    let (kind, found) = match study {
        Ok(study) => (study.kind, Some(study.diagnosis)),
        Err(StudyError::Problem(_)) => return,
        Err(_) => match kinds::build(&case.experiment, robot.as_ref()) {
            Ok(kind) => (kind, None),
            Err(_) => return,
        },
    };
    let said = found
        .as_ref()
        .map_or_else(|| "no motion".into(), verdict::say);
    let tally = table.entry((name.into(), (*what).into())).or_default();
    let ids: Vec<&str> = hidden.iter().map(|h| h.0).collect();
    let is_right = found
        .as_ref()
        .is_some_and(|d| judge(tally, kind.as_ref(), d, &case, what));
    tally.sets += 1;
    tally.right += usize::from(is_right);
    let truth: Vec<String> = case
        .truth
        .iter()
        .map(|t| format!("{} {:?} ({:.1} σ)", t.id, t.parameters, t.sigmas))
        .collect();
    let line = format!("seed {seed} {}: {said}", truth.join(" + "));
    println!(
        "{} {name} {what} {ids:?} {line} [{:.1} + {:.1} s]",
        if is_right { "ok   " } else { "WRONG" },
        made,
        start.elapsed().as_secs_f64() - made
    );
    let is_abstained = found
        .as_ref()
        .is_some_and(|d| d.findings.is_empty() && d.unknown.is_some());
    tally.abstained += usize::from(is_right && is_abstained);
    let row = tally.by_effect.entry(ids.join(" + ")).or_default();
    row.0 += 1;
    let all = found.as_ref().map(|d| verdict::sets(d)).unwrap_or_default();
    match (
        is_right && !(is_abstained && ["huge", "beside"].contains(what)),
        all.as_slice(),
    ) {
        (true, [set]) if set.len() > 1 => row.2 += 1,
        (true, _) => row.1 += 1,
        (false, _) => {
            let mut ids: Vec<String> = all.iter().map(|set| set.join(" or ")).collect();
            ids.extend(
                found
                    .as_ref()
                    .and_then(|d| d.unknown.as_ref())
                    .map(|_| "unknown".into()),
            );
            row.3.push(if ids.is_empty() {
                "none".into()
            } else {
                ids.join(" and ")
            });
        }
    }
    if !is_right {
        tally.wrong.push(line);
    }
}

/// Whether the answer is right; counts intervals, and names that are wrong.
fn judge(tally: &mut Tally, kind: &dyn Kind, d: &Diagnosis, case: &Case, what: &str) -> bool {
    let sets = verdict::sets(d);
    if let [truth] = &case.truth[..] {
        tally.alone += usize::from(sets == [[truth.id]]);
    }
    tally.alone_wrong += usize::from(verdict::is_alone_and_wrong(d, &case.truth));
    let candidates = || {
        d.findings
            .iter()
            .flat_map(|f| std::iter::once(&f.best).chain(&f.rivals))
    };
    for truth in &case.truth {
        if let Some(candidate) = candidates().find(|c| is_of(kind, c, truth)) {
            tally.compare(candidate, truth);
        }
    }
    if ["clear", "subtle"].contains(&what) {
        for gain in &d.gains {
            tally.gains += 1;
            tally.at_noise += usize::from(gain.rms.1 <= 1.1 * gain.noise);
        }
    }
    let is_cautious = || {
        let is_named = || verdict::is_named(d, &case.truth[0]);
        d.unknown.is_some() && (d.findings.is_empty() || is_named())
    };
    match what {
        "outside" | "outside-clear" => {
            d.unknown.is_some() || d.findings.iter().any(|f| f.unlisted.is_some())
        }
        "beside" => is_cautious(),
        "huge" => is_cautious() || verdict::names(d, &case.truth),
        "misstated" => d.findings.is_empty(),
        _ => verdict::names(d, &case.truth),
    }
}

/// Whether a candidate is the hidden effect: a fault of a sensor, on the same column.
fn is_of(kind: &dyn Kind, candidate: &Candidate, truth: &Effect) -> bool {
    let is_sensor = kind.causes()[candidate.cause].fault.is_some();
    let column = candidate.column.as_deref().filter(|_| is_sensor);
    let is_on = |column: &str| truth.parameters.iter().any(|(n, _)| n.starts_with(column));
    candidate.id == truth.id && column.is_none_or(is_on)
}

impl Tally {
    /// Counts the parameters of a candidate that are as they are hidden.
    fn compare(&mut self, candidate: &Candidate, truth: &Effect) {
        for r in &candidate.reported {
            let hidden = truth.parameters.iter().find(|(n, _)| is_called(n, &r.name));
            let Some((_, known)) = hidden else { continue };
            self.parameters += 1;
            self.within += usize::from((r.value - known).abs() <= 2.0 * r.error);
            if let Some(Interval { low, high }) = r.interval {
                let is_inside =
                    low.is_none_or(|low| low <= *known) && high.is_none_or(|high| *known <= high);
                self.intervals += 1;
                self.inside += usize::from(is_inside);
                if !is_inside {
                    let (id, name) = (truth.id, &r.name);
                    self.outside
                        .push(format!("{id} {name} {known:.6e}: {low:?} to {high:?}"));
                }
            }
        }
    }
}

/// Whether the laboratory's `key` is the parameter that is reported as `name`: offsets of a sensor
/// have their column's unit in the report alone.
fn is_called(key: &str, name: &str) -> bool {
    key.ends_with(name) || (name.starts_with("offset_") && key.ends_with(" offset"))
}
