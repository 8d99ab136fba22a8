//! Where a function comes to 0.

/// From the bracket `a`, `b` of (place, value), the value above 0 at `a` and not at `b`: the place
/// just past the root, as near as `resolution`. The Illinois method, with bisection where it is
/// slow.
pub(super) fn past_root(
    (mut a, mut fa): (f64, f64),
    (mut b, mut fb): (f64, f64),
    resolution: f64,
    mut value: impl FnMut(f64) -> f64,
) -> f64 {
    let mut side = 0;
    for i in 0..80 {
        if b - a <= resolution || fb == 0.0 {
            break;
        }
        let mut s = (a * fb - b * fa) / (fb - fa);
        // Once one end has converged, the other comes to it at once.
        let margin = 0.5 * resolution;
        if s - a < margin {
            s = a + margin;
        } else if b - s < margin {
            s = b - margin;
        }
        if i % 8 == 7 || !(s > a && s < b) {
            s = 0.5 * (a + b);
        }
        if s <= a || s >= b {
            break;
        }
        let f = value(s);
        if f > 0.0 {
            (a, fa) = (s, f);
            if side == 1 {
                fb *= 0.5;
            }
            side = 1;
        } else {
            (b, fb) = (s, f);
            if side == -1 {
                fa *= 0.5;
            }
            side = -1;
        }
    }
    b
}
