//! How well a ball knows its motion by its sensors, and that a worse estimate, and worse switches, are seen to be worse.

use saltus::gait::GaitError;
use saltus::gait::space::{
    DrawnBalls, Flashed, Gait, Hearing, Knows, Roll, Stable, drawn_ball, roll,
};
use saltus_controller::ball::Rotation;
use saltus_robot::Robot;
use saltus_sim_check::Stepping;
use saltus_tests::known::Known;

const SECONDS: f64 = 20.0;
/// What gyros read at rest (rad/s).
const BIAS: f64 = 0.01;

fn drawn(k: usize) -> Result<Robot, GaitError> {
    let biased = format!("sensors.gyro_bias_rad_s={BIAS}");
    let robot = saltus_robot::resolve("rats-twelve", &[biased]).expect("a sound robot");
    drawn_ball(&robot, &DrawnBalls::default(), 9, k)
}

fn rolls(robot: Robot, seed: u64) -> Roll {
    let mut setup = Roll::new(robot, SECONDS);
    setup.gait = Gait::Stable(Stable::default());
    setup.knows = Knows::Sensors(seed);
    setup.stepping = Stepping::Fixed(1e-3);
    setup
}

/// The heading's drift (degrees a minute).
fn drift(known: &Known) -> f64 {
    known.heading.to_degrees() * 60.0 / SECONDS
}

#[test]
fn it_finds_contacts_and_knows_its_attitude_and_its_heading() -> Result<(), GaitError> {
    let (mut sum, mut squares) = (Known::default(), 0.0);
    for k in 0..4 {
        let mut known = Known::default();
        roll(&rolls(drawn(k)?, 3), |ball| {
            known.take(ball);
            true
        })?;
        squares += drift(&known).powi(2) / 4.0;
        sum.add(&known);
    }
    assert!(sum.touch_downs > 200 && sum.cycles > 20_000, "{sum:?}");
    assert!(
        sum.found[1] as f64 > 0.99 * sum.touch_downs as f64,
        "{sum:?}"
    );
    let [plane, lean, _] = sum.rms().map(f64::to_degrees);
    assert!(plane < 1.0 && lean < 1.0, "{plane} {lean}");
    assert!(squares.sqrt() < 1.0, "{} deg/min", squares.sqrt());
    Ok(())
}

/// Beside the run hears an estimator that knows nothing of the bias, and switches that answer 3 ms late.
#[test]
fn a_bias_that_stays_and_slow_switches_are_seen() -> Result<(), GaitError> {
    let setup = rolls(drawn(1)?, 3);
    let Knows::Sensors(seed) = setup.knows else {
        return Ok(());
    };
    let flashed = Flashed::new(&setup.robot, &Stable::default())?;
    let mut deaf = flashed.clone();
    deaf.filter.bias = [0.0; 3];
    let mut beside: Option<[_; 2]> = None;
    let mut hearing: Option<Hearing> = None;
    let mut known = [(); 3].map(|()| Known::default());
    let mut past = [0_u64; 3];
    roll(&setup, |ball| {
        let start = (Rotation(ball.attitude), ball.place);
        let estimators =
            beside.get_or_insert_with(|| [&flashed, &deaf].map(|it| it.estimator(start)));
        let ears = hearing.get_or_insert_with(|| Hearing::new(&setup.robot, ball.attitude, seed));
        let readings = ears.read(ball.attitude, ball.velocity, ball.touching);
        for estimator in estimators.iter_mut() {
            estimator.take(&readings);
            ball.fired
                .iter()
                .for_each(|firing| estimator.fired(firing.leg));
        }
        let [same, worse] = estimators;
        // What is flashed is what runs, to the bit.
        assert_eq!(ball.estimate.as_ref(), Some(same.estimate()));
        known[0].take(ball);
        let mut other = ball.clone();
        other.estimate = Some(*worse.estimate());
        known[1].take(&other);
        let mut late = ball.clone();
        late.touching &= past[0] & past[1] & past[2];
        past = [past[1], past[2], ball.touching];
        known[2].take(&late);
        true
    })?;
    let [good, biased, late] = &known;
    let rms = |known: &Known| known.rms().map(f64::to_degrees);
    let worst = rms(biased).into_iter().fold(drift(biased).abs(), f64::max);
    assert!(worst > 3.0, "{:?} {}", rms(biased), drift(biased));
    assert!(rms(good).iter().all(|off| *off < 1.0), "{:?}", rms(good));
    assert!(
        10 * late.found[1] < late.touch_downs && late.touch_downs == good.touch_downs,
        "{late:?}"
    );
    Ok(())
}
