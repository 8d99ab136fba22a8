//! Jumps: those of the multi-body simulation, and those of the planar model.

use std::io::Write;

use saltus_ballistic::DragFlight;
use saltus_lagrangian::{LiftOff, Trace};
use saltus_sim_check::{Report, Rig, Sample};

use super::body::Moment;
use super::{Error, Recording};

/// Slip slower than this (m/s) is none.
const STILL: f64 = 1e-9;
/// Time (s) between two instants of a flight of the planar model.
const STEP: f64 = 1e-3;

/// How a simulated jump is put into a recording.
#[derive(Clone, Copy, Debug, Default)]
pub struct Flown {
    /// When it starts (s).
    pub start: f64,
    /// Its foothold (m along the course), and the height of the surface there (m).
    pub foot: [f64; 2],
    /// How long its valve is open (s).
    pub valve_open: f64,
    /// Height of the axle above the foothold at which it lands (m); 0: it is followed to its end.
    pub landing_height: f64,
}

impl<W: Write> Recording<W> {
    /// Adds a jump of the multi-body simulation; gives the time (s) at which it ends.
    ///
    /// # Errors
    /// [`Error::File`] if the file takes no bytes.
    pub fn jump(&mut self, report: &Report, flown: &Flown) -> Result<f64, Error> {
        let Some(rig) = self.body.as_ref().map(|body| body.rig().clone()) else {
            return Ok(flown.start);
        };
        let lift_off = report.lift_off.map_or(f64::INFINITY, |l| l.time);
        let fired = report.lift_off.map_or(f64::INFINITY, |l| l.time_fire);
        let samples = until_landing(report, flown.landing_height);
        let mut slipping = false;
        self.events_of(report.lift_off.as_ref(), report.slips_at, flown)?;
        for sample in samples {
            let touching = sample.time < lift_off;
            let slips = touching && sample.slip[0].abs() > STILL;
            if slipping && !slips && touching {
                self.event(flown.start + sample.time, "stick")?;
            }
            slipping = slips;
            let force = rig.force_on_foot(0, &sample.coordinates, sample.force);
            let forces = [(0, force.into())];
            let open = sample.time >= fired && sample.time < fired + flown.valve_open;
            let mut coordinates = sample.coordinates.clone();
            coordinates[0] += flown.foot[0] / rig.boom.unwrap_or(1.0);
            self.moment(&Moment {
                time: flown.start + sample.time,
                coordinates: &coordinates,
                velocities: &sample.velocities,
                base: flown.foot[1],
                // A leg without a chamber has none, which the simulation tells as 0.
                pressures: &[if sample.pressure > 0.0 {
                    sample.pressure
                } else {
                    f64::NAN
                }],
                valves: &[open],
                slip: if touching { sample.slip[0] } else { 0.0 },
                forces: if touching { &forces } else { &[] },
                sensed: None,
            })?;
        }
        let end = end(report, samples.len(), flown.landing_height);
        if report.apex.is_finite() && report.landing_at.is_finite() {
            self.event(flown.start + end, "landing")?;
        }
        Ok(flown.start + end)
    }

    fn events_of(
        &mut self,
        lift_off: Option<&LiftOff>,
        slips_at: Option<f64>,
        flown: &Flown,
    ) -> Result<(), Error> {
        let mut events = Vec::new();
        events.extend(slips_at.map(|time| (time, "slip")));
        if let Some(lift_off) = lift_off {
            events.push((lift_off.time_fire, "fire"));
            events.push((lift_off.time, "lift-off"));
        }
        events.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (time, what) in events {
            self.event(flown.start + time, what)?;
        }
        Ok(())
    }

    /// Adds a jump of the planar model: its stance as it was integrated, and its flight, if there is
    /// one, until the wheel is back on the ground. The leg stays as it is at lift-off.
    ///
    /// # Errors
    /// [`Error::File`] if the file takes no bytes.
    pub fn planned(
        &mut self,
        trace: &Trace,
        flight: Option<&DragFlight<f64>>,
        valve_open: f64,
    ) -> Result<(), Error> {
        let Some(rig) = self.body.as_ref().map(|body| body.rig().clone()) else {
            return Ok(());
        };
        let end = &trace.lift_off;
        let shown = Planar { rig: &rig };
        self.events_of(flight.is_some().then_some(end), None, &Flown::default())?;
        for sample in &trace.samples {
            let state = shown.standing(
                [sample.lean, sample.rate],
                [sample.extension, sample.extension_rate],
            );
            let force = [sample.reaction.normal, sample.reaction.friction, 0.0];
            let force = rig.force_on_foot(0, &state[0], force).into();
            let open = sample.time >= end.time_fire && sample.time < end.time_fire + valve_open;
            self.moment(&Moment {
                time: sample.time,
                coordinates: &state[0],
                velocities: &state[1],
                pressures: &[sample.pressure],
                valves: &[open],
                forces: &[(0, force)],
                ..Moment::default()
            })?;
        }
        if let Some(flight) = flight {
            self.flight(&shown, end, flight)?;
        }
        Ok(())
    }

    fn flight(
        &mut self,
        shown: &Planar<'_>,
        end: &LiftOff,
        flight: &DragFlight<f64>,
    ) -> Result<(), Error> {
        let long = flight
            .time_to_height(shown.rig.radius)
            .or_else(|_| flight.time_to_height(0.0));
        let Ok(long) = long else {
            return Ok(());
        };
        // A flight is shorter than the simulation's longest one, 100 s.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let steps = (long.min(100.0) / STEP).floor() as u32;
        let times = (1..=steps).map(|k| f64::from(k) * STEP).chain([long]);
        for t in times {
            let state = shown.state(
                flight.position(t),
                flight.velocity(t),
                [end.lean + end.rate * t, end.rate],
                [end.extension, 0.0],
            );
            self.moment(&Moment {
                time: end.time + t,
                coordinates: &state[0],
                velocities: &state[1],
                pressures: &[end.pressure],
                ..Moment::default()
            })?;
        }
        self.event(end.time + long, "landing")
    }
}

/// The samples up to where the axle comes down to `height` (m).
fn until_landing(report: &Report, height: f64) -> &[Sample] {
    const NEAR: f64 = 1e-9;
    let samples = &report.samples;
    let top = (0..samples.len())
        .max_by(|a, b| samples[*a].axle[1].total_cmp(&samples[*b].axle[1]))
        .unwrap_or(0);
    let above = |sample: &&Sample| sample.axle[1] >= height - NEAR;
    let down = samples[top..].iter().take_while(above).count();
    &samples[..top + down]
}

/// When (s) the axle comes down to `height` (m): after `count` samples, of which the last is above it.
fn end(report: &Report, count: usize, height: f64) -> f64 {
    let Some(last) = report.samples[..count].last() else {
        return 0.0;
    };
    let rest = report.samples.get(count).map_or(0.0, |next| {
        let share = (height - last.axle[1]) / (next.axle[1] - last.axle[1]);
        share * (next.time - last.time)
    });
    last.time + rest
}

/// What the planar model knows, as coordinates and velocities of a rig.
struct Planar<'a> {
    rig: &'a Rig,
}

impl Planar<'_> {
    /// On its foot, which is at travel 0: lean (rad) and extension (m), each with its rate.
    fn standing(&self, lean: [f64; 2], leg: [f64; 2]) -> [Vec<f64>; 2] {
        let (sin, cos) = lean[0].sin_cos();
        let reach = self.rig.radius + leg[0];
        let axle = [reach * sin, reach * cos];
        let rates = [
            leg[1] * sin + reach * cos * lean[1],
            leg[1] * cos - reach * sin * lean[1],
        ];
        self.state(axle, rates, lean, leg)
    }

    /// The axle at a travel and a height (m), with their rates (m/s).
    fn state(
        &self,
        axle: [f64; 2],
        rates: [f64; 2],
        lean: [f64; 2],
        leg: [f64; 2],
    ) -> [Vec<f64>; 2] {
        let (rig, tree) = (self.rig, &self.rig.mechanism.tree);
        let mut q = vec![0.0; tree.coordinates()];
        let mut v = vec![0.0; tree.velocities()];
        (q[0], q[1], v[0], v[1]) = (axle[0], axle[1], rates[0], rates[1]);
        if let Some(length) = rig.boom {
            // The axle's height above that of standing is L sin of the pivot angle.
            let sin = ((axle[1] - rig.radius) / length).clamp(-1.0, 1.0);
            (q[0], q[1]) = (axle[0] / length, sin.asin());
            (v[0], v[1]) = (rates[0] / length, rates[1] / (length * q[1].cos()));
        }
        (q[rig.lean_coordinate()], v[rig.lean_velocity()]) = (lean[0], lean[1]);
        q[rig.extension_coordinate(0)] = leg[0];
        v[tree.velocity_of(rig.legs[0])] = leg[1];
        [q, v]
    }
}
