//! Laws of physics, agreement of the crates, and what the whole does.

mod architecture;
mod ball_known;
mod boom;
mod columns;
mod controller;
mod corrections;
mod diagnosis;
mod documents;
mod hardened;
mod hopper;
mod lab;
mod laws;
mod machines;
mod models;
mod parkour;
mod planar;
mod predictions;
mod reference;
mod routes;
mod slip;
mod strides;
mod subsets;
mod tanks;
mod terms;
mod thesis;
mod verdicts;
