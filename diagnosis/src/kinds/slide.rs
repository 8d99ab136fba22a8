//! A mass on a guide, driven by a measured force.

use std::f64::consts::TAU;

use super::input::Input;
use super::{
    Causes, FREE, amount, braked, causes, delay, directional, faults, gain, offset, share, simple,
    unknown,
};
use crate::experiment::{Experiment, Run, Sort};
use crate::kind::{Asked, Cause, Data, Kind, Parameter, Terms};
use crate::layout::{Draw, Layout, count};
use crate::noise;
use crate::plausible;
use crate::spec::{
    FORCE, LOAD, PART, POSITION, Source, Spec, Synthesis, calm, lively, noisy, optional,
};

/// What is given of a run.
#[derive(Clone, Debug, PartialEq)]
struct Drive {
    /// Mass (kg), if it is known.
    mass: Option<f64>,
    /// Force (N).
    force: Input,
}

/// Slides.
#[derive(Clone, Debug)]
pub struct Slides {
    data: Data,
    drives: Vec<Drive>,
    causes: Causes<Effect>,
    mass_is_known: bool,
    /// Standard deviation (N) of a measured force.
    force_noise: f64,
}

/// Longest step (s).
const STEP: f64 = 1e-3;

impl Slides {
    /// The experiment's slides.
    pub fn new(experiment: &Experiment) -> Slides {
        let column = |name| experiment.column(name).unwrap_or(0);
        let (force, position) = (column("force_n"), column("position_m"));
        let mut data = Data::of(experiment, &[position]);
        let of_force = noise::channels(experiment, &[force]).swap_remove(0);
        data.channels[0].is_given &= of_force.is_given;
        let force_noise = of_force.noise;
        let runs = experiment.runs.iter();
        let drive = |run: &Run| Drive {
            mass: run.settings.get("mass_kg").copied(),
            force: Input::of(run, Some(force)),
        };
        let drives: Vec<Drive> = runs.map(drive).collect();
        let mass_is_known = drives.iter().all(|d| d.mass.is_some());
        Slides {
            causes: Causes::of(&mut data, listed(mass_is_known), unnamed()),
            data,
            drives,
            mass_is_known,
            force_noise,
        }
    }

    /// What acts on the mass of a run; none where nothing says what it is.
    fn guide(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Option<Guide> {
        let mass = match (self.drives[run].mass, unknowns.get(2)) {
            (_, Some(&mass)) => mass,
            // Where a run does not tell its mass, there is no such cause: the others' are believed.
            (Some(mass), None) => mass * self.causes.or(Effect::Mass, 1.0, terms),
            _ => return None,
        };
        let [dry, forward] = self
            .causes
            .friction(Effect::Dry, Effect::Directional, terms);
        Some(Guide {
            mass,
            forward,
            friction: [
                dry,
                self.causes.get(Effect::Viscous, 0, terms)?,
                self.causes.get(Effect::Drag, 0, terms)?,
            ],
            stiffness: self.causes.get(Effect::Spring, 0, terms)?,
            preload: self.causes.get(Effect::Spring, 1, terms)?,
            stiffening: self.causes.get(Effect::Stiffening, 0, terms)?,
            tightening: self.causes.get(Effect::Tightening, 0, terms)?,
            start: *unknowns.first()?,
        })
    }
}

/// What a cause does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Effect {
    Dry,
    Directional,
    Viscous,
    Drag,
    Spring,
    Mass,
    /// Without a name.
    Stiffening,
    Tightening,
}

/// Terms without a name; x is how far it is from where it starts.
fn unnamed() -> Vec<(Option<Effect>, Cause)> {
    let stiffening = simple("force -c x^3", "c_n_per_m3", 0.0, (-1e9, 1e9), 100.0, &[]);
    let tightening = simple(
        "dry friction c |x|",
        "c_n_per_m",
        0.0,
        (-1e6, 1e6),
        5.0,
        &[],
    );
    causes! {
        Effect::Stiffening => stiffening;
        Effect::Tightening => tightening;
    }
}

fn listed(mass_is_known: bool) -> Vec<(Option<Effect>, Cause)> {
    let viscous = "viscous_friction_n_s_per_m";
    let spring = vec![
        unknown("stiffness_n_per_m", 0.0, (0.0, 1e7), 5.0),
        unknown("preload_n", 0.0, (-1e5, 1e5), 0.5),
    ];
    let dry = amount(
        "coulomb-friction",
        "coulomb_friction_n",
        1e5,
        0.5,
        &[1.0, 5.0],
    );
    let mut all = causes! {
        Effect::Directional => directional(&dry);
        Effect::Dry => dry;
        Effect::Viscous => amount("viscous-friction", viscous, 1e6, 0.5, &[1.0, 10.0]);
        Effect::Drag => amount("air-drag", "drag_n_s2_per_m2", 1e5, 0.1, &[1.0]);
        Effect::Spring => Cause::several("return-spring", spring);
    };
    all.extend(faults([
        offset("force_n", "n", FREE, 0.1),
        delay("position_m", 0.5, 1e-3),
        delay("force_n", 0.5, 1e-3),
        gain("position_m"),
    ]));
    if mass_is_known {
        all.extend(faults([gain("force_n")]));
        all.push((Some(Effect::Mass), share("mass", "mass_share", 0.02)));
    }
    all
}

/// What acts on the mass beside the drive.
struct Guide {
    /// Mass (kg).
    mass: f64,
    /// Dry friction (N), viscous friction (N s/m) and drag (N s²/m²).
    friction: [f64; 3],
    /// How far (N) dry friction forward is above its mean of both directions.
    forward: f64,
    /// Stiffness (N/m) of a spring and its force (N) at the start.
    stiffness: f64,
    preload: f64,
    /// Spring of the third order (N/m³), and dry friction (N/m) that grows with the way from the start.
    stiffening: f64,
    tightening: f64,
    /// Where (m) it starts.
    start: f64,
}

impl Guide {
    /// One step of h (s) under a force (N): the middle of the step gives the forces.
    fn go(&self, [x, v]: [f64; 2], force: f64, h: f64) -> [f64; 2] {
        let middle = x + 0.5 * h * v;
        let way = middle - self.start;
        let spring = self.stiffness * way + self.stiffening * way.powi(3) + self.preload;
        let push = force - spring - self.forward;
        let [dry, viscous, drag] = self.friction;
        let dry = (dry + self.tightening * way.abs()).max(0.0);
        let next = braked(v, push, [dry, viscous, drag], self.mass, h);
        [x + 0.5 * h * (v + next), next]
    }
}

impl Kind for Slides {
    fn data(&self) -> &Data {
        &self.data
    }

    /// Where and how fast it starts; its mass where nobody knows it.
    fn unknowns(&self, run: usize) -> Vec<Parameter> {
        let readings = &self.data.logs[run].readings;
        let start = readings.first().map_or(0.0, |r| r.value);
        let mut all = vec![
            unknown("start_m", start, FREE, 1e-3),
            unknown("start_speed_m_s", 0.0, FREE, 0.01),
        ];
        if !self.mass_is_known {
            all.push(unknown("mass_kg", 1.0, (1e-4, 1e5), 0.1));
        }
        all
    }

    fn stronger(&self) -> String {
        let most = self
            .drives
            .iter()
            .flat_map(|drive| &drive.force.values)
            .fold(0.0_f64, |most, f| most.max(f.abs()));
        format!(
            "runs with a larger force, so that the mass moves more (the largest of these is \
             {most:.3} N)"
        )
    }

    /// The noise of the force, twice integrated.
    fn input_noise(&self, run: usize, normal: &mut dyn FnMut() -> f64) -> Option<Vec<f64>> {
        let drive = &self.drives[run];
        let (mass, time) = (drive.mass?, &drive.force.time);
        let (mut x, mut v, mut row) = (0.0, 0.0, 0);
        let moved = |reading: &crate::kind::Reading| {
            while row + 1 < time.len() && time[row] < reading.time {
                let h = time[row + 1] - time[row];
                let kick = h * self.force_noise * normal() / mass;
                (x, v, row) = (x + h * (v + 0.5 * kick), v + kick, row + 1);
            }
            x
        };
        Some(self.data.logs[run].readings.iter().map(moved).collect())
    }

    fn truths(&self, asked: &Asked<'_>) -> Option<Vec<f64>> {
        let (run, terms, unknowns) = asked.parts();
        let drive = &self.drives[run];
        let guide = self.guide(run, terms, unknowns)?;
        let gauge = self.data.sensor("force_n", terms);
        let mut state = [unknowns[0], unknowns[1]];
        let (mut now, mut at) = (*drive.force.time.first()?, 0);
        // A stiff spring swings fast.
        let step = STEP.min(0.3 * (guide.mass / guide.stiffness).sqrt());
        let mut out = Vec::with_capacity(asked.times.len());
        for &until in &asked.times {
            while now < until {
                let h = step.min(until - now);
                let force = drive.force.smooth(now + 0.5 * h, &gauge, &mut at);
                state = guide.go(state, force, h);
                now += h;
            }
            out.push(state[0]);
        }
        Some(out)
    }
}

/// The kind.
pub(super) const SPEC: Spec = Spec {
    sort: Sort::Slide,
    id: "slide",
    description: "A mass driven on a guide",
    // A weight on a string pulls always the same.
    channels: &[calm("force_n", FORCE), lively("position_m", POSITION)],
    settings: &[optional("mass_kg", LOAD)],
    checks: plausible::SLIDE,
    model: |data, _| Ok(Box::new(Slides::new(data))),
    synthesis: Synthesis {
        instruments: &[noisy("force_n", 1e-3), noisy("position_m", 2e-4)],
        without_boom: None,
        runs: 6,
        lay_out,
        source: Source::Model,
    },
    ..PART
};

/// Adds slides of one mass, driven by three sines that set in smoothly.
fn lay_out(layout: &mut Layout, runs: usize, draw: &mut Draw) {
    let mass = draw.stepped(0.5, 4.0, 1e-3);
    for _ in 0..runs {
        let sines = [(); 3].map(|()| {
            // Fast enough that a mass without friction stays on the guide.
            let rate = TAU * draw.between(1.0, 4.0);
            (
                mass * draw.between(1.0, 4.0) * rate / 10.0,
                rate,
                draw.between(0.0, TAU),
            )
        });
        let rows = count(draw.between(0.7, 1.2), 2e-3);
        layout.add(&[("mass_kg", mass)], rows, 2e-3, vec![0.0, 0.0]);
        let force = layout.column("force_n");
        let Some(run) = layout.experiment.runs.last_mut() else {
            return;
        };
        for (row, t) in run.time.iter().enumerate() {
            let window = (t / 0.2).clamp(0.0, 1.0).powi(2);
            run.values[force][row] = window
                * sines
                    .iter()
                    .map(|(a, w, p)| a * (w * t + p).sin())
                    .sum::<f64>();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use crate::toy;

    const MASS: f64 = 1.5;

    /// What a mass that starts at 0.1 m with `speed` (m/s) does under `force` (N) with terms on:
    /// every 10 ms for a second.
    fn moved(force: f64, speed: f64, on: &[(&str, usize, f64)]) -> Vec<(f64, f64)> {
        let time: Vec<f64> = (0..=100).map(|k| f64::from(k) * 0.01).collect();
        let columns = [
            ("position_m", time.clone()),
            ("force_n", vec![force; time.len()]),
        ];
        let data = toy::measured(Sort::Slide, &[("mass_kg", MASS)], &time, &columns);
        let slides = Slides::new(&data);
        let terms = toy::terms(&slides, on);
        let found = slides.predict(0, &terms, &[0.1, speed]);
        time.into_iter().zip(found.expect("an answer")).collect()
    }

    #[track_caller]
    fn check(found: &[(f64, f64)], within: f64, closed: impl Fn(f64) -> f64) {
        for &(t, x) in found {
            let y = closed(t);
            assert!((x - y).abs() < within, "{t} s: {x} m, in closed form {y}");
        }
    }

    #[test]
    fn a_constant_force_makes_a_parabola() {
        let parabola = |t: f64| 0.1 + 0.4 * t + 0.5 * 3.0 / MASS * t * t;
        check(&moved(3.0, 0.4, &[]), 1e-12, parabola);
        // The same force, read half as large or 2 N less; a mass believed half as large.
        check(
            &moved(1.5, 0.4, &[("encoder-scale@force_n", 0, 0.5)]),
            1e-12,
            parabola,
        );
        check(
            &moved(1.0, 0.4, &[("sensor-offset", 0, -2.0)]),
            1e-12,
            parabola,
        );
        check(&moved(6.0, 0.4, &[("mass", 0, 2.0)]), 1e-12, parabola);
    }

    #[test]
    fn dry_friction_stops_it_for_good() {
        let (speed, friction) = (0.8, 3.0);
        let stop = MASS * speed / friction;
        let found = moved(0.0, speed, &[("coulomb-friction", 0, friction)]);
        check(&found, 1e-3 * speed, |t| {
            let t = t.min(stop);
            0.1 + speed * t - 0.5 * friction / MASS * t * t
        });
        let at_rest: Vec<f64> = found.iter().filter(|r| r.0 > stop).map(|r| r.1).collect();
        assert!(at_rest.windows(2).all(|w| w[0] == w[1]));
        // What holds a mass at rest is no more than what pushes it.
        check(
            &moved(2.9, 0.0, &[("coulomb-friction", 0, friction)]),
            1e-15,
            |_| 0.1,
        );
    }

    /// Place (m) of a mass with dry friction forward and back (N), from its speed (m/s) under a constant
    /// force (N): a parabola until it stops, and from there on another one, or rest.
    fn parabolas([forward, back]: [f64; 2], force: f64, speed: f64, t: f64) -> f64 {
        let against = if speed > 0.0 { -forward } else { back };
        let first = (force + against) / MASS;
        let stop = if first * speed < 0.0 {
            -speed / first
        } else {
            f64::INFINITY
        };
        let second = (force - forward).max(0.0) + (force + back).min(0.0);
        let (early, late) = (t.min(stop), (t - stop).max(0.0));
        let until = speed * early + 0.5 * first * early * early;
        until + 0.5 * second / MASS * late * late
    }

    /// Where it turns round within a step, friction turns round with it: else its rate would be off by
    /// 80 µm/s from there on.
    #[test]
    fn dry_friction_turns_round_within_a_step() {
        for (force, speed) in [(-2.0, 0.7), (2.4, -0.6)] {
            let found = moved(force, speed, &[("coulomb-friction", 0, 0.9)]);
            check(&found, 3e-6, |t| {
                0.1 + parabolas([0.9, 0.9], force, speed, t)
            });
        }
    }

    /// Ids of the causes that a diagnosis names for a mass with this dry friction (N), forward and back,
    /// and the values of the first.
    fn found_in_parabolas(friction: [f64; 2]) -> (Vec<&'static str>, Vec<f64>) {
        let mut draw = Draw::new(8);
        let time: Vec<f64> = (0..=200).map(|k| f64::from(k) * 5e-3).collect();
        let mut run = |(force, speed): (f64, f64)| {
            let place = |t: &f64| parabolas(friction, force, speed, *t) + 2e-4 * draw.normal();
            Run {
                settings: [("mass_kg".to_owned(), MASS)].into(),
                values: vec![time.iter().map(place).collect(), vec![force; time.len()]],
                time: time.clone(),
                ..Run::default()
            }
        };
        let runs = [
            (0.0, 0.9),
            (0.0, -0.6),
            (2.0, -0.5),
            (-2.2, 0.7),
            (2.5, 0.1),
        ];
        let data = Experiment {
            kind: Sort::Slide,
            mechanism: None,
            columns: ["position_m", "force_n"].map(str::to_owned).into(),
            noise: vec![Some(2e-4), None],
            resolution: vec![None; 2],
            runs: runs.map(&mut run).into(),
        };
        let slides = Slides::new(&data);
        let found = crate::diagnose(&slides, &Settings::default(), &|_| ()).expect("an answer");
        let causes: Vec<usize> = found.findings.iter().map(|f| f.best.cause).collect();
        let ids = causes.iter().map(|c| slides.causes()[*c].id).collect();
        let first = causes.first().map(|c| found.after.terms.of(*c).to_vec());
        assert!(found.unknown.is_none());
        (ids, first.unwrap_or_default())
    }

    #[test]
    fn dry_friction_that_differs_by_direction_is_found() {
        let (ids, values) = found_in_parabolas([1.2, 0.7]);
        assert_eq!(ids, ["directional-friction"]);
        assert!(
            (values[0] - 1.2).abs() < 0.02 && (values[1] - 0.7).abs() < 0.02,
            "{values:?}"
        );
        let (ids, values) = found_in_parabolas([1.0, 1.0]);
        assert_eq!(ids, ["coulomb-friction"]);
        assert!((values[0] - 1.0).abs() < 0.02, "{values:?}");
        assert!(found_in_parabolas([0.0, 0.0]).0.is_empty());
    }

    #[test]
    fn viscous_friction_and_drag_are_those_of_the_textbook() {
        let (speed, c) = (0.8, 4.0);
        check(
            &moved(0.0, speed, &[("viscous-friction", 0, c)]),
            1e-6,
            |t| 0.1 + speed * MASS / c * (1.0 - (-c * t / MASS).exp()),
        );
        // A step takes the drag of its start.
        check(&moved(0.0, speed, &[("air-drag", 0, c)]), 2e-4, |t| {
            0.1 + MASS / c * (1.0 + c * speed * t / MASS).ln()
        });
    }

    #[test]
    fn a_spring_swings_about_its_balance() {
        let (stiffness, preload) = (60.0, 1.2);
        let on = [
            ("return-spring", 0, stiffness),
            ("return-spring", 1, preload),
        ];
        let (rate, low) = (f64::sqrt(stiffness / MASS), preload / stiffness);
        check(&moved(0.0, 0.3, &on), 1e-5, |t| {
            0.1 - low + low * (rate * t).cos() + 0.3 / rate * (rate * t).sin()
        });
    }

    /// Friction in proportion to the way slows like a spring, and then holds it; a spring of the third order
    /// turns it round where it has taken its energy.
    #[test]
    fn terms_without_a_name_take_their_work() {
        let (speed, c) = (0.6, 30.0);
        let rate = f64::sqrt(c / MASS);
        check(
            &moved(0.0, speed, &[("dry friction c |x|", 0, c)]),
            1e-4,
            |t| 0.1 + speed / rate * (rate * t.min(std::f64::consts::FRAC_PI_2 / rate)).sin(),
        );
        let found = moved(0.0, speed, &[("force -c x^3", 0, 400.0)]);
        let farthest = found.iter().map(|r| r.1).fold(0.0, f64::max);
        let closed = 0.1 + (2.0 * MASS * speed * speed / 400.0).powf(0.25);
        assert!((farthest - closed).abs() < 1e-4, "{farthest} {closed}");
    }

    #[test]
    fn a_sensor_is_late_or_shows_too_much() {
        let late = moved(3.0, 0.4, &[("sensor-delay@position_m", 0, 0.05)]);
        check(&late, 1e-12, |t| {
            let t = (t - 0.05).max(0.0);
            0.1 + 0.4 * t + 0.5 * 3.0 / MASS * t * t
        });
        let long = moved(3.0, 0.4, &[("encoder-scale@position_m", 0, 1.1)]);
        check(&long, 1e-12, |t| {
            1.1 * (0.1 + 0.4 * t + 0.5 * 3.0 / MASS * t * t)
        });
    }
}
