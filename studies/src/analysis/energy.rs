//! Where the energy of a run goes.

use saltus_gait::Summary;
use saltus_robot::Robot;

/// The energy of a run (J), part by part. What comes in, `gas` and `outside`, is what goes out and
/// what is left: [`Energy::unexplained`] is round-off of the simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct Energy {
    /// Exergy of the gas that the supply gave: m R T ln(P_s/P_a), the most work that it could do.
    pub gas: f64,
    /// Of it, what the legs did not turn into work: lost in valves and with the exhaust, or still in
    /// the chambers.
    pub valves: f64,
    /// Work of each leg's drive.
    pub leg_work: Vec<f64>,
    /// Lost in each leg: in friction and dampers, and what its spring holds at the end.
    pub leg_loss: Vec<f64>,
    /// Lost in other joints: the axle's friction, the boom's bend.
    pub joints: f64,
    /// Lost where feet slip.
    pub slip: f64,
    /// Lost in impacts on the ground and on obstacles.
    pub impacts: f64,
    /// Lost in impacts of legs on their stops.
    pub stops: f64,
    /// Lost to the air.
    pub drag: f64,
    /// Work of what pushes from outside.
    pub outside: f64,
    /// What motion, height and springs have more than at the start.
    pub gained: f64,
    /// Travel (m), backwards or forwards.
    pub way: f64,
}

impl Energy {
    /// That of the run of `robot` that came to `summary`.
    pub fn of(robot: &Robot, summary: &Summary) -> Energy {
        let (start, end) = (&summary.start, &summary.ledger);
        let work: f64 = summary.leg_work.iter().sum();
        let gas = robot.leg.cylinder().map_or(work, |cylinder| {
            let ambient = robot.environment.ambient;
            let ratio = cylinder.supply.absolute(ambient).0 / ambient.0;
            summary.gas * cylinder.gas.constant * cylinder.temperature * ratio.ln()
        });
        let stored = |l: &saltus_sim_check::Ledger| l.kinetic + l.potential + l.springs;
        let stops = end.stops - start.stops;
        Energy {
            gas,
            valves: gas - work,
            leg_work: summary.leg_work.clone(),
            leg_loss: summary.leg_loss.clone(),
            joints: end.joints - start.joints - summary.leg_loss.iter().sum::<f64>(),
            slip: end.contacts - start.contacts,
            impacts: end.impacts - start.impacts - stops,
            stops,
            drag: end.drag - start.drag,
            outside: end.outside - start.outside,
            gained: stored(end) - stored(start),
            way: summary.travel.abs(),
        }
    }

    /// All that is lost (J): in valves, legs, joints, by slip, impacts, stops and to the air.
    pub fn lost(&self) -> f64 {
        let legs: f64 = self.leg_loss.iter().sum();
        self.valves + legs + self.joints + self.slip + self.impacts + self.stops + self.drag
    }

    /// What no part explains (J): what came in, less what is lost and gained.
    pub fn unexplained(&self) -> f64 {
        self.gas + self.outside - self.lost() - self.gained
    }
}
