//! The ground and what stands on it, to draw.

use std::io::Write;

use saltus_sim_check::{Rig, Surface};
use saltus_telemetry::{Definition, message};

use super::body::WORLD;
use super::{Error, Recording};

/// A box on the ground, across the robot's way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Where it begins (m) along the travel.
    pub front: f64,
    /// Where it ends (m).
    pub back: f64,
    /// Height of its top (m).
    pub top: f64,
}

/// Half the length of the ground that is drawn (m), and its thickness.
const GROUND: [f64; 2] = [10.0, 0.02];
const GREY: [f32; 4] = [0.6, 0.6, 0.6, 1.0];
const BROWN: [f32; 4] = [0.6, 0.45, 0.3, 1.0];

impl<W: Write> Recording<W> {
    /// Adds the ground and `blocks` upon it, for viewers; without a [`robot`](Recording::robot)
    /// nothing.
    ///
    /// # Errors
    /// [`Error::File`] if the file takes no bytes.
    pub fn course(&mut self, blocks: &[Block]) -> Result<(), Error> {
        let Some(body) = &self.body else {
            return Ok(());
        };
        let mut drawn = vec![ground(body.rig())];
        drawn.extend(blocks.iter().map(|block| boxed(body.rig(), block)));
        let topic = self.writer.channel("/course", &Definition::MARKERS)?;
        message::blocks(&mut self.encoder, 0, WORLD, &drawn);
        Ok(self.writer.write(topic, 0, self.encoder.bytes())?)
    }
}

/// A slab whose upper side is the ground.
fn ground(rig: &Rig) -> message::Block {
    let [half, thick] = GROUND;
    let slope = match rig.mechanism.surfaces.first() {
        Some(Surface::Plane { normal, .. }) => (-normal.x).atan2(normal.z),
        _ => 0.0,
    };
    // Uphill forwards is a turn about −y.
    let (sin, cos) = (-0.5 * slope).sin_cos();
    message::Block {
        center: [0.5 * thick * slope.sin(), 0.0, -0.5 * thick * slope.cos()],
        size: [2.0 * half, 2.0 * half, thick],
        rotation: [0.0, sin, 0.0, cos],
        color: GREY,
    }
}

fn boxed(rig: &Rig, block: &Block) -> message::Block {
    let length = block.back - block.front;
    let straight = [0.0, 0.0, 0.0, 1.0];
    let (center, size, rotation) = match rig.box_across(block.front, length, block.top) {
        Surface::TurnedBlock {
            low,
            high,
            about,
            turn,
        } => {
            let middle = 0.5 * (low + high);
            let (sin, cos) = turn.sin_cos();
            let turned = [
                about.x + middle.x * cos + middle.y * sin,
                about.y - middle.x * sin + middle.y * cos,
                about.z + middle.z,
            ];
            let (sin, cos) = (0.5 * turn).sin_cos();
            // Forwards is a turn about −z.
            (turned, high - low, [0.0, 0.0, -sin, cos])
        }
        Surface::Block { low, high } => ((0.5 * (low + high)).into(), high - low, straight),
        // No box is a plane.
        Surface::Plane { .. } => ([0.0; 3], saltus_sim_check::Vec3::zeros(), straight),
    };
    message::Block {
        center,
        size: size.into(),
        rotation,
        color: BROWN,
    }
}
