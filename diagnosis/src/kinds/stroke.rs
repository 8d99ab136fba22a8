//! A piston moved slowly back and forth under regulated pressure: what its seal does to the force.

use super::{FREE, simple, unknown};
use crate::kind::{Cause, Channel, Kind, Log, Parameter, Terms};

/// What is given of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Bore (m).
    pub bore: f64,
    /// Position (m), retracting against the pressure as it increases, at each reading.
    pub position: Vec<f64>,
    /// Gauge pressure (Pa) at each reading.
    pub pressure: Vec<f64>,
}

/// Strokes.
#[derive(Clone, Debug)]
pub struct Strokes {
    channels: Vec<Channel>,
    logs: Vec<Log>,
    drives: Vec<Drive>,
    causes: Vec<Cause>,
    /// Position (m) without its noise, speed (m/s), for each run and reading.
    motion: Vec<Vec<(f64, f64)>>,
}

const COULOMB: usize = 0;
const SEAL: usize = 1;
const VISCOUS: usize = 2;
const SPRING: usize = 3;
const OFFSET: usize = 4;
const SCALE: usize = 5;

impl Strokes {
    /// Strokes whose one channel is the force (N).
    pub fn new(channel: Channel, logs: Vec<Log>, drives: Vec<Drive>) -> Strokes {
        let spring = Cause {
            id: "return-spring",
            parameters: vec![
                unknown("stiffness_n_per_m", 0.0, (0.0, 1e6), 10.0),
                unknown("preload_n", 0.0, (0.0, 1e4), 1.0),
            ],
        };
        let causes = vec![
            simple("coulomb-friction", "coulomb_friction_n", 0.0, (0.0, 1e4), 0.5, &[1.0]),
            simple("seal-friction", "seal_friction_n_per_pa", 0.0, (0.0, 1.0), 1e-6, &[1e-5]),
            simple("viscous-friction", "viscous_friction_n_s_per_m", 0.0, (0.0, 1e6), 1.0, &[10.0]),
            spring,
            simple("sensor-offset", "force_offset_n", 0.0, FREE, 0.5, &[]),
            simple("encoder-scale", "force_scale", 1.0, (0.2, 5.0), 0.01, &[]),
        ];
        let motion = logs.iter().zip(&drives).map(|(log, drive)| motion(log, drive)).collect();
        Strokes { channels: vec![channel], logs, drives, causes, motion }
    }
}

/// Position and speed from least-squares lines over nine readings.
fn motion(log: &Log, drive: &Drive) -> Vec<(f64, f64)> {
    const HALF: usize = 4;
    let n = drive.position.len();
    (0..n)
        .map(|i| {
            let window = i.saturating_sub(HALF)..(i + HALF + 1).min(n);
            let count = window.len() as f64;
            let mean = |f: &dyn Fn(usize) -> f64| window.clone().map(f).sum::<f64>() / count;
            let (t, x) = (mean(&|k| log.readings[k].time), mean(&|k| drive.position[k]));
            let (mut above, mut below) = (0.0, 0.0);
            for k in window.clone() {
                let dt = log.readings[k].time - t;
                above += dt * (drive.position[k] - x);
                below += dt * dt;
            }
            let speed = if below > 0.0 { above / below } else { 0.0 };
            (x + speed * (log.readings[i].time - t), speed)
        })
        .collect()
}

impl Kind for Strokes {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn logs(&self) -> &[Log] {
        &self.logs
    }

    /// How the seal stands at the start, and over what way it turns over.
    fn unknowns(&self, _: usize) -> Vec<Parameter> {
        vec![unknown("seal_state", 0.0, (-1.0, 1.0), 0.5), unknown("presliding_m", 2e-4, (1e-6, 5e-3), 1e-4)]
    }

    fn causes(&self) -> &[Cause] {
        &self.causes
    }

    /// Force on the load cell: p A, friction against the motion (after Dahl: it turns over within the presliding way), and a spring.
    fn predict(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Option<Vec<f64>> {
        let drive = &self.drives[run];
        let area = std::f64::consts::FRAC_PI_4 * drive.bore * drive.bore;
        let (mut state, way) = (unknowns[0], unknowns[1]);
        let start = self.motion[run].iter().map(|m| m.0).fold(f64::INFINITY, f64::min);
        let mut last = self.motion[run].first()?.0;
        let out: Vec<f64> = self.motion[run]
            .iter()
            .zip(&drive.pressure)
            .map(|(&(x, speed), &pressure)| {
                let moved = x - last;
                last = x;
                let end = if moved < 0.0 { -1.0 } else { 1.0 };
                state = end + (state - end) * (-moved.abs() / way).exp();
                let dry = terms.get(COULOMB, 0) + terms.get(SEAL, 0) * pressure.max(0.0);
                let spring = terms.get(SPRING, 0) * (x - start) + terms.get(SPRING, 1);
                let force = pressure * area + state * dry + terms.get(VISCOUS, 0) * speed - spring;
                terms.get(SCALE, 0) * force + terms.get(OFFSET, 0)
            })
            .collect();
        out.iter().all(|x| x.is_finite()).then_some(out)
    }
}
