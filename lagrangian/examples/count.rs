use saltus_lagrangian::*;
use saltus_robot::Robot;
fn main() {
    let b = Batch::new(&Robot::rats_planar(), 2e-9);
    let l: Vec<Launch> = (0..2000).map(|i| Launch::at_firing(3.0 + 0.0015 * i as f64, -0.1, 0.06)).collect();
    let a: f64 = b.jumps(&l).into_iter().map(|e| e.unwrap().time).sum();
    println!("{a}");
}
