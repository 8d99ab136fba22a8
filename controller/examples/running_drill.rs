//! The drill of `firmware/running.c` in Rust: the same wheels, and a hash of what is decided.
//!
//!     cargo run --release -p saltus-controller --example running_drill -- [CYCLES [double]]

use saltus_controller::run::{
    Action, Ahead, Gait, Hold, Instruments, Knot, Law, Leap, Readings, Runner, Signals, Stall,
    Standing,
};
use saltus_controller::{Axis, Real};

/// Cycles of a run.
const RUN: u32 = 1000;

/// Inputs, the same on every machine.
struct Draw(u32);

impl Draw {
    fn word(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(2_891_336_453).wrapping_add(12345);
        self.0 >> 8
    }

    /// From −most to most.
    fn up_to(&mut self, most: i32) -> i32 {
        (self.word() % (2 * most + 1).unsigned_abs()).cast_signed() - most
    }

    fn one_in(&mut self, n: u32) -> bool {
        self.word().is_multiple_of(n)
    }

    /// From low to high, in steps of the difference over 2²⁴.
    fn between<R: Real>(&mut self, low: f64, high: f64) -> R {
        let (low, high) = (R::of(low), R::of(high));
        low + (high - low) * (R::of_count(self.word().cast_signed()) / R::of(16_777_216.0))
    }
}

/// A number of which every bit counts.
trait Bits: Real {
    fn words(self) -> Vec<u32>;
}

impl Bits for f32 {
    fn words(self) -> Vec<u32> {
        vec![self.to_bits()]
    }
}

impl Bits for f64 {
    #[allow(clippy::cast_possible_truncation)]
    fn words(self) -> Vec<u32> {
        vec![self.to_bits() as u32, (self.to_bits() >> 32) as u32]
    }
}

/// FNV-1a over words, least byte first; and how often a robot knew its feet.
struct Hash(u32, u32);

impl Hash {
    fn word(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u32::from(byte)).wrapping_mul(16_777_619);
        }
    }

    fn action<R: Bits>(&mut self, action: &Action<R>) {
        self.word(action.leg.unwrap_or(u32::MAX));
        self.word(action.in_zone);
        self.word(u32::from(action.stalled));
        for x in [
            action.valve_open,
            action.lean,
            action.rate,
            action.firing_angle,
        ] {
            x.words().into_iter().for_each(|word| self.word(word));
        }
    }
}

/// What a law refers to.
struct Drawn<R: 'static> {
    time: Law<'static, R>,
    knots: Vec<Knot<R>>,
    zone: R,
    first: Vec<[R; 2]>,
    hold: Option<Hold<R>>,
    leap: Option<Leap<R>>,
    cells: Vec<u8>,
    choices: Vec<[R; 2]>,
    room: R,
    sees: bool,
}

impl<R: Real + 'static> Drawn<R> {
    fn new(draw: &mut Draw) -> Drawn<R> {
        let time = Law::OverTime {
            amplitude: draw.between(-0.2, 0.2),
            slope: draw.between(1.0, 20.0),
            shift: draw.between(0.0, 4.0),
            level: draw.between(0.0, 0.1),
            valve_open: R::of(0.04),
        };
        let mut knots: Vec<Knot<R>> = Vec::new();
        // The second and the third knot are a jump.
        for k in 0..4 {
            let rate = match k {
                0 => R::ZERO,
                2 => knots[1].rate,
                _ => knots[k - 1].rate + draw.between(0.5, 6.0),
            };
            knots.push(Knot {
                rate,
                firing_angle: draw.between(-0.2, 0.2),
                valve_open: draw.between(0.02, 0.06),
            });
        }
        let zone = draw.between(-0.26, 0.26);
        let mut first: Vec<[R; 2]> = (0..2)
            .map(|_| [draw.between(-0.2, 0.2), draw.between(0.02, 0.06)])
            .collect();
        first.truncate((draw.word() % 3) as usize);
        let hold = draw.one_in(2).then_some(Hold {
            way: R::of(0.0086),
            renewed: R::of(0.004),
            ahead: R::of(0.8),
            by_error: R::of(0.1),
            by_sum: R::of(0.05),
            most_sum: R::of(1.0),
        });
        let leaps = draw.one_in(2);
        let leap = Leap {
            after: draw.word() % 4,
            slope: draw.between(-0.1, 0.1),
            level: draw.between(-0.1, 0.1),
            least: R::of(-0.1),
            most: R::of(0.1),
            valve_open: R::of(0.05),
            shock: draw.up_to(20000) + 15000,
        };
        // The last choice is of no leg; the one before it does not fire.
        let cells = (0..ROWS * LEVELS * COLUMNS)
            .map(|_| u8::try_from(draw.word() % 6).unwrap_or(0))
            .collect();
        let mut choices: Vec<[R; 2]> = (0..5)
            .map(|_| [draw.between(-0.2, 0.2), draw.between(0.02, 0.06)])
            .collect();
        choices[4][1] = R::ZERO;
        let room = if draw.one_in(2) {
            R::ZERO
        } else {
            draw.between(0.0, 2.0)
        };
        let sees = draw.one_in(2);
        Drawn {
            cells,
            choices,
            room,
            sees,
            time,
            knots,
            zone,
            first,
            hold,
            leap: leaps.then_some(leap),
        }
    }

    fn gait<'a>(&'a self, run: u32, taps: &'a [R]) -> Gait<'a, R> {
        let law = if run.is_multiple_of(4) {
            self.time
        } else {
            Law::Lines(&self.knots)
        };
        Gait {
            law,
            zone: self.zone,
            legs: 3 + run % 10,
            period: R::of(0.001),
            instruments: instruments(),
            taps,
            hold: self.hold,
            stall: Stall {
                rate: R::of(0.5),
                time: R::of(0.1),
                restarts: run.is_multiple_of(3),
            },
            first: &self.first,
            leap: self.leap,
            ahead: self.sees.then_some(self.ahead()),
        }
    }
}

/// Cells of the table for an obstacle.
const ROWS: usize = 5;
const LEVELS: usize = 3;
const COLUMNS: usize = 12;

impl<R: Real + 'static> Drawn<R> {
    fn ahead(&self) -> Ahead<'_, R> {
        Ahead {
            way: R::of(0.0086),
            climb: R::of(0.0083),
            least_weight: R::of(0.1),
            same: R::of(0.3),
            room: self.room,
            rates: Axis::new(R::of(-1.0), R::of(9.0), ROWS + 1),
            heights: Axis::new(R::of(0.0), R::of(0.12), LEVELS + 1),
            distances: Axis::new(R::of(-0.5), R::of(2.5), COLUMNS + 1),
            cells: &self.cells,
            choices: &self.choices,
            first_leap: 3,
        }
    }
}

fn instruments<R: Real>() -> Instruments<R> {
    Instruments {
        wheel: R::of(0.007853981633974483),
        wheel_turn: 800,
        radius: R::of(0.003926990816987241),
        pivot: R::of(0.003926990816987241),
        fine_gyro: R::of(0.00030521),
        fine_limit: 32111,
        coarse_gyro: R::of(0.00079897),
        fine_accelerometer: R::of(0.00059856),
        accelerometer_limit: 32767,
    }
}

/// A wheel: 64ths of counts, and of counts in a cycle.
#[derive(Default)]
struct Wheel {
    place: i32,
    rate: i32,
    wanted: i32,
}

impl Wheel {
    fn roll(&mut self, draw: &mut Draw, readings: &mut Readings) {
        if draw.one_in(400) {
            self.wanted = if draw.one_in(4) { 0 } else { draw.up_to(140) };
        }
        if draw.one_in(3) {
            self.rate += (self.wanted - self.rate).signum();
        }
        self.place += self.rate;
        // Now and then the wheel is knocked, or the counter errs by up to a turn.
        if draw.one_in(200) {
            self.place += draw.up_to(300);
        }
        if draw.one_in(2000) {
            self.place += draw.up_to(800 * 64);
        }
        readings.fine_gyro = (self.rate * 402 + draw.up_to(90)).clamp(-32767, 32767);
        readings.coarse_gyro = self.rate * 154 + draw.up_to(90);
        readings.wheel = (self.place + draw.up_to(40)) >> 6;
        readings.radius = (self.place + draw.up_to(40)) >> 8;
        readings.pivot = draw.up_to(12) + 10;
        let most = if draw.one_in(50) { 32767 } else { 500 };
        readings.coarse_accelerometer = [draw.up_to(most), draw.up_to(most)];
    }
}

/// Which leg a robot at rest stands on, by what its accelerometer says; a leg that it has where it
/// cannot tell.
fn stand<R: Real>(draw: &mut Draw, hash: &mut Hash, gait: &Gait<'_, R>) -> u32 {
    let signals = Signals::new(gait.instruments, gait.taps);
    let mut standing = Standing::new();
    let (mut forward, mut up) = (draw.up_to(16000), draw.up_to(16000));
    let noise = if draw.one_in(4) { 8000 } else { 300 };
    let count = if draw.one_in(9) { 99 } else { 200 };
    // A third of the length is of that of gravity for sure.
    if !draw.one_in(3) {
        up = 15500 - forward.abs() / 3;
        if draw.one_in(2) {
            up = -up;
        }
        forward /= 2;
    }
    for _ in 0..count {
        let fine_accelerometer = [forward + draw.up_to(noise), up + draw.up_to(noise)];
        let most = if draw.one_in(4000) { 3000 } else { 300 };
        let readings = Readings {
            fine_accelerometer,
            fine_gyro: draw.up_to(most),
            ..Readings::default()
        };
        standing.take(&signals, &readings);
    }
    let answer = standing.rear_leg(&signals, gait.legs, R::of(9.81));
    hash.word(answer.map_or_else(|unsure| unsure as u32, |_| 0));
    hash.1 += u32::from(answer.is_ok());
    let leg = answer.unwrap_or_else(|_| draw.word() % gait.legs);
    hash.word(leg);
    leg
}

fn drill<R: Bits + 'static>(cycles: u32) {
    let (mut draw, mut hash) = (Draw(1), Hash(2_166_136_261, 0));
    let (mut fired, mut stood) = (0, 0);
    let taps = [R::of(0.2); 5];
    let mut wheel = Wheel::default();
    for run in 0..cycles / RUN {
        let drawn = Drawn::new(&mut draw);
        let gait = drawn.gait(run, &taps);
        let rear = stand(&mut draw, &mut hash, &gait);
        wheel.rate = 0;
        wheel.wanted = draw.up_to(140);
        let mut runner = Runner::new(gait, rear, wheel.place >> 6, run % 5 != 4);
        runner.demand(draw.between(-4.0, 4.0));
        if draw.one_in(2) {
            runner.sense(draw.between(0.1, 2.0));
        }
        let mut readings = Readings::default();
        for _ in 0..RUN {
            wheel.roll(&mut draw, &mut readings);
            if draw.one_in(1500) {
                runner.turn_round(readings.wheel);
            }
            if draw.one_in(300) {
                let stands = draw.one_in(8);
                runner.demand(if stands {
                    R::ZERO
                } else {
                    draw.between(-4.0, 4.0)
                });
            }
            if draw.one_in(30) {
                runner.sense(draw.between(-0.2, 3.0));
            }
            let action = runner.step(&readings);
            fired += u32::from(action.leg.is_some());
            stood += u32::from(action.stalled);
            hash.action(&action);
        }
    }
    println!(
        "cycles: {cycles} calls, {fired} answered, hash {:08x}",
        hash.0
    );
    let (knew, runs) = (hash.1, cycles / RUN);
    println!("stood still in {stood}, knew its feet in {knew} of {runs} runs");
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let cycles: u32 = arguments
        .next()
        .map_or(100_000, |text| text.parse().expect("a number of cycles"));
    if arguments.next().is_some_and(|text| text == "double") {
        drill::<f64>(cycles);
    } else {
        drill::<f32>(cycles);
    }
}
