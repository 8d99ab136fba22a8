//! What every supply keeps: mass, energy, and the symmetry of its lines.

use std::f64::consts::TAU;

use proptest::prelude::*;
use saltus_pneumatics::{Line, Opening, OrificeLaw, Passage, Stock, Supply, Wall};
use saltus_robot::Gas;

use crate::passage::passages;
use crate::{cases, decades, gases};

/// A supply with the gas in it, and how its chambers move.
#[derive(Clone, Debug)]
struct Drawn {
    supply: Supply,
    /// Pressure (Pa) and temperature (K) of the tank, and of each line.
    tank: [f64; 2],
    lines: Vec<[f64; 2]>,
    motions: Vec<Motion>,
}

/// A chamber that comes and goes: mean volume (m³), share of it that moves, cycles, phase.
#[derive(Clone, Copy, Debug)]
struct Motion {
    mean: f64,
    share: f64,
    cycles: f64,
    phase: f64,
}

impl Motion {
    /// Volume (m³) so far (0 to 1) along the run.
    fn volume(&self, along: f64) -> f64 {
        self.mean * (1.0 + self.share * (TAU * (self.cycles * along + self.phase)).sin())
    }
}

/// Opening of each valve, for a while.
type Valves = Vec<Opening>;

/// Pressure (Pa) and temperature (K) of gas.
fn states() -> impl Strategy<Value = [f64; 2]> {
    (decades(1e4, 4e6), 220.0..400.0).prop_map(|(p, t)| [p, t])
}

fn walls() -> impl Strategy<Value = Wall> {
    let resistance = prop_oneof![Just(0.0), decades(1e-5, 1e4), Just(f64::INFINITY)];
    (220.0..400.0, resistance).prop_map(|(temperature, resistance)| Wall {
        temperature,
        resistance,
    })
}

fn lines(gas: Gas) -> impl Strategy<Value = Line> {
    let leak = prop::option::of(passages(gas).prop_map(|leak| leak.times(0.01)));
    (passages(gas), passages(gas), leak, walls()).prop_map(|(fill, vent, leak, wall)| Line {
        fill,
        vent,
        leak,
        wall,
    })
}

fn motions() -> impl Strategy<Value = Motion> {
    (decades(1e-6, 1e-2), 0.0..0.8, 0.0..2.0, 0.0..1.0).prop_map(|(mean, share, cycles, phase)| {
        Motion {
            mean,
            share,
            cycles,
            phase,
        }
    })
}

/// A tank of any size with one to four lines, each with its gas, wall and motion.
fn supplies() -> impl Strategy<Value = Drawn> {
    let whole = |gas: Gas| {
        let lines = prop::collection::vec((lines(gas), states(), motions()), 1..=4);
        let tank = (decades(1e-6, 1e-1), states(), walls());
        (
            Just(gas),
            tank,
            prop::option::of(passages(gas)),
            lines,
            states(),
        )
    };
    gases()
        .prop_flat_map(whole)
        .prop_map(|(gas, (size, tank, wall), outlet, drawn, ambient)| {
            let supply = Supply {
                gas,
                ambient,
                tank: size,
                wall,
                outlet,
                lines: drawn.iter().map(|(line, _, _)| *line).collect(),
            };
            Drawn {
                supply,
                tank,
                lines: drawn.iter().map(|(_, state, _)| *state).collect(),
                motions: drawn.iter().map(|(_, _, motion)| *motion).collect(),
            }
        })
}

/// Shut, open, and in between; for four lines, four times over.
fn schedules() -> impl Strategy<Value = Vec<Valves>> {
    let open = || prop_oneof![Just(0.0), Just(1.0), 0.0..1.0];
    let opening = (open(), open()).prop_map(|(fill, vent)| Opening { fill, vent });
    prop::collection::vec(prop::collection::vec(opening, 4), 4)
}

impl Drawn {
    /// Lets no heat pass.
    fn insulate(&mut self) {
        let lines = self.supply.lines.iter_mut().map(|line| &mut line.wall);
        for wall in lines.chain([&mut self.supply.wall]) {
            wall.resistance = f64::INFINITY;
        }
    }

    fn stock(&self) -> Stock {
        let lines = self.motions.iter().zip(&self.lines);
        let lines: Vec<_> = lines.map(|(m, state)| (m.volume(0.0), *state)).collect();
        self.supply.stock(self.tank, &lines)
    }

    /// A step (s) in which no volume is filled or emptied by more than a twentieth: a step of the
    /// midpoint rule that makes sense.
    fn step(&self) -> f64 {
        let supply = &self.supply;
        let all = self.lines.iter().chain([&self.tank, &supply.ambient]);
        let high = all.map(|state| state[0]).fold(0.0, f64::max);
        let coldest = 150.0;
        let most = |passage: &Passage| passage.flow([high, coldest], 0.0);
        let content = |volume| supply.store(volume, [high, 400.0]).mass;
        let mut step = f64::INFINITY;
        let mut drawn = 0.0;
        for (line, motion) in supply.lines.iter().zip(&self.motions) {
            let leak = line.leak.as_ref().map_or(0.0, most);
            let through = most(&line.fill) + most(&line.vent) + leak;
            drawn += most(&line.fill);
            step = step.min(content(motion.mean * (1.0 - motion.share)) / through);
        }
        0.05 * step.min(content(supply.tank) / drawn)
    }

    /// Runs the schedule in so many steps, `look` at each.
    fn run(&self, schedule: &[Valves], steps: usize, mut look: impl FnMut(&Stock)) {
        let h = self.step();
        let mut stock = self.stock();
        let all =
            |along: f64| -> Vec<f64> { self.motions.iter().map(|m| m.volume(along)).collect() };
        for step in 0..steps {
            let at = |ahead: f64| all((step as f64 + ahead) / steps as f64);
            let valves = &schedule[step * schedule.len() / steps];
            let [from, middle, to] = [0.0, 0.5, 1.0].map(at);
            let valves = &valves[..self.supply.lines.len()];
            self.supply
                .advance(&mut stock, h, [&from, &middle, &to], valves);
            look(&stock);
        }
    }
}

/// Mass (kg) and energy (J) that come from nowhere if they change.
fn kept(stock: &Stock) -> [f64; 2] {
    let all = || stock.lines.iter().chain([&stock.tank, &stock.vented]);
    let mass = all().map(|store| store.mass).sum();
    let energy: f64 = all().map(|store| store.energy).sum();
    [mass, energy + stock.work - stock.heat]
}

/// Flow (kg/s) from one state to another; negative backwards.
fn between(passage: &Passage, a: [f64; 2], b: [f64; 2]) -> f64 {
    if a[0] > b[0] {
        passage.flow(a, b[0])
    } else {
        -passage.flow(b, a[0])
    }
}

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn mass_and_energy_are_kept(drawn in supplies(), schedule in schedules()) {
        let start = kept(&drawn.stock());
        // What has been in play: round-off of 200 steps is 1e-14 of it.
        let mut most = start;
        let mut last = drawn.stock();
        drawn.run(&schedule, 200, |stock| {
            most[0] = most[0].max(stock.vented.mass.abs());
            for energy in [stock.vented.energy, stock.heat, stock.work] {
                most[1] = most[1].max(energy.abs());
            }
            last = stock.clone();
        });
        for (now, (before, most)) in kept(&last).iter().zip(start.iter().zip(most)) {
            prop_assert!((now - before).abs() < 1e-12 * most, "{before} became {now}");
        }
        for store in last.lines.iter().chain([&last.tank]) {
            prop_assert!(store.mass > 0.0 && store.energy > 0.0, "{last:?}");
        }
    }

    #[test]
    fn a_line_flows_back_into_the_tank(drawn in supplies(), times in 1.5_f64..10.0) {
        let mut drawn = drawn;
        // All lines above the tank, shut to the atmosphere.
        drawn.insulate();
        for (state, motion) in drawn.lines.iter_mut().zip(&mut drawn.motions) {
            state[0] = times * drawn.tank[0];
            motion.share = 0.0;
        }
        for line in &mut drawn.supply.lines {
            line.leak = None;
        }
        let before = drawn.stock();
        let mut after = before.clone();
        let open = vec![Opening { fill: 1.0, vent: 0.0 }; drawn.lines.len()];
        drawn.run(&[open], 10, |stock| after = stock.clone());
        prop_assert!(after.tank.mass > before.tank.mass && after.tank.energy > before.tank.energy);
        for (now, then) in kept(&after).iter().zip(kept(&before)) {
            prop_assert!((now / then - 1.0).abs() < 1e-12);
        }
        prop_assert_eq!((after.vented.mass, after.heat, after.work), (0.0, 0.0, 0.0));
    }

    #[test]
    fn the_manifold_passes_on_what_it_gets(
        drawn in supplies(),
        schedule in schedules(),
        level in 0..3,
    ) {
        let mut drawn = drawn;
        // A wall without resistance would change the state at once.
        drawn.insulate();
        // As drawn; one line near the pressure of the tank; and all of them.
        let near = [0, 1, drawn.lines.len()][usize::try_from(level).expect("small")];
        for state in &mut drawn.lines[..near] {
            state[0] = drawn.tank[0] * (1.0 + 1e-3 * (state[0] / 4e6 - 0.5));
        }
        let Some(outlet) = drawn.supply.outlet else {
            return Ok(());
        };
        let mut stock = drawn.stock();
        let volumes: Vec<f64> = drawn.motions.iter().map(|m| m.volume(0.0)).collect();
        let valves = &schedule[0][..drawn.lines.len()];
        // Not quite what was drawn: a pressure's last digit.
        let tank = drawn.supply.tank_state(&stock);
        let each = stock.lines.iter().zip(&volumes);
        let lines: Vec<_> = each.map(|(store, v)| drawn.supply.state(*store, *v)).collect();
        // So short a step that the pressures stay as they are.
        drawn.supply.advance(&mut stock, 1e-30, [&volumes; 3], valves);
        let manifold = [stock.manifold, tank[1]];
        let gives = between(&outlet, tank, manifold);
        // Near no flow at all, an orifice lets 1e-8 of its choked flow through for the last digit
        // of a pressure.
        let mut choked = between(&outlet, tank, [0.0, 0.0]);
        let mut most = gives.abs();
        let mut left = gives;
        for (i, line) in drawn.supply.lines.iter().enumerate() {
            let flow = valves[i].fill * between(&line.fill, manifold, lines[i]);
            choked = choked.max(valves[i].fill * between(&line.fill, lines[i], [0.0, 0.0]));
            left -= flow;
            most = most.max(flow.abs());
        }
        prop_assert!(left.abs() <= 1e-6 * most.max(0.1 * choked), "{left} of {most} kg/s left");
        let all = lines.iter().zip(valves).filter(|(_, valve)| valve.fill > 0.0);
        let (low, high) = all.fold((tank[0], tank[0]), |(low, high), (state, _)| {
            (low.min(state[0]), high.max(state[0]))
        });
        prop_assert!((low..=high).contains(&stock.manifold));
    }

    #[test]
    fn equal_lines_do_the_same(drawn in supplies(), schedule in schedules()) {
        let mut drawn = drawn;
        let twin = (drawn.supply.lines[0], drawn.lines[0], drawn.motions[0]);
        drawn.supply.lines.insert(1, twin.0);
        drawn.lines.insert(1, twin.1);
        drawn.motions.insert(1, twin.2);
        let mut schedule = schedule;
        for valves in &mut schedule {
            let twin = valves[0];
            valves.insert(1, twin);
        }
        let mut same = true;
        drawn.run(&schedule, 50, |stock| same &= stock.lines[0] == stock.lines[1]);
        prop_assert!(same);
    }

    #[test]
    fn a_valve_that_opens_in_part_lets_that_share_through(
        drawn in supplies(),
        shares in prop::collection::vec((0.01..1.0, 0.01..1.0), 4),
    ) {
        let mut drawn = drawn;
        let count = drawn.lines.len();
        let volumes: Vec<f64> = drawn.motions.iter().map(|m| m.volume(0.0)).collect();
        let h = drawn.step();
        let (mut part, mut whole) = (drawn.stock(), drawn.stock());
        let valves: Vec<_> = shares.iter().map(|&(fill, vent)| Opening { fill, vent }).collect();
        drawn.supply.advance(&mut part, h, [&volumes; 3], &valves[..count]);
        for (line, valve) in drawn.supply.lines.iter_mut().zip(&valves) {
            line.fill = line.fill.times(valve.fill);
            line.vent = line.vent.times(valve.vent);
        }
        let open = vec![Opening { fill: 1.0, vent: 1.0 }; count];
        drawn.supply.advance(&mut whole, h, [&volumes; 3], &open);
        for (part, whole) in part.lines.iter().zip(&whole.lines) {
            // The manifold's search ends at 1e-9 of what flows.
            prop_assert!((part.mass / whole.mass - 1.0).abs() < 1e-9, "{part:?}, {whole:?}");
        }
    }

    #[test]
    fn a_step_that_is_far_too_long_is_no_panic(
        drawn in supplies(),
        schedule in schedules(),
        long in decades(1.0, 1e6),
    ) {
        let mut stock = drawn.stock();
        let volumes: Vec<f64> = drawn.motions.iter().map(|m| m.volume(0.0)).collect();
        for valves in &schedule {
            let valves = &valves[..drawn.lines.len()];
            drawn.supply.advance(&mut stock, long * drawn.step(), [&volumes; 3], valves);
        }
    }

    #[test]
    fn a_regulated_supply_keeps_its_pressure(drawn in supplies(), schedule in schedules()) {
        let mut drawn = drawn;
        drawn.supply.tank = f64::INFINITY;
        let start = drawn.stock().tank;
        let mut same = true;
        drawn.run(&schedule, 50, |stock| same &= stock.tank == start);
        prop_assert!(same);
    }

    #[test]
    fn an_outlet_without_resistance_is_none(drawn in supplies(), schedule in schedules()) {
        let mut drawn = drawn;
        let last = |drawn: &Drawn| {
            let mut last = drawn.stock();
            drawn.run(&schedule, 1, |stock| last = stock.clone());
            last
        };
        for motion in &mut drawn.motions {
            motion.share = 0.0;
        }
        drawn.supply.outlet = None;
        let without = last(&drawn);
        // 1000 m². The lines let as much through as 0.2 m² of an orifice do at most, at up to 400
        // times the tank's pressure; the pressure falls by the square of that ratio.
        drawn.supply.outlet = Some(Passage::Orifice(OrificeLaw::new(drawn.supply.gas), 1e3));
        let with = last(&drawn);
        prop_assert!((with.manifold / without.manifold - 1.0).abs() < 1e-7);
    }
}
