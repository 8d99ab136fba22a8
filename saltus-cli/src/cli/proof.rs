//! What is said of answers that hold on a plant.

use saltus::on_plant::{CONFIRMED, Confirmed, OnPlant};
use saltus::planner::Correction;
use serde_json::{Value, json};

use crate::output::digits;

/// How answers were corrected for a plant, and what flying them came to.
pub(crate) struct Proof {
    plant: String,
    correction: Correction,
    confirmed: Confirmed,
}

impl Proof {
    pub(crate) fn new(plant: &OnPlant, correction: Correction, confirmed: Confirmed) -> Proof {
        Proof {
            plant: plant.robot().name.clone(),
            correction,
            confirmed,
        }
    }

    /// One line, indented.
    pub(crate) fn line(&self) -> String {
        let Confirmed {
            jumps,
            miss,
            dropped,
        } = self.confirmed;
        let corrected = if self.correction.is_exact {
            "jumps as the planar model says".to_owned()
        } else {
            let jumps = self.correction.jumps;
            format!("{jumps} simulated jumps corrected the planar model")
        };
        let flown = format!(
            "{jumps} answers flown, {} mm off at most",
            digits(1e3 * miss, 2)
        );
        let dropped = match dropped {
            0 => String::new(),
            n => format!(
                "; {n} more, which do not land or are off by more than {} mm, are not answers",
                digits(1e3 * CONFIRMED, 2)
            ),
        };
        format!("  on {}: {corrected}; {flown}{dropped}\n", self.plant)
    }

    pub(crate) fn json(&self) -> Value {
        json!({
            "simulated_jumps": self.correction.jumps,
            "is_exact": self.correction.is_exact,
            "confirmed": self.confirmed.jumps,
            "miss_greatest_m": self.confirmed.miss,
            "dropped": self.confirmed.dropped,
        })
    }
}
