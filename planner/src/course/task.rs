//! The course as it is given, and what is allowed in it.

use saltus_numeric::refused;

use super::Span;

/// Greatest number of jumps that one plan may have.
pub const MAX_JUMPS: usize = 12;

/// Greatest number of obstacles and of no-landing areas, each.
const MAX_ITEMS: usize = 64;

/// Greatest magnitude of a position or size (m), to keep round-off below a nanometre.
const MAX_LENGTH: f64 = 1e4;

/// A box on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle {
    /// Middle (m).
    pub center: f64,
    /// Extent along the travel (m), > 0.
    pub width: f64,
    /// Top above the ground (m), > 0.
    pub height: f64,
}

impl Obstacle {
    /// From the front edge to the back edge (m).
    pub fn span(&self) -> Span {
        Span::new(
            self.center - self.width / 2.0,
            self.center + self.width / 2.0,
        )
    }
}

/// What is to be jumped. Positions are along the travel, heights above the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// What the errors call it.
    pub id: String,
    /// First foothold (m).
    pub start: f64,
    /// Height of the first foothold (m).
    pub start_height: f64,
    /// Jumps to make, 1 to [`MAX_JUMPS`].
    pub jumps: usize,
    /// Where the last jump lands (m): an exact place where its ends are equal, else a zone.
    pub goal: Span,
    /// Boxes that do not overlap, in any order.
    pub obstacles: Vec<Obstacle>,
    /// Where no jump may land (m).
    pub no_landing: Vec<Span>,
}

/// A course that cannot even be tried.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CourseError {
    /// A value outside its domain.
    #[error("course `{course}`: {key} = {value}, allowed: {allowed}")]
    Value {
        /// Identity of the course.
        course: String,
        /// Key of the value, as in course files; obstacles and areas are counted from 1.
        key: String,
        /// What was given.
        value: f64,
        /// What may be given.
        allowed: &'static str,
    },
    /// Two boxes in one place.
    #[error(
        "course `{course}`: obstacle {} and obstacle {} overlap, allowed: disjoint obstacles", first + 1, second + 1
    )]
    Overlap {
        /// Identity of the course.
        course: String,
        /// Index of the obstacle in front.
        first: usize,
        /// Index of the other one.
        second: usize,
    },
}

impl Course {
    /// Checks every value.
    ///
    /// # Errors
    /// [`CourseError`] with the first value that is not allowed.
    pub fn check(&self) -> Result<(), CourseError> {
        let length = |x: f64| x.abs() <= MAX_LENGTH;
        let size = |x: f64| x > 0.0 && x <= MAX_LENGTH;
        let (a_length, a_size) = ("from -10000 to 10000 m", "above 0, to 10000 m");
        let (goal, boxes, areas) = (self.goal, self.obstacles.len(), self.no_landing.len());
        self.allow(
            "",
            refused! {
                "start_x_m", self.start, length(self.start) => a_length;
                "start_height_m", self.start_height, (0.0..=MAX_LENGTH).contains(&self.start_height)
                    => "0 to 10000 m";
                "jumps", self.jumps as f64, (1..=MAX_JUMPS).contains(&self.jumps) => "1 to 12";
                "goal_x_m", goal.low, length(goal.low) => a_length;
                "goal_x_m", goal.high, length(goal.high) => a_length;
                "goal_x_m", goal.high, !goal.is_empty() => "a zone that ends behind its beginning";
                "obstacles (number)", boxes as f64, boxes <= MAX_ITEMS => "0 to 64";
            },
        )?;
        for (i, o) in self.obstacles.iter().enumerate() {
            self.allow(
                &format!("obstacle {}.", i + 1),
                refused! {
                    "center_x_m", o.center, length(o.center) => a_length;
                    "width_m", o.width, size(o.width) => a_size;
                    "height_m", o.height, size(o.height) => a_size;
                },
            )?;
        }
        self.allow(
            "",
            refused! { "no_landing (number)", areas as f64, areas <= MAX_ITEMS => "0 to 64"; },
        )?;
        for (i, a) in self.no_landing.iter().enumerate() {
            let center = f64::midpoint(a.low, a.high);
            self.allow(
                &format!("no_landing {}.", i + 1),
                refused! {
                    "center_x_m", center, length(center) => a_length;
                    "width_m", a.width(), size(a.width()) => a_size;
                },
            )?;
        }
        self.check_overlap()
    }

    /// The error of a number that is not allowed, whose key begins with `of`.
    fn allow(
        &self,
        of: &str,
        refused: Option<(&str, f64, &'static str)>,
    ) -> Result<(), CourseError> {
        refused.map_or(Ok(()), |(key, value, allowed)| {
            Err(CourseError::Value {
                course: self.id.clone(),
                key: format!("{of}{key}"),
                value,
                allowed,
            })
        })
    }

    /// Touching boxes are two steps of a stair; a nanometre of overlap is round-off.
    fn check_overlap(&self) -> Result<(), CourseError> {
        let mut order: Vec<usize> = (0..self.obstacles.len()).collect();
        order.sort_by(|&a, &b| {
            self.obstacles[a]
                .center
                .total_cmp(&self.obstacles[b].center)
        });
        for pair in order.windows(2) {
            let (first, second) = (pair[0], pair[1]);
            if self.obstacles[first].span().high > self.obstacles[second].span().low + 1e-9 {
                return Err(CourseError::Overlap {
                    course: self.id.clone(),
                    first,
                    second,
                });
            }
        }
        Ok(())
    }
}
