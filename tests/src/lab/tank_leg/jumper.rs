//! A robot of five links that is its own mirror image: a torso that stays level, and on either side
//! a thigh and a shank whose joints muscles pull straight.
//!
//! Coordinates are the height y of the torso and the angles φ of thigh and shank from downwards,
//! outwards below 0. Of one half, with m the masses, c the distances from the upper end to the
//! centre, l the lengths and b₁ = m₁ c₁ + m₂ l₁, b₂ = m₂ c₂, Lagrange's equations are
//!
//! M ÿ + b₁ (sin φ₁ φ̇₁)˙ + b₂ (sin φ₂ φ̇₂)˙ = −M g + Y,
//! J₁ φ̈₁ + b₁ sin φ₁ (ÿ + g) + b₂ l₁ (cos δ φ̈₂ + sin δ φ̇₂²) = Q₁,
//! J₂ φ̈₂ + b₂ sin φ₂ (ÿ + g) + b₂ l₁ (cos δ φ̈₁ − sin δ φ̇₁²) = Q₂ with δ = φ₁ − φ₂.

use super::super::motion::GRAVITY;

/// How far (m) the ground gives way under the weight of the robot at one point.
const GIVES_WAY: f64 = 1.25e-3;
/// Damping of a contact in terms of √(stiffness × mass).
const CONTACT_DAMPING: f64 = 0.2;
/// Joint rate (rad/s) at which dry friction is there.
const CREEP: f64 = 0.01;

/// A link: mass (kg) and length (m) of a solid cylinder.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    pub mass: f64,
    pub length: f64,
}

/// What is in the joints of one kind, hips or knees.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joint {
    /// A spring (N m/rad) against the muscle, and from which angle (rad) past straight on.
    pub spring: [f64; 2],
    /// Damping (N m s/rad).
    pub damping: f64,
    /// Dry friction (N m).
    pub friction: f64,
}

/// The robot: its links (torso, thigh, shank), their radius (m), hips and knees.
#[derive(Clone, Debug)]
pub(super) struct Jumper {
    pub links: [Link; 3],
    pub radius: f64,
    pub joints: [Joint; 2],
    /// Friction coefficient under a foot.
    pub grip: f64,
}

/// The ground: its height (m) under the torso and under a foot, and where a foot's friction holds
/// it (m); none: it is in the air.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ground {
    pub height: [f64; 2],
    pub hold: Option<f64>,
}

/// A force on a point: along outwards and up (N), and what would be left in the hold's spring (m).
struct Push {
    force: [f64; 2],
    left: f64,
}

impl Jumper {
    /// kg.
    pub(super) fn mass(&self) -> f64 {
        let [torso, thigh, shank] = self.links;
        torso.mass + 2.0 * (thigh.mass + shank.mass)
    }

    /// b₁ and b₂.
    fn moments(&self) -> [f64; 2] {
        let [_, thigh, shank] = self.links;
        [
            (0.5 * thigh.mass + shank.mass) * thigh.length,
            0.5 * shank.mass * shank.length,
        ]
    }

    /// J₁ and J₂: about the upper ends, with the shank's mass at the knee.
    fn inertias(&self) -> [f64; 2] {
        let about = |Link { mass, length }: Link| {
            mass * (self.radius.powi(2) / 4.0 + length * length / 3.0)
        };
        let [_, thigh, shank] = self.links;
        [
            about(thigh) + shank.mass * thigh.length.powi(2),
            about(shank),
        ]
    }

    /// Height (m) of the centre of mass.
    pub(super) fn centre(&self, [y, thigh, shank]: [f64; 3]) -> f64 {
        let [b1, b2] = self.moments();
        y - 2.0 * (b1 * thigh.cos() + b2 * shank.cos()) / self.mass()
    }

    /// Where a foot is (m), outwards of the hip and up, and its rates by the angles.
    fn foot(&self, [y, thigh, shank]: [f64; 3]) -> ([f64; 2], [[f64; 2]; 2]) {
        let [_, l1, l2] = self.links.map(|link| link.length);
        let ((s1, c1), (s2, c2)) = (thigh.sin_cos(), shank.sin_cos());
        (
            [-l1 * s1 - l2 * s2, y - l1 * c1 - l2 * c2],
            [[-l1 * c1, l1 * s1], [-l2 * c2, l2 * s2]],
        )
    }

    /// The ground under a robot at rest: it carries the weight, the feet so much of it that the
    /// joints are as still as that can make them.
    pub(super) fn stand(&self, place: [f64; 3]) -> Ground {
        let [b1, b2] = self.moments();
        let (foot, by) = self.foot(place);
        let weights = [b1 * place[1].sin(), b2 * place[2].sin()].map(|b| GRAVITY * b);
        // Hips turn both links, knees the shank.
        let joints = |[first, second]: [f64; 2]| [first + second, second];
        let (lift, weight) = (joints([by[0][1], by[1][1]]), joints(weights));
        let load =
            (lift[0] * weight[0] + lift[1] * weight[1]) / (lift[0].powi(2) + lift[1].powi(2));
        let load = load.max(0.0);
        let rest = (0.5 * self.mass() * GRAVITY - load).max(0.0);
        let k = self.stiffness();
        Ground {
            height: [place[0] + rest / k, foot[1] + load / k],
            hold: None,
        }
    }

    fn stiffness(&self) -> f64 {
        self.mass() * GRAVITY / GIVES_WAY
    }

    /// What the ground does to a point at a place and with a rate: a spring and a damper, upwards
    /// where it is below, and along as far as friction goes from where it is held.
    fn push(&self, place: [f64; 2], rate: [f64; 2], height: f64, hold: (Option<f64>, f64)) -> Push {
        let k = self.stiffness();
        let c = CONTACT_DAMPING * (k * self.mass()).sqrt();
        let normal = k * (height - place[1]) - c * rate[1];
        if place[1] >= height || normal <= 0.0 {
            return Push {
                force: [0.0; 2],
                left: f64::NAN,
            };
        }
        let (held, grip) = (hold.0.unwrap_or(place[0]), hold.1 * normal);
        let along = (-k * (place[0] - held) - c * rate[0]).clamp(-grip, grip);
        Push {
            force: [along, normal],
            left: -(along + c * rate[0]) / k,
        }
    }

    fn under_foot(
        &self,
        place: [f64; 3],
        rate: [f64; 3],
        ground: &Ground,
    ) -> (Push, [[f64; 2]; 2]) {
        let (foot, by) = self.foot(place);
        let speed = [0, 1].map(|k| by[0][k] * rate[1] + by[1][k] * rate[2]);
        let speed = [speed[0], speed[1] + rate[0]];
        (
            self.push(foot, speed, ground.height[1], (ground.hold, self.grip)),
            by,
        )
    }

    /// Where friction holds a foot after a step: where it was, or so that the spring is as long as
    /// friction allows.
    pub(super) fn settle(&self, place: [f64; 3], rate: [f64; 3], ground: &mut Ground) {
        let (push, _) = self.under_foot(place, rate, ground);
        let at = self.foot(place).0[0];
        ground.hold = (!push.left.is_nan()).then_some(at - push.left);
    }

    /// Accelerations with torques (N m) of the muscles that pull hip and knee straight.
    pub(super) fn accelerations(
        &self,
        place: [f64; 3],
        rate: [f64; 3],
        pulls: [f64; 2],
        ground: &Ground,
    ) -> [f64; 3] {
        let ([b1, b2], [j1, j2]) = (self.moments(), self.inertias());
        let [_, thigh, _] = self.links;
        let ((s1, c1), (s2, c2)) = (place[1].sin_cos(), place[2].sin_cos());
        let (sd, cd) = (place[1] - place[2]).sin_cos();
        let torso = self.push(
            [0.0, place[0]],
            [0.0, rate[0]],
            ground.height[0],
            (None, 0.0),
        );
        let (foot, by) = self.under_foot(place, rate, ground);
        // Hips are straight at 0 and come from below, knees from above.
        let torques = [
            (0, place[1], rate[1], 1.0),
            (1, place[2] - place[1], rate[2] - rate[1], -1.0),
        ]
        .map(|(k, angle, turns, side): (usize, f64, f64, f64)| {
            let joint = &self.joints[k];
            let beyond = (side * angle - joint.spring[1]).max(0.0);
            side * (pulls[k] - joint.spring[0] * beyond)
                - joint.damping * turns
                - joint.friction * (turns / CREEP).tanh()
        });
        let of_foot = |k: usize| by[k][0] * foot.force[0] + by[k][1] * foot.force[1];
        let half = 0.5 * self.mass();
        let couple = b2 * thigh.length;
        let forces = [
            torso.force[1] + foot.force[1]
                - half * GRAVITY
                - b1 * c1 * rate[1].powi(2)
                - b2 * c2 * rate[2].powi(2),
            torques[0] - torques[1] + of_foot(0)
                - b1 * s1 * GRAVITY
                - couple * sd * rate[2].powi(2),
            torques[1] + of_foot(1) - b2 * s2 * GRAVITY + couple * sd * rate[1].powi(2),
        ];
        let (o1, o2) = (b1 * s1, b2 * s2);
        solve(
            [[half, o1, o2], [o1, j1, couple * cd], [o2, couple * cd, j2]],
            forces,
        )
    }

    /// Kinetic and potential energy (J), without that of ground and springs.
    #[cfg(test)]
    fn energy(&self, place: [f64; 3], rate: [f64; 3]) -> f64 {
        let ([b1, b2], [j1, j2]) = (self.moments(), self.inertias());
        let ([_, w1, w2], [s1, s2]) = (rate, [place[1].sin(), place[2].sin()]);
        let moving = 0.5 * self.mass() * rate[0].powi(2)
            + j1 * w1 * w1
            + j2 * w2 * w2
            + 2.0 * rate[0] * (b1 * s1 * w1 + b2 * s2 * w2)
            + 2.0 * b2 * self.links[1].length * (place[1] - place[2]).cos() * w1 * w2;
        moving + self.mass() * GRAVITY * self.centre(place)
    }
}

/// The solution of three equations, by Cramer's rule.
fn solve(m: [[f64; 3]; 3], f: [f64; 3]) -> [f64; 3] {
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    // The matrix is symmetric: its rows are its columns.
    let [a, b, c] = m;
    let whole = dot(a, cross(b, c));
    [
        dot(f, cross(b, c)) / whole,
        dot(a, cross(f, c)) / whole,
        dot(a, cross(b, f)) / whole,
    ]
}

#[cfg(test)]
mod tests {
    use super::super::super::motion::rk4;
    use super::*;

    fn jumper() -> Jumper {
        let joint = Joint {
            spring: [0.0, 0.0],
            damping: 0.0,
            friction: 0.0,
        };
        let link = |mass, length| Link { mass, length };
        Jumper {
            links: [link(1.0, 0.55), link(0.5, 0.5), link(0.3, 0.6)],
            radius: 0.02,
            joints: [joint; 2],
            grip: 0.9,
        }
    }

    fn go(jumper: &Jumper, ground: &Ground, y: &mut [f64; 6], steps: u32, h: f64) {
        for _ in 0..steps {
            let rates = |_: f64, y: &[f64; 6]| {
                let (place, rate) = ([y[0], y[1], y[2]], [y[3], y[4], y[5]]);
                let [a, b, c] = jumper.accelerations(place, rate, [0.0; 2], ground);
                [y[3], y[4], y[5], a, b, c]
            };
            *y = rk4(rates, 0.0, y, h);
        }
    }

    /// In the air energy stays, and the centre of mass falls on a parabola, however the legs swing.
    #[test]
    fn a_flight_keeps_its_energy_and_its_parabola() {
        let jumper = jumper();
        let ground = Ground {
            height: [-9.0; 2],
            hold: None,
        };
        let start = [0.3, -2.0, 0.4, 2.0, 9.0, -14.0];
        let mut y = start;
        go(&jumper, &ground, &mut y, 4000, 1e-4);
        let energy = |y: &[f64; 6]| jumper.energy([y[0], y[1], y[2]], [y[3], y[4], y[5]]);
        assert!((energy(&y) - energy(&start)).abs() < 1e-8 * energy(&start).abs());
        let height = |y: &[f64; 6]| jumper.centre([y[0], y[1], y[2]]);
        let mut later = start;
        go(&jumper, &ground, &mut later, 1, 1e-6);
        let climbs = (height(&later) - height(&start)) / 1e-6 + 0.5e-6 * GRAVITY;
        let parabola = height(&start) + 0.4 * climbs - 0.5 * GRAVITY * 0.16;
        // The first speed is a difference of heights with 16 digits.
        assert!(
            (height(&y) - parabola).abs() < 1e-8,
            "{} {parabola}",
            height(&y)
        );
        // The legs did swing.
        assert!(
            (y[1] - start[1]).abs() > 1.0 && (y[2] - start[2]).abs() > 1.0,
            "{y:?}"
        );
    }

    /// The ground carries the weight of a robot at rest, which hardly moves on it at first.
    #[test]
    fn a_robot_stands_on_its_ground() {
        let jumper = jumper();
        let place = [0.0, -2.5, 0.15];
        let mut ground = jumper.stand(place);
        jumper.settle(place, [0.0; 3], &mut ground);
        let (foot, by) = jumper.under_foot(place, [0.0; 3], &ground);
        let torso = jumper.push([0.0; 2], [0.0; 2], ground.height[0], (None, 0.0));
        let carried = 2.0 * (foot.force[1] + torso.force[1]);
        assert!(
            (carried / (jumper.mass() * GRAVITY) - 1.0).abs() < 1e-12,
            "{carried}"
        );
        assert!(foot.force[0].abs() < 1e-12 && ground.hold.is_some());
        // What is left in the joints is across what feet can do: no load would leave less.
        let turns = |load: f64| {
            let weights = jumper.moments();
            let shank = load * by[1][1] - GRAVITY * weights[1] * place[2].sin();
            let thigh = load * by[0][1] - GRAVITY * weights[0] * place[1].sin();
            (thigh + shank).powi(2) + shank.powi(2)
        };
        let load = foot.force[1];
        assert!(turns(load) < turns(1.01 * load) && turns(load) < turns(0.99 * load));
    }

    /// A foot that is pulled harder than friction holds slides with the friction's force, and its
    /// hold follows.
    #[test]
    fn a_foot_slides() {
        let jumper = Jumper {
            grip: 0.3,
            ..jumper()
        };
        let place = [0.0, -2.5, 0.15];
        let mut ground = jumper.stand(place);
        let (foot, _) = jumper.foot(place);
        ground.hold = Some(foot[0] - 0.02);
        let (push, _) = jumper.under_foot(place, [0.0; 3], &ground);
        assert!(
            (push.force[0] + 0.3 * push.force[1]).abs() < 1e-9,
            "{:?}",
            push.force
        );
        jumper.settle(place, [0.0; 3], &mut ground);
        let (held, _) = jumper.under_foot(place, [0.0; 3], &ground);
        let spring = jumper.stiffness() * (foot[0] - ground.hold.unwrap_or(f64::NAN));
        assert!(
            (spring + held.force[0]).abs() < 1e-9,
            "{spring} {:?}",
            held.force
        );
    }
}
