//! The simulation's report as a jump of the page.

use saltus::Robot;
use saltus::sim_check::{Pose, Report, Rig, Sample, Surface};

use super::{Event, Frame, Jump, Obstacle, Scene};

/// Slip slower than this (m/s) is none.
const STILL: f64 = 1e-9;
/// Radius of the hub as a part of the wheel's: no robot file says.
const HUB: f64 = 0.25;
/// Length of the rod of a leg that has none, as a part of the wheel's radius.
const ROD: f64 = 0.4;

/// Radius of the hub of `robot` and length of its rods (m), as they are drawn.
pub(crate) fn sizes(robot: &Robot) -> [f64; 2] {
    let radius = robot.body.radius;
    let rod = Some(robot.leg.body.length).filter(|length| *length > 0.0);
    let rod = rod.unwrap_or(ROD * radius);
    [HUB * radius, rod.min((1.0 - HUB) * radius)]
}

impl Scene {
    /// A scene of `robot` among `obstacles`.
    pub(crate) fn of(
        robot: &Robot,
        title: String,
        obstacles: Vec<Obstacle>,
        jumps: Vec<Jump>,
    ) -> Scene {
        let [hub_radius_m, rod_length_m] = sizes(robot);
        Scene {
            robot: robot.name.clone(),
            title,
            wheel_radius_m: robot.body.radius,
            hub_radius_m,
            legs: robot.body.legs as usize,
            rod_length_m,
            boom_length_m: robot.boom.map(|boom| boom.length),
            slope_rad: robot.ground.slope,
            obstacles,
            avoid: Vec::new(),
            zones: Vec::new(),
            jumps,
        }
    }
}

impl Jump {
    /// What was `asked` of a jump with its simulation, the `report` of `rig`. It ends where the axle comes down to the
    /// landing height (m): the rig's radius, or the `landing_height` of the simulation's plan.
    pub(crate) fn of(rig: &Rig, report: &Report, landing_height: f64, asked: Jump) -> Jump {
        let mut frames = frames(rig, report);
        let at_standing = (landing_height - rig.radius).abs() < 1e-12;
        let land_m = if at_standing {
            report.landing
        } else {
            report.landing_at
        };
        let mut events = stance_events(report);
        let lift_off = report.lift_off.map_or(f64::INFINITY, |l| l.time);
        if report.apex.is_finite() {
            let flight = frames.iter().filter(|frame| frame.time_s >= lift_off);
            if let Some(top) = flight
                .max_by(|a, b| a.axle_m[1].total_cmp(&b.axle_m[1]))
                .map(|f| f.time_s)
            {
                events.push(event(top, "apex"));
                if land_m.is_finite() {
                    end_at_landing(&mut frames, top, landing_height);
                    events.extend(frames.last().map(|frame| event(frame.time_s, "landing")));
                }
            }
        }
        events.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        Jump {
            apex_m: report.apex,
            land_m,
            frames,
            events,
            ..asked
        }
    }

    /// Moves it from the origin to its foothold (m along the course, and up).
    pub(crate) fn stand_at(&mut self, foot: [f64; 2], boom: Option<f64>) {
        let [x, y] = foot;
        let moved = |place: &mut [f64; 2]| *place = [place[0] + x, place[1] + y];
        self.planned.iter_mut().for_each(moved);
        moved(&mut self.foothold_m);
        for frame in &mut self.frames {
            moved(&mut frame.axle_m);
            moved(&mut frame.foot_m);
            if let (Some(angles), Some(length)) = (&mut frame.boom, boom) {
                angles[0] += x / length;
            }
        }
        self.planned_apex_m += y;
        self.apex_m += y;
        self.planned_land_m += x;
        self.land_m += x;
    }
}

fn event(time_s: f64, what: &str) -> Event {
    Event {
        time_s,
        what: what.into(),
    }
}

/// Firing, slip, stick and lift-off; slips after the first to the nearest sample.
fn stance_events(report: &Report) -> Vec<Event> {
    let mut events = Vec::new();
    let slipping = |sample: &Sample| sample.slip[0].abs() > STILL;
    for pair in standing(report).windows(2) {
        match (slipping(&pair[0]), slipping(&pair[1])) {
            (false, true) => {
                let exact = report
                    .slips_at
                    .filter(|t| (pair[0].time..=pair[1].time).contains(t));
                events.push(event(exact.unwrap_or(pair[1].time), "slip"));
            }
            (true, false) => events.push(event(pair[1].time, "stick")),
            _ => {}
        }
    }
    if let Some(at) = report
        .slips_at
        .filter(|_| !events.iter().any(|event| event.what == "slip"))
    {
        events.push(event(at, "slip"));
    }
    if let Some(lift_off) = report.lift_off {
        events.push(event(lift_off.time_fire, "fire"));
        events.push(event(lift_off.time, "lift-off"));
    }
    events
}

/// The samples before lift-off.
fn standing(report: &Report) -> &[Sample] {
    let lift_off = report.lift_off.map_or(f64::INFINITY, |l| l.time);
    &report.samples[..report
        .samples
        .partition_point(|sample| sample.time < lift_off)]
}

fn frames(rig: &Rig, report: &Report) -> Vec<Frame> {
    let stance = standing(report).len();
    let mut slip = 0.0;
    let mut frames = Vec::with_capacity(report.samples.len());
    for (i, sample) in report.samples.iter().enumerate() {
        let touching = i < stance;
        if let Some(before) = i
            .checked_sub(1)
            .filter(|_| touching)
            .map(|i| &report.samples[i])
        {
            slip += 0.5 * (before.slip[0] + sample.slip[0]) * (sample.time - before.time);
        }
        frames.push(frame(rig, sample, touching, slip));
    }
    frames
}

fn frame(rig: &Rig, sample: &Sample, touching: bool, slip_m: f64) -> Frame {
    let q = &sample.coordinates;
    let slope = slope(rig);
    let [normal, along, _] = if touching { sample.force } else { [0.0; 3] };
    Frame {
        time_s: sample.time,
        axle_m: sample.axle,
        lean_rad: sample.lean,
        extensions_m: (0..rig.legs.len())
            .map(|k| q[rig.extension_coordinate(k)])
            .collect(),
        pressure_pa: sample.pressure,
        foot_m: foot(rig, q),
        force_n: [
            along * slope.cos() - normal * slope.sin(),
            along * slope.sin() + normal * slope.cos(),
        ],
        slip_m,
        touching,
        boom: rig.boom.map(|_| [q[0], q[1]]),
    }
}

/// Travel and height (m) of the jumping foot's nearest point to the ground.
fn foot(rig: &Rig, q: &[f64]) -> [f64; 2] {
    let tree = &rig.mechanism.tree;
    let mut pose = Pose::default();
    pose.set(tree, q, &vec![0.0; tree.velocities()]);
    let point = &rig.mechanism.points[0];
    let mut place = pose.frames[point.body].point(&point.center);
    let slope = slope(rig);
    place.x += point.radius * slope.sin();
    place.z -= point.radius * slope.cos();
    [rig.travel_of(&place), place.z]
}

/// Slope of the rig's ground (rad).
fn slope(rig: &Rig) -> f64 {
    match rig.mechanism.surfaces.first() {
        Some(Surface::Plane { normal, .. }) => (-normal.x).atan2(normal.z),
        _ => 0.0,
    }
}

/// Cuts what is lower than `height` (m) after the time `top` (s), and goes on straight from the
/// last two frames to just there: the simulation stops between samples.
fn end_at_landing(frames: &mut Vec<Frame>, top: f64, height: f64) {
    frames.retain(|frame| frame.time_s <= top || frame.axle_m[1] >= height);
    if let [.., before, last] = frames.as_slice() {
        let share = (height - before.axle_m[1]) / (last.axle_m[1] - before.axle_m[1]);
        if share.is_finite() && share > 1.0 {
            let end = between(before, last, share);
            frames.push(end);
        }
    }
}

/// The frame that is `share` of the way from `a` to `b`, or beyond.
fn between(a: &Frame, b: &Frame, share: f64) -> Frame {
    let mix = |a: f64, b: f64| a + share * (b - a);
    let place = |a: [f64; 2], b: [f64; 2]| [mix(a[0], b[0]), mix(a[1], b[1])];
    Frame {
        time_s: mix(a.time_s, b.time_s),
        axle_m: place(a.axle_m, b.axle_m),
        lean_rad: mix(a.lean_rad, b.lean_rad),
        pressure_pa: b.pressure_pa,
        foot_m: place(a.foot_m, b.foot_m),
        boom: a.boom.zip(b.boom).map(|(a, b)| place(a, b)),
        ..b.clone()
    }
}
