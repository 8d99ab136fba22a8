//! Numbers of several topics, each with its own times, as rows of one table.

use std::collections::BTreeMap;
use std::io::Write;

use saltus_diagnosis::spec::Spec;
use saltus_telemetry as telemetry;

use super::super::manifest::LogClock;
use super::{Look, MOST};

/// A step so many times the usual one of its topic is a gap, over which nothing is interpolated.
const GAP: i64 = 10;

/// The messages of a topic.
pub(super) struct Track {
    names: Vec<String>,
    pub(super) has_header: bool,
    /// Times of the log (ns).
    pub(super) log_times: Vec<i64>,
    /// Times of the headers (ns), if there are any.
    stamps: Vec<i64>,
    /// The numbers of each message, one after the other.
    values: Vec<f64>,
    found: Vec<f64>,
}

impl Track {
    pub(super) fn new(names: Vec<String>, has_header: bool) -> Track {
        Track {
            found: vec![f64::NAN; names.len() + 2],
            names,
            has_header,
            log_times: Vec::new(),
            stamps: Vec::new(),
            values: Vec::new(),
        }
    }

    pub(super) fn add(
        &mut self,
        look: &Look,
        log_time: u64,
        data: &[u8],
    ) -> Result<(), telemetry::Error> {
        if self.log_times.len() >= MOST {
            let reason = format!("more than {MOST} messages on one topic: cut the file");
            return Err(std::io::Error::other(reason).into());
        }
        self.found.fill(f64::NAN);
        look.selection.find(data, &mut self.found)?;
        self.log_times
            .push(i64::try_from(log_time).unwrap_or(i64::MAX));
        if look.has_header {
            // Whole numbers of 32 bits.
            #[allow(clippy::cast_possible_truncation)]
            let [seconds, rest] =
                [self.found[look.columns], self.found[look.columns + 1]].map(|x| x as i64);
            // Other types than those of ROS may hold anything.
            let stamp = seconds.saturating_mul(1_000_000_000).saturating_add(rest);
            self.stamps.push(stamp);
        }
        self.values.extend(&self.found[..look.columns]);
        Ok(())
    }

    /// All columns, row by row.
    pub(super) fn text(&self) -> Vec<u8> {
        let mut text = self.names.join(",").into_bytes();
        text.push(b'\n');
        for row in self.values.chunks_exact(self.names.len().max(1)) {
            line(&mut text, None, row);
        }
        text
    }

    /// Messages in the order of `clock`: times (ns), and which each is. Of those with one time the
    /// last counts.
    fn ordered(&self, clock: LogClock) -> (Vec<(i64, usize)>, usize) {
        let times = match clock {
            LogClock::Header => &self.stamps,
            LogClock::Log => &self.log_times,
        };
        let mut order: Vec<(i64, usize)> = times.iter().copied().zip(0..).collect();
        order.sort_unstable();
        let all = order.len();
        let mut kept: Vec<(i64, usize)> = Vec::with_capacity(all);
        for one in order {
            match kept.last_mut() {
                Some(last) if last.0 == one.0 => *last = one,
                _ => kept.push(one),
            }
        }
        let left_out = all - kept.len();
        (kept, left_out)
    }

    fn value(&self, message: usize, column: usize) -> f64 {
        self.values[message * self.names.len() + column]
    }
}

/// Writes a row; what is NaN is an empty cell.
fn line(text: &mut Vec<u8>, time: Option<i64>, row: &[f64]) {
    // Writing to a list does not fail.
    let _ = time.map(|time| write!(text, "{time},"));
    for (k, x) in row.iter().enumerate() {
        if k > 0 {
            text.push(b',');
        }
        let _ = (!x.is_nan()).then(|| write!(text, "{x:?}"));
    }
    text.push(b'\n');
}

/// Time (ns) from a message to the next.
fn step(two: &[(i64, usize)]) -> i64 {
    two[1].0.saturating_sub(two[0].0)
}

/// Whether a column holds its value until it is told another.
fn is_held(name: &str) -> bool {
    name == "valve" || name.starts_with("valve_")
}

/// The text of the table in which the tracks, each with its topic, stand side by side.
pub(super) fn joined(
    tracks: &[(String, Track)],
    clock: LogClock,
    spec: &Spec,
    notes: &mut Vec<String>,
) -> Result<Vec<u8>, String> {
    let mut joint = Joint::new(tracks, clock, notes);
    if !spec.timed {
        let [(_, track)] = tracks else {
            let reason = "must have all its columns from one topic: a message is a row";
            return Err(format!("a run of kind {} {reason}", spec.id));
        };
        return Ok(track.text());
    }
    if spec.any_of {
        joint.side_by_side();
    } else {
        joint.onto_the_fastest(notes);
    }
    let names: Vec<&str> = joint.names().collect();
    let mut text = format!("time_ns,{}\n", names.join(",")).into_bytes();
    for (time, row) in &joint.rows {
        line(&mut text, Some(*time), row);
    }
    Ok(text)
}

/// Rows as they come together.
struct Joint<'a> {
    tracks: &'a [(String, Track)],
    /// The messages of each in their order.
    orders: Vec<Vec<(i64, usize)>>,
    /// Where the columns of each begin.
    first: Vec<usize>,
    width: usize,
    rows: BTreeMap<i64, Vec<f64>>,
}

impl<'a> Joint<'a> {
    fn new(tracks: &'a [(String, Track)], clock: LogClock, notes: &mut Vec<String>) -> Joint<'a> {
        let (mut orders, mut first, mut width) = (Vec::new(), Vec::new(), 0);
        for (topic, track) in tracks {
            let (order, left_out) = track.ordered(clock);
            if left_out > 0 {
                notes.push(format!(
                    "{left_out} messages on {topic} have the time of another and are left out"
                ));
            }
            orders.push(order);
            first.push(width);
            width += track.names.len();
        }
        Joint {
            tracks,
            orders,
            first,
            width,
            rows: BTreeMap::new(),
        }
    }

    fn names(&self) -> impl Iterator<Item = &'a str> {
        let tracks = self.tracks.iter();
        tracks.flat_map(|(_, track)| track.names.iter().map(String::as_str))
    }

    fn row(&mut self, time: i64) -> &mut Vec<f64> {
        let width = self.width;
        self.rows
            .entry(time)
            .or_insert_with(|| vec![f64::NAN; width])
    }

    /// Every message is a row; what others measured then is missing in it.
    fn side_by_side(&mut self) {
        for t in 0..self.tracks.len() {
            self.take(t);
        }
    }

    /// Puts the messages of track `t` in their rows.
    fn take(&mut self, t: usize) {
        let (track, first) = (&self.tracks[t].1, self.first[t]);
        for (time, message) in self.orders[t].clone() {
            let row = self.row(time);
            for column in 0..track.names.len() {
                row[first + column] = track.value(message, column);
            }
        }
    }

    /// The messages of the fastest topic are rows. Others are interpolated to them, and valves hold
    /// their value; a valve that switches between two rows has a row of its own.
    fn onto_the_fastest(&mut self, notes: &mut Vec<String>) {
        let measures = |t: &usize| self.tracks[*t].1.names.iter().any(|name| !is_held(name));
        let measuring = (0..self.tracks.len()).filter(measures);
        // Of equally fast ones the first.
        let fastest = measuring
            .rev()
            .max_by_key(|t| self.orders[*t].len())
            .unwrap_or(0);
        self.take(fastest);
        let times: Vec<i64> = self.orders[fastest].iter().map(|(time, _)| *time).collect();
        for t in (0..self.tracks.len()).filter(|t| *t != fastest) {
            let (topic, track) = &self.tracks[t];
            let measured = (0..track.names.len()).filter(|column| !is_held(&track.names[*column]));
            let moved = measured.map(|column| self.interpolate(t, column, &times));
            if let Some(moved) = moved.max().filter(|moved| *moved > 0) {
                notes.push(format!(
                    "{topic} is interpolated to the times of {}, in {moved} rows",
                    self.tracks[fastest].0
                ));
            }
        }
        let held = self.held();
        for (t, column) in &held {
            self.switch(*t, *column);
        }
        for (t, column) in &held {
            self.hold(*t, *column);
        }
    }

    /// The columns that hold their value, each with its track.
    fn held(&self) -> Vec<(usize, usize)> {
        let of = |t: usize| {
            let names = self.tracks[t].1.names.iter().enumerate();
            names
                .filter(|(_, name)| is_held(name))
                .map(move |(column, _)| (t, column))
        };
        (0..self.tracks.len()).flat_map(of).collect()
    }

    /// Fills a column at `times`; gives how many values no message has.
    fn interpolate(&mut self, t: usize, column: usize, times: &[i64]) -> usize {
        let (track, order) = (&self.tracks[t].1, self.orders[t].clone());
        let place = self.first[t] + column;
        let mut steps: Vec<i64> = order.windows(2).map(step).collect();
        steps.sort_unstable();
        let longest = steps
            .get(steps.len() / 2)
            .map_or(0, |step| step.saturating_mul(GAP));
        let mut made = 0;
        for time in times {
            let after = order.partition_point(|(t, _)| t < time);
            let x = match (order.get(after.wrapping_sub(1)), order.get(after)) {
                (_, Some((t, message))) if t == time => track.value(*message, column),
                (Some((t0, a)), Some((t1, b))) if t1.saturating_sub(*t0) <= longest => {
                    made += 1;
                    let part = time.saturating_sub(*t0) as f64;
                    let share = part / t1.saturating_sub(*t0) as f64;
                    let (a, b) = (track.value(*a, column), track.value(*b, column));
                    a + share * (b - a)
                }
                _ => continue,
            };
            self.row(*time)[place] = x;
        }
        made
    }

    /// Puts in rows where a valve switches. Before its first message it is shut.
    fn switch(&mut self, t: usize, column: usize) {
        let mut last = 0.0;
        for (time, message) in self.orders[t].clone() {
            let x = self.tracks[t].1.value(message, column);
            if x.is_finite() && x != last {
                last = x;
                self.row(time);
            }
        }
    }

    /// Fills the column of a valve in all rows.
    fn hold(&mut self, t: usize, column: usize) {
        let (track, order) = (&self.tracks[t].1, &self.orders[t]);
        let place = self.first[t] + column;
        let (mut next, mut last) = (0, 0.0);
        for (time, row) in &mut self.rows {
            while let Some((_, message)) = order.get(next).filter(|(told, _)| told <= time) {
                let x = track.value(*message, column);
                last = if x.is_finite() { x } else { last };
                next += 1;
            }
            row[place] = last;
        }
    }
}
