//! A simulated ball's run once more from what its sensors said: by the controller in Rust here, and by the exported C.
//!
//! ```text
//! cd studies && cargo run --release --bin ball_replay -- [SECONDS [float|double [FOLDER]]]
//! ```
//!
//! Into the folder it writes the exported files, and `ball_readings.h` with what the sensors said. `controller/firmware/ball_replay.c` takes them, and
//! prints the same line: how often legs fired, and a hash of every bit of what was known and decided. In double precision each
//! cycle here is held against the run itself.

use std::fmt::Write as _;
use std::path::Path;

use saltus::controller::Real;
use saltus::controller::ball::{
    Balancer, Estimate, Firing, Inertial, Lying, Plane, Rotation, Sight,
};
use saltus::export::{CFiles, Number};
use saltus::gait::space::{Ball, Facing, Flashed, Gait, Hearing, Knows, Roll, Stable, roll};
use saltus::robot::space::{discs, rests};
use saltus::sim_check::Stepping;

type Failed = Box<dyn std::error::Error>;

/// Seed of the sensors' noise.
const SEED: u64 = 1;

/// A run: each cycle, and what the sensors said.
struct Run {
    balls: Vec<Ball>,
    readings: Vec<Inertial>,
    /// Its plane, by its number among those that are flashed.
    plane: usize,
    flashed: Flashed<f64>,
}

impl Run {
    fn new(seconds: f64) -> Result<Run, Failed> {
        let robot = saltus::robot::resolve("rats-twelve", &[])?;
        let stable = Stable::default();
        let flashed = Flashed::new(&robot, &stable)?;
        let space = robot.space.as_ref().ok_or("no robot in space")?;
        let directions = space.directions.vectors();
        let (rests, discs) = (rests(&directions), discs(&directions));
        let axis = Facing::all(&rests[0], &discs)[0].plane().axis;
        let is_its = |plane: &saltus::gait::space::FlashedPlane<f64>| plane.axes[0] == axis;
        let plane = flashed.planes.iter().position(is_its);
        let mut setup = Roll::new(robot, seconds);
        setup.gait = Gait::Stable(stable);
        setup.knows = Knows::Sensors(SEED);
        setup.stepping = Stepping::Fixed(1e-3);
        let (mut balls, mut readings) = (Vec::new(), Vec::new());
        let mut hearing: Option<Hearing> = None;
        roll(&setup, |ball| {
            let ears =
                hearing.get_or_insert_with(|| Hearing::new(&setup.robot, ball.attitude, SEED));
            readings.push(ears.read(ball.attitude, ball.velocity, ball.touching));
            balls.push(ball.clone());
            true
        })?;
        Ok(Run {
            balls,
            readings,
            plane: plane.ok_or("no plane to roll in")?,
            flashed,
        })
    }

    /// The run by the controller alone, in numbers `R`, cycle by cycle; how often legs fired.
    fn replay<R: Number>(&self, mut cycle: impl FnMut(usize, &Seen<R>)) -> usize {
        let flashed = self.flashed.rounded::<R>();
        let first = &self.balls[0];
        let place = first.place.map(R::of);
        let mut estimator = flashed.estimator((Rotation(first.attitude.map(R::of)), place));
        let plane = &flashed.planes[self.plane];
        let [axis, first, ahead] = plane.axes;
        let plane = Plane {
            axis,
            first,
            ahead,
            stations: &plane.stations,
        };
        let mut balancer = Balancer::new(flashed.balance, plane);
        let mut start = None;
        let mut fired = 0;
        for (k, readings) in self.readings.iter().enumerate() {
            estimator.take(readings);
            let estimate = *estimator.estimate();
            let line = *start.get_or_insert(estimate.place[1]);
            let (lying, firings) = balancer.step(&Sight {
                attitude: estimate.attitude,
                spin: estimate.spin,
                aside: estimate.place[1] - line,
                aside_rate: estimate.velocity[1],
                course: R::ZERO,
                touching: readings.touching,
            });
            for firing in firings.iter().flatten() {
                estimator.fired(firing.leg);
            }
            fired += usize::from(firings.iter().any(Option::is_some));
            cycle(
                k,
                &Seen {
                    estimate,
                    lying,
                    firings,
                },
            );
        }
        fired
    }

    /// `ball_readings.h`.
    fn header<R: Number>(&self) -> String {
        let first = &self.balls[0];
        let list = |all: &[f64]| {
            let numbers: Vec<String> = all.iter().map(|x| R::of(*x).c()).collect();
            numbers.join(", ")
        };
        let (attitude, place) = (list(&first.attitude), list(&first.place));
        let (count, plane) = (self.readings.len(), self.plane);
        let mut text = format!(
            "/* What the sensors of a simulated ball said: fine and coarse gyros, fine and coarse accelerometers, feet. */\n\
             #define BALL_CYCLES {count}\n#define BALL_PLANE {plane}\n\
             static const saltus_rotation ball_attitude = {{{attitude}}};\n\
             static const saltus_real ball_place[3] = {{{place}}};\n\
             static const int16_t ball_readings[BALL_CYCLES][13] = {{\n"
        );
        for r in &self.readings {
            text.push_str("    {");
            let counts = [
                r.fine_gyro,
                r.coarse_gyro,
                r.fine_accelerometer,
                r.coarse_accelerometer,
            ];
            for count in counts.iter().flatten() {
                // Writing to a string does not fail.
                let _ = write!(text, "{count}, ");
            }
            let _ = writeln!(text, "{}}},", r.touching);
        }
        text + "};\n"
    }
}

/// What a cycle knew and decided.
struct Seen<R> {
    estimate: Estimate<R>,
    lying: Lying<R>,
    firings: [Option<Firing<R>>; 2],
}

impl<R: Real> Seen<R> {
    fn numbers(&self) -> [R; 19] {
        let (e, l) = (&self.estimate, &self.lying);
        let [w, x, y, z] = e.attitude.0;
        let lies = [
            l.lean,
            l.rate,
            l.roll,
            l.roll_rate,
            l.heading,
            l.heading_rate,
        ];
        let rest = [e.spin, e.velocity, e.place].concat();
        let all = [&[w, x, y, z][..], &lies[..], &rest[..]].concat();
        std::array::from_fn(|k| all[k])
    }
}

/// FNV-1a.
struct Hash(u32);

impl Hash {
    fn bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u32::from(*byte)).wrapping_mul(16_777_619);
        }
    }

    fn cycle<R: Number>(&mut self, seen: &Seen<R>) {
        for x in seen.numbers() {
            self.bytes(x.bytes().as_ref());
        }
        for firing in seen.firings {
            let leg = firing.map_or(u32::MAX, |firing| firing.leg);
            self.bytes(&leg.to_le_bytes());
            let open = firing.map_or(R::ZERO, |firing| firing.open);
            self.bytes(open.bytes().as_ref());
        }
    }
}

/// How far a valve opening time (s) may be from that of the run, whose stations' angles are not rounded to 1e-12 rad.
const SAME: f64 = 1e-10;

/// Holds cycle `k` against the run.
fn check(run: &Run, k: usize, seen: &Seen<f64>) -> Result<(), String> {
    let ball = &run.balls[k];
    if ball.estimate != Some(seen.estimate) {
        return Err(format!(
            "cycle {k}: {:?}, not {:?}",
            seen.estimate, ball.estimate
        ));
    }
    let fired: Vec<Firing<f64>> = seen.firings.iter().flatten().copied().collect();
    let same =
        |(a, b): (&Firing<f64>, &Firing<f64>)| a.leg == b.leg && (a.open - b.open).abs() < SAME;
    if fired.len() != ball.fired.len() || !fired.iter().zip(&ball.fired).all(same) {
        return Err(format!("cycle {k}: fires {fired:?}, not {:?}", ball.fired));
    }
    Ok(())
}

fn written<R: Number>(run: &Run, folder: Option<&str>) -> Result<(), Failed> {
    let mut hash = Hash(2_166_136_261);
    let fired = run.replay::<R>(|_, seen| hash.cycle(seen));
    let (cycles, hash) = (run.readings.len(), hash.0);
    println!("replay: {cycles} calls, {fired} answered, hash {hash:08x}");
    if let Some(folder) = folder.map(Path::new) {
        std::fs::create_dir_all(folder)?;
        let robot = saltus::robot::resolve("rats-twelve", &[])?;
        for (name, text) in CFiles::stable::<R>(&robot, &Stable::default())?.files {
            std::fs::write(folder.join(name), text)?;
        }
        std::fs::write(folder.join("ball_readings.h"), run.header::<R>())?;
    }
    Ok(())
}

fn main() -> Result<(), Failed> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let seconds = words.first().map_or(Ok(2.0), |text| text.parse())?;
    let run = Run::new(seconds)?;
    let mut wrong = None;
    run.replay::<f64>(|k, seen| {
        if wrong.is_none() {
            wrong = check(&run, k, seen).err();
        }
    });
    if let Some(wrong) = wrong {
        return Err(wrong.into());
    }
    let folder = words.get(2).map(String::as_str);
    match words.get(1).map_or("float", String::as_str) {
        "float" => written::<f32>(&run, folder),
        "double" => written::<f64>(&run, folder),
        other => Err(format!("{other}: must be float or double").into()),
    }
}
