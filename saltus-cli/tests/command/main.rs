//! The command `saltus`, run as a user runs it.

#![allow(clippy::unwrap_used)]

mod answers;
mod bad_input;
mod ball;
mod ball_export;
mod cases;
mod clock;
mod commands;
mod common;
mod courses;
mod diagnose;
mod documents;
mod evidence;
mod filling;
#[path = "../../../saltus/tests/experiment/folder.rs"]
mod folder;
mod gases;
mod golden;
mod inject;
mod jump;
mod keys;
mod learn;
mod ledger;
mod logs;
mod meaning;
mod misleading;
mod named;
mod overwrites;
mod pages;
mod plant;
mod plots;
mod power;
mod recorded;
mod run;
mod running_export;
mod slips;
mod strides;
mod tables;
mod unwritable;
mod valves;
mod verify;
