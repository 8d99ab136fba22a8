//! A chamber over a stretch of time in which its leg moves along a parabola.

use saltus_numeric::root::bisect;
use saltus_pneumatics::{Chamber, Piece};

/// A leg's motion: extension (m), speed (m/s) and acceleration (m/s²) at the start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Path {
    pub extension: f64,
    pub speed: f64,
    pub acceleration: f64,
}

impl Path {
    /// The motion from `t` (s) on.
    pub(crate) fn from(&self, t: f64) -> Path {
        Path {
            extension: self.extension + t * (self.speed + 0.5 * t * self.acceleration),
            speed: self.speed + t * self.acceleration,
            acceleration: self.acceleration,
        }
    }
}

/// What a chamber holds, and what its valve and port do.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gas {
    pub piece: Piece<f64>,
    /// The piece's variable u.
    pub u: f64,
    pub energized: bool,
    pub port_open: bool,
}

/// Change of u in a sub-step by which its rate may change it more or less, relative to u.
const BEND: f64 = 0.02;
/// Explicit sub-steps, after which the rest is done implicitly.
const SUB_STEPS: usize = 48;

impl Gas {
    /// The gas after `h` seconds of `path`: midpoint sub-steps on each piece of the law, and where
    /// it is too stiff for them, an implicit one, which is stable and stays on its piece.
    pub(crate) fn advance(&mut self, chamber: &Chamber<f64>, path: &Path, h: f64) {
        let (mut t, mut tau) = (0.0, h);
        for _ in 0..SUB_STEPS {
            if t >= h {
                return;
            }
            tau = tau.min(h - t);
            let (next, bend) = self.midpoint(chamber, &path.from(t), tau);
            if bend > BEND * self.u.abs() || next <= 0.0 {
                tau *= (BEND * self.u.abs() / bend).sqrt().clamp(0.125, 0.7);
                continue;
            }
            let (above, below) = self.piece.guards(next);
            if above > 0.0 || below > 0.0 {
                t += self.meet_edge(chamber, &path.from(t), tau, next, above > 0.0);
            } else {
                self.u = next;
                t += tau;
            }
            tau *= 2.0;
        }
        if t < h {
            self.implicit(chamber, &path.from(h), h - t);
        }
    }

    fn rate(&self, chamber: &Chamber<f64>, u: f64, path: &Path) -> f64 {
        self.piece.gas(chamber, u, path.extension, path.speed).1
    }

    /// u after `tau`, and how much less the first rate alone would have told.
    fn midpoint(&self, chamber: &Chamber<f64>, path: &Path, tau: f64) -> (f64, f64) {
        let first = self.rate(chamber, self.u, path);
        let middle = self.u + 0.5 * tau * first;
        if middle <= 0.0 {
            return (0.0, f64::INFINITY);
        }
        let second = self.rate(chamber, middle, &path.from(0.5 * tau));
        (self.u + tau * second, (second - first).abs() * tau)
    }

    /// Goes to the edge of the piece that `next`, after `tau`, is past, and onto the piece beyond
    /// it; the time that took.
    fn meet_edge(
        &mut self,
        chamber: &Chamber<f64>,
        path: &Path,
        tau: f64,
        next: f64,
        is_above: bool,
    ) -> f64 {
        let edge = if is_above {
            self.piece.high
        } else {
            self.piece.low
        };
        let (mut a, mut b, mut fa, mut fb) = (0.0, tau, self.u - edge, next - edge);
        // Secant steps; the parabola that the midpoint rule follows needs few.
        for _ in 0..4 {
            if fa == fb {
                break;
            }
            let s = (b - fb * (b - a) / (fb - fa)).clamp(0.0, tau);
            (a, fa) = (b, fb);
            (b, fb) = (s, self.midpoint(chamber, path, s).0 - edge);
            if fb.abs() <= 1e-14 * edge.abs() {
                break;
            }
        }
        self.renew(chamber, edge, if is_above { 1.0 } else { -1.0 });
        b.clamp(0.0, tau)
    }

    /// Leaves the present piece at its variable `edge`, upwards (1) or downwards (−1) in pressure.
    fn renew(&mut self, chamber: &Chamber<f64>, edge: f64, side: f64) {
        let pressure = chamber.pressure(self.piece.flow, edge);
        self.piece = Piece::new(chamber, self.energized, pressure, side, self.port_open);
        self.u = chamber.variable(self.piece.flow, pressure);
    }

    /// An implicit Euler step of `tau` to the end `path`: u₁ − τ u̇(u₁) = u, between the edges of
    /// the piece.
    fn implicit(&mut self, chamber: &Chamber<f64>, path: &Path, tau: f64) {
        let (edge_low, edge_high) = (
            self.piece.low.min(self.piece.high),
            self.piece.low.max(self.piece.high),
        );
        let (low, high) = bisect(edge_low.max(f64::MIN_POSITIVE), edge_high, 80, |u| {
            u - tau * self.rate(chamber, u, path) < self.u
        });
        self.u = 0.5 * (low + high);
    }
}
