//! The drill of `firmware/ball.c` in Rust: the same balls, and a hash of every bit of what they know and decide.
//!
//!     cd studies && cargo run --release --bin ball_drill -- [CYCLES [double]]

use saltus_controller::Real;
use saltus_controller::ball::{
    AtRest, Balance, Balancer, Estimate, Estimator, Feet, Filter, Firing, Inertial, Lead, Lying,
    Pilot, Plane, Rotation, Scales, Sight, Station, Steer, View,
};

/// Cycles of a run.
const RUN: u32 = 1000;
const LEGS: u32 = 12;
const STATIONS: usize = 6;

const A: f64 = 0.5;
const B: f64 = 0.809_016_994_374_947_5;
const C: f64 = 0.309_016_994_374_947_45;
/// Across the planes of a dodecahedron.
const AXES: [[f64; 3]; 15] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [A, B, C],
    [A, B, -C],
    [A, -B, C],
    [A, -B, -C],
    [B, C, A],
    [B, -C, A],
    [-B, C, A],
    [-B, -C, A],
    [C, A, B],
    [-C, A, B],
    [C, A, -B],
    [-C, A, -B],
];

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

    fn numbers<R: Real, const N: usize>(&mut self, low: f64, high: f64) -> [R; N] {
        std::array::from_fn(|_| self.between(low, high))
    }

    fn vector<R: Real>(&mut self) -> [R; 3] {
        self.numbers(-1.0, 1.0)
    }

    /// What is no number, or has no bound.
    fn odd<R: Real>(&mut self) -> R {
        R::of(match self.word() % 4 {
            0 | 1 => f64::NAN,
            2 => f64::INFINITY,
            _ => f64::NEG_INFINITY,
        })
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

/// FNV-1a over words, least byte first.
struct Hash(u32);

impl Hash {
    fn word(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u32::from(byte)).wrapping_mul(16_777_619);
        }
    }

    /// What is not a number has many bits; here it is one word.
    fn numbers<R: Bits>(&mut self, numbers: &[R]) {
        for x in numbers {
            let is_number = x.partial_cmp(x).is_some();
            let words = if is_number {
                x.words()
            } else {
                vec![0x7FC0_0000]
            };
            for word in words {
                self.word(word);
            }
        }
    }

    fn cycle<R: Bits>(&mut self, e: &Estimate<R>, l: &Lying<R>, fired: &[Option<Firing<R>>; 2]) {
        self.numbers(&e.attitude.0);
        let lies = [
            l.lean,
            l.rate,
            l.roll,
            l.roll_rate,
            l.heading,
            l.heading_rate,
        ];
        self.numbers(&lies);
        for numbers in [e.spin, e.velocity, e.place] {
            self.numbers(&numbers);
        }
        for firing in fired {
            self.word(firing.map_or(u32::MAX, |firing| firing.leg));
            self.numbers(&[firing.map_or(R::ZERO, |firing| firing.open)]);
        }
    }
}

/// A ball with any legs, plane and gains.
struct Drawn<R> {
    directions: [[R; 3]; LEGS as usize],
    filter: Filter<R>,
    stations: Vec<Station<R>>,
    axes: [[R; 3]; 3],
    balance: Balance<R>,
    path: [[R; 2]; 4],
    lead: Lead<R>,
}

impl<R: Real> Drawn<R> {
    fn new(draw: &mut Draw) -> Drawn<R> {
        let directions = std::array::from_fn(|_| draw.vector());
        let filter = Filter {
            period: R::of(0.001),
            gravity: R::of(9.80665),
            bias: draw.numbers(-0.01, 0.01),
            by_foot: R::of(40.0),
            tilt: R::of(0.1),
            settles: draw.between(0.0, 0.05),
            returns: draw.between(0.0, 0.3),
        };
        let axes = std::array::from_fn(|_| draw.vector());
        let mut angle = R::ZERO;
        let mut stations: Vec<Station<R>> = Vec::new();
        for _ in 0..STATIONS {
            let leg = draw.word() % LEGS;
            let is_single = draw.one_in(2);
            let other = if is_single { leg } else { draw.word() % 70 };
            let legs = [leg, other];
            stations.push(Station { legs, angle });
            angle = angle + draw.between(0.1, 1.2);
        }
        stations.truncate(draw.word() as usize % (STATIONS + 1));
        let balance = balance(draw);
        let path = std::array::from_fn(|_| draw.numbers(-5.0, 5.0));
        let lead = lead(draw, balance);
        Drawn {
            directions,
            filter,
            stations,
            axes,
            balance,
            path,
            lead,
        }
    }

    fn planes(&self) -> Vec<Plane<'_, R>> {
        let [_, first, ahead] = self.axes;
        let stations = &self.stations;
        let plane = |axis: [R; 3]| Plane {
            axis,
            first,
            ahead,
            stations,
        };
        let both = |axis: &[f64; 3]| [axis.map(R::of), axis.map(|x| -R::of(x))];
        AXES.iter().flat_map(both).map(plane).collect()
    }

    fn estimator(&self, start: (Rotation<R>, [R; 3])) -> Estimator<'_, R> {
        let feet = Feet {
            directions: &self.directions,
            reach: R::of(0.233),
            radius: R::of(0.007),
        };
        Estimator::new(self.filter, scales(), feet, start)
    }

    fn balancer(&self) -> Balancer<'_, R> {
        let [axis, first, ahead] = self.axes;
        let stations = &self.stations;
        let plane = Plane {
            axis,
            first,
            ahead,
            stations,
        };
        Balancer::new(self.balance, plane)
    }
}

fn scales<R: Real>() -> Scales<R> {
    Scales {
        fine_gyro: R::of(0.00030521),
        coarse_gyro: R::of(0.00079897),
        fine_accelerometer: R::of(0.00059856),
        coarse_accelerometer: R::of(0.014964),
        limit: 32111,
    }
}

fn balance<R: Real>(draw: &mut Draw) -> Balance<R> {
    Balance {
        period: R::of(0.001),
        zone: draw.between(-0.5, 0.2),
        angles: draw.numbers(-0.2, 0.4),
        opens: draw.numbers(0.0, 0.02),
        by_rate: draw.numbers(-0.005, 0.005),
        rate: draw.between(0.0, 8.0),
        first: draw.numbers(0.0, 0.03),
        slow: draw.between(0.0, 2.0),
        stall: draw.between(0.0, 0.4),
        lead: R::of(0.01),
        least: R::of(0.0005),
        steer: Steer {
            roll: draw.between(-0.01, 0.01),
            roll_rate: draw.between(-0.01, 0.01),
            heading: draw.between(-0.01, 0.01),
            heading_rate: draw.between(-0.01, 0.01),
            aside: draw.between(-0.01, 0.01),
            aside_rate: draw.between(-0.01, 0.01),
            sum: draw.between(-0.01, 0.01),
            most: draw.between(0.0, 0.01),
            from: draw.between(-0.2, 0.5),
            rest: draw.between(0.0, 0.03),
        },
    }
}

fn lead<R: Real>(draw: &mut Draw, balance: Balance<R>) -> Lead<R> {
    Lead {
        balance,
        ahead: draw.between(0.0, 3.0),
        slew: draw.between(0.0, 1.0),
        tips: draw.between(0.1, 1.5),
        astray: draw.between(0.0, 20.0),
        turn: draw.between(0.1, 3.0),
        near: draw.between(0.0, 1.0),
        still: draw.between(0.0, 20.0),
        rests: draw.between(0.0, 0.05),
        patience: draw.between(0.0, 0.3),
    }
}

/// Rates that go after others, shocks, and feet that come and go.
#[derive(Default)]
struct Tumble {
    rates: [i32; 3],
    wanted: [i32; 3],
}

impl Tumble {
    fn read(&mut self, draw: &mut Draw, readings: &mut Inertial) {
        if draw.one_in(300) {
            for wanted in &mut self.wanted {
                *wanted = if draw.one_in(4) {
                    0
                } else {
                    draw.up_to(40_000)
                };
            }
        }
        let shock = if draw.one_in(100) { 32_767 } else { 800 };
        for k in 0..3 {
            self.rates[k] += (self.wanted[k] - self.rates[k]) / 64;
            let rate = self.rates[k];
            readings.fine_gyro[k] = (rate + draw.up_to(90)).clamp(-32_767, 32_767);
            readings.coarse_gyro[k] = rate * 3 / 8 + draw.up_to(40);
            readings.fine_accelerometer[k] = draw.up_to(16_384);
            readings.coarse_accelerometer[k] = draw.up_to(shock);
        }
        if draw.one_in(60) {
            let (low, high) = (u64::from(draw.word()), u64::from(draw.word()));
            readings.touching = if draw.one_in(4) {
                u64::MAX
            } else if draw.one_in(3) {
                0
            } else {
                low & u64::from(draw.word()) | high << 40
            };
        }
    }
}

fn see<R: Real>(draw: &mut Draw, e: &Estimate<R>, course: R, touching: u64) -> Sight<R> {
    let mut sight = Sight {
        attitude: e.attitude,
        spin: e.spin,
        aside: e.place[1],
        aside_rate: e.velocity[1],
        course,
        touching,
    };
    if draw.one_in(100) {
        match draw.word() % 6 {
            0 => sight.attitude.0[1] = draw.odd(),
            1 => sight.attitude = Rotation([R::ZERO; 4]),
            2 => sight.spin[1] = draw.odd(),
            3 => sight.aside = draw.odd(),
            4 => sight.aside_rate = draw.odd(),
            _ => sight.course = draw.odd(),
        }
    }
    sight
}

/// How a ball lies, by what its sensors say at rest or while it is moved; any attitude where it cannot tell.
fn lie<R: Real>(draw: &mut Draw, hash: &mut Hash, knew: &mut u32) -> Rotation<R> {
    let noise = if draw.one_in(4) { 8000 } else { 300 };
    let far = if draw.one_in(9) { 99 } else { 200 };
    let mut up: [i32; 3] = std::array::from_fn(|_| draw.up_to(16_000));
    // Of a third of them the length is that of gravity for sure.
    if draw.one_in(3) {
        let z = if up[2] < 0 { -16_000 } else { 16_000 };
        up = [up[0] / 8, up[1] / 8, z];
    }
    let (mut rest, mut readings) = (AtRest::new(), Inertial::default());
    for _ in 0..far {
        for (k, up) in up.iter().enumerate() {
            readings.fine_accelerometer[k] = up + draw.up_to(noise);
            let most = if draw.one_in(4000) { 3000 } else { 300 };
            readings.fine_gyro[k] = draw.up_to(most);
        }
        rest.take(&scales::<R>(), &readings);
    }
    let answer = rest.attitude(&scales::<R>(), R::of(9.80665));
    hash.word(answer.map_or_else(|unsettled| unsettled as u32, |_| 0));
    *knew += u32::from(answer.is_ok());
    let half = R::of(0.5);
    answer.unwrap_or(Rotation([half, half, -half, half]))
}

/// What a pilot sees.
fn view<R: Real>(sight: &Sight<R>, now: &Estimate<R>) -> View<R> {
    View {
        attitude: sight.attitude,
        spin: sight.spin,
        place: [sight.aside, now.place[1]],
        velocity: [sight.aside_rate, now.velocity[1]],
        touching: sight.touching,
    }
}

fn drill<R: Bits>(cycles: u32) {
    let (mut draw, mut hash, mut fired) = (Draw(1), Hash(2_166_136_261), 0);
    let (mut tumble, mut knew) = (Tumble::default(), 0);
    let mut starts = 0;
    for run in 0..cycles / RUN {
        let drawn = Drawn::<R>::new(&mut draw);
        let attitude = lie(&mut draw, &mut hash, &mut knew);
        let mut estimator = drawn.estimator((attitude, draw.vector()));
        let mut balancer = drawn.balancer();
        let course = draw.between(-3.0, 3.0);
        let planes = drawn.planes();
        let pilot = Pilot::new(drawn.lead, &planes, &drawn.path);
        let mut pilot = (run % 2 == 1).then_some(pilot);
        let none = R::ZERO;
        let mut lying = Lying {
            lean: none,
            rate: none,
            roll: none,
            roll_rate: none,
            heading: none,
            heading_rate: none,
        };
        let mut readings = Inertial::default();
        for _ in 0..RUN {
            tumble.read(&mut draw, &mut readings);
            let sight = see(&mut draw, estimator.estimate(), course, readings.touching);
            estimator.take(&readings);
            let firings = if let Some(pilot) = &mut pilot {
                pilot.step(&view(&sight, estimator.estimate()))
            } else {
                let (lies, firings) = balancer.step(&sight);
                lying = lies;
                firings
            };
            for firing in firings.iter().flatten() {
                estimator.fired(firing.leg);
            }
            fired += u32::from(firings.iter().any(Option::is_some));
            hash.cycle(estimator.estimate(), &lying, &firings);
            if let Some(pilot) = &pilot {
                let plane = pilot.plane().and_then(|plane| u32::try_from(plane).ok());
                hash.word(plane.unwrap_or(u32::MAX));
            }
        }
        starts += pilot.map_or(0, |pilot| pilot.starts());
    }
    println!(
        "balls: {cycles} calls, {fired} answered, hash {:08x}",
        hash.0
    );
    let runs = cycles / RUN;
    println!("knew how it lay in {knew} of {runs} runs, set out {starts} times");
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
