//! Measured tosses of a cube: what friction and impacts do to a real body.

use std::path::{Path, PathBuf};

use saltus_sim_check::SimError;

mod toss;
use toss::{Law, Toss, board_height, compare, lowest_corner, parse, read_folder, roll_out};

fn tosses() -> Vec<Toss> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../tests/reference/cube-tosses");
    read_folder(&folder).expect("the reference is sound")
}

/// Mean error of the centre over `tosses`, as a part of the width.
fn score(tosses: &[Toss], law: &Law) -> Result<f64, SimError> {
    let mut sum = 0.0;
    for toss in tosses {
        let apart = compare(toss, law)?;
        // The centre is the mean of the corners.
        assert!(apart.corners >= apart.center, "{apart:?}");
        sum += apart.center;
    }
    Ok(sum / tosses.len() as f64)
}

/// Nothing is fitted: friction and restitution as published, the board where the cube comes to
/// rest.
#[test]
fn a_cube_slides_as_far_as_measured() -> Result<(), SimError> {
    let tosses = tosses();
    assert_eq!(tosses.len(), 12);
    let law = Law::published(board_height(&tosses));
    let with = |friction: f64| score(&tosses, &Law { friction, ..law });
    let (published, none, low, high) =
        (score(&tosses, &law)?, with(0.0)?, with(0.12)?, with(0.25)?);
    println!(
        "mean error {published:.3} of the width; {none:.3} without friction, {low:.3} for 0.12, \
         {high:.3} for 0.25"
    );
    // 0.12 over all 95 tosses, with a standard error of 0.02 for twelve.
    assert!(published < 0.15, "{published}");
    assert!(
        none > 5.0 * published && low > 2.0 * published && high > 2.0 * published,
        "{none} {low} {high}"
    );
    Ok(())
}

/// Every toss ends on a face, on the board: the centre is half a width above it, whatever the
/// impacts on the way.
#[test]
fn a_cube_ends_on_a_face_at_rest() -> Result<(), SimError> {
    let tosses = tosses();
    let law = Law::published(board_height(&tosses));
    for toss in &tosses {
        let places = roll_out(toss, &law)?;
        let (before, last) = (places[places.len() - 2].0, places[places.len() - 1].0);
        let height = last.z - law.board;
        assert!(
            (height - 0.1048 / 2.0).abs() < 1e-6,
            "{height} m at the end"
        );
        let measured = toss.rows[toss.rows.len() - 1];
        if measured.velocity.norm() < 0.01 {
            assert!(
                (last - before).norm() < 3e-3,
                "{} m in the last sample",
                (last - before).norm()
            );
        }
        // No toss of the reference begins in the board.
        assert!(lowest_corner(&toss.rows[0]) > law.board);
    }
    Ok(())
}

#[test]
fn bad_files_are_named() {
    let header = "time_s,x_m,y_m,z_m,qw,qx,qy,qz,vx_m_s,vy_m_s,vz_m_s,wx_body_rad_s,wy_body_rad_s,wz_body_rad_s";
    let row = |time: &str, qw: &str| format!("{time},0,0,0.1,{qw},0,0,0,0,0,0,0,0,0");
    let check = |text: String, wanted: &str| {
        let found = parse(Path::new("7.csv"), &text)
            .map(|rows| rows.len())
            .map_err(|e| e.to_string());
        assert!(
            found.as_ref().is_err_and(|m| m.contains(wanted)),
            "{found:?} for '{wanted}'"
        );
    };
    check(
        "time,x".into(),
        "7.csv: row 1: the columns must be time_s,x_m",
    );
    check(
        format!("{header}\n{}\n", row("0", "1")),
        "7.csv: 1 rows, at least 2 wanted",
    );
    check(
        format!("{header}\n1,2,3\n"),
        "7.csv: row 2: 3 cells, 14 wanted",
    );
    check(
        format!("{header}\n{}\n", row("NaN", "1")),
        "7.csv: row 2, column time_s: 'NaN': must be a finite number",
    );
    check(
        format!("{header}\n{}\n", row("0", "one")),
        "7.csv: row 2, column qw: 'one': must be a finite number",
    );
    check(
        format!("{header}\n{}\n", row("0", "0.9")),
        "7.csv: row 2, column qw: '0.9': must be of a quaternion of length 1",
    );
    let twice = format!("{header}\n{0}\n{0}\n", row("0.5", "1"));
    check(
        twice,
        "7.csv: row 3, column time_s: '0.5': must be later than in the row before",
    );
    let missing = read_folder(Path::new("no such folder"))
        .map(|t| t.len())
        .map_err(|e| e.to_string());
    assert!(
        missing
            .as_ref()
            .is_err_and(|m| m.starts_with("no such folder: ")),
        "{missing:?}"
    );
}
