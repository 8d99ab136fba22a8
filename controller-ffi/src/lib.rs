//! The controller for programs in C: a static library and its header,
//! `include/saltus_controller_ffi.h`.
//!
//! Tables are those of `saltus export`, handed over in a [`SaltusController`]. Every function takes
//! pointers, reads what they point to, and returns a [`SaltusStatus`]; a null pointer, too, gets a
//! reason. Nothing allocates or panics.

#![cfg_attr(not(feature = "std"), no_std)]

use saltus_controller::qp::{self, HalfPlane};
use saltus_controller::{
    Approach, Axis, Controller, FiringTable, Guess, Input, LiftOffMap, Limits, MAP_NODE, NoTakeOff,
    Observer, Obstacle, Rates, Reason, Robot, Rule, Sensed, Task, Timing,
};

/// A value, or the reason why there is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum SaltusStatus {
    /// A value.
    Ok = 0,
    /// Outside what the tables were made for.
    OutOfTable = 1,
    /// Inside, but no jump does what is asked.
    Infeasible = 2,
    /// A number that is no measurement, or a pointer that points nowhere.
    SensorInvalid = 3,
    /// Take-off: the obstacle is too far yet; ask again at the next touch-down.
    AskLater = 4,
}

/// Which number of a [`SaltusApproach`] there is no take-off for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum SaltusInput {
    /// None of them alone: no jump clears this obstacle.
    None = 0,
    /// The distance.
    Distance = 1,
    /// The height.
    Height = 2,
    /// The length.
    Length = 3,
    /// The speed.
    Speed = 4,
    /// The clearance.
    Clearance = 5,
}

/// When to command the valve, counted from the reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum SaltusTiming {
    /// Not within this control period, but after the time.
    Wait = 0,
    /// Within this control period, the time after the reading.
    Fire = 1,
    /// The instant passed by the time.
    Late = 2,
}

/// Evenly spaced nodes.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct SaltusAxis {
    /// The first node.
    pub first: f32,
    /// The last node.
    pub last: f32,
    /// Nodes in a unit.
    pub per_unit: f32,
    /// How many nodes.
    pub count: u32,
}

/// What a robot decides by: tables as `saltus export` writes them.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct SaltusController {
    /// Rates (rad/s) of table and map, at the reference lean.
    pub rates: SaltusAxis,
    /// Distances (m) of the table.
    pub distances: SaltusAxis,
    /// Firing angles (rad) of the map.
    pub angles: SaltusAxis,
    /// The table: four numbers a node, as many nodes as rates times distances.
    pub table_nodes: *const [f32; 4],
    /// Its cells.
    pub table_open: *const u8,
    /// The map: twenty numbers a node, as many nodes as rates times angles.
    pub map_nodes: *const [f32; 20],
    /// Its cells.
    pub map_open: *const u8,
    /// Foot to wheel centre (m).
    pub radius: f32,
    /// At the axle (m/s²).
    pub gravity: f32,
    /// m g r/(I + m r²) (1/s²).
    pub pendulum: f32,
    /// Lean (rad) at which the rates of table and map count.
    pub reference_lean: f32,
    /// Least approach rate (rad/s).
    pub least_rate: f32,
    /// Greatest approach rate (rad/s).
    pub greatest_rate: f32,
    /// Whether approach rates count at the firing angle; else at the reference lean.
    pub at_firing: bool,
    /// From one touch-down to the next (m).
    pub stride: f32,
    /// Valve opening time (s) of the tables.
    pub valve_open: f32,
    /// Of the wheel's centre (m).
    pub landing_height: f32,
    /// Control period (s).
    pub period: f32,
    /// Of the valve, beyond the robot file's (s).
    pub extra_delay: f32,
    /// Least valve opening time (s).
    pub least_valve_open: f32,
    /// Greatest valve opening time (s).
    pub greatest_valve_open: f32,
    /// Cost of a squared second of open valve (m²/s²).
    pub effort: f32,
    /// Newton steps, 0 to 3.
    pub newton_steps: u8,
}

/// Lean (rad) and lean rate (rad/s) of the loaded leg.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct SaltusSensed {
    /// Lean (rad).
    pub lean: f32,
    /// Its rate (rad/s).
    pub rate: f32,
}

/// A box on the ground.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct SaltusObstacle {
    /// From the foot to its front (m).
    pub front: f32,
    /// From the foot to its back (m).
    pub back: f32,
    /// Its height (m).
    pub height: f32,
    /// Least distance of the wheel to keep (m).
    pub clearance: f32,
}

/// Firing angle (rad) and valve opening time (s) to start from.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct SaltusGuess {
    /// Firing angle (rad).
    pub firing_angle: f32,
    /// Valve opening time (s).
    pub valve_open: f32,
}

/// What is wanted of a jump.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct SaltusTask {
    /// Distance (m) from the foot to the landing.
    pub distance: f32,
    /// Height of the wheel's centre there (m).
    pub landing_height: f32,
    /// What is to be cleared; or null.
    pub obstacle: *const SaltusObstacle,
    /// Over an obstacle, the last decision on the same jump; or null.
    pub guess: *const SaltusGuess,
}

/// A firing decision.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct SaltusDecision {
    /// Approach rate (rad/s), counted as `at_firing` says.
    pub approach_rate: f32,
    /// Firing angle (rad).
    pub firing_angle: f32,
    /// Valve opening time (s).
    pub valve_open: f32,
    /// Time (s) of `timing`.
    pub time: f32,
    /// When to command the valve.
    pub timing: SaltusTiming,
    /// Whether the jump clears what it should.
    pub settled: bool,
}

/// A running robot before an obstacle.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct SaltusApproach {
    /// From the next touch-down's foot to the obstacle's front (m).
    pub distance: f32,
    /// Height of the obstacle (m).
    pub height: f32,
    /// Its length along the travel (m).
    pub length: f32,
    /// Running speed of the axle (m/s).
    pub speed: f32,
    /// Least distance to keep (m).
    pub clearance: f32,
}

/// Where and how to take off.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct SaltusTakeOff {
    /// From which touch-down; 0 is the next.
    pub touch_down: u32,
    /// Approach rate (rad/s).
    pub approach_rate: f32,
    /// Firing angle (rad).
    pub firing_angle: f32,
    /// From that touch-down's foot to the landing (m).
    pub distance: f32,
    /// What the jump keeps (m).
    pub clearance: f32,
}

/// normal · x ≤ bound.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct SaltusHalfPlane {
    /// a.
    pub normal: [f32; 2],
    /// b.
    pub bound: f32,
}

/// Most constraints of a quadratic program.
pub const SALTUS_MOST_CONSTRAINTS: usize = 16;

impl From<Reason> for SaltusStatus {
    fn from(reason: Reason) -> SaltusStatus {
        match reason {
            Reason::OutOfTable => SaltusStatus::OutOfTable,
            Reason::Infeasible => SaltusStatus::Infeasible,
            Reason::SensorInvalid => SaltusStatus::SensorInvalid,
            Reason::AskLater => SaltusStatus::AskLater,
        }
    }
}

impl From<Option<Input>> for SaltusInput {
    fn from(input: Option<Input>) -> SaltusInput {
        match input {
            None => SaltusInput::None,
            Some(Input::Distance) => SaltusInput::Distance,
            Some(Input::Height) => SaltusInput::Height,
            Some(Input::Length) => SaltusInput::Length,
            Some(Input::Speed) => SaltusInput::Speed,
            Some(Input::Clearance) => SaltusInput::Clearance,
        }
    }
}

impl From<SaltusAxis> for Axis<f32> {
    fn from(a: SaltusAxis) -> Axis<f32> {
        Axis {
            first: a.first,
            last: a.last,
            per_unit: a.per_unit,
            count: a.count as usize,
        }
    }
}

impl SaltusController {
    /// The controller behind it.
    ///
    /// # Safety
    /// Its pointers are null, or point to as many nodes and cells as its axes say.
    unsafe fn view(&self) -> Controller<'_, f32> {
        let (rates, distances, angles) =
            (self.rates.into(), self.distances.into(), self.angles.into());
        // SAFETY: as the caller promises.
        let (table, map) = unsafe {
            (
                (
                    nodes(self.table_nodes, &rates, &distances),
                    cells(self.table_open, &rates, &distances),
                ),
                (
                    nodes::<MAP_NODE>(self.map_nodes, &rates, &angles),
                    cells(self.map_open, &rates, &angles),
                ),
            )
        };
        Controller {
            rule: Rule::Table(FiringTable {
                rates,
                distances,
                nodes: table.0,
                open: table.1,
            }),
            map: LiftOffMap {
                rates,
                angles,
                nodes: map.0,
                open: map.1,
            },
            rates: Rates {
                least: self.least_rate,
                greatest: self.greatest_rate,
                reference_lean: self.reference_lean,
                at_firing: self.at_firing,
            },
            robot: Robot {
                radius: self.radius,
                gravity: self.gravity,
                pendulum: self.pendulum,
                stride: self.stride,
                valve_open: self.valve_open,
                landing_height: self.landing_height,
            },
            limits: Limits {
                period: self.period,
                extra_delay: self.extra_delay,
                newton_steps: self.newton_steps,
                least_valve_open: self.least_valve_open,
                greatest_valve_open: self.greatest_valve_open,
                effort: self.effort,
            },
        }
    }
}

/// As many nodes as two axes have; none behind a null pointer.
///
/// # Safety
/// `first` is null or points to as many.
unsafe fn nodes<'a, const N: usize>(
    first: *const [f32; N],
    a: &Axis<f32>,
    b: &Axis<f32>,
) -> &'a [[f32; N]] {
    match a.count.checked_mul(b.count) {
        // SAFETY: as the caller promises; a count whose bytes are more than memory holds is
        // refused.
        Some(count) if !first.is_null() && count < isize::MAX as usize / (4 * N) => unsafe {
            core::slice::from_raw_parts(first, count)
        },
        _ => &[],
    }
}

/// As many cells as two axes have; none behind a null pointer.
///
/// # Safety
/// `first` is null or points to as many.
unsafe fn cells<'a>(first: *const u8, a: &Axis<f32>, b: &Axis<f32>) -> &'a [u8] {
    match a
        .count
        .saturating_sub(1)
        .checked_mul(b.count.saturating_sub(1))
    {
        // SAFETY: as the caller promises.
        Some(count) if !first.is_null() && count < isize::MAX as usize => unsafe {
            core::slice::from_raw_parts(first, count)
        },
        _ => &[],
    }
}

/// Whether and when to open the valve now, and how long for.
///
/// # Safety
/// Each pointer is null or points to what its type says, tables as large as their axes say;
/// `decision` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn saltus_controller_decide(
    controller: *const SaltusController,
    sensed: *const SaltusSensed,
    task: *const SaltusTask,
    decision: *mut SaltusDecision,
) -> SaltusStatus {
    // SAFETY: as the caller promises; null becomes none.
    let given = unsafe {
        (
            controller.as_ref(),
            sensed.as_ref(),
            task.as_ref(),
            decision.as_mut(),
        )
    };
    let (Some(controller), Some(sensed), Some(task), Some(decision)) = given else {
        return SaltusStatus::SensorInvalid;
    };
    // SAFETY: as the caller promises.
    let (obstacle, guess, controller) = unsafe {
        (
            task.obstacle.as_ref(),
            task.guess.as_ref(),
            controller.view(),
        )
    };
    let task = Task {
        distance: task.distance,
        landing_height: task.landing_height,
        obstacle: obstacle.map(|o| Obstacle {
            front: o.front,
            back: o.back,
            height: o.height,
            clearance: o.clearance,
        }),
        guess: guess.map(|g| Guess {
            firing_angle: g.firing_angle,
            valve_open: g.valve_open,
        }),
    };
    match controller.decide(
        &Sensed {
            lean: sensed.lean,
            rate: sensed.rate,
        },
        &task,
    ) {
        Err(reason) => reason.into(),
        Ok(d) => {
            let (timing, time) = match d.timing {
                Timing::Wait(time) => (SaltusTiming::Wait, time),
                Timing::Fire(time) => (SaltusTiming::Fire, time),
                Timing::Late(time) => (SaltusTiming::Late, time),
            };
            *decision = SaltusDecision {
                approach_rate: d.approach_rate,
                firing_angle: d.firing_angle,
                valve_open: d.valve_open,
                time,
                timing,
                settled: d.settled,
            };
            SaltusStatus::Ok
        }
    }
}

/// The firing angle (rad) for an approach rate (rad/s), a distance (m) and a landing height (m).
///
/// # Safety
/// As [`saltus_controller_decide`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn saltus_controller_firing_angle(
    controller: *const SaltusController,
    rate: f32,
    distance: f32,
    height: f32,
    angle: *mut f32,
) -> SaltusStatus {
    // SAFETY: as the caller promises; null becomes none.
    let (Some(controller), Some(angle)) = (unsafe { (controller.as_ref(), angle.as_mut()) }) else {
        return SaltusStatus::SensorInvalid;
    };
    // SAFETY: as the caller promises.
    match unsafe { controller.view() }.firing_angle(rate, distance, height) {
        Err(reason) => reason.into(),
        Ok(found) => {
            *angle = found;
            SaltusStatus::Ok
        }
    }
}

/// From which of the next four touch-downs to jump, and at which angle; `input` says which number
/// there is no take-off for.
///
/// # Safety
/// As [`saltus_controller_decide`]; `input` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn saltus_controller_take_off(
    controller: *const SaltusController,
    approach: *const SaltusApproach,
    take_off: *mut SaltusTakeOff,
    input: *mut SaltusInput,
) -> SaltusStatus {
    // SAFETY: as the caller promises; null becomes none.
    let given = unsafe { (controller.as_ref(), approach.as_ref(), take_off.as_mut()) };
    let (Some(controller), Some(a), Some(take_off)) = given else {
        return SaltusStatus::SensorInvalid;
    };
    let approach = Approach {
        distance: a.distance,
        height: a.height,
        length: a.length,
        speed: a.speed,
        clearance: a.clearance,
    };
    let mut ignored = SaltusInput::None;
    // SAFETY: as the caller promises; null becomes none.
    let input = unsafe { input.as_mut() }.unwrap_or(&mut ignored);
    // SAFETY: as the caller promises.
    match unsafe { controller.view() }.take_off(&approach) {
        Err(NoTakeOff {
            reason,
            input: which,
        }) => {
            *input = which.into();
            reason.into()
        }
        Ok(t) => {
            *input = SaltusInput::None;
            *take_off = SaltusTakeOff {
                touch_down: t.touch_down,
                approach_rate: t.approach_rate,
                firing_angle: t.firing_angle,
                distance: t.distance,
                clearance: t.clearance,
            };
            SaltusStatus::Ok
        }
    }
}

/// Minimises x' H x/2 + g' x under at most 16 constraints; `h` points to H11, H12, H22, `g` and `x`
/// to two numbers.
///
/// # Safety
/// Each pointer is null or points to as many numbers and constraints; `x` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn saltus_controller_qp2(
    h: *const [f32; 3],
    g: *const [f32; 2],
    constraints: *const SaltusHalfPlane,
    count: usize,
    x: *mut [f32; 2],
) -> SaltusStatus {
    // SAFETY: as the caller promises; null becomes none.
    let given = unsafe { (h.as_ref(), g.as_ref(), x.as_mut()) };
    let (Some(h), Some(g), Some(x)) = given else {
        return SaltusStatus::SensorInvalid;
    };
    if count > SALTUS_MOST_CONSTRAINTS || (count > 0 && constraints.is_null()) {
        return SaltusStatus::SensorInvalid;
    }
    let mut planes = [HalfPlane {
        normal: [0.0; 2],
        bound: 0.0,
    }; SALTUS_MOST_CONSTRAINTS];
    for (k, plane) in planes.iter_mut().enumerate().take(count) {
        // SAFETY: k < count, and the caller promises as many.
        let SaltusHalfPlane { normal, bound } = unsafe { *constraints.add(k) };
        *plane = HalfPlane { normal, bound };
    }
    match qp::two(*h, *g, planes.get(..count).unwrap_or(&[])) {
        Ok(found) => {
            *x = found;
            SaltusStatus::Ok
        }
        Err(reason) => reason.into(),
    }
}

/// Follows the lean of a pivoting wheel through an encoder's reading `lean` (rad); `pendulum`
/// (1/s²), `period` (s), `memory` from 0 to below 1.
///
/// # Safety
/// `state` is null or may be read and written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn saltus_controller_observe(
    state: *mut SaltusSensed,
    lean: f32,
    pendulum: f32,
    period: f32,
    memory: f32,
) {
    // SAFETY: as the caller promises; null becomes none.
    let Some(state) = (unsafe { state.as_mut() }) else {
        return;
    };
    let sensed = Sensed {
        lean: state.lean,
        rate: state.rate,
    };
    let mut observer = Observer {
        sensed,
        period,
        pendulum,
        memory,
    };
    observer.update(lean);
    *state = SaltusSensed {
        lean: observer.sensed.lean,
        rate: observer.sensed.rate,
    };
}

/// Never runs: the linked program has no call to it, which `check.sh` looks for.
#[cfg(all(not(feature = "std"), not(test)))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}
