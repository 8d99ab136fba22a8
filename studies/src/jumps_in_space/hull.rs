//! How near a robot's feet, and all that lies between them, come to a box.

/// A place across the way of a robot: along it and up (m).
pub(super) type Flat = [f64; 2];

/// The convex hull of `points`, counter-clockwise.
///
/// Source: Andrew 1979, the monotone chain.
pub(super) fn hull(points: &[Flat]) -> Vec<Flat> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut chain: Vec<Flat> = Vec::new();
    let mut half = |ordered: &mut dyn Iterator<Item = &Flat>| {
        let start = chain.len();
        for point in ordered {
            while chain.len() >= start + 2
                && turn(&chain[chain.len() - 2], &chain[chain.len() - 1], point) <= 0.0
            {
                chain.pop();
            }
            chain.push(*point);
        }
        // The last point is the first of the other half.
        chain.pop();
    };
    half(&mut sorted.iter());
    half(&mut sorted.iter().rev());
    chain
}

/// Twice the area of a triangle, positive where it is counter-clockwise.
fn turn(a: &Flat, b: &Flat, c: &Flat) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Distance (m) between two convex polygons, counter-clockwise; negative where they overlap: how far one has to move.
pub(super) fn gap(a: &[Flat], b: &[Flat]) -> f64 {
    let apart = separation(a, b).max(separation(b, a));
    if apart <= 0.0 {
        return apart;
    }
    let near = |from: &[Flat], to: &[Flat]| {
        let sides = || (0..to.len()).map(|k| (to[k], to[(k + 1) % to.len()]));
        let all = from
            .iter()
            .flat_map(|p| sides().map(|side| to_side(p, &side)));
        all.fold(f64::INFINITY, f64::min)
    };
    near(a, b).min(near(b, a))
}

/// Greatest distance (m) of all of `b` beyond a side of `a`.
fn separation(a: &[Flat], b: &[Flat]) -> f64 {
    let beyond = |k: usize| {
        let (from, to) = (a[k], a[(k + 1) % a.len()]);
        let (x, y) = (to[0] - from[0], to[1] - from[1]);
        let length = x.hypot(y).max(f64::MIN_POSITIVE);
        let out = |p: &Flat| ((p[0] - from[0]) * y - (p[1] - from[1]) * x) / length;
        b.iter().map(out).fold(f64::INFINITY, f64::min)
    };
    (0..a.len()).map(beyond).fold(f64::NEG_INFINITY, f64::max)
}

/// Distance (m) of a point from a side.
fn to_side(p: &Flat, (from, to): &(Flat, Flat)) -> f64 {
    let side = [to[0] - from[0], to[1] - from[1]];
    let square = (side[0] * side[0] + side[1] * side[1]).max(f64::MIN_POSITIVE);
    let along = ((p[0] - from[0]) * side[0] + (p[1] - from[1]) * side[1]) / square;
    let along = along.clamp(0.0, 1.0);
    (p[0] - from[0] - along * side[0]).hypot(p[1] - from[1] - along * side[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64, side: f64) -> Vec<Flat> {
        vec![[x, y], [x + side, y], [x + side, y + side], [x, y + side]]
    }

    #[test]
    fn a_hull_has_its_corners_alone() {
        let points = [
            [0.0, 0.0],
            [0.5, 0.5],
            [1.0, 0.0],
            [1.0, 1.0],
            [0.2, 0.7],
            [0.0, 1.0],
            [0.5, 0.0],
        ];
        assert_eq!(hull(&points), square(0.0, 0.0, 1.0));
    }

    #[test]
    fn gaps_between_squares() {
        let one = square(0.0, 0.0, 1.0);
        for (x, y, expected) in [
            (1.5, 0.0, 0.5),
            (1.3, 1.4, 0.5),
            (-2.0, 0.3, 1.0),
            (0.9, 0.0, -0.1),
            (0.25, -0.98, -0.02),
            (1.0, 0.0, 0.0),
        ] {
            let found = gap(&one, &square(x, y, 1.0));
            assert!((found - expected).abs() < 1e-12, "{x} {y}: {found}");
        }
        // A corner over a side.
        let kite = [[0.5, 1.2], [1.0, 1.7], [0.5, 2.2], [0.0, 1.7]];
        assert!((gap(&one, &kite) - 0.2).abs() < 1e-12);
    }
}
