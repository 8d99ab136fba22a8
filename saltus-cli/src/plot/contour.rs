//! Contour lines of a quantity on a grid, by marching squares.

/// Some ten round numbers between `low` and `high`.
pub(super) fn levels(low: f64, high: f64) -> Vec<f64> {
    let width = high - low;
    if width <= 0.0 || !width.is_finite() {
        return Vec::new();
    }
    let raw = width / 12.0;
    let power = 10_f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|m| m * power)
        .find(|step| *step >= raw)
        .unwrap_or(power);
    let first = (low / step).ceil();
    (0..20)
        .map(|i| (first + f64::from(i)) * step)
        .take_while(|level| *level <= high)
        .collect()
}

/// A quantity on a grid, y within x. It is continuous only where the kind is the same.
pub(super) struct Field<'a> {
    pub(super) x: &'a [f64],
    pub(super) y: &'a [f64],
    pub(super) values: &'a [Option<f64>],
    pub(super) kinds: &'a [&'static str],
}

impl Field<'_> {
    /// The contour of `level`: straight pieces within the squares between neighbours of one kind.
    pub(super) fn segments(&self, level: f64) -> Vec<[(f64, f64); 2]> {
        let mut found = Vec::new();
        for i in 1..self.x.len() {
            for j in 1..self.y.len() {
                if let Some([a, b, c, d]) = self.square(i, j, level) {
                    let crossings: Vec<_> = [(a, b), (b, c), (c, d), (d, a)]
                        .into_iter()
                        .filter_map(crossing)
                        .collect();
                    found.extend(crossings.chunks_exact(2).map(|pair| [pair[0], pair[1]]));
                }
            }
        }
        found
    }

    /// The corners of a square, its last being (i, j), with their values above `level`.
    fn square(&self, i: usize, j: usize, level: f64) -> Option<[Corner; 4]> {
        let corners = [(i - 1, j - 1), (i, j - 1), (i, j), (i - 1, j)];
        let place = |(i, j): (usize, usize)| i * self.y.len() + j;
        if corners
            .iter()
            .any(|corner| self.kinds[place(*corner)] != self.kinds[place((i, j))])
        {
            return None;
        }
        let known = corners
            .map(|(i, j)| Some(((self.x[i], self.y[j]), self.values[place((i, j))]? - level)));
        match known {
            [Some(a), Some(b), Some(c), Some(d)] => Some([a, b, c, d]),
            _ => None,
        }
    }
}

type Corner = ((f64, f64), f64);

/// Where a value passes 0 on the way between two corners.
fn crossing(((p, u), (q, v)): (Corner, Corner)) -> Option<(f64, f64)> {
    let share = u / (u - v);
    ((u > 0.0) != (v > 0.0)).then_some((p.0 + share * (q.0 - p.0), p.1 + share * (q.1 - p.1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_round_and_inside() {
        assert_eq!(
            levels(-0.3, 5.2),
            [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0]
        );
        assert!(levels(1.0, 1.0).is_empty());
        assert!(levels(-3.0, 12.0).iter().all(|x| (-3.0..=12.0).contains(x)));
    }

    #[test]
    fn the_contour_of_a_plane_is_a_line() {
        let axis = [0.0, 1.0, 2.0];
        let values: Vec<_> = axis
            .iter()
            .flat_map(|x| axis.map(|y| Some(x + y)))
            .collect();
        let mut kinds = ["stroke"; 9];
        let lines = |kinds: &[&'static str]| {
            Field {
                x: &axis,
                y: &axis,
                values: &values,
                kinds,
            }
            .segments(1.5)
        };
        assert_eq!(lines(&kinds).len(), 3);
        assert!(
            lines(&kinds)
                .iter()
                .flatten()
                .all(|(x, y)| (x + y - 1.5).abs() < 1e-12)
        );
        // None is drawn from one kind to another.
        kinds[0] = "force";
        assert_eq!(lines(&kinds).len(), 2);
    }
}
