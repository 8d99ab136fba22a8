use saltus_lagrangian::*;
use saltus_robot::Robot;
fn main() {
    let s = Stance::<f64>::new(&Robot::rats_planar(), |_, x| x).with_tolerance(2e-9);
    for (r, a, v) in [(4.5, -0.1, 0.04), (3.0, -0.25, 0.025)] {
        eprintln!("--");
        let e = s.jump(&Launch::at_firing(r, a, v)).unwrap();
        eprintln!("{:?}", e);
    }
}
