//! What a course demands of a jump, and whether a simulated jump meets it.

use saltus_planner::course::Span;

use super::Flown;

/// A length demand (m) that is missed by less than this is met: the simulation and the planner
/// differ by as much.
pub const ROUND_OFF: f64 = 1e-5;

/// The same of a friction coefficient: the simulation takes the stance's greatest from samples 1 ms
/// apart.
const FRICTION_ROUND_OFF: f64 = 1e-3;

/// Something that is demanded of a jump.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Demand {
    /// The axle comes down to its landing height.
    Touchdown,
    /// Landing and next foothold are on a surface of the planned height: on a box's top, or on the
    /// ground and in no box.
    Ground,
    /// The landing keeps the course's distance from every edge of a box.
    Edge,
    /// The landing is in no area that is to be avoided.
    Avoid,
    /// The landing is in the zone of its jump.
    Zone,
    /// The last landing is in the goal.
    Goal,
    /// The landing is where it is wanted, to the tolerance.
    Tolerance,
    /// In flight the wheel, and the fired leg while it is out, keeps the course's clearance from
    /// every box.
    Clearance,
    /// In the stance the wheel touches no box.
    Stance,
    /// The foot needs no more friction than the course has.
    Friction,
}

impl Demand {
    /// All demands.
    pub const ALL: [Demand; 10] = [
        Demand::Touchdown,
        Demand::Ground,
        Demand::Edge,
        Demand::Avoid,
        Demand::Zone,
        Demand::Goal,
        Demand::Tolerance,
        Demand::Clearance,
        Demand::Stance,
        Demand::Friction,
    ];

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Demand::Touchdown => "touchdown",
            Demand::Ground => "ground",
            Demand::Edge => "edge",
            Demand::Avoid => "avoid",
            Demand::Zone => "zone",
            Demand::Goal => "goal",
            Demand::Tolerance => "tolerance",
            Demand::Clearance => "clearance",
            Demand::Stance => "stance",
            Demand::Friction => "friction",
        }
    }

    /// Whether it is about the place of the landing.
    pub fn is_of_landing(self) -> bool {
        use Demand::{Avoid, Edge, Goal, Ground, Tolerance, Zone};
        matches!(self, Ground | Edge | Avoid | Zone | Goal | Tolerance)
    }

    fn round_off(self) -> f64 {
        if self == Demand::Friction {
            FRICTION_ROUND_OFF
        } else {
            ROUND_OFF
        }
    }
}

/// How a jump fares with one demand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judgement {
    /// The demand.
    pub demand: Demand,
    /// How far inside the demand's limit (m; of friction 1) the jump stays; negative: outside.
    /// Infinite for [`Demand::Touchdown`].
    pub margin: f64,
    /// What was measured: a place's distance (m) beyond the limit's far end, negative short of its
    /// near end; a landing error (m), a distance to a box (m), a friction coefficient.
    pub value: f64,
    /// The box or area that it is about, from 0.
    pub item: Option<usize>,
}

impl Judgement {
    pub(super) fn new(demand: Demand, margin: f64, value: f64, item: Option<usize>) -> Judgement {
        Judgement {
            demand,
            margin,
            value,
            item,
        }
    }

    /// Whether the demand is met, but for round-off.
    pub fn holds(&self) -> bool {
        self.margin >= -self.demand.round_off()
    }

    /// By how much the demand is missed, in words; of a demand that holds they mean nothing.
    pub fn miss(&self) -> String {
        let number = self.item.map_or(0, |item| item + 1);
        let (off, value) = (length(self.margin), length(self.value));
        let side = if self.value < 0.0 {
            "short of"
        } else {
            "beyond"
        };
        match self.demand {
            Demand::Touchdown => "does not land".into(),
            Demand::Ground if self.item.is_some() => {
                format!("comes down {off} inside obstacle {number}")
            }
            Demand::Ground => format!("misses the top that it should land on by {off}"),
            Demand::Edge => format!("lands {off} too near to an edge of obstacle {number}"),
            Demand::Avoid => format!("lands {off} inside avoid area {number}"),
            Demand::Zone => format!("lands {off} {side} its landing zone"),
            Demand::Goal => format!("lands {off} {side} the goal"),
            Demand::Tolerance if !self.value.is_finite() => {
                "lands where the planner has no landing".into()
            }
            Demand::Tolerance => {
                let allowed = length(self.value.abs() + self.margin);
                format!("{}, {allowed} are allowed", self.place())
            }
            Demand::Clearance if self.value < 0.0 => {
                format!("touches obstacle {number} by {value}")
            }
            Demand::Clearance => {
                let wanted = length(self.value - self.margin);
                format!("keeps {value} from obstacle {number}, {wanted} are demanded")
            }
            Demand::Stance => format!("touches obstacle {number} by {value} in the stance"),
            Demand::Friction => format!(
                "needs a friction coefficient of {:.3}, the course has {:.3}",
                self.value,
                self.value + self.margin
            ),
        }
    }
}

impl Judgement {
    /// Where a landing judged by [`Demand::Tolerance`] is, in words.
    pub fn place(&self) -> String {
        let side = if self.value < 0.0 {
            "short of"
        } else {
            "beyond"
        };
        format!("lands {} {side} the wanted place", length(self.value))
    }
}

/// A length (m) without its sign, in mm with three digits.
pub(super) fn length(x: f64) -> String {
    let mm = 1e3 * x.abs();
    let decimals = match mm {
        100.0.. => 0,
        10.0.. => 1,
        1.0.. => 2,
        _ => 3,
    };
    let text = format!("{mm:.decimals$}");
    let text = if decimals > 0 {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        &text
    };
    format!("{text} mm")
}

/// What a course demands of its jumps. Places are along the course (m).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Demands {
    /// How far (m) a landing may be from where it is wanted.
    pub tolerance: f64,
    /// Boxes: front, back and top.
    pub obstacles: Vec<[f64; 3]>,
    /// Least distance (m) in flight between wheel and boxes.
    pub clearance: f64,
    /// Time (s) after lift-off during which the fired leg has to keep it too.
    pub leg_out: f64,
    /// Least distance (m) of a landing from the edges of boxes.
    pub edge_margin: f64,
    /// Where no jump may land.
    pub avoid: Vec<Span>,
    /// Where each jump has to land; none or missing: anywhere.
    pub zones: Vec<Option<Span>>,
    /// Where the last jump has to land.
    pub goal: Option<Span>,
    /// Distance (m) from a landing to the next foothold.
    pub roll: f64,
    /// Friction coefficient that the stances may need.
    pub friction: Option<f64>,
}

/// A landing that is to be judged.
#[derive(Clone, Copy, Debug)]
pub(super) struct Landing {
    /// Index of the jump.
    pub(super) jump: usize,
    /// Whether it is the last.
    pub(super) is_last: bool,
    /// Where it is, and where it is wanted (m along the course).
    pub(super) place: f64,
    pub(super) wanted: f64,
    /// Height (m) of the surface landed on; none where nothing is asked of it.
    pub(super) surface: Option<f64>,
}

impl Demands {
    /// Landings within `tolerance` (m) of where they are wanted, and nothing else.
    pub fn within(tolerance: f64) -> Demands {
        Demands {
            tolerance,
            ..Demands::default()
        }
    }

    /// Whether a wheel at `x` (m along the course) stands on box number `item` if its foot is at
    /// `height` (m).
    pub(super) fn carries(&self, item: usize, x: f64, height: f64) -> bool {
        let [front, back, top] = self.obstacles[item];
        top == height && x >= front - ROUND_OFF && x <= back + ROUND_OFF
    }

    /// All that is demanded of a landing's place.
    pub(super) fn of_landing(&self, landing: &Landing) -> Vec<Judgement> {
        let Landing {
            jump,
            is_last,
            place,
            wanted,
            surface,
        } = *landing;
        let mut found = Vec::new();
        if let Some(height) = surface {
            let foothold = (!is_last).then_some(place + self.roll);
            let ground = [Some(place), foothold]
                .into_iter()
                .flatten()
                .map(|x| self.ground(x, height));
            found.extend(ground.min_by(by_margin));
            found.extend(self.edge(place, height).filter(|_| self.edge_margin > 0.0));
        }
        let outside = self.avoid.iter().enumerate().map(|(item, area)| {
            let margin = (area.low - place).max(place - area.high);
            Judgement::new(Demand::Avoid, margin, margin, Some(item))
        });
        found.extend(outside.min_by(by_margin));
        let zone = self.zones.get(jump).copied().flatten();
        found.extend(zone.map(|zone| inside(Demand::Zone, zone, place)));
        found.extend(
            self.goal
                .filter(|_| is_last)
                .map(|goal| inside(Demand::Goal, goal, place)),
        );
        let error = place - wanted;
        let margin = self.tolerance - error.abs();
        found.push(Judgement::new(Demand::Tolerance, margin, error, None));
        found
    }

    /// Whether there is a surface of this height (m) at `x` (m): its margin counts from the
    /// surface's ends.
    fn ground(&self, x: f64, height: f64) -> Judgement {
        let judged = |margin, item| Judgement::new(Demand::Ground, margin, margin, item);
        let tops = self.obstacles.iter().filter(|solid| solid[2] == height);
        let top = tops
            .map(|[front, back, _]| (x - front).min(back - x))
            .reduce(f64::max);
        if height != 0.0 {
            return judged(top.unwrap_or(f64::NEG_INFINITY), None);
        }
        let outside = self.obstacles.iter().enumerate();
        let outside =
            outside.map(|(item, [front, back, _])| judged((front - x).max(x - back), Some(item)));
        outside
            .min_by(by_margin)
            .unwrap_or(judged(f64::INFINITY, None))
    }

    /// How far from the edge margin of the nearest box a landing at `x` on a surface of this height
    /// (m) is.
    fn edge(&self, x: f64, height: f64) -> Option<Judgement> {
        let boxes = self.obstacles.iter().enumerate();
        let kept = boxes.map(|(item, [front, back, _])| {
            let inside = (x - front).min(back - x);
            let distance = if self.carries(item, x, height) {
                inside
            } else {
                -inside
            };
            let margin = distance - self.edge_margin;
            Judgement::new(Demand::Edge, margin, distance, Some(item))
        });
        kept.min_by(by_margin)
    }

    /// The boxes on which a foot (m along the course, and up) does not stand.
    fn in_the_way(&self, foot: [f64; 2]) -> impl Iterator<Item = usize> {
        (0..self.obstacles.len()).filter(move |item| !self.carries(*item, foot[0], foot[1]))
    }

    fn is_landed_on(&self, item: usize, landing: Option<(f64, f64)>) -> bool {
        landing.is_some_and(|(x, height)| self.carries(item, x, height))
    }

    /// Least distance (m) between the wheel and the boxes, negative where they overlap; none
    /// without one. Neither the box that the robot stands on counts nor, unless it is touched
    /// before, the one that it lands on.
    pub(super) fn clearance(
        &self,
        flown: &Flown,
        foot: [f64; 2],
        landing: Option<(f64, f64)>,
    ) -> Option<f64> {
        let gap = |item: usize| {
            let gap = flown.clearances[item].least();
            (gap < -ROUND_OFF || !self.is_landed_on(item, landing)).then_some(gap)
        };
        self.in_the_way(foot).filter_map(gap).reduce(f64::min)
    }

    /// All that is demanded of the way to the landing: a jump from `foot` (m along the course, and
    /// up) to `landing` (m along the course, and the height of the surface), where there is one.
    /// What the robot stands on is not in its way; what it lands on is not touched before.
    pub(super) fn of_way(
        &self,
        flown: &Flown,
        foot: [f64; 2],
        landing: Option<(f64, f64)>,
    ) -> Vec<Judgement> {
        let gaps = || {
            self.in_the_way(foot)
                .map(|item| (item, flown.clearances[item]))
        };
        let flight = gaps().filter_map(|(item, gap)| {
            let value = gap.flight?;
            let margin = if self.is_landed_on(item, landing) {
                value
            } else {
                value - self.clearance
            };
            let item = Some(item);
            Some(Judgement::new(Demand::Clearance, margin, value, item))
        });
        let stance = gaps()
            .map(|(item, gap)| Judgement::new(Demand::Stance, gap.stance, gap.stance, Some(item)));
        let needed = flown.report.friction_needed;
        let friction = self
            .friction
            .map(|friction| Judgement::new(Demand::Friction, friction - needed, needed, None));
        [flight.min_by(by_margin), stance.min_by(by_margin), friction]
            .into_iter()
            .flatten()
            .collect()
    }
}

/// A place that has to be in a span.
fn inside(demand: Demand, span: Span, place: f64) -> Judgement {
    let (after, before) = (place - span.low, span.high - place);
    let value = if after < before {
        after.min(0.0)
    } else {
        (-before).max(0.0)
    };
    Judgement::new(demand, after.min(before), value, None)
}

fn by_margin(a: &Judgement, b: &Judgement) -> std::cmp::Ordering {
    a.margin.total_cmp(&b.margin)
}
