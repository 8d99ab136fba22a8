//! What decides on a robot, as files in C: the code, and the robot's constants.

use saltus_robot::Robot;

use super::c::{comment, fill, number_words};
use super::fingerprint;
use super::numbers::Number;

/// What is written for a robot that runs or rolls, in C99 with no other dependency than `math.h`'s square root.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CFiles {
    /// What heads every file.
    pub about: Vec<String>,
    /// A header, a source, and a header with the robot's constants: names and texts.
    pub files: [(&'static str, String); 3],
}

impl CFiles {
    /// Those of `robot`, which is a `what`: the header and the source of its `code`, and its `tables`, each with its name.
    pub(super) fn of<R: Number>(
        robot: &Robot,
        what: &str,
        code: [(&'static str, &str); 2],
        (tables, constants): (&'static str, &str),
    ) -> CFiles {
        let about = vec![
            format!(
                "What decides on the {what} {}, whose file's SHA-256 begins {}.",
                robot.name.escape_default(),
                fingerprint(robot)
            ),
            format!(
                "Written by saltus {}; to change it, write it anew. Numbers: {}.",
                env!("CARGO_PKG_VERSION"),
                R::C_TYPE
            ),
        ];
        let head = comment(&about);
        let [header, source] = code.map(|(name, text)| {
            let head = ("HEADER", head.clone());
            (
                name,
                fill(text, number_words::<R>().into_iter().chain([head])),
            )
        });
        let constants = format!("{head}\n{constants}");
        CFiles {
            about,
            files: [header, source, (tables, constants)],
        }
    }
}
