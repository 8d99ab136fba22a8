//! What the page holds is what was run.

use saltus::gait::space::{Ball, Gait, Knows, Roll, Stable, roll};
use saltus::robot::resolve;
use serde_json::Value;

use super::{About, Film, MOST};

fn about(title: &str) -> About {
    About {
        title: title.into(),
        ended: "rolled to the end".into(),
        rolled: true,
    }
}

/// A run of `seconds` by the sensors, its cycles and its page.
fn filmed(seconds: f64) -> (Roll, Vec<Ball>, String) {
    let robot = resolve("rats-twelve", &[]).unwrap();
    let mut setup = Roll::new(robot, seconds);
    (setup.gait, setup.knows) = (Gait::Stable(Stable::default()), Knows::Sensors(1));
    let mut film = Film::new(&setup);
    setup.forces_every = film.every();
    let mut balls = Vec::new();
    roll(&setup, |ball| {
        film.push(ball);
        balls.push(ball.clone());
        true
    })
    .unwrap();
    let page = film.page(&setup, &about("</script><script>alert(1)"));
    (setup, balls, page)
}

fn scene(page: &str) -> Value {
    let (_, rest) = page
        .split_once("<script type=\"application/json\" id=\"scene\">")
        .unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

/// The bytes that stand for base64 (RFC 4648): the other way than the page is made, and than its script reads it.
fn bytes(text: &Value) -> Vec<u8> {
    const DIGITS: &str = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let text = text.as_str().unwrap();
    let six = |letter: char| DIGITS.find(letter).unwrap();
    let letters = text.trim_end_matches('=').chars();
    let bits: Vec<usize> = letters
        .flat_map(|letter| (0..6).rev().map(move |k| six(letter) >> k & 1))
        .collect();
    let whole = bits.chunks_exact(8);
    let byte = |eight: &[usize]| {
        let all = eight.iter().fold(0, |sum, bit| 2 * sum + bit);
        u8::try_from(all).unwrap()
    };
    whole.map(byte).collect()
}

fn floats(text: &Value) -> Vec<f64> {
    let bytes = bytes(text);
    let four = bytes.chunks_exact(4);
    four.map(|b| f64::from(f32::from_le_bytes(b.try_into().unwrap())))
        .collect()
}

fn shares(packed: &Value) -> Vec<f64> {
    let most = packed["most"].as_f64().unwrap();
    let bytes = bytes(&packed["share"]);
    let two = bytes.chunks_exact(2);
    two.map(|b| f64::from(i16::from_le_bytes(b.try_into().unwrap())) / 32767.0 * most)
        .collect()
}

#[test]
fn frames_are_the_cycles_that_were_run() {
    let (_, balls, page) = filmed(0.8);
    let scene = scene(&page);
    assert_eq!(scene["frames"], balls.len());
    let near = |found: &[f64], wanted: &mut dyn Iterator<Item = f64>, tolerance: f64| {
        let wanted: Vec<f64> = wanted.collect();
        assert_eq!(found.len(), wanted.len());
        for (a, b) in found.iter().zip(&wanted) {
            assert!((a - b).abs() <= tolerance, "{a} {b}");
        }
    };
    // 32 bits hold 1 m to 6e-8; 16 bits hold the greatest to 1.5e-5 of it, which has six digits itself.
    near(
        &floats(&scene["time_s"]),
        &mut balls.iter().map(|ball| ball.time),
        1e-7,
    );
    near(
        &floats(&scene["place_m"]),
        &mut balls.iter().flat_map(|ball| ball.place),
        1e-7,
    );
    near(
        &shares(&scene["attitude"]),
        &mut balls.iter().flat_map(|ball| ball.attitude),
        1.6e-5,
    );
    let estimates = || balls.iter().map(|ball| ball.estimate.unwrap());
    near(
        &floats(&scene["estimated_place_m"]),
        &mut estimates().flat_map(|estimate| estimate.place),
        1e-7,
    );
    near(
        &shares(&scene["estimated_attitude"]),
        &mut estimates().flat_map(|estimate| estimate.attitude.0),
        1.6e-5,
    );
    near(
        &shares(&scene["extension_m"]),
        &mut balls.iter().flat_map(|ball| ball.extensions.clone()),
        2e-6,
    );
    near(
        &floats(&scene["columns"]["roll_rad"]),
        &mut balls.iter().map(|ball| ball.rolling.roll),
        1e-7,
    );
    let touching = bytes(&scene["touching"]);
    for (ball, feet) in balls.iter().zip(touching.chunks_exact(12)) {
        for (leg, down) in feet.iter().enumerate() {
            assert_eq!(u64::from(*down), ball.touching >> leg & 1);
        }
    }
    let forces = shares(&scene["force_n"]);
    let most = scene["force_n"]["most"].as_f64().unwrap();
    for (ball, told) in balls.iter().zip(forces.chunks_exact(36)) {
        for leg in 0..12 {
            let on_leg = ball.forces.iter().filter(|force| force.0 == leg);
            let wanted = on_leg.fold([0.0; 3], |sum: [f64; 3], (_, f)| {
                [sum[0] + f[0], sum[1] + f[1], sum[2] + f[2]]
            });
            for k in 0..3 {
                let off = (told[3 * leg + k] - wanted[k]).abs();
                assert!(off <= 1.6e-5 * most + 1e-6, "{off}");
            }
        }
    }
    assert!((100.0..3000.0).contains(&most), "{most} N");
    let fired: usize = balls.iter().map(|ball| ball.fired.len()).sum();
    assert_eq!(scene["firings"].as_array().unwrap().len(), fired);
    assert!(fired > 0 && !scene["touch_downs"].as_array().unwrap().is_empty());
}

#[test]
fn a_minute_is_small_and_smooth() {
    let (_, balls, _) = filmed(0.3);
    let robot = resolve("rats-twelve", &[]).unwrap();
    let setup = Roll::new(robot, 60.0);
    let mut film = Film::new(&setup);
    // A firing each 0.15 s, as in a run; what is in the frames does not change their size.
    for cycle in 0..=60_000_usize {
        let mut ball = balls[cycle % balls.len()].clone();
        ball.time = cycle as f64 * 1e-3;
        film.push(&ball);
    }
    let page = film.page(&setup, &about("a minute"));
    assert!(page.len() < 20_000_000, "{} bytes", page.len());
    let frames = scene(&page)["frames"].as_u64().unwrap();
    assert!((60 * 30..=MOST + 1).contains(&frames), "{frames} frames");
}

#[test]
fn the_page_asks_for_nothing_and_holds_no_markup_of_its_scene() {
    let (_, _, page) = filmed(0.05);
    let links = page.match_indices("http").filter(|(at, _)| {
        let rest = &page[*at..];
        rest.starts_with("http:") || rest.starts_with("https:")
    });
    let outside: Vec<_> = links
        .filter(|(at, _)| !page[*at..].starts_with("http://www.w3.org/2000/svg"))
        .collect();
    assert!(outside.is_empty() && !page.contains("@import") && !page.contains("url("));
    assert!(page.contains("default-src 'none'") && page.contains("webgl2"));
    assert!(!page.contains("@VIEW@") && !page.contains("@STYLE@") && !page.contains("@SCENE@"));
    assert!(!page.contains("<script>alert(1)"));
    assert_eq!(scene(&page)["title"], "</script><script>alert(1)");
}
