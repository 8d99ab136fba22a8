//! The muscle: its force law, its volume by virtual work, and the spring in series.

use proptest::prelude::*;
use saltus_pneumatics::Muscle;

use crate::{cases, decades, near};

/// Greatest pressure (Pa, gauge) of the muscle's tests.
const MOST: f64 = 8e5;

/// Points and weights of Gauss and Legendre's rule on [−1, 1], exact to degree 5.
const GAUSS: [(f64, f64); 3] = [
    (-0.774_596_669_241_483_4, 5.0 / 9.0),
    (0.0, 8.0 / 9.0),
    (0.774_596_669_241_483_4, 5.0 / 9.0),
];

/// The muscle of the jumping robot of `GTDynamics`, whose file is in kPa and cm.
fn muscle() -> Muscle {
    let (kilo, centi) = (1e3, 1e-2);
    let of_kpa = [
        3.05583930,
        7.58361626e-2,
        -4.91579771e-4,
        1.42792618e-6,
        -1.54817477e-9,
    ];
    let mut reach = of_kpa.map(|c| c * centi);
    let mut unit = 1.0;
    for c in &mut reach {
        *c /= unit;
        unit *= kilo;
    }
    Muscle {
        volume: 4.243e-5,
        force: 1.966409 / kilo,
        slope: 0.35541599 / (kilo * centi),
        reach,
        most: Muscle::rising_to(reach, MOST),
    }
}

#[test]
fn its_numbers_are_those_of_its_file() {
    let muscle = muscle();
    // At 100 kPa: 3.0558393 + 7.58361626 − 4.91579771 + 1.42792618 − 0.154817477 cm.
    near(muscle.free_contraction(1e5), 0.06996766553, 1e-12);
    // At full length, 1.966409 N for each kPa.
    near(muscle.at(2e5).pull(0.0), 393.2818, 1e-12);
}

#[test]
fn its_reach_rises_with_the_pressure_and_then_stays() {
    let muscle = muscle();
    let last = muscle.free_contraction(muscle.most);
    let mut before = muscle.free_contraction(0.0);
    for k in 1..=1000 {
        let here = muscle.free_contraction(MOST * f64::from(k) / 1000.0);
        // To round-off.
        assert!(here >= before * (1.0 - 1e-15), "step {k}");
        before = here;
    }
    assert_eq!(before, last);
    assert!(muscle.most > 1e5 && muscle.most < MOST, "{}", muscle.most);
    // A polynomial that rises everywhere, and one that never does.
    assert_eq!(Muscle::rising_to([0.0, 1.0, 0.0, 0.0, 0.0], MOST), MOST);
    assert_eq!(Muscle::rising_to([1.0, -1.0, 0.0, 0.0, 0.0], MOST), 0.0);
}

#[test]
fn without_pressure_or_past_its_reach_it_does_not_pull() {
    let muscle = muscle();
    for pressure in [-1e5, -1.0, 0.0] {
        for x in [-0.02, 0.0, 0.02, 0.2] {
            assert_eq!(muscle.at(pressure).pull(x), 0.0);
            assert_eq!(muscle.at(pressure).stiffness(x), 0.0);
            assert_eq!(muscle.pull_through(1e-4, x, pressure), 0.0);
        }
    }
    let end = muscle.free_contraction(2e5);
    assert_eq!(muscle.at(2e5).pull(1.001 * end), 0.0);
    // Volume does not grow where there is no force.
    assert_eq!(muscle.at(2e5).volume(2.0 * end), muscle.at(2e5).volume(end));
}

/// `along` its reach; one in three is stretched.
fn contractions() -> impl Strategy<Value = f64> {
    prop_oneof![2 => 0.0..1.0, 1 => -0.5..0.0]
}

proptest! {
    #![proptest_config(cases(500))]

    #[test]
    fn it_pulls_less_the_shorter_it_is(
        pressure in 0.0..MOST,
        along in contractions(),
        more in 1e-3_f64..1.0,
    ) {
        prop_assume!(pressure > 0.0);
        let muscle = muscle();
        let end = muscle.free_contraction(pressure);
        let [x, further] = [along * end, (along + more) * end];
        let full = muscle.at(pressure).pull(0.0);
        let [pull, less] = [x, further].map(|x| muscle.at(pressure).pull(x));
        prop_assert!(less < pull || pull == 0.0, "{pull} N, then {less} N");
        prop_assert!(muscle.at(pressure).stiffness(x) <= 0.0);
        prop_assert!(muscle.at(pressure).volume(further) >= muscle.at(pressure).volume(x));
        // Where it ends, so does the slope: near there it pulls by the square of what is left.
        let left = 1e-4;
        let near_end = muscle.at(pressure).pull((1.0 - left) * end);
        // The force is (1 − x/end)² (a + (2a/end − b) x), at the end 3a − b end: at most 3 a.
        prop_assert!(near_end <= 3.0 * full * left * left, "{near_end} N");
        let slope = muscle.at(pressure).stiffness((1.0 - left) * end);
        prop_assert!(slope.abs() <= 6.0 * full / end * left, "{slope} N/m");
    }

    #[test]
    fn its_volume_does_the_work_of_its_pull(
        pressure in 1.0..MOST,
        from in contractions(),
        to in contractions(),
    ) {
        let muscle = muscle();
        let end = muscle.free_contraction(pressure);
        // The law is of degree 3 on either side of the full length: Gauss is exact there.
        let work = |to: f64| -> f64 {
            let half = 0.5 * to;
            let pull = |at: f64| muscle.at(pressure).pull(half * (1.0 + at));
            GAUSS.iter().map(|(at, weight)| weight * half * pull(*at)).sum()
        };
        let [from, to] = [from * end, to * end];
        let work = work(to) - work(from);
        let gained = pressure * (muscle.at(pressure).volume(to) - muscle.at(pressure).volume(from));
        // Round-off of volumes: 1e-16 of p V.
        let scale = pressure * muscle.at(pressure).volume(end);
        prop_assert!((work - gained).abs() < 1e-13 * scale, "{work} J, {gained} J");
    }

    #[test]
    fn its_stiffness_is_the_slope_of_its_pull(pressure in 1.0..MOST, along in contractions()) {
        let muscle = muscle();
        let end = muscle.free_contraction(pressure);
        let (x, step) = (along * end, 1e-5 * end);
        let ahead = muscle.at(pressure).pull(x + step);
        let slope = (ahead - muscle.at(pressure).pull(x - step)) / (2.0 * step);
        let scale = muscle.at(pressure).pull(0.0) / end;
        // Central differences: 1e-10 of a third derivative; 1e-5 of a second one across the full
        // length or the end, where that jumps by up to 8 a/end².
        let off = (slope - muscle.at(pressure).stiffness(x)).abs();
        let across = x.abs() < step || (x - end).abs() < step;
        prop_assert!(off < scale * if across { 1e-4 } else { 1e-8 }, "{slope} N/m, off by {off}");
    }

    #[test]
    fn through_a_spring_it_pulls_where_both_agree(
        pressure in 1.0..MOST,
        along in contractions(),
        compliance in decades(1e-8, 1e2),
        softer in 1.0_f64..10.0,
    ) {
        let muscle = muscle();
        let travel = along * muscle.free_contraction(pressure);
        let stiff = muscle.at(pressure).pull(travel);
        prop_assert_eq!(muscle.pull_through(0.0, travel, pressure), stiff);
        let pull = muscle.pull_through(compliance, travel, pressure);
        // What a change of the pull changes on the right, beside the change itself.
        let at = travel + compliance * pull;
        let gain = 1.0 - compliance * muscle.at(pressure).stiffness(at);
        let off = (muscle.at(pressure).pull(at) - pull).abs() / gain;
        // Newton's last step.
        prop_assert!(off < 1e-9 * (1.0 + stiff), "{pull} N of {stiff} N, off by {off}");
        prop_assert!((0.0..=stiff).contains(&pull), "{pull} N of {stiff} N");
        let softer = muscle.pull_through(softer * compliance, travel, pressure);
        prop_assert!(softer <= pull + 2e-9 * (1.0 + pull), "{pull} N, softer {softer} N");
    }
}
