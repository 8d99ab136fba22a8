//! The decisions in C99, as templates: words between `@` stand for what an export fills in.

/// Declarations of the decisions that jump from tables.
pub const CONTROLLER_HEADER: &str = include_str!("../c/saltus_controller.h");

/// Their definitions, operation by operation those of [`Controller`](crate::Controller).
pub const CONTROLLER: &str = include_str!("../c/saltus_controller.c");

/// Declarations of what decides on a running robot.
pub const RUNNING_HEADER: &str = include_str!("../c/saltus_running.h");

/// Their definitions, operation by operation those of [`run`](crate::run).
pub const RUNNING: &str = include_str!("../c/saltus_running.c");

/// Declarations of what decides on a ball.
pub const BALL_HEADER: &str = include_str!("../c/saltus_ball.h");

/// Their definitions, operation by operation those of [`ball`](crate::ball).
pub const BALL: &str = include_str!("../c/saltus_ball.c");

/// A table that was learnt, and the choice in it, operation by operation that of [`Choices`](crate::run::Choices).
pub const POLICY: &str = include_str!("../c/saltus_policy.h");
