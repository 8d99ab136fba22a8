//! One jump: gas from the tank into the muscles, and what they do with the links.

use saltus_numeric::statistics::median;
use saltus_pneumatics::{Line, Muscle, Opening, OrificeLaw, Passage, Stock, Supply, Wall};

use super::rig::{Changed, Rig};
use crate::experiment::Run;
use crate::machine::{Machine, State};
use crate::spec::Problem;

/// Step (s).
const STEP: f64 = 2e-3;
/// The first rows (s), in which links hardly move yet.
pub(super) const REST: f64 = 0.018;
/// Pressure (Pa) of the atmosphere.
const AMBIENT: f64 = 101_325.0;
/// Time (s) in which a muscle's shape follows its pressure.
const SHAPE: f64 = 1e-3;
/// A step is taken again, so often at most, where pressures that muscles follow go elsewhere than
/// was foreseen by more than this (Pa): where valves turn.
const RETAKES: usize = 4;
const SURPRISE: f64 = 1e3;
/// Losses of a tube's ends, in dynamic pressures.
const ENDS: f64 = 1.5;
/// Time constants of a spool after which it has moved, to one part in 10¹⁵.
const SWITCHED: f64 = 35.0;
/// Opening of a valve below which it is shut.
const SHUT: f64 = 1e-6;

/// What is known of a run.
#[derive(Clone, Debug)]
pub(super) struct Told {
    /// When (s) it begins.
    first: f64,
    /// Coordinates at the start.
    q: Vec<f64>,
    /// When (s) each valve is switched, and to what.
    switches: Vec<Vec<(f64, bool)>>,
    /// Gauge pressure (Pa) of the tank at the start.
    pub(super) tank: f64,
    /// What the muscles' gauges say (Pa) without pressure.
    pub(super) zero: f64,
    /// What the track of the centre of mass says beside the posture at the start (m).
    pub(super) off: [f64; 2],
    tube: Passage,
}

impl Told {
    /// What the first rows and the commands of a run say.
    pub(super) fn of(run: &Run, rig: &Rig, columns: &[String]) -> Result<Told, Problem> {
        let first = run.time.first().copied().unwrap_or(0.0);
        let index = |name: &str| columns.iter().position(|column| column == name);
        let readings = |name: &str| -> Vec<(f64, f64)> {
            let Some(column) = index(name) else {
                return Vec::new();
            };
            let rows = run
                .time
                .iter()
                .copied()
                .zip(run.values[column].iter().copied());
            rows.filter(|(_, x)| x.is_finite()).collect()
        };
        let mean = |name: &str| {
            let all = readings(name);
            let early: Vec<f64> = all
                .iter()
                .filter(|r| r.0 < first + REST)
                .map(|r| r.1)
                .collect();
            (!early.is_empty()).then(|| early.iter().sum::<f64>() / early.len() as f64)
        };
        let switches: Vec<Vec<(f64, bool)>> = rig
            .actuators
            .iter()
            .map(|name| switched(run, index(&format!("valve_{name}"))))
            .collect();
        let opens = switches.iter().flatten().map(|switch| switch.0);
        let opens = opens.fold(f64::INFINITY, f64::min).max(first);
        // Before a valve opens; where there is no such row, the first one.
        let before = |name: &str| -> Vec<f64> {
            let all = readings(name);
            let count = all.partition_point(|r| r.0 <= opens).max(1);
            all.iter().take(count).map(|r| r.1).collect()
        };
        let missing = |name: &str| Problem::NoMachine {
            what: format!(
                "{}: {name} is empty in the first {REST} s, which tell how the machine stands",
                run.name
            ),
        };
        let mut q = vec![0.0; 3 + rig.joints.len()];
        q[1] = mean("torso_y_m").unwrap_or(0.0);
        q[2] = mean("torso_angle_rad").unwrap_or(0.0);
        let mut zeros = Vec::new();
        for (name, joint) in rig.actuators.iter().zip(&rig.joints) {
            let angle = format!("{name}_angle_rad");
            q[joint.coordinate] = mean(&angle).ok_or_else(|| missing(&angle))?;
            zeros.extend(before(&format!("{name}_pressure_gauge_pa")));
        }
        let mut tank = before("tank_pressure_gauge_pa");
        if tank.is_empty() {
            return Err(Problem::NoMachine {
                what: format!("{}: tank_pressure_gauge_pa is empty in all rows", run.name),
            });
        }
        let tank = median(&mut tank);
        let zero = if zeros.is_empty() {
            0.0
        } else {
            median(&mut zeros)
        };
        let pressures = [tank + AMBIENT, AMBIENT];
        let gas = (rig.gas, rig.temperature);
        let mut told = Told {
            first,
            q,
            switches,
            tank,
            zero,
            off: [0.0; 2],
            tube: Passage::long_tube(rig.tube, ENDS, gas, pressures),
        };
        if let Some(machine) = rig.machine(&rig.believed()) {
            let still = vec![0.0; told.q.len()];
            let center = machine.center(&State::new(&machine, &told.q, &still));
            for (k, name) in ["com_x_m", "com_y_m"].into_iter().enumerate() {
                told.off[k] = mean(name).map_or(0.0, |seen| seen - center[k]);
            }
        }
        Ok(told)
    }
}

/// When (s) the valve in a column is switched, and to what; it is shut before the first row.
fn switched(run: &Run, column: Option<usize>) -> Vec<(f64, bool)> {
    let (mut all, mut is_open) = (Vec::new(), false);
    for (t, x) in run
        .time
        .iter()
        .zip(column.map_or(&[][..], |c| &run.values[c]))
    {
        if x.is_finite() && (*x > 0.5) != is_open {
            is_open = !is_open;
            all.push((*t, is_open));
        }
    }
    all
}

/// What a run does.
#[derive(Debug)]
pub(super) struct Course {
    first: f64,
    /// Of each step: the tank's gauge, the centre of mass, the muscles' gauges.
    rows: Vec<f64>,
    width: usize,
    step: f64,
}

impl Course {
    fn add(&mut self, stock: &Stock, center: [f64; 2], gauges: &[f64]) {
        self.rows.push(stock.manifold - AMBIENT);
        self.rows.extend(center);
        self.rows.extend(gauges);
    }

    /// Takes what is known at the start back to half a step before it, on the line through the
    /// middle of the first step.
    fn begin(&mut self) {
        for column in 0..3 {
            if let Some(middle) = self.rows.get(self.width + column) {
                self.rows[column] = 2.0 * self.rows[column] - middle;
            }
        }
    }

    fn at(&self, column: usize, time: f64) -> f64 {
        let steps = ((time - self.first) / self.step).max(0.0);
        let last = self.rows.len() / self.width - 1;
        // The number of a row.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let row = (steps as usize).min(last.saturating_sub(1));
        let share = (steps - row as f64).min(1.0);
        let of = |row: usize| self.rows[row.min(last) * self.width + column];
        of(row) + share * (of(row + 1) - of(row))
    }

    /// The manifold and the centre are known in the middle of each step.
    pub(super) fn tank(&self, time: f64) -> f64 {
        self.at(0, time + 0.5 * self.step)
    }

    pub(super) fn center(&self, k: usize, time: f64) -> f64 {
        self.at(1 + k, time + 0.5 * self.step)
    }

    pub(super) fn muscle(&self, k: usize, time: f64) -> f64 {
        self.at(3 + k, time)
    }
}

/// The muscles with their tendons and pulleys.
struct Muscles<'a> {
    rig: &'a Rig,
    muscle: Muscle,
    changed: &'a Changed,
    /// Angles at the start.
    start: &'a [f64],
    /// The gauge pressure (Pa) that each one's shape has followed, and how fast that changes (Pa/s).
    felt: Vec<[f64; 2]>,
}

impl Muscles<'_> {
    /// Muscle `k` where its joint is at `angle` (rad), `ahead` (s) of now.
    fn at(&self, k: usize, angle: f64, ahead: f64) -> Strained {
        let joint = &self.rig.joints[k];
        let [felt, rate] = self.felt[k];
        let shape = self.muscle.at(felt + ahead * rate);
        let travel = joint.side() * joint.pulley * (angle - self.start[joint.coordinate]);
        let compliance = self.changed.tendons[usize::from(!joint.is_knee)];
        let pull = shape.pull_through(compliance, travel);
        Strained {
            pull,
            volume: self.changed.tube + shape.volume(travel + compliance * pull),
        }
    }

    /// The shape of muscle `k` follows its gauge pressures (Pa) at both ends of a step of `h` (s);
    /// by how much (Pa) it goes elsewhere than was foreseen.
    fn follow(&mut self, k: usize, gauges: [f64; 2], h: f64) -> f64 {
        let [felt, rate] = &mut self.felt[k];
        let mean = 0.5 * (gauges[0] + gauges[1]);
        let foreseen = *rate;
        *rate = (mean - *felt) / (SHAPE + 0.5 * h);
        h * (*rate - foreseen).abs()
    }

    /// All shapes go on by `h` (s).
    fn go_on(&mut self, h: f64) {
        for [felt, rate] in &mut self.felt {
            *felt += h * *rate;
        }
    }
}

/// A muscle with its line.
struct Strained {
    /// N.
    pull: f64,
    /// m³.
    volume: f64,
}

/// The supply of a run.
fn supply(rig: &Rig, told: &Told, changed: &Changed) -> Supply {
    let wall = |resistance: f64| Wall {
        temperature: rig.temperature,
        resistance,
    };
    let tube = told.tube.times(changed.flow);
    let line = Line {
        fill: tube.times(changed.valve),
        vent: told.tube.times(changed.vent),
        leak: (changed.leak > 0.0)
            .then(|| Passage::Orifice(OrificeLaw::new(rig.gas), changed.leak)),
        wall: wall(changed.walls[1]),
    };
    let outlet = match told.tube {
        Passage::Tube(a, b) if changed.outlet > 0.0 => {
            Some(Passage::Tube(changed.outlet * a, changed.outlet * b))
        }
        Passage::LongTube(law) if changed.outlet > 0.0 => {
            Some(Passage::LongTube(law.map(|x| changed.outlet * x)))
        }
        _ => None,
    };
    Supply {
        gas: rig.gas,
        ambient: [AMBIENT, rig.temperature],
        tank: changed.tank * rig.tank,
        wall: wall(changed.walls[0]),
        outlet,
        lines: vec![line; rig.joints.len()],
    }
}

/// A switch 1/(1 + exp(−t/spool)), on average over a step of `h` (s) about `time` (s): a spool may
/// be faster than a step.
fn smooth(time: f64, h: f64, spool: f64) -> f64 {
    // Its integral, ln(1 + exp x), without overflow.
    let integral = |t: f64| spool * ((t / spool).max(0.0) + (-(t / spool).abs()).exp().ln_1p());
    if time.abs() > 0.5 * h + SWITCHED * spool {
        return if time > 0.0 { 1.0 } else { 0.0 };
    }
    (integral(time + 0.5 * h) - integral(time - 0.5 * h)) / h
}

/// How far the valve with these switches is open in a step of `h` (s) about `time` (s).
fn opening(
    rig: &Rig,
    changed: &Changed,
    switches: &[(f64, bool)],
    (time, h): (f64, f64),
) -> Opening {
    let [opens, closes, vents] = changed.lags;
    let smooth = |time: f64| smooth(time, h, rig.spool);
    let fill: f64 = switches
        .iter()
        .map(|(at, is_open)| {
            if *is_open {
                smooth(time - at - opens)
            } else {
                -smooth(time - at - closes)
            }
        })
        .sum();
    let vent = rig.exhaust.map_or(0.0, |at| smooth(time - at - vents));
    let cut = |x: f64| if x < SHUT { 0.0 } else { x.min(1.0) };
    Opening {
        // What is vented is not filled.
        fill: cut(fill * (1.0 - vent)),
        vent: cut(vent),
    }
}

/// A run from rest, with the tank at a gauge pressure (Pa), up to `last` (s).
pub(super) fn fly(
    rig: &Rig,
    told: &Told,
    changed: &Changed,
    tank: f64,
    last: f64,
) -> Option<Course> {
    fly_by(STEP, rig, told, changed, (tank, last))
}

/// The same in steps of `h` (s).
fn fly_by(
    h: f64,
    rig: &Rig,
    told: &Told,
    changed: &Changed,
    (tank, last): (f64, f64),
) -> Option<Course> {
    let mut machine: Machine = rig.machine(changed)?;
    machine.set_down(&told.q);
    let mut state = State::new(&machine, &told.q, &vec![0.0; told.q.len()]);
    let supply = supply(rig, told, changed);
    let muscle = Muscle {
        force: changed.force * rig.muscle.force,
        slope: changed.force * rig.muscle.slope,
        ..rig.muscle
    };
    let count = rig.joints.len();
    let mut muscles = Muscles {
        rig,
        muscle,
        changed,
        start: &told.q,
        felt: vec![[0.0; 2]; count],
    };
    let angle = |state: &State, k: usize, by: f64| state.ahead(rig.joints[k].coordinate, by);
    let mut now: Vec<f64> = (0..count)
        .map(|k| muscles.at(k, angle(&state, k, 0.0), 0.0).volume)
        .collect();
    let air = [AMBIENT, rig.temperature];
    let at_rest: Vec<(f64, [f64; 2])> = now.iter().map(|volume| (*volume, air)).collect();
    let mut stock = supply.stock([tank + AMBIENT, rig.temperature], &at_rest);
    let mut course = Course {
        first: told.first,
        rows: Vec::new(),
        width: 3 + count,
        step: h,
    };
    let mut gauges = vec![0.0; count];
    course.add(&stock, machine.center(&state), &gauges);
    let (mut time, mut torques) = (told.first, vec![0.0; told.q.len()]);
    let (mut middle, mut end) = (now.clone(), now.clone());
    let mut valves = vec![Opening::default(); count];
    let mut after = gauges.clone();
    while time < last {
        for (valve, switches) in valves.iter_mut().zip(&told.switches) {
            *valve = opening(rig, changed, switches, (time + 0.5 * h, h));
        }
        let before = stock.clone();
        for _ in 0..RETAKES {
            for k in 0..count {
                let strained = muscles.at(k, angle(&state, k, 0.5 * h), 0.5 * h);
                middle[k] = strained.volume;
                end[k] = muscles.at(k, angle(&state, k, h), h).volume;
                let joint = &rig.joints[k];
                torques[joint.coordinate] = joint.side() * joint.pulley * strained.pull;
            }
            stock.clone_from(&before);
            supply.advance(&mut stock, h, [&now, &middle, &end], &valves);
            let mut surprise: f64 = 0.0;
            for k in 0..count {
                after[k] = supply.state(stock.lines[k], end[k])[0] - AMBIENT;
                surprise = surprise.max(muscles.follow(k, [gauges[k], after[k]], h));
            }
            if surprise < SURPRISE {
                break;
            }
        }
        muscles.go_on(h);
        gauges.clone_from(&after);
        if !machine.step(&mut state, h, &torques) {
            return None;
        }
        std::mem::swap(&mut now, &mut end);
        time += h;
        course.add(&stock, machine.center_of_step(&state), &gauges);
    }
    course.begin();
    Some(course)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Sort;
    use crate::layout::{Draw, Layout};

    /// Gauges (Pa, m) of some jumps in steps of `h`, every 10 ms.
    fn gauges(h: f64, change: impl Fn(&mut Changed)) -> Vec<Vec<f64>> {
        let layout = Layout::new(Sort::TankLeg, false, Some(3), &mut Draw::new(5));
        let experiment = &layout.experiment;
        let mut all = Vec::new();
        for run in &experiment.runs {
            let rig = Rig::of(&run.settings).expect("a rig");
            let told = Told::of(run, &rig, &experiment.columns).expect("a start");
            let mut changed = rig.believed();
            change(&mut changed);
            let course = fly_by(h, &rig, &told, &changed, (told.tank, 0.5)).expect("a jump");
            for row in 0..50 {
                let t = 0.01 * f64::from(row);
                let center = [0, 1].map(|k| course.center(k, t));
                let muscles = (0..4).map(|k| course.muscle(k, t));
                all.push(
                    [course.tank(t)]
                        .into_iter()
                        .chain(center)
                        .chain(muscles)
                        .collect(),
                );
            }
        }
        all
    }

    /// Root mean square difference of pressures (Pa) and of places (m), each of the worst gauge.
    fn difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> [f64; 2] {
        let of = |k: usize| {
            let all: Vec<f64> = a.iter().zip(b).map(|(a, b)| a[k] - b[k]).collect();
            saltus_numeric::statistics::rms(&all)
        };
        let worst = |all: &[usize]| all.iter().map(|k| of(*k)).fold(0.0, f64::max);
        [worst(&[0, 3, 4, 5, 6]), worst(&[1, 2])]
    }

    /// What a step leaves out is far below what gauges can tell, and falls with its square.
    #[test]
    fn a_step_is_short_enough() {
        let all = |changed: &mut Changed| {
            changed.lags = [0.01, 0.02, 0.005];
            changed.walls = [2.0, 1.0];
            changed.outlet = 0.02;
            changed.friction = 0.5;
            changed.leak = 1e-7;
        };
        for change in [(|_: &mut Changed| {}) as fn(&mut Changed), all] {
            let fine = gauges(STEP / 16.0, change);
            let of = |part: f64| difference(&gauges(part * STEP, change), &fine);
            let [coarse, quarter] = [of(1.0), of(0.25)];
            assert!(coarse[0] < 500.0 && coarse[1] < 3e-4, "{coarse:?}");
            for (coarse, quarter) in coarse.iter().zip(quarter) {
                assert!(*coarse > 6.0 * quarter, "{coarse} {quarter}");
            }
        }
    }
}
