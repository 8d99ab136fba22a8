//! Figures 6.2 to 6.7 of the thesis from Saltus' robots that learn, on the thesis' axes, as drawings in docs/learning/.
//!
//! ```text
//! cd studies && cargo run --release --bin learning_figures -- ../docs/learning 30
//! ```
//!
//! The folder, and the seeds of figure 6.4; without them a short version is made in a temporary folder. With 30 seeds it takes
//! about 15 minutes of one core.

use std::path::Path;

use saltus::chart::{COLORS, Chart, Ink};
use saltus::gait::learn::{Algorithm, Bin, Score};
use saltus::gait::{Footfall, Lines, Program, Row, Run, Setup, Smooth, run};
use saltus::learning::{Learnt, Pupil, Settings, Task, interquartile, learn};
use saltus::numeric::parallel::available;

type Failed = Box<dyn std::error::Error>;

/// Size of a drawing (px).
const SIZE: (f64, f64) = (520.0, 300.0);
/// Chamber pressure (Pa) above which a leg pushes.
const PUSHES: f64 = 1.5e5;
/// The seed of what is shown of one robot.
const SEED: u64 = 2;

/// A millisecond of a run.
struct Moment {
    time: f64,
    angle: f64,
    rate: f64,
    travel: f64,
    /// Of each leg: whether it pushes, and whether its foot is on the ground.
    legs: Vec<[bool; 2]>,
}

#[derive(Default)]
struct Kept(Vec<Moment>);

impl Run for Kept {
    fn row(&mut self, row: &Row<'_>) {
        let touches = |leg| row.contacts.iter().any(|contact| contact.point == leg);
        let legs = row.pressures.iter().enumerate();
        self.0.push(Moment {
            time: row.time,
            angle: row.lean,
            rate: row.rate,
            travel: row.axle[0],
            legs: legs.map(|(leg, p)| [*p > PUSHES, touches(leg)]).collect(),
        });
    }
    fn footfall(&mut self, _: &Footfall) {}
    fn asks_contacts(&mut self, _: f64) -> bool {
        true
    }
}

fn flown(settings: &Settings, program: Program, seconds: f64) -> Result<Vec<Moment>, Failed> {
    let mut setup = Setup::new(settings.plant.robot.clone(), program, seconds);
    setup.zone = -0.3;
    let mut kept = Kept::default();
    run(&setup, &mut kept)?;
    let start = kept.0.first().map_or(0.0, |moment| moment.angle);
    kept.0.iter_mut().for_each(|moment| moment.angle -= start);
    Ok(kept.0)
}

/// The reading of table 6.2 that learns: its columns interchanged.
fn settings(algorithm: Algorithm, episodes: usize) -> Result<Settings, Failed> {
    let robot = saltus::resolve("rats-run", &[])?;
    let mut settings = Task::RunLegs.settings(robot, algorithm);
    (settings.rates.alpha, settings.rates.gamma) = (settings.rates.gamma, settings.rates.alpha);
    settings.schedule.episodes = episodes;
    Ok(settings)
}

fn taught(settings: &Settings, seed: u64, seeds: usize) -> Result<Learnt, Failed> {
    Ok(learn(settings, (seed, seeds), None, available(), &|| true)?)
}

/// The run of what one seed has learnt.
fn after(settings: &Settings, seconds: f64) -> Result<Vec<Moment>, Failed> {
    let learnt = taught(settings, SEED, 1)?;
    flown(settings, program(settings, &learnt.pupils[0])?, seconds)
}

/// What runs by the table of one seed.
fn program(settings: &Settings, pupil: &Pupil) -> Result<Program, Failed> {
    Ok(Program::Learnt(settings.policy(&pupil.table)?))
}

fn over_time(moments: &[Moment], of: impl Fn(&Moment) -> f64) -> Vec<(f64, f64)> {
    moments.iter().map(|it| (it.time, of(it))).collect()
}

fn write(folder: &Path, name: &str, chart: &Chart) -> Result<(), Failed> {
    let path = folder.join(format!("{name}.svg"));
    std::fs::write(&path, chart.file())?;
    println!("{}", path.display());
    Ok(())
}

/// Figures 6.2 and 6.3: SARSA after 1, 20 and all episodes.
fn snapshots(folder: &Path, most: usize) -> Result<(), Failed> {
    let axis = |name, range| (name, range);
    let time = axis("time (s)", (0.0, 1.0));
    let mut angle = Chart::new(SIZE, time, axis("wheel angle (rad)", (-2.0, 8.0)));
    let mut rate = Chart::new(SIZE, time, axis("wheel rate (rad/s)", (-5.0, 15.0)));
    let mut raster = Chart::new(
        (SIZE.0, 360.0),
        time,
        axis("leg, after 1, 20 and all episodes", (0.0, 18.0)),
    );
    for (k, episodes) in [1, 20.min(most), most].into_iter().enumerate() {
        let run = after(&settings(Algorithm::Sarsa, episodes)?, 1.0)?;
        let ink = Ink::Solid(COLORS[k]);
        angle.line(ink, &over_time(&run, |it| it.angle));
        rate.line(ink, &over_time(&run, |it| it.rate));
        for chart in [&mut angle, &mut rate] {
            chart.key(ink, &format!("after {episodes}"));
        }
        for leg in 0..run[0].legs.len() {
            let height = 6.0 * k as f64 + leg as f64 + 0.8;
            let dots = |on_ground: bool| {
                let pushes = run.iter().filter(|it| it.legs[leg] == [true, on_ground]);
                pushes.map(|it| (it.time, height)).collect::<Vec<_>>()
            };
            raster.dots(Ink::Faint(COLORS[k]), &dots(false));
            raster.dots(ink, &dots(true));
        }
    }
    raster.title("legs that push: full colour with the foot on the ground");
    write(folder, "figure-6.2-angle", &angle)?;
    write(folder, "figure-6.2-rate", &rate)?;
    write(folder, "figure-6.3", &raster)
}

/// Figures 6.4 and 6.5: mean rate over the episodes with its band, and the final policies.
fn curves(folder: &Path, most: usize, seeds: usize) -> Result<(), Failed> {
    let mut last = Chart::new(
        SIZE,
        ("time (s)", (0.0, 1.0)),
        ("wheel angle (rad)", (0.0, 8.0)),
    );
    for (name, pair, episodes, range) in [
        (
            "figure-6.4-one-step",
            [Algorithm::Sarsa, Algorithm::Q],
            most,
            (-10.0, 15.0),
        ),
        (
            "figure-6.4-traces",
            [Algorithm::SarsaLambda, Algorithm::QLambda],
            most.min(100),
            (-2.0, 12.0),
        ),
    ] {
        let x = ("episode", (0.0, episodes as f64));
        let mut chart = Chart::new(SIZE, x, ("mean rate (rad/s)", range));
        for (k, algorithm) in pair.into_iter().enumerate() {
            let settings = settings(algorithm, episodes)?;
            let learnt = taught(&settings, 1, seeds)?;
            let rate = |score: &Score| score.outcome.angle / score.outcome.time;
            let at = |episode: usize| {
                let rates = learnt.pupils.iter().map(|it| rate(&it.curve[episode]));
                interquartile(&rates.collect::<Vec<_>>())
            };
            // A mean over so many episodes is a point.
            let every = (episodes / 100).max(1);
            let points: Vec<_> = (0..episodes)
                .step_by(every)
                .filter_map(|episode| at(episode).map(|it| (episode as f64 + 1.0, it)))
                .collect();
            let color = COLORS[2 * usize::from(range.0 > -5.0) + k];
            let line = |of: fn(&saltus::learning::Interval) -> f64| {
                points
                    .iter()
                    .map(|(x, it)| (*x, of(it)))
                    .collect::<Vec<_>>()
            };
            chart.line(Ink::Faint(color), &line(|it| it.interval[0]));
            chart.line(Ink::Faint(color), &line(|it| it.interval[1]));
            chart.line(Ink::Solid(color), &line(|it| it.value));
            chart.key(Ink::Solid(color), algorithm.name());
            let best = learnt.best(&settings).ok_or("no seed")?;
            let run = flown(&settings, program(&settings, best)?, 1.0)?;
            last.line(Ink::Solid(color), &over_time(&run, |it| it.angle));
            last.key(
                Ink::Solid(color),
                &format!("{}, best of {seeds}", algorithm.name()),
            );
        }
        write(folder, name, &chart)?;
    }
    write(folder, "figure-6.5", &last)
}

/// Figure 6.6: `run-zone` after 1, 4 and 11 episodes; and the states in which it fires.
fn zone(folder: &Path, seeds: usize) -> Result<Program, Failed> {
    let robot = saltus::resolve("rats-run", &[])?;
    let mut settings = Task::RunZone.settings(robot, Algorithm::SarsaLambda);
    settings.schedule.episodes = 11;
    let learnt = taught(&settings, 1, seeds)?;
    let best = learnt.best(&settings).ok_or("no seed")?;
    let mut chart = Chart::new(
        SIZE,
        ("time (s)", (0.0, 2.0)),
        ("wheel angle (rad)", (0.0, 7.0)),
    );
    for (k, episodes) in [1, 4, 11].into_iter().enumerate() {
        settings.schedule.episodes = episodes;
        let then = taught(&settings, best.seed, 1)?;
        let run = flown(&settings, program(&settings, &then.pupils[0])?, 2.0)?;
        let ink = Ink::Solid(COLORS[k]);
        chart.line(ink, &over_time(&run, |it| it.angle));
        chart.key(ink, &format!("after {episodes}"));
    }
    write(folder, "figure-6.6", &chart)?;
    let policy = program(&settings, best)?;
    if let Program::Learnt(learnt) = &policy {
        let [angle, rate] = [&learnt.axes[0], &learnt.axes[1]];
        let x = ("wheel angle (rad)", (angle.from, angle.to));
        let mut map = Chart::new(SIZE, x, ("wheel rate (rad/s)", (rate.from, rate.to)));
        let middle = |axis: &saltus::controller::run::Steps<f64>, k: usize| {
            axis.from + (axis.to - axis.from) * (k as f64 + 0.5) / f64::from(axis.count)
        };
        let width = usize::from(rate.count);
        let fires = learnt
            .choices
            .iter()
            .enumerate()
            .filter(|(_, choice)| **choice == 1);
        let places =
            fires.map(|(state, _)| (middle(angle, state / width), middle(rate, state % width)));
        map.dots(Ink::Solid(COLORS[0]), &places.collect::<Vec<_>>());
        map.title("states in which the leg in the active zone fires");
        write(folder, "policy-run-zone", &map)?;
    }
    value_map(folder, &settings, best.table.values())?;
    Ok(policy)
}

/// The greatest value in each state that was visited, in five shades of equally many states.
fn value_map(folder: &Path, settings: &Settings, values: &[f64]) -> Result<(), Failed> {
    const SHADES: [&str; 5] = ["#c6dbef", "#9ecae1", "#6baed6", "#3182bd", "#08519c"];
    let [angle, rate] = settings.bins.axes() else {
        return Err("two axes".into());
    };
    let visited: Vec<(usize, f64)> = values
        .chunks(2)
        .map(|pair| pair[0].max(pair[1]))
        .enumerate()
        .filter(|(state, _)| values[2 * state] != 0.0 || values[2 * state + 1] != 0.0)
        .collect();
    let mut sorted: Vec<f64> = visited.iter().map(|(_, value)| *value).collect();
    sorted.sort_by(f64::total_cmp);
    let x = ("wheel angle (rad)", (angle.from, angle.to));
    let mut map = Chart::new(SIZE, x, ("wheel rate (rad/s)", (rate.from, rate.to)));
    let edge =
        |axis: &Bin, k: usize| axis.from + (axis.to - axis.from) * k as f64 / axis.count as f64;
    for (state, value) in &visited {
        let below = sorted.partition_point(|other| other < value);
        let shade = SHADES[(SHADES.len() * below / sorted.len()).min(SHADES.len() - 1)];
        let (i, j) = (state / rate.count, state % rate.count);
        let low = (edge(angle, i), edge(rate, j));
        let high = (edge(angle, i + 1), edge(rate, j + 1));
        map.block(Ink::Solid(shade), low, high);
    }
    for (k, shade) in SHADES.iter().enumerate() {
        let at = |part: usize| sorted[(part * (sorted.len() - 1)) / SHADES.len()];
        let says = format!("{:.1} to {:.1}", at(k), at(k + 1));
        map.key(Ink::Solid(shade), &says);
    }
    map.title("greatest value in each state that was visited");
    write(folder, "values-run-zone", &map)
}

/// Figure 6.7: travel and speed of what was learnt beside the closed loop.
fn beside(folder: &Path, zone: Program, (seeds, most): (usize, usize)) -> Result<(), Failed> {
    let robot = saltus::resolve("rats-run", &[])?;
    let mut stride = Task::RunStride.settings(robot, Algorithm::Q);
    stride.schedule.episodes = most.min(500);
    let strides = taught(&stride, 1, seeds)?;
    let strides = program(&stride, strides.best(&stride).ok_or("no seed")?)?;
    let two = Program::ClosedLoop(Lines::Two {
        first: 0.35,
        slope: -0.01,
        switch: 5.0,
        last: -0.1,
        at: 13.3,
        jumps: false,
    });
    let time = ("time (s)", (0.0, 2.0));
    let mut travel = Chart::new(SIZE, time, ("travel (m)", (0.0, 3.0)));
    let mut speed = Chart::new(SIZE, time, ("speed (m/s)", (0.0, 3.0)));
    for (k, (name, program)) in [
        ("run-zone, best seed", zone),
        ("firing angles learnt", strides),
        ("two lines", two),
        ("smooth law", Smooth::QUICK.program()),
    ]
    .into_iter()
    .enumerate()
    {
        let run = flown(&stride, program, 2.0)?;
        let ink = Ink::Solid(COLORS[k]);
        let travels = over_time(&run, |it| it.travel);
        // A mean over 0.15 s, as in the thesis.
        let speeds = travels.windows(150).map(|it| {
            let ((from, x), (to, y)) = (it[0], it[149]);
            (to, ((y - x) / (to - from)).clamp(0.0, 3.0))
        });
        speed.line(ink, &speeds.collect::<Vec<_>>());
        travel.line(
            ink,
            &travels
                .into_iter()
                .map(|(t, x)| (t, x.clamp(0.0, 3.0)))
                .collect::<Vec<_>>(),
        );
        for chart in [&mut travel, &mut speed] {
            chart.key(ink, name);
        }
    }
    let thesis = Ink::Solid(COLORS[6]);
    speed.dots(thesis, &[(1.6, 1.4), (1.6, 2.9)]);
    speed.key(thesis, "thesis: learnt 1.4, closed loop 2.9 m/s");
    write(folder, "figure-6.7-travel", &travel)?;
    write(folder, "figure-6.7-speed", &speed)
}

fn main() -> Result<(), Failed> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (folder, seeds, most) = match &arguments[..] {
        [folder, seeds] => (folder.into(), seeds.parse()?, 1000),
        _ => (std::env::temp_dir().join("saltus-learning-figures"), 2, 30),
    };
    std::fs::create_dir_all(&folder)?;
    snapshots(&folder, most)?;
    curves(&folder, most, seeds)?;
    let zone = zone(&folder, seeds)?;
    beside(&folder, zone, (seeds, most))
}
