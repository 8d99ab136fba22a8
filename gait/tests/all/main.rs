//! Tests of the analysis of gaits, in one binary: linking is what takes time.

mod passive;

use saltus_robot::{Robot, resolve};

/// The robot of that name.
fn robot(name: &str) -> Robot {
    let path = format!("{}/../robots/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    resolve(&path, &[] as &[String]).unwrap_or_else(|e| panic!("{name}: {e}"))
}
