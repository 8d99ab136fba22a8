//! How commanded speeds are held.

/// A commanded speed: how it was held in the second half of its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Held {
    /// From when (s) and to when.
    pub(super) from: f64,
    to: f64,
    /// What is demanded (m/s).
    pub(super) speed: f64,
    /// Time (s) and travel (m) where the second half begins, and where it ends.
    begin: Option<[f64; 2]>,
    end: [f64; 2],
}

impl Held {
    /// Those of the schedule `speeds`, from each time (s) on a speed (m/s), up to `seconds` (s).
    pub(super) fn all(speeds: &[[f64; 2]], seconds: f64) -> Vec<Held> {
        let ends = speeds.iter().skip(1).map(|next| next[0].min(seconds));
        let ends = ends.chain([seconds]);
        let begun = speeds.iter().zip(ends).filter(|(at, _)| at[0] < seconds);
        begun
            .map(|(&[from, speed], to)| Held {
                from,
                to,
                speed,
                begin: None,
                end: [0.0; 2],
            })
            .collect()
    }

    /// Notes the travel (m) at a time (s).
    pub(super) fn note(&mut self, time: f64, travel: f64) {
        if time >= 0.5 * (self.from + self.to) && time <= self.to {
            self.begin.get_or_insert([time, travel]);
            self.end = [time, travel];
        }
    }

    /// Mean speed (m/s) over the second half; none where the run did not come to it.
    pub(super) fn mean(&self) -> Option<f64> {
        let [time, travel] = self.begin?;
        let span = self.end[0] - time;
        (span > 0.0).then(|| (self.end[1] - travel) / span)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_half_of_each_speed_counts() {
        let mut all = Held::all(&[[0.0, 1.0], [4.0, -2.0], [30.0, 1.0]], 8.0);
        assert_eq!(all.len(), 2);
        // At 1 m/s to 4 s, back at 2 m/s after 6 s.
        for k in 0..800 {
            let time = 0.01 * f64::from(k);
            let travel = if time < 6.0 {
                time.min(4.0)
            } else {
                4.0 - 2.0 * (time - 6.0)
            };
            for held in &mut all {
                held.note(time, travel);
            }
        }
        let means: Vec<f64> = all.iter().filter_map(Held::mean).collect();
        assert!((means[0] - 1.0).abs() < 1e-9 && (means[1] + 2.0).abs() < 1e-9);
    }
}
