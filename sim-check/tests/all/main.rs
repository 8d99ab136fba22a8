//! The simulation from outside: mechanics, jumps, measured tosses, cost, bad input.

mod bad_input;
mod bodies;
mod cost;
mod fixed;
mod in_motion;
mod jumps;
mod mechanics;
mod ring;
mod tosses;
