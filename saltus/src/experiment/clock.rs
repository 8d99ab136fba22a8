//! The time column: its order, its length and its gaps.

use std::path::Path;

use super::error::Error;
use super::header::bare;
use super::lines::Lines;
use super::spec::Spec;

/// A step so many times the usual one is a gap.
const GAP: f64 = 10.0;
/// Most rows that are read again to say what is wrong with their order.
const MOST_AGAIN: usize = 4_000_000;

/// The times of the rows that count.
#[derive(Debug, Default)]
pub(super) struct Clock {
    /// First and last (s).
    span: Option<(f64, f64)>,
    /// Longest step (s): where it starts and ends, and the line where it ends.
    longest: Option<(f64, f64, u64)>,
}

impl Clock {
    /// Takes in the next time (s).
    pub(super) fn tick(&mut self, line: u64, time: f64) {
        let Some((_, last)) = &mut self.span else {
            self.span = Some((time, time));
            return;
        };
        if self.longest.is_none_or(|(from, to, _)| time - *last > to - from) {
            self.longest = Some((*last, time, line));
        }
        *last = time;
    }

    /// Refuses a run that is too long to be one.
    pub(super) fn judge(&self, file: &str, spec: &Spec) -> Result<(), Error> {
        match self.span {
            Some((from, to)) if to - from > spec.longest => {
                let symptom = format!(
                    "goes from {from} to {to}, and no {} takes more than {} s: is it in ms?",
                    spec.id, spec.longest
                );
                Err(Error::signal(file, "time_s", symptom))
            }
            _ => Ok(()),
        }
    }

    /// A note of the longest gap, if there is one, in a run of so many rows.
    pub(super) fn gap(&self, name: &str, kept: &[f64], rows: usize) -> Option<String> {
        let (from, to, line) = self.longest?;
        let mut steps: Vec<f64> = kept.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        // What is kept of a long run has wider steps than the run.
        let usual = steps.get(steps.len() / 2)? * kept.len() as f64 / rows as f64;
        let wide = to - from > GAP * usual;
        wide.then(|| {
            format!("{name}:{line}: no row between {from} and {to} s, where {usual:.2e} s is the usual step")
        })
    }
}

/// Why the `time` at `line` of the file at `path` does not come after `last`.
pub(super) fn disorder(path: &Path, file: &str, line: u64, column: usize, times: (f64, f64)) -> Error {
    let (last, time) = times;
    let place = format!("{file}:{line}");
    if last == time {
        return Error::signal(
            place,
            "time_s",
            format!("= {time} is also that of the row before: it must increase"),
        );
    }
    let cause = match again(path, column) {
        Some(Order::Shuffled) => "; the rows only are shuffled: sort them by time",
        Some(Order::Single) => "; without this row or the one before it all would be in order",
        Some(Order::Restarted) => "; the clock starts again: a file must be one run",
        None => "",
    };
    Error::signal(place, "time_s", format!("= {time} follows {last}: it must increase{cause}"))
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

/// What is wrong with the order of the times in a `column` of the file at `path`; none where it is not as simple.
fn again(path: &Path, column: usize) -> Option<Order> {
    let mut lines = Lines::open(path).ok()?;
    lines.next().ok()?;
    let mut times: Vec<f64> = Vec::new();
    while let Some((_, line)) = lines.next().ok()? {
        let cell = line.split(|byte| *byte == b',').nth(column)?;
        times.push(bare(std::str::from_utf8(cell).ok()?).parse().ok().filter(|time: &f64| time.is_finite())?);
        if times.len() > MOST_AGAIN {
            return None;
        }
    }
    order(times)
}

fn order(mut times: Vec<f64>) -> Option<Order> {
    let falls = times.windows(2).filter(|pair| pair[1] <= pair[0]).count();
    let fall = 1 + times.windows(2).position(|pair| pair[1] <= pair[0])?;
    times.swap(fall - 1, fall);
    if increase(&times, &[]) {
        return Some(Order::Shuffled);
    }
    times.swap(fall - 1, fall);
    if [fall - 1, fall].iter().any(|&wrong| increase(&times[..wrong], &times[wrong + 1..])) {
        return Some(Order::Single);
    }
    times.sort_unstable_by(f64::total_cmp);
    match (increase(&times, &[]), falls) {
        (true, _) => Some(Order::Shuffled),
        (false, 1) => Some(Order::Restarted),
        _ => None,
    }
}

/// Whether times increase from one to the next, first the one part, then the other.
fn increase(first: &[f64], then: &[f64]) -> bool {
    first.iter().chain(then).is_sorted_by(|a, b| a < b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_times_is_understood() {
        let check = |times: &[f64], expected: Option<Order>| {
            assert_eq!(order(times.to_vec()), expected, "{times:?}");
        };
        check(&[1.0, 2.0, 3.0], None);
        check(&[1.0, 3.0, 2.0, 4.0], Some(Order::Shuffled));
        check(&[4.0, 3.0, 2.0, 1.0], Some(Order::Shuffled));
        check(&[1.0, 9.0, 2.0, 3.0], Some(Order::Single));
        check(&[1.0, 2.0, 0.0, 3.0, 4.0], Some(Order::Single));
        check(&[1.0, 2.0, 1.0, 3.0, 4.0], Some(Order::Single));
        check(&[1.0, 2.0, 3.0, 1.0, 2.0, 3.0], Some(Order::Restarted));
        check(&[1.0, 1.0, 3.0, 2.0, 5.0, 1.0], None);
    }
}
