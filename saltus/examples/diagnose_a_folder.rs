//! What a folder of measured data says is wrong with the simulation.
//!
//! `cargo run --release -p saltus --example diagnose_a_folder`

use saltus::diagnosis::Settings;
use saltus::experiment::Folder;

const DROPS: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../tests/reference/ball-drops/whiffle-ball-1"
);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let study = Folder::open(DROPS)?.diagnose(&Settings::default())?;
    for finding in &study.diagnosis.findings {
        println!("{}: {}", finding.best.title(), finding.best.meaning());
        for found in &finding.best.reported {
            println!("  {} = {:.4} ± {:.4}", found.name, found.value, found.error);
        }
    }
    Ok(())
}
