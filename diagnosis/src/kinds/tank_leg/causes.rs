//! What can be wrong with a robot that is fed from a tank.

use super::rig::{Changed, Rig};
use super::{Flights, Gauge};
use crate::kind::{Cause, Channel, Terms};
use crate::kinds::{FREE, amount, causes, delay, faults, gain, offset, share, simple, unknown};

/// What a cause does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effect {
    /// What the way to the air lets through in terms of a tube, which nobody knows.
    Vent,
    Lags,
    Tube,
    Valve,
    Tank,
    Outlet,
    TankVolume,
    Tendon,
    Dry,
    Viscous,
    Mass,
    Spring,
    Heat,
    Leak,
    /// Without a name.
    Force,
}

impl Rig {
    /// Volume (m³) of a tube.
    fn tube_volume(&self) -> f64 {
        let [length, diameter, _] = self.tube;
        0.25 * std::f64::consts::PI * diameter * diameter * length
    }

    /// As the operator believes it is.
    pub(super) fn believed(&self) -> Changed {
        Changed {
            lags: [0.0; 3],
            tube: self.tube_volume(),
            flow: 1.0,
            valve: 1.0,
            vent: 1.0,
            walls: [0.0; 2],
            tank: 1.0,
            outlet: 0.0,
            tendons: [self.tendon; 2],
            friction: 0.0,
            damping: self.damping,
            mass: 1.0,
            spring: 1.0,
            leak: 0.0,
            force: 1.0,
        }
    }
}

impl Flights {
    /// The machine with `terms` on.
    pub(super) fn changed(&self, terms: &Terms) -> Changed {
        let believed = self.rig.believed();
        let get = |effect, p, none| self.causes.get(effect, p, terms).unwrap_or(none);
        Changed {
            lags: [0, 1, 2].map(|p| get(Effect::Lags, p, 0.0)),
            tube: get(Effect::Tube, 0, believed.tube),
            flow: get(Effect::Tube, 1, 1.0),
            valve: get(Effect::Valve, 0, 1.0),
            vent: get(Effect::Vent, 0, 1.0),
            walls: [get(Effect::Tank, 0, 0.0), get(Effect::Heat, 0, 0.0)],
            outlet: get(Effect::Outlet, 0, 0.0),
            tank: get(Effect::TankVolume, 0, 1.0),
            tendons: [0, 1].map(|p| get(Effect::Tendon, p, self.rig.tendon)),
            friction: get(Effect::Dry, 0, 0.0),
            damping: get(Effect::Viscous, 0, believed.damping),
            mass: get(Effect::Mass, 0, 1.0),
            spring: get(Effect::Spring, 0, 1.0),
            leak: get(Effect::Leak, 0, 0.0),
            force: get(Effect::Force, 0, 1.0),
        }
    }
}

/// Causes, each with what it does.
type All = Vec<(Option<Effect>, Cause)>;

/// The listed causes, and terms without a name.
pub(super) fn of(rig: &Rig, channels: &[Channel], gauges: &[Gauge]) -> (All, All) {
    let vent = simple("tube", "vent_flow_share", 1.0, (0.05, 5.0), 0.02, &[]);
    let mut named = vec![(Some(Effect::Vent), vent)];
    named.extend(of_gas(rig));
    named.extend(of_links(rig));
    for (channel, gauge) in channels.iter().zip(gauges) {
        named.extend(of_gauge(channel, *gauge));
    }
    let name = "pull of the muscles, times c";
    let force = simple(name, "c", 1.0, (0.1, 5.0), 0.02, &[0.7, 1.4]);
    (named, vec![(Some(Effect::Force), force)])
}

fn of_gas(rig: &Rig) -> All {
    let lag = |name| unknown(name, 0.0, (0.0, 0.2), 1e-3);
    let mut lags = ["opening_delay_s", "closing_delay_s", "venting_delay_s"]
        .map(lag)
        .to_vec();
    if rig.exhaust.is_none() {
        lags.pop();
    }
    for lag in &mut lags {
        lag.starts = vec![0.01, 0.03];
    }
    let volume = rig.tube_volume();
    let tube = vec![
        unknown(
            "tube_volume_m3",
            volume,
            (0.0, 50.0 * volume),
            0.05 * volume,
        ),
        unknown("tube_flow_share", 1.0, (0.05, 5.0), 0.02),
    ];
    let tank = |name, most, scale, starts: &[f64]| amount("tank", name, most, scale, starts);
    let known = "a tank's volume is known";
    causes! {
        Effect::Lags => Cause::several("valve-delay", lags);
        Effect::Tube => Cause::several("tube", tube);
        Effect::Valve => share("valve-discharge", "valve_flow_share", 0.02);
        Effect::Tank => tank("tank_wall_k_per_w", 1e3, 0.05, &[0.5, 5.0]);
        Effect::Outlet => tank("outlet_drop_share", 10.0, 2e-3, &[0.01]);
        Effect::TankVolume => share("tank", "tank_volume_share", 0.02).usual(0.03, known);
        Effect::Heat => amount("heat-transfer", "muscle_wall_k_per_w", 1e3, 0.05, &[0.3, 3.0]);
        Effect::Leak => amount("chamber-leak", "leak_area_m2", 1e-4, 2e-8, &[1e-7, 1e-6]);
    }
}

fn of_links(rig: &Rig) -> All {
    let tendon = |name| {
        unknown(
            name,
            rig.tendon,
            (0.0, 20.0 * rig.tendon),
            0.05 * rig.tendon,
        )
    };
    let tendons = ["knee_tendon_m_per_n", "hip_tendon_m_per_n"].map(tendon);
    let name = "viscous_friction_n_m_s_per_rad";
    let damping = simple(
        "viscous-friction",
        name,
        rig.damping,
        (0.0, 10.0),
        5e-3,
        &[0.1],
    );
    let mass = share("mass", "mass_share", 0.02).usual(0.03, "links are weighed");
    causes! {
        Effect::Tendon => Cause::several("series-spring", tendons.to_vec());
        Effect::Dry => amount("coulomb-friction", "coulomb_friction_n_m", 20.0, 0.02, &[0.3, 1.0]);
        Effect::Viscous => damping;
        Effect::Mass => mass;
        Effect::Spring => share("return-spring", "spring_share", 0.02);
    }
}

fn of_gauge(channel: &Channel, gauge: Gauge) -> All {
    let own = channel.name.as_str();
    let prompt = "gauges are prompt";
    let mut all: All = faults([gain(own), delay(own, 0.1, 1e-3).usual(3e-3, prompt)]).collect();
    // Where the track of the centre begins is not known anyway.
    if !matches!(gauge, Gauge::Center(_)) {
        all.extend(faults([offset(own, "pa", FREE, 500.0)]));
    }
    all
}
