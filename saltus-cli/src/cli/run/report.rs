//! What a run came to, in words and as JSON.

use saltus::gait::{Ending, Setup, Summary, When};
use saltus::running::exergy_of_gas;
use saltus::sim_check::Stepping;
use serde_json::{Value, json};

use super::InPlane;
use super::follow::{Follower, OUT, OnTheWay};
use crate::cli::disturb::Typed;
use crate::output::{self, digits, joined, measured, message};

/// Part of the drives' work from which on what is unexplained is said to be: at 1 ms up to 0.3 % is usual.
const UNSOUND: f64 = 0.02;
/// Energy (J) that says nothing, however little the drives did.
const ROUND_OFF: f64 = 0.5;

/// A run and what it came to.
pub(super) struct Report<'a> {
    pub(super) run: &'a InPlane,
    pub(super) setup: &'a Setup,
    pub(super) summary: &'a Summary,
    pub(super) follower: &'a Follower<'a>,
    /// Whether Ctrl-C ended it.
    pub(super) interrupted: bool,
}

impl Report<'_> {
    /// The run in a line.
    pub(super) fn title(&self) -> String {
        let mut title = format!(
            "{}: {}, {} s",
            self.setup.robot.name,
            self.run.words,
            digits(self.setup.seconds, 6)
        );
        if !self.setup.forwards {
            title += ", backwards";
        }
        title
    }

    /// How it ended, after `the robot`.
    pub(super) fn ending(&self) -> String {
        match self.summary.ending {
            _ if self.interrupted => {
                format!("interrupted at {} s", digits(self.summary.time, 6))
            }
            Ending::Ran => "ran to the end of its time".into(),
            Ending::Stalled { since, at } => format!(
                "stalled: stands still since {} s, at {} m; {}",
                short(since.max(0.0)),
                short(at),
                self.reason()
            ),
        }
    }

    /// Why it stands still.
    fn reason(&self) -> String {
        let Some(last) = &self.follower.last else {
            return "it ran for no cycle".into();
        };
        let lean = digits(last.lean, 3);
        match last.firing_angle {
            _ if self.setup.valve_open == 0.0 => "the valve opening time is 0".into(),
            None => "no leg was to fire".into(),
            Some(angle) if last.lean < angle => format!(
                "leg {} in the active zone leans by {lean} rad, short of its firing angle {} rad",
                last.leg,
                digits(angle, 3)
            ),
            Some(_) => format!(
                "leg {} in the active zone, at {lean} rad, has fired already, and a leg fires once each \
                 time it enters{}",
                last.leg,
                self.stuck()
            ),
        }
    }

    /// Why a leg that fired moved nothing, on ground where feet never slip.
    fn stuck(&self) -> &'static str {
        let grips = self.setup.robot.ground.static_friction.is_infinite();
        if grips && self.summary.firings < 2 {
            "; a leg of two that stand cannot push where no foot slips: give \
             ground.static_friction"
        } else {
            ""
        }
    }

    /// Legs that are out at the end, with their extensions (m).
    fn out(&self) -> Vec<(usize, f64)> {
        let extensions = self
            .follower
            .last
            .as_ref()
            .map(|last| last.extensions.as_slice());
        let legs = extensions.unwrap_or_default().iter().copied().enumerate();
        legs.filter(|(_, extension)| *extension > OUT).collect()
    }

    /// Gas (g/m), and what it could have done (J/m), of the way; none where the robot did not travel a
    /// radius.
    fn per_metre(&self) -> Option<[f64; 2]> {
        let way = self.summary.way;
        let exergy = exergy_of_gas(&self.setup.robot)?;
        let gas = self.summary.gas / way;
        (way > self.setup.robot.body.radius).then_some([gas * 1e3, gas * exergy])
    }

    pub(super) fn text(&self) -> String {
        let mut lines = self.course();
        lines.extend(self.feet());
        lines.extend(self.gas());
        lines.extend(self.energies());
        output::lines(&self.title(), 18, &lines)
    }

    /// How it ended and how fast it was.
    fn course(&self) -> Vec<(&'static str, String)> {
        let s = self.summary;
        let disturb = &self.run.plane.disturb;
        let mut lines = Disturbed::of(disturb, &s.disturbed).lines(s.time);
        lines.push(("ending", self.ending()));
        let stalls = self.follower.stalls;
        if let (Some([time, at]), Ending::Ran) = (stalls.first, s.ending) {
            let first = if stalls.count == 1 { "" } else { "first " };
            let words = format!(
                "{}, {first}noticed at {} s, {} m",
                times(stalls.count),
                short(time),
                short(at)
            );
            lines.push(("stood still", words));
        }
        let mut speeds = format!("{} m/s", short(s.mean_speed));
        if let Some(late) = s.mean_speed_last_4_s.filter(|_| s.time > 4.0) {
            let late = short(late);
            speeds = format!("{speeds}; over the last 4 s {late} m/s");
        }
        lines.extend(self.follower.held.iter().filter_map(|held| {
            let mean = held.mean()?;
            let words = format!(
                "{} m/s from {} s on: {} m/s, mean over the second half of that time",
                short(held.speed),
                short(held.from),
                short(mean)
            );
            Some(("demanded", words))
        }));
        let reached = s.reached_3_2.map(|t| format!("reached at {} s", short(t)));
        lines.extend([
            ("travel", self.travel()),
            ("mean speed", speeds),
            ("top speed", format!("{} m/s", short(s.top_speed))),
            ("speed at the end", format!("{} m/s", short(s.speed_at_end))),
            ("3.2 m/s", reached.unwrap_or("not reached".into())),
        ]);
        let speed = s.speed_at_1_6.map(|speed| format!("{} m/s", short(speed)));
        lines.extend(speed.map(|words| ("speed at 1.6 s", words)));
        let time = s
            .time_to_1_6_m
            .map(|t| format!("reached at {} s", short(t)));
        lines.extend(time.map(|words| ("1.6 m", words)));
        lines.extend(self.follower.boxes.iter().map(|it| ("box", on_the_way(it))));
        lines
    }

    fn travel(&self) -> String {
        let s = self.summary;
        let travel = format!("{} m", short(s.travel));
        if s.way > s.travel.abs() {
            format!("{travel}, on a way of {} m", short(s.way))
        } else {
            travel
        }
    }

    /// What the legs did and what touched.
    fn feet(&self) -> [(&'static str, String); 4] {
        let s = self.summary;
        let touched = format!(
            "{}, of these {} of legs still out by over {} mm",
            s.touch_downs,
            self.follower.out_at_touch_down,
            OUT * 1e3
        );
        let out = self.out();
        let legs: Vec<String> = out
            .iter()
            .map(|(leg, x)| format!("leg {leg} by {} mm", digits(x * 1e3, 3)))
            .collect();
        let legs = if legs.is_empty() {
            "no leg".into()
        } else {
            legs.join(", ")
        };
        [
            ("firings", s.firings.to_string()),
            ("touch-downs", touched),
            ("out at the end", legs),
            ("other contacts", self.bumps()),
        ]
    }

    fn gas(&self) -> Option<(&'static str, String)> {
        exergy_of_gas(&self.setup.robot)?;
        let gas = format!("{} g", short(self.summary.gas * 1e3));
        let words = match self.per_metre() {
            Some([each, exergy]) => {
                format!(
                    "{gas}, {} g/m; its exergy {} J/m",
                    short(each),
                    short(exergy)
                )
            }
            None => gas,
        };
        Some(("gas", words))
    }

    /// Where the energy comes from and goes.
    fn energies(&self) -> Vec<(&'static str, String)> {
        let s = self.summary;
        let l = &s.ledger;
        let work: Vec<String> = s.leg_work.iter().map(|work| short(*work)).collect();
        let mut lines = vec![("work of the legs", format!("{} J", work.join(", ")))];
        let entries = [
            ("drives", l.drive),
            ("from outside", l.outside),
            ("lost in legs", l.joints),
            ("lost by slip", l.contacts),
            ("lost to the air", l.drag),
            ("lost at the ground", l.impacts - l.stops),
            ("lost at end stops", l.stops),
        ];
        let shown = entries
            .into_iter()
            .filter(|(name, x)| *x != 0.0 || !matches!(*name, "from outside" | "lost to the air"));
        lines.extend(shown.map(|(name, x)| (name, format!("{} J", short(x)))));
        let [kinetic, potential, springs] = self.gained();
        let gained = format!(
            "{} J in motion, {} J in height, {} J in springs",
            short(kinetic),
            short(potential),
            short(springs)
        );
        lines.push(("gained", gained));
        let rest = format!(
            "{} J in bodies, {} J in gas",
            digits(-s.residual, 2),
            digits(s.gas_residual, 2)
        );
        lines.push(("unexplained", rest));
        lines.extend(approximate(s.ledger.approximate).map(|words| ("contacts", words)));
        lines
    }

    /// What motion, height and springs have more (J) than at the start.
    fn gained(&self) -> [f64; 3] {
        let (start, end) = (&self.summary.start, &self.summary.ledger);
        [
            end.kinetic - start.kinetic,
            end.potential - start.potential,
            end.springs - start.springs,
        ]
    }

    /// Contacts other than feet on the ground.
    fn bumps(&self) -> String {
        let s = self.summary;
        let Some((time, part, _)) = s.bumps.first() else {
            return "none".into();
        };
        format!(
            "{}, the first of {part} at {} s",
            s.bump_count,
            digits(*time, 4)
        )
    }

    /// Advises shorter steps where more is unexplained than is usual.
    pub(super) fn note_unexplained(&self) {
        let (drives, s) = (self.summary.ledger.drive, self.summary);
        let most = UNSOUND * drives + ROUND_OFF;
        let [bodies, gas] = [s.residual, s.gas_residual].map(f64::abs);
        if bodies.max(gas) > most {
            message(&format!(
                "unexplained are {} J in bodies and {} J in gas, the drives did {} J of work: the steps are too long for \
                 this robot; --step 0.25ms has shorter ones",
                digits(bodies, 2),
                digits(gas, 2),
                digits(drives, 3)
            ));
        }
    }

    pub(super) fn json(&self) -> String {
        output::json(&self.value())
    }

    pub(super) fn value(&self) -> Value {
        let s = self.summary;
        let l = &s.ledger;
        let ending = match s.ending {
            _ if self.interrupted => json!({ "how": "interrupted", "at_s": s.time }),
            Ending::Ran => json!({ "how": "ran" }),
            Ending::Stalled { since, at } => json!({
                "how": "stalled", "since_s": since.max(0.0), "at_m": at, "reason": self.reason(),
            }),
        };
        let out = |(leg, extension): &(usize, f64)| json!({ "leg": leg, "extension_m": extension });
        let bump = |(time, part, surface): &(f64, String, usize)| json!({ "time_s": time, "part": part, "surface": surface });
        let [gas, exergy] = match self.per_metre() {
            Some([gas, exergy]) => [json!(gas * 1e-3), json!(exergy)],
            None => [Value::Null, Value::Null],
        };
        let motion = json!({
            "rear_leg_at_start": s.rear,
            "ending": ending,
            "stalls": self.follower.stalls.count,
            "ran_for_s": s.time,
            "demanded": self.follower.held.iter().map(|held| json!({
                "from_s": held.from, "speed_m_s": held.speed, "mean_of_second_half_m_s": held.mean(),
            })).collect::<Vec<_>>(),
            "travel_m": s.travel,
            "way_m": s.way,
            "mean_speed_m_s": s.mean_speed,
            "mean_speed_last_4_s_m_s": s.mean_speed_last_4_s,
            "speed_at_end_m_s": s.speed_at_end,
            "top_speed_m_s": s.top_speed,
            "reached_3_2_m_s_s": s.reached_3_2,
            "speed_at_1_6_s_m_s": s.speed_at_1_6,
            "time_to_1_6_m_s": s.time_to_1_6_m,
            "boxes": self.follower.boxes.iter().map(box_json).collect::<Vec<_>>(),
            "firings": s.firings,
            "touch_downs": s.touch_downs,
            "touch_downs_of_legs_out": self.follower.out_at_touch_down,
            "legs_out_at_end": self.out().iter().map(out).collect::<Vec<_>>(),
            "other_contacts": s.bump_count,
            "first_other_contacts": s.bumps.iter().map(bump).collect::<Vec<_>>(),
        });
        let [kinetic, potential, springs] = self.gained();
        let energy = json!({
            "gas_kg": s.gas,
            "gas_kg_per_m": gas,
            "exergy_j_per_m": exergy,
            "leg_work_j": s.leg_work,
            "approximate_contacts": l.approximate,
            "ledger_j": {
                "kinetic_gained": kinetic, "potential_gained": potential, "springs_gained": springs,
                "drives": l.drive, "outside": l.outside, "legs": l.joints, "slip": l.contacts,
                "air": l.drag, "impacts_at_ground": l.impacts - l.stops,
                "impacts_at_stops": l.stops, "residual": -s.residual, "gas_residual": s.gas_residual,
            },
        });
        let head = head(self.setup, self.run, &s.disturbed);
        joined([head, motion, energy])
    }
}

/// What disturbed a run, as it was typed, and what was to disturb it and did not.
pub(super) struct Disturbed<'a> {
    pub(super) by: Vec<&'a str>,
    not_by: Vec<&'a Typed>,
}

impl<'a> Disturbed<'a> {
    /// Of `all`, each of which was there or not.
    pub(super) fn of(all: &'a [Typed], met: &[bool]) -> Disturbed<'a> {
        let (by, not_by): (Vec<_>, Vec<_>) = all.iter().zip(met).partition(|(_, met)| **met);
        Disturbed {
            by: by.iter().map(|(typed, _)| typed.text.as_str()).collect(),
            not_by: not_by.iter().map(|(typed, _)| *typed).collect(),
        }
    }

    /// Why each that did not disturb a run of `time` (s) did not.
    pub(super) fn reasons(&self, time: f64) -> impl Iterator<Item = String> {
        self.not_by.iter().map(move |typed| {
            let text = &typed.text;
            match typed.disturbance.when {
                When::Time(from, _) if from >= time => {
                    format!("{text}: the run ends before it, at {} s", digits(time, 6))
                }
                When::Time(..) => format!("{text}: it is shorter than a cycle"),
                When::Place(..) => format!("{text}: the robot does not come there"),
            }
        })
    }

    /// The lines of a report on a run of `time` (s).
    pub(super) fn lines(&self, time: f64) -> Vec<(&'static str, String)> {
        let by = self
            .by
            .iter()
            .map(|text| ("disturbed by", (*text).to_owned()));
        let not_by = self
            .reasons(time)
            .map(|reason| ("not disturbed by", reason));
        by.chain(not_by).collect()
    }
}

/// What was run, for JSON.
pub(super) fn head(setup: &Setup, run: &InPlane, met: &[bool]) -> Value {
    let disturbed = Disturbed::of(&run.plane.disturb, met);
    json!({
        "command": "run",
        "robot": setup.robot.name,
        "gait": run.gait,
        "gait_in_words": run.words,
        "direction": if setup.forwards { "forwards" } else { "backwards" },
        "zone_rad": setup.zone,
        "taps": setup.taps,
        "seconds": setup.seconds,
        "step_s": step(setup.stepping),
        "seed": setup.seed,
        "disturbances": disturbed.by,
        "disturbances_not_met": disturbed.not_by.iter().map(|typed| &typed.text).collect::<Vec<_>>(),
    })
}

/// The fixed step (s); null for error control.
fn step(stepping: Stepping) -> Option<f64> {
    match stepping {
        Stepping::Fixed(step) => Some(step),
        Stepping::Adaptive => None,
    }
}

/// A number for people.
fn short(x: f64) -> String {
    measured(x, 4)
}

fn times(count: usize) -> String {
    if count == 1 {
        "once".into()
    } else {
        format!("{count} times")
    }
}

/// What the axle did above a box.
fn on_the_way(it: &OnTheWay) -> String {
    let o = &it.obstacle;
    let size = format!("{} m high, from {} m on", short(o.height), short(o.front));
    let over = it.over.map_or("not reached".into(), |[since, up]| {
        format!(
            "the axle over it at {} s, up to {} m high",
            short(since),
            short(up)
        )
    });
    let passed = it
        .passed
        .map(|time| format!("; passed at {} s", short(time)));
    format!("{size}: {over}{}", passed.unwrap_or_default())
}

fn box_json(it: &OnTheWay) -> Value {
    let o = &it.obstacle;
    json!({
        "front_m": o.front, "length_m": o.length, "height_m": o.height,
        "over_s": it.over.map(|[since, _]| since), "highest_m": it.over.map(|[_, up]| up), "passed_s": it.passed,
    })
}

/// What is said of fixed steps whose contact forces obey the laws only nearly, if there are any.
pub(super) fn approximate(steps: usize) -> Option<String> {
    (steps > 0).then(|| {
        format!("in {steps} steps the forces obey the laws of contact only to 1 mm/s and 1e-4 of the greatest")
    })
}
