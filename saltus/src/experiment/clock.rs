//! The time column: its order, its length and its gaps.

use std::path::Path;

use super::error::Error;
use super::header::bare;
use super::instant::Instant;
use super::lines::Lines;
use super::thin::Thinned;
use saltus_diagnosis::spec::Spec;

/// A step so many times the usual one is a gap.
const GAP: f64 = 10.0;
/// A step so many times all others together is no part of a run.
const LOST: f64 = 100.0;
/// Most rows that are read again to say what is wrong with their order.
const MOST_AGAIN: usize = 4_000_000;

/// The times of the rows that count.
#[derive(Debug, Default)]
pub(super) struct Clock {
    /// First and last.
    span: Option<(Instant, Instant)>,
    /// Longest step (ps), and the line and the instant where it ends.
    longest: Option<(i128, u64, Instant)>,
    /// How many steps.
    steps: usize,
}

impl Clock {
    /// Takes in the next instant.
    pub(super) fn tick(&mut self, line: u64, time: Instant) {
        let Some((_, last)) = &mut self.span else {
            self.span = Some((time, time));
            return;
        };
        let step = time.picoseconds_since(*last);
        if self.longest.is_none_or(|(longest, ..)| step > longest) {
            self.longest = Some((step, line, time));
        }
        self.steps += 1;
        *last = time;
    }

    /// The instant from which a run counts its times: its first row. No row: any instant.
    pub(super) fn origin(&self) -> Instant {
        self.span.map_or(Instant::of_row(0), |(first, _)| first)
    }

    /// Refuses a run that is too long to be one, from its first row or from the `command` of its
    /// valve.
    pub(super) fn judge(
        &self,
        file: &str,
        spec: &Spec,
        command: Option<Instant>,
    ) -> Result<(), Error> {
        if let (Some((first, last)), Some((longest, line, after))) = (self.span, self.longest) {
            let (longest, all) = (longest as f64 * 1e-12, last.since(first));
            if self.steps > 1 && longest > LOST * (all - longest) {
                let symptom = format!(
                    "= {after} is {longest:.2e} s after the row before, and all other rows are \
                     within {:.2e} s: is one of the two stamps wrong?",
                    all - longest
                );
                return Err(Error::signal(format!("{file}:{line}"), "time_s", symptom));
            }
        }
        let span = self
            .span
            .map(|(from, to)| (command.map_or(from, |command| command.min(from)), to));
        match span {
            Some((from, to)) if to.since(from) > spec.longest => {
                let symptom = format!(
                    "goes from {from} to {to}, and no {} takes more than {} s: is it in ms?",
                    spec.id, spec.longest
                );
                Err(Error::signal(file, "time_s", symptom))
            }
            _ => Ok(()),
        }
    }

    /// A note of the longest gap, if there is one, in a run of which these rows are kept.
    pub(super) fn gap(&self, name: &str, kept: &Thinned) -> Option<String> {
        let (longest, line, _) = self.longest?;
        let longest = longest as f64 * 1e-12;
        let mut steps: Vec<f64> = kept
            .time
            .windows(2)
            .map(|pair| pair[1].since(pair[0]))
            .collect();
        steps.sort_by(f64::total_cmp);
        // What is kept of a long run has wider steps than the run.
        let usual = steps.get(steps.len() / 2)? * kept.time.len() as f64 / kept.seen as f64;
        let wide = longest > GAP * usual;
        wide.then(|| {
            format!(
                "{name}:{line}: {longest:.2e} s after the row before, where the usual step is \
                 {usual:.2e} s"
            )
        })
    }
}

/// Why the last of `times` at `line` of the file at `path` does not come after the first.
pub(super) fn disorder(
    path: &Path,
    file: &str,
    line: u64,
    (column, power): (usize, i32),
    times: (Instant, Instant),
) -> Error {
    let (last, time) = times;
    let place = format!("{file}:{line}");
    if last == time {
        return Error::signal(
            place,
            "time_s",
            format!("= {time} is also that of the row before: it must increase"),
        );
    }
    let cause = match again(path, column, power) {
        Some(Order::Shuffled) => "; the rows only are shuffled: sort them by time",
        Some(Order::Single) => "; without this row or the one before it all would be in order",
        Some(Order::Restarted) => "; the clock starts again: a file must be one run",
        None => "",
    };
    Error::signal(
        place,
        "time_s",
        format!("= {time} follows {last}: it must increase{cause}"),
    )
}

/// What is wrong with the order of times.
#[derive(Debug, PartialEq)]
enum Order {
    /// All differ.
    Shuffled,
    /// One is wrong.
    Single,
    /// They fall once, and some are there twice.
    Restarted,
}

/// What is wrong with the order of the times in a `column` of the file at `path`, in units of
/// 10^`power` s; none where it is not as simple.
fn again(path: &Path, column: usize, power: i32) -> Option<Order> {
    let mut lines = Lines::open(path).ok()?;
    lines.next().ok()?;
    let mut times: Vec<Instant> = Vec::new();
    while let Some((_, line)) = lines.next().ok()? {
        let cell = line.split(|byte| *byte == b',').nth(column)?;
        times.push(Instant::parse(
            bare(std::str::from_utf8(cell).ok()?),
            power,
        )?);
        if times.len() > MOST_AGAIN {
            return None;
        }
    }
    order(times)
}

fn order<T: Ord + Copy>(mut times: Vec<T>) -> Option<Order> {
    let falls = times.windows(2).filter(|pair| pair[1] <= pair[0]).count();
    let fall = 1 + times.windows(2).position(|pair| pair[1] <= pair[0])?;
    times.swap(fall - 1, fall);
    if increase(&times, &[]) {
        return Some(Order::Shuffled);
    }
    times.swap(fall - 1, fall);
    if [fall - 1, fall]
        .iter()
        .any(|&wrong| increase(&times[..wrong], &times[wrong + 1..]))
    {
        return Some(Order::Single);
    }
    times.sort_unstable();
    match (increase(&times, &[]), falls) {
        (true, _) => Some(Order::Shuffled),
        (false, 1) => Some(Order::Restarted),
        _ => None,
    }
}

/// Whether times increase from one to the next, first the one part, then the other.
fn increase<T: Ord>(first: &[T], then: &[T]) -> bool {
    first.iter().chain(then).is_sorted_by(|a, b| a < b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_times_is_understood() {
        let check = |times: &[u32], expected: Option<Order>| {
            assert_eq!(order(times.to_vec()), expected, "{times:?}");
        };
        check(&[1, 2, 3], None);
        check(&[1, 3, 2, 4], Some(Order::Shuffled));
        check(&[4, 3, 2, 1], Some(Order::Shuffled));
        check(&[1, 9, 2, 3], Some(Order::Single));
        check(&[1, 2, 0, 3, 4], Some(Order::Single));
        check(&[1, 2, 1, 3, 4], Some(Order::Single));
        check(&[1, 2, 3, 1, 2, 3], Some(Order::Restarted));
        check(&[1, 1, 3, 2, 5, 1], None);
    }
}
