//! The path of the wheel, and how near it comes to a box.

use saltus_ballistic::{Disc, ExtendedLeg, FlightSample, Obstacle, SampledFlight};
use saltus_sim_check::{Report, Sample};

/// Height (m) at which a box ends below that has no lower end.
const BOTTOM: f64 = -1e3;

/// Distances (m) between the wheel and a box; negative: how deep they overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Least distance until lift-off.
    pub stance: f64,
    /// Least distance from lift-off to the landing, of the fired leg too while that is out; none
    /// without a flight.
    pub flight: Option<f64>,
}

impl Clearance {
    /// The lesser of the two.
    pub fn least(&self) -> f64 {
        self.flight
            .map_or(self.stance, |flight| flight.min(self.stance))
    }
}

/// The path of an axle that carries a wheel.
pub(super) struct Path {
    stance: Part,
    flight: Option<Part>,
}

/// Part of a path, what must stay clear on it, and from when to when (s).
struct Part {
    path: SampledFlight<f64>,
    disc: Disc<f64>,
    span: [f64; 2],
}

impl Part {
    /// The part of a jump between two times (s), which counts from the first.
    fn of(report: &Report, [from, to]: [f64; 2], radius: f64) -> Option<Part> {
        let is_in = |s: &&Sample| (from..=to).contains(&s.time);
        let sample = |s: &Sample| FlightSample {
            time: s.time - from,
            position: s.axle,
            velocity: s.axle_rates,
        };
        let mut samples: Vec<_> = report.samples.iter().filter(is_in).map(sample).collect();
        samples.dedup_by(|b, a| b.time <= a.time);
        let span = [samples.first()?.time, samples.last()?.time];
        Some(Part {
            path: SampledFlight::new(samples).ok()?,
            disc: Disc::wheel(radius),
            span,
        })
    }

    /// Least distance (m) from a box.
    fn clearance(&self, solid: &Obstacle) -> f64 {
        let [from, to] = self.span;
        let least = self.path.clearance(&self.disc, solid, from, to);
        least.unwrap_or(f64::NAN)
    }
}

impl Path {
    /// Of a jump that lands where the axle is at `height` (m), if it lands; the fired leg is out for
    /// `leg_out` (s) after lift-off. None of a report without samples.
    pub(super) fn new(
        report: &Report,
        radius: f64,
        height: Option<f64>,
        leg_out: f64,
    ) -> Option<Path> {
        let Some(lift_off) = report.lift_off else {
            let stance = Part::of(report, [0.0, f64::INFINITY], radius)?;
            return Some(Path {
                stance,
                flight: None,
            });
        };
        let mut flight = Part::of(report, [lift_off.time, f64::INFINITY], radius);
        if let Some(flight) = &mut flight {
            if let Some(landing) = height.and_then(|it| flight.path.time_to_height(it).ok()) {
                flight.span[1] = landing;
            }
            flight.disc.leg = (leg_out > 0.0).then_some(ExtendedLeg {
                reach: radius + lift_off.extension,
                until: leg_out,
            });
        }
        Some(Path {
            stance: Part::of(report, [0.0, lift_off.time], radius)?,
            flight,
        })
    }

    /// Distances to the box from `front` to `back`, which ends at `top` and has no lower end (m
    /// from the foothold); none of a box without an inside.
    pub(super) fn clearance(&self, &[front, back, top]: &[f64; 3]) -> Option<Clearance> {
        let solid = Obstacle::block([front, BOTTOM], [back, top]).ok()?;
        Some(Clearance {
            stance: self.stance.clearance(&solid),
            flight: self.flight.as_ref().map(|it| it.clearance(&solid)),
        })
    }
}
