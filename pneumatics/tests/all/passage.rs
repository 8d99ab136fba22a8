//! Orifices and tubes: closed forms of their flow.

use std::f64::consts::PI;

use proptest::prelude::*;
use saltus_pneumatics::{OrificeLaw, Passage};
use saltus_robot::Gas;

use crate::{cases, decades, gases, near};

/// Viscosity (Pa s) of air at room temperature.
const VISCOSITY: f64 = 1.82e-5;

/// Any passage of a robot.
pub(crate) fn passages(gas: Gas) -> impl Strategy<Value = Passage> {
    let orifice =
        decades(1e-8, 1e-4).prop_map(move |area| Passage::Orifice(OrificeLaw::new(gas), area));
    let sizes = (
        decades(0.01, 10.0),
        decades(5e-4, 0.02),
        0.0..0.02,
        0.0..5.0,
    );
    let drop = (decades(1e4, 4e6), 0.0..1.0, 220.0..400.0);
    let tube = (sizes, drop).prop_map(
        move |((length, diameter, rough, ends), (high, ratio, temperature))| {
            Passage::tube(
                [length, diameter, rough * diameter],
                ends,
                (gas, temperature),
                [high, ratio * high],
            )
        },
    );
    // Of sharp bends only: no laminar flow.
    let bends = decades(1e12, 1e18).prop_map(|b| Passage::Tube(0.0, b));
    let long = (decades(1e8, 1e16), decades(1e12, 1e18), decades(1e12, 1e18))
        .prop_map(|(a, b, c)| Passage::LongTube([a, b, c]));
    prop_oneof![3 => orifice, 3 => tube, 1 => bends, 1 => long]
}

#[test]
fn slow_flow_is_that_of_hagen_and_poiseuille() {
    let (gas, temperature) = (Gas::AIR, 293.0);
    let [length, diameter] = [2.0, 5e-4];
    for fall in [1.0, 10.0, 100.0, 5000.0] {
        let [high, low] = [1e5 + fall, 1e5];
        let tube = Passage::tube(
            [length, diameter, 0.0],
            1.5,
            (gas, temperature),
            [high, low],
        );
        // Mean density times π d⁴ Δp/(128 μ l).
        let density = 0.5 * (high + low) / (gas.constant * temperature);
        let poiseuille = density * PI * diameter.powi(4) * fall / (128.0 * VISCOSITY * length);
        let reynolds = 4.0 * poiseuille / (PI * diameter * VISCOSITY);
        // Turbulence and ends add a factor of 0.05 to that of laminar flow, 64/Re.
        let tolerance = 0.051 * reynolds / 64.0;
        assert!(tolerance < 0.03, "Reynolds number {reynolds}");
        near(tube.flow([high, temperature], low), poiseuille, tolerance);
    }
}

/// Friction factor by Haaland.
fn haaland(reynolds: f64, roughness: f64) -> f64 {
    let inside = 6.9 / reynolds + (roughness / 3.7).powf(1.11);
    (-1.8 * inside.log10()).powi(-2)
}

#[test]
fn haaland_is_colebrook_to_two_percent() {
    // The charts' numbers, e.g. White, Fluid Mechanics, fig. 6.13: 0.0309 and 0.0116 (smooth),
    // and 0.0379 where it is rough through and through.
    for (reynolds, roughness, factor) in
        [(1e4, 0.0, 0.0309), (1e6, 0.0, 0.0116), (1e8, 0.01, 0.0379)]
    {
        near(haaland(reynolds, roughness), factor, 0.02);
    }
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn fast_flow_is_that_of_darcy_and_weisbach(
        gas in gases(),
        (length, diameter) in (decades(0.01, 10.0), decades(5e-4, 0.02)),
        rough in 0.0..0.02,
        ends in 0.0..5.0,
        temperature in 220.0..400.0,
        high in decades(1e4, 4e6),
        ratio in 0.0..1.0,
    ) {
        let low = ratio * high;
        let tube = Passage::tube(
            [length, diameter, rough * diameter], ends, (gas, temperature), [high, low]);
        let flow = tube.flow([high, temperature], low);
        let area = 0.25 * PI * diameter * diameter;
        // P₁² − P₂² = 2 ∫ p dp of ∫ ρ dp = f (l/d) G²/2.
        let specific = gas.constant * temperature;
        let law = |flow: f64| {
            let reynolds = flow * diameter / (area * VISCOSITY);
            let factor = haaland(reynolds.max(500.0), rough).max(64.0 / reynolds);
            (factor * length / diameter + ends) * (flow / area).powi(2) * specific
        };
        let fall = high * high - low * low;
        // Its own rounds towards the friction factor.
        prop_assert!((law(flow) / fall - 1.0).abs() < 1e-9);
        // It holds at a third of the flow as well.
        let down = (high * high - law(flow / 3.0)).sqrt();
        prop_assert!((tube.flow([high, temperature], down) / (flow / 3.0) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_long_tube_keeps_to_the_law_where_gas_flows_slower(
        gas in gases(),
        (length, diameter) in (decades(0.2, 10.0), decades(2e-3, 0.02)),
        rough in 0.0..0.02,
        ends in 0.0..5.0,
        high in decades(3e5, 4e6),
        part in 0.01_f64..1.0,
    ) {
        let temperature = 293.0;
        let tube = Passage::long_tube(
            [length, diameter, rough * diameter], ends, (gas, temperature), [high, 1e5]);
        let area = 0.25 * PI * diameter * diameter;
        let fall = part * (high * high - 1e10);
        let flow = tube.flow([high, temperature], (high * high - fall).sqrt());
        let reynolds = flow * diameter / (area * VISCOSITY);
        let factor = haaland(reynolds.max(500.0), rough).max(64.0 / reynolds);
        let law = (factor * length / diameter + ends) * (flow / area).powi(2)
            * gas.constant * temperature;
        prop_assume!(reynolds > 2300.0);
        prop_assert!((law / fall - 1.0).abs() < 0.01, "{} at Re {reynolds}", law / fall);
    }

    #[test]
    fn a_share_of_a_passage_lets_that_share_through(
        passage in gases().prop_flat_map(passages),
        share in decades(1e-3, 1e3),
        up in decades(1e4, 4e6),
        ratio in 0.0..1.0,
        temperature in 220.0..400.0,
    ) {
        let low = ratio * up;
        let whole = passage.flow([up, temperature], low);
        let part = passage.times(share).flow([up, temperature], low);
        prop_assert!((part / whole / share - 1.0).abs() < 1e-13, "{part} kg/s of {whole} kg/s");
    }

    #[test]
    fn the_lower_the_pressure_beyond_the_more_flows(
        passage in gases().prop_flat_map(passages),
        up in decades(1e4, 4e6),
        ratio in 0.0..1.0,
        less in 0.0..1.0,
        temperature in 220.0..400.0,
    ) {
        let flow = |down: f64| passage.flow([up, temperature], down);
        prop_assert_eq!(flow(up), 0.0);
        prop_assert!(flow(ratio * up) > 0.0);
        // To round-off.
        prop_assert!(flow(less * ratio * up) >= flow(ratio * up) * (1.0 - 1e-14));
        prop_assert!(flow(0.0).is_finite());
    }
}
