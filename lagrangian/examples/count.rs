use saltus_lagrangian::*;
use saltus_robot::Robot;
fn main() {
    let s = Stance::<f64>::new(&Robot::rats_planar(), |_, x| x).with_tolerance(2e-9);
    let mut a = 0.0;
    for i in 0..2000 {
        let e = s.jump(&Launch::at_firing(3.0 + 0.0015 * i as f64, -0.1, 0.06)).unwrap();
        a += e.time;
    }
    println!("{a}");
}
