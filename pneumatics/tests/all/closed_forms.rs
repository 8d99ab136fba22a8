//! Cases of the supply that have a solution on paper.

use saltus_pneumatics::{Line, Opening, OrificeLaw, Passage, Stock, Supply, Wall};
use saltus_robot::Gas;

use crate::near;

const WARM: f64 = 300.0;
const ADIABATIC: Wall = Wall {
    temperature: WARM,
    resistance: f64::INFINITY,
};
const ISOTHERMAL: Wall = Wall {
    temperature: WARM,
    resistance: 0.0,
};
const FILL: Opening = Opening {
    fill: 1.0,
    vent: 0.0,
};
const VENT: Opening = Opening {
    fill: 0.0,
    vent: 1.0,
};
const SHUT: Opening = Opening {
    fill: 0.0,
    vent: 0.0,
};
const TANK: f64 = 2e-3;
const CHAMBER: f64 = 1e-4;
const AREA: f64 = 1e-6;

/// A tank with a line, all walls alike, and orifices.
fn supply(wall: Wall) -> Supply {
    let orifice = Passage::Orifice(OrificeLaw::new(Gas::AIR), AREA);
    Supply {
        gas: Gas::AIR,
        ambient: [1e5, WARM],
        tank: TANK,
        wall,
        outlet: None,
        lines: vec![Line {
            fill: orifice,
            vent: orifice,
            leak: None,
            wall,
        }],
    }
}

/// Goes on for `seconds` in `steps` with chambers that stay as they are.
fn rest(
    supply: &Supply,
    stock: &mut Stock,
    seconds: f64,
    steps: u32,
    volumes: &[f64],
    valves: &[Opening],
) {
    let h = seconds / f64::from(steps);
    for _ in 0..steps {
        supply.advance(stock, h, [volumes; 3], valves);
    }
}

/// Time (s) in which the line would be empty at the choked flow of its start: V/(A C₁ R √T) with
/// C₁ = √(κ/R) (2/(κ+1))^((κ+1)/(2(κ−1))).
fn emptying(area: f64) -> f64 {
    let (k, r) = (Gas::AIR.heat_ratio, Gas::AIR.constant);
    let choked = (k / r).sqrt() * (2.0 / (k + 1.0)).powf((k + 1.0) / (2.0 * (k - 1.0)));
    CHAMBER / (area * choked * r * WARM.sqrt())
}

#[test]
fn a_vessel_without_heat_empties_by_a_power_of_time() {
    let k = Gas::AIR.heat_ratio;
    let supply = supply(ADIABATIC);
    let tau = emptying(AREA);
    // ṁ = −A C₁ P/√T with T/T₀ = (P/P₀)^((κ−1)/κ); choked down to 1.89 bar.
    for (share, ends) in [(0.5, 20e5), (1.0, 20e5), (1.5, 40e5)] {
        let mut stock = supply.stock([1e5, WARM], &[(CHAMBER, [ends, WARM])]);
        rest(&supply, &mut stock, share * tau, 4000, &[CHAMBER], &[VENT]);
        let factor = 1.0 + 0.5 * (k - 1.0) * share;
        let [pressure, temperature] = supply.state(stock.lines[0], CHAMBER);
        assert!(pressure > 2e5, "{pressure} Pa: no longer choked");
        // The square of a step of 1/4000 of τ.
        near(pressure, ends * factor.powf(-2.0 * k / (k - 1.0)), 1e-7);
        near(temperature, WARM * factor.powi(-2), 1e-7);
        // What is in the tank stays there.
        assert_eq!(supply.tank_state(&stock), [1e5, WARM]);
    }
}

#[test]
fn a_leak_is_a_vent_that_never_shuts() {
    let mut supply = supply(ADIABATIC);
    let volumes = [CHAMBER];
    let mut vented = supply.stock([1e5, WARM], &[(CHAMBER, [20e5, WARM])]);
    let mut leaked = vented.clone();
    let seconds = emptying(AREA);
    rest(&supply, &mut vented, seconds, 100, &volumes, &[VENT]);
    supply.lines[0].leak = Some(supply.lines[0].vent);
    rest(&supply, &mut leaked, seconds, 100, &volumes, &[SHUT]);
    assert_eq!(vented, leaked);
    // Both at once.
    let mut both = supply.stock([1e5, WARM], &[(CHAMBER, [20e5, WARM])]);
    rest(&supply, &mut both, 0.5 * seconds, 100, &volumes, &[VENT]);
    near(both.lines[0].mass, leaked.lines[0].mass, 1e-12);
}

#[test]
fn an_empty_vessel_draws_in_air_of_the_atmosphere() {
    let k = Gas::AIR.heat_ratio;
    let mut supply = supply(ADIABATIC);
    let [outside, cold] = [1e5, 260.0];
    supply.ambient = [outside, cold];
    supply.lines[0].vent = Passage::tube([1.0, 3e-3, 0.0], 1.0, (Gas::AIR, cold), [outside, 0.0]);
    let low = 1e3;
    let mut stock = supply.stock([8e5, WARM], &[(CHAMBER, [low, WARM])]);
    rest(&supply, &mut stock, 1.0, 50_000, &[CHAMBER], &[VENT]);
    let [pressure, temperature] = supply.state(stock.lines[0], CHAMBER);
    near(pressure, outside, 1e-9);
    // P − P₀ = κ R T (m − m₀)/V with the temperature of what comes in.
    let mass = low / WARM + (outside - low) / (k * cold);
    near(temperature, outside / mass, 1e-9);
    assert!(stock.vented.mass < 0.0 && stock.vented.energy < 0.0);
}

#[test]
fn a_vessel_at_the_temperature_of_its_wall_empties_exponentially() {
    let supply = supply(ISOTHERMAL);
    let tau = emptying(AREA);
    for share in [0.5, 1.0, 2.0] {
        let mut stock = supply.stock([1e5, WARM], &[(CHAMBER, [20e5, WARM])]);
        rest(&supply, &mut stock, share * tau, 4000, &[CHAMBER], &[VENT]);
        let [pressure, temperature] = supply.state(stock.lines[0], CHAMBER);
        // The square of a step of share/4000 of τ, over 6.
        near(pressure, 20e5 * (-share).exp(), 1e-7);
        near(temperature, WARM, 1e-14);
    }
}

#[test]
fn a_shut_vessel_takes_the_temperature_of_its_wall_exponentially() {
    let resistance = 3.0;
    let supply = supply(Wall {
        temperature: WARM,
        resistance,
    });
    let start = supply.store(CHAMBER, [5e5, 400.0]);
    // m c_v = U/T.
    let tau = resistance * start.energy / 400.0;
    for steps in [10, 100, 1000] {
        let mut stock = supply.stock([1e5, WARM], &[(CHAMBER, [5e5, 400.0])]);
        rest(&supply, &mut stock, 1.5 * tau, steps, &[CHAMBER], &[SHUT]);
        let [_, temperature] = supply.state(stock.lines[0], CHAMBER);
        let left = 100.0 * (-1.5_f64).exp();
        let off = (temperature - WARM - left).abs();
        // Each step x of τ is off by x³/6, and a tenth of that at ten steps by higher powers.
        let step = 1.5 / f64::from(steps);
        let expected = left * 1.5 * step * step / 6.0;
        assert!(off < 1.1 * expected, "{off} K of {expected} K");
        assert_eq!(stock.lines[0].mass, start.mass);
        near(stock.heat, stock.lines[0].energy - start.energy, 1e-12);
    }
    // However long the step, it comes nearer to the wall and does not pass it.
    for long in [1.0, 10.0, 1e3, 1e9] {
        let mut stock = supply.stock([1e5, WARM], &[(CHAMBER, [5e5, 400.0])]);
        supply.advance(&mut stock, long * tau, [&[CHAMBER]; 3], &[SHUT]);
        let [_, temperature] = supply.state(stock.lines[0], CHAMBER);
        let bounds = WARM * (1.0 - 1e-15)..WARM + 100.0 / long;
        assert!(bounds.contains(&temperature), "{temperature} K");
    }
}

#[test]
fn each_volume_has_a_wall_of_its_own() {
    let wall = |temperature| Wall {
        temperature,
        resistance: 0.0,
    };
    let mut supply = supply(wall(250.0));
    supply.lines = vec![supply.lines[0]; 2];
    supply.lines[0].wall = wall(350.0);
    let start = [5e5, WARM];
    let mut stock = supply.stock(start, &[(CHAMBER, start), (CHAMBER, start)]);
    rest(&supply, &mut stock, 1e-3, 1, &[CHAMBER; 2], &[SHUT; 2]);
    near(supply.tank_state(&stock)[1], 250.0, 1e-14);
    near(supply.state(stock.lines[0], CHAMBER)[1], 350.0, 1e-14);
    near(supply.state(stock.lines[1], CHAMBER)[1], 250.0, 1e-14);
}

#[test]
fn a_shut_chamber_follows_the_adiabat_or_the_isotherm() {
    let k = Gas::AIR.heat_ratio;
    let steps = 1000;
    let volume = |step: f64| CHAMBER * (1.0 + step / f64::from(steps));
    for (wall, exponent) in [(ADIABATIC, k), (ISOTHERMAL, 1.0)] {
        let supply = supply(wall);
        let mut stock = supply.stock([1e5, WARM], &[(CHAMBER, [5e5, WARM])]);
        for step in (0..steps).map(f64::from) {
            let volumes = [step, step + 0.5, step + 1.0].map(|s| [volume(s)]);
            let h = 1e-4;
            supply.advance(
                &mut stock,
                h,
                [&volumes[0], &volumes[1], &volumes[2]],
                &[SHUT],
            );
        }
        let [pressure, _] = supply.state(stock.lines[0], 2.0 * CHAMBER);
        // The square of a step of 1/1000 of the volume.
        near(pressure, 5e5 * 0.5_f64.powf(exponent), 3e-7);
        let work = if exponent == 1.0 {
            5e5 * CHAMBER * 2.0_f64.ln()
        } else {
            5e5 * CHAMBER / (k - 1.0) * (1.0 - 0.5_f64.powf(k - 1.0))
        };
        near(stock.work, work, 3e-7);
    }
}

#[test]
fn two_vessels_come_to_the_pressure_of_their_energy() {
    let k = Gas::AIR.heat_ratio;
    let [high, low] = [20e5, 1e5];
    // P (V₁ + V₂) = P₁ V₁ + P₂ V₂: of mass where temperatures are one, of energy where no heat
    // passes.
    let both = (high * TANK + low * 20.0 * CHAMBER) / (TANK + 20.0 * CHAMBER);
    // A tube: its flow is linear near the end, which an orifice's, a root, only hovers about.
    let tube = Passage::tube([1.0, 3e-3, 0.0], 1.0, (Gas::AIR, WARM), [high, low]);
    for outlet in [None, Some(tube)] {
        for wall in [ADIABATIC, ISOTHERMAL] {
            let mut supply = supply(wall);
            supply.outlet = outlet;
            supply.lines[0].fill = tube;
            let volume = 20.0 * CHAMBER;
            let mut stock = supply.stock([high, WARM], &[(volume, [low, WARM])]);
            rest(&supply, &mut stock, 10.0, 20_000, &[volume], &[FILL]);
            let tank = supply.tank_state(&stock);
            let line = supply.state(stock.lines[0], volume);
            near(tank[0], both, 1e-9);
            near(line[0], both, 1e-9);
            if wall == ISOTHERMAL {
                near(tank[1], WARM, 1e-14);
                near(line[1], WARM, 1e-14);
                continue;
            }
            // What stays in the tank has expanded without heat; the rest is by the balance of mass.
            let stays = WARM * (both / high).powf((k - 1.0) / k);
            let all = [(TANK, high), (volume, low)].map(|(v, p)| supply.store(v, [p, WARM]).mass);
            let comes = all[0] + all[1] - supply.store(TANK, [both, stays]).mass;
            // The square of a step of 0.5 ms.
            near(tank[1], stays, 1e-8);
            near(line[1], both * volume / (comes * supply.gas.constant), 1e-8);
        }
    }
}

#[test]
fn a_vessel_filled_from_a_regulated_supply_warms_up_to_kappa() {
    let k = Gas::AIR.heat_ratio;
    let mut supply = supply(ADIABATIC);
    supply.tank = f64::INFINITY;
    let high = 8e5;
    supply.lines[0].fill = Passage::tube([1.0, 3e-3, 0.0], 1.0, (Gas::AIR, WARM), [high, 0.0]);
    for low in [1e2, 1e5, 4e5] {
        let mut stock = supply.stock([high, WARM], &[(CHAMBER, [low, WARM])]);
        let start = stock.clone();
        rest(&supply, &mut stock, 2.0, 200_000, &[CHAMBER], &[FILL]);
        // It keeps what it has, to the bit.
        assert_eq!(stock.tank, start.tank);
        near(supply.tank_state(&stock)[0], high, 1e-15);
        let [pressure, temperature] = supply.state(stock.lines[0], CHAMBER);
        near(pressure, high, 1e-9);
        // U − U₀ = h (m − m₀): P − P₀ = κ R T₀ (m − m₀)/V, and T = P V/(m R).
        let ratio = low / high;
        near(temperature, WARM * k / (1.0 + (k - 1.0) * ratio), 1e-9);
        if low == 1e2 {
            near(temperature, k * WARM, 1e-4);
        }
    }
}

/// A tank whose gas goes through an outlet to two lines that move, all of it smooth in time: where
/// it is after 10 ms in so many steps.
fn smooth(resistance: f64, steps: u32) -> Vec<f64> {
    let wall = |temperature| Wall {
        temperature,
        resistance,
    };
    let mut supply = supply(wall(290.0));
    let tube = |length| Passage::tube([length, 3e-3, 1e-6], 1.0, (Gas::AIR, WARM), [8e5, 4e5]);
    supply.outlet = Some(tube(0.3));
    supply.lines = [0.5, 1.0]
        .map(|length| Line {
            fill: tube(length),
            vent: tube(2.0),
            leak: Some(tube(20.0)),
            wall: wall(310.0),
        })
        .to_vec();
    let mut stock = supply.stock(
        [8e5, 290.0],
        &[(CHAMBER, [3e5, 310.0]), (CHAMBER, [2e5, 310.0])],
    );
    let h = 0.01 / f64::from(steps);
    for step in 0..steps {
        let middle = (f64::from(step) + 0.5) * h;
        let at = |t: f64| {
            [
                CHAMBER * (1.0 + 30.0 * t),
                CHAMBER * (1.0 + 0.3 * (200.0 * t).sin()),
            ]
        };
        let volumes = [middle - 0.5 * h, middle, middle + 0.5 * h].map(at);
        let fill = 0.6 + 0.3 * (300.0 * middle).sin();
        let valves = [
            Opening { fill, vent: 0.1 },
            Opening {
                fill: 0.5,
                vent: 1.0 - fill,
            },
        ];
        supply.advance(
            &mut stock,
            h,
            [&volumes[0], &volumes[1], &volumes[2]],
            &valves,
        );
    }
    let mut all = vec![
        stock.heat,
        stock.work,
        stock.vented.mass,
        stock.vented.energy,
    ];
    for store in stock.lines.iter().chain([&stock.tank]) {
        all.extend([store.mass, store.energy]);
    }
    all
}

#[test]
fn half_the_step_leaves_a_quarter_of_the_error() {
    // No heat, heat of which much passes in the time, and gas as warm as its wall.
    for resistance in [f64::INFINITY, 0.05, 0.0] {
        let [coarse, middle, fine] = [50, 100, 200].map(|steps| smooth(resistance, steps));
        let distance = |a: &[f64], b: &[f64]| {
            a.iter()
                .zip(b)
                .filter(|(_, b)| **b != 0.0)
                .map(|(a, b)| (a / b - 1.0).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        let order = (distance(&coarse, &middle) / distance(&middle, &fine)).log2();
        assert!(
            (1.9..2.1).contains(&order),
            "{resistance} K/W: order {order}"
        );
    }
}
