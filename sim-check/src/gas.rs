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
    /// What has moved, if anybody counts: gas (kg) from the supply and to the surroundings, and the
    /// work ∫P dV (J).
    pub moved: Option<[f64; 3]>,
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
            let (next, bend, middle) = self.midpoint(chamber, &path.from(t), tau);
            if bend > BEND * self.u.abs() || next <= 0.0 {
                tau *= (BEND * self.u.abs() / bend).sqrt().clamp(0.125, 0.7);
                continue;
            }
            let (above, below) = self.piece.guards(next);
            if above > 0.0 || below > 0.0 {
                t += self.meet_edge(chamber, &path.from(t), tau, next, above > 0.0);
            } else {
                self.count(chamber, &path.from(t + 0.5 * tau), middle, tau);
                self.u = next;
                t += tau;
            }
            tau *= 2.0;
        }
        if t < h {
            self.implicit(chamber, [&path.from(t), &path.from(h)], h - t);
        }
    }

    fn rate(&self, chamber: &Chamber<f64>, u: f64, path: &Path) -> f64 {
        self.piece.gas(chamber, u, path.extension, path.speed).1
    }

    /// u after `tau`, how much less the first rate alone would have told, and u half way.
    fn midpoint(&self, chamber: &Chamber<f64>, path: &Path, tau: f64) -> (f64, f64, f64) {
        let first = self.rate(chamber, self.u, path);
        let middle = self.u + 0.5 * tau * first;
        if middle <= 0.0 {
            return (0.0, f64::INFINITY, self.u);
        }
        let second = self.rate(chamber, middle, &path.from(0.5 * tau));
        (self.u + tau * second, (second - first).abs() * tau, middle)
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
        let tau = b.clamp(0.0, tau);
        let middle = self.midpoint(chamber, path, tau).2;
        self.count(chamber, &path.from(0.5 * tau), middle, tau);
        self.renew(chamber, edge, if is_above { 1.0 } else { -1.0 });
        tau
    }

    /// Counts what moves in `tau` (s) at the variable `u` and the motion `at`, both of the middle.
    fn count(&mut self, chamber: &Chamber<f64>, at: &Path, u: f64, tau: f64) {
        if let Some([supplied, released, pushed]) = &mut self.moved {
            let flows = self.piece.mass_flows(chamber, u, at.extension, at.speed);
            *supplied += tau * flows[0];
            *released += tau * flows[1];
            *pushed += tau * chamber.pressure(self.piece.flow, u) * chamber.area * at.speed;
        }
    }

    /// Leaves the present piece at its variable `edge`, upwards (1) or downwards (−1) in pressure.
    fn renew(&mut self, chamber: &Chamber<f64>, edge: f64, side: f64) {
        let pressure = chamber.pressure(self.piece.flow, edge);
        self.piece = Piece::new(chamber, self.energized, pressure, side, self.port_open);
        self.u = chamber.variable(self.piece.flow, pressure);
    }

    /// An implicit Euler step of `tau` from one state of motion to another: u₁ − τ u̇(u₁) = u, between
    /// the edges of the piece.
    fn implicit(&mut self, chamber: &Chamber<f64>, [start, path]: [&Path; 2], tau: f64) {
        let (edge_low, edge_high) = (
            self.piece.low.min(self.piece.high),
            self.piece.low.max(self.piece.high),
        );
        let (low, high) = bisect(edge_low.max(f64::MIN_POSITIVE), edge_high, 80, |u| {
            u - tau * self.rate(chamber, u, path) < self.u
        });
        let u = 0.5 * (low + high);
        self.count_change(chamber, [(self.u, start), (u, path)], tau);
        self.u = u;
    }

    /// Counts what moves in a step of `tau` (s) that is too long for the rates at an instant: what the gas became of it
    /// says how much has flowed, n R T Δm = Δ(P V) + (n − 1) ∫P dV. The way that is not the valve's, as a leak, has the
    /// rate at the end.
    fn count_change(&mut self, chamber: &Chamber<f64>, ends: [(f64, &Path); 2], tau: f64) {
        let Some([supplied, released, pushed]) = &mut self.moved else {
            return;
        };
        let states = ends.map(|(u, at)| {
            let volume = chamber.volume(at.extension);
            (chamber.pressure(self.piece.flow, u), volume)
        });
        let [(p, v), (p_end, v_end)] = states;
        let work = 0.5 * (p + p_end) * (v_end - v);
        let net = p_end * v_end - p * v + (chamber.exponent() - 1.0) * work;
        let net = net / chamber.pressure_per_mass();
        let (u, at) = ends[1];
        let flows = self.piece.mass_flows(chamber, u, at.extension, at.speed);
        let [ins, outs] = flows.map(|flow| flow * tau);
        let fills = self.energized;
        *supplied += if fills { net + outs } else { ins };
        *released += if fills { outs } else { ins - net };
        *pushed += work;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use saltus_pneumatics::Leg;
    use saltus_robot::Robot;

    /// What has flowed is what the chamber holds, while it fills to the supply, stays open and exhausts, at rest and in
    /// motion: n R T Δm = Δ(P V) + (n − 1) ∫P dV, to the errors of the sub-steps.
    #[test]
    fn what_flows_is_what_the_chamber_holds() {
        let robot = Robot::builtin("rats-planar").expect("a built-in robot");
        let leg = Leg::new(&robot, |_, x| x);
        let chamber = leg.chamber().expect("a chamber");
        let check = |path: Path, h: f64| {
            let start = 101_325.0;
            let stored = |gas: &Gas, at: &Path| {
                chamber.pressure(gas.piece.flow, gas.u) * chamber.volume(at.extension)
            };
            let on = |energized: bool, p: f64, moved| {
                let piece = Piece::new(chamber, energized, p, 0.0, false);
                Gas {
                    piece,
                    u: chamber.variable(piece.flow, p),
                    energized,
                    port_open: false,
                    moved,
                }
            };
            let mut gas = on(true, start, Some([0.0; 3]));
            let before = stored(&gas, &path);
            let mut most = 0.0_f64;
            for k in 0..80 {
                if k == 50 {
                    let p = chamber.pressure(gas.piece.flow, gas.u);
                    gas = on(false, p, gas.moved);
                }
                gas.advance(chamber, &path.from(f64::from(k) * h), h);
                let held = stored(&gas, &path.from(f64::from(k + 1) * h));
                let [supplied, released, pushed] = gas.moved.expect("counts");
                let flowed = chamber.pressure_per_mass() * (supplied - released)
                    - (chamber.exponent() - 1.0) * pushed;
                assert!(
                    (held - before - flowed).abs() < 0.003 * held,
                    "{k}: {held} {flowed}"
                );
                most = most.max(held);
            }
            assert!(most > 4.0, "{most} J");
        };
        let at = |extension, speed, acceleration| Path {
            extension,
            speed,
            acceleration,
        };
        check(at(0.0, 0.0, 0.0), 5e-4);
        check(at(0.0, 1e-9, 0.0), 5e-4);
        check(at(0.0, 0.3, 8.0), 5e-4);
        check(at(0.05, -1.0, 25.0), 5e-4);
    }
}
