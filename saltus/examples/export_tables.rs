//! Tables for a controller, as C.
//!
//! `cargo run --release -p saltus --example export_tables`

use saltus::export::{Request, Tables};
use saltus::{Planner, Robot};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let planner = Planner::new(Robot::rats_planar());
    let (rates, distances) = ((4.0, 5.0, 3), (0.5, 0.7, 3));
    let request = Request {
        rates,
        distances,
        angles: 5,
        ..Request::default()
    };
    let [header, source] = Tables::<f32>::new(&planner, &request)?.c();
    println!("{header}\n{source}");
    Ok(())
}
