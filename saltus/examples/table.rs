//! A firing table: the angle for each approach rate that lands 0.6 m ahead.
//!
//! `cargo run -p saltus --example table`

use saltus::planner::TableRequest;
use saltus::{Planner, Robot};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let planner = Planner::new(Robot::rats_planar());
    let table = planner.table(&TableRequest::distance(0.6).rates([3.0, 4.0, 5.0, 6.0]))?;
    for cell in &table.cells {
        let angle = cell
            .entries
            .first()
            .map(|entry| entry.jump.launch.firing_angle);
        println!("{} rad/s: {angle:.4?} rad", cell.rate);
    }
    Ok(())
}
