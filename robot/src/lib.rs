//! What a jumping robot is: parameters with units, TOML files, checks.
//!
//! A robot file is TOML with the unit in each key's name; `robots/README.md` lists the keys.
//! Reading it gives the [`Robot`] that the models see, in SI, each value checked; an unknown key, a
//! value outside its domain or a quantity given twice is an error that names the place. [`resolve`]
//! is what a command line needs: a built-in robot or a file, with overrides.
//!
//! ```
//! use saltus_robot::resolve;
//! let robot = resolve("rats-planar", &["leg.supply_pressure_gauge_psi=100".into()])?;
//! assert_eq!(robot.body.legs, 5);
//!
//! let error = resolve("rats-planar", &["leg.boer_mm=20".into()]).unwrap_err();
//! assert_eq!(
//!     error.to_string(),
//!     "--set leg.boer_mm=20: unknown key leg.boer_mm; the nearest known key is leg.bore_mm",
//! );
//! # Ok::<(), saltus_robot::RobotError>(())
//! ```

pub mod bodies;
mod document;
pub mod domain;
mod error;
mod file;
mod files;
pub mod gas;
mod implausible;
mod in_space;
mod launch;
mod model;
mod reading;
pub mod section;
pub mod space;
mod table;
pub mod terms;
pub mod units;
mod write;

use std::io::ErrorKind;
use std::path::Path;

pub use error::{Place, RobotError};
use files::{Files, ROBOTS, read_text};
pub use gas::Gas;
pub use implausible::Implausible;
pub use launch::{Launch, LiftOff, Outcome};
pub use model::*;
pub use space::Space;
pub use terms::Term;

/// The robot `name_or_path`, built in or in a file, with each of `overrides` applied in turn.
///
/// A built-in name comes before a file of that name, which is then `./name`.
///
/// An override is `KEY=VALUE` with a dotted key of the robot file and a TOML value; a value that is
/// not TOML is text without quotes. It may name a quantity in another unit than the file does, add
/// optional keys and tables, or replace a whole table.
///
/// # Errors
/// [`RobotError`] if there is no such robot, its file cannot be read, or robot and overrides
/// together are not a sound robot.
pub fn resolve(name_or_path: &str, overrides: &[String]) -> Result<Robot, RobotError> {
    resolve_from(name_or_path, overrides, &|_| ())
}

/// As [`resolve`]; `opened` is told of each file before it is read.
///
/// # Errors
/// As [`resolve`].
pub fn resolve_from(
    name_or_path: &str,
    overrides: &[String],
    opened: &dyn Fn(&Path),
) -> Result<Robot, RobotError> {
    if let Some((name, text)) = built_in(name_or_path) {
        let files = Files {
            place: files::Place::BuiltIn,
            opened,
        };
        return read(text, &format!("robots/{name}.toml"), files, overrides);
    }
    let path = Path::new(name_or_path);
    opened(path);
    let text = read_text(path).map_err(|error| match error {
        RobotError::Unreadable { source, .. } if source.kind() == ErrorKind::NotFound => {
            RobotError::UnknownRobot {
                name: name_or_path.into(),
                built_in: Robot::builtin_names().collect(),
            }
        }
        error => error,
    })?;
    let place = files::Place::Folder(path.parent().unwrap_or(path));
    read(&text, name_or_path, Files { place, opened }, overrides)
}

/// As [`resolve`], from the `text` of a robot file, which messages call `name`; what it names is
/// below the working folder.
///
/// # Errors
/// As [`resolve`].
pub fn resolve_text(text: &str, name: &str, overrides: &[String]) -> Result<Robot, RobotError> {
    let files = Files {
        place: files::Place::BuiltIn,
        opened: &|_| (),
    };
    read(text, name, files, overrides)
}

impl Robot {
    /// The thesis' planar robot without its boom: `rats-planar`.
    ///
    /// Source: `robots/rats-planar.toml`.
    ///
    /// # Panics
    /// Never: a test reads it.
    pub fn rats_planar() -> Robot {
        Robot::builtin("rats-planar").expect("rats-planar is built in")
    }

    /// The built-in robot `name`, if there is one.
    ///
    /// # Panics
    /// Never: a test reads each of them.
    pub fn builtin(name: &str) -> Option<Robot> {
        let (name, text) = built_in(name)?;
        let files = Files {
            place: files::Place::BuiltIn,
            opened: &|_| (),
        };
        Some(read(text, name, files, &[]).expect("the built-in robots are sound"))
    }

    /// Names of the built-in robots.
    pub fn builtin_names() -> impl Iterator<Item = &'static str> {
        ROBOTS.iter().map(|&(name, _)| name)
    }

    /// The robot in the file at `path`.
    ///
    /// # Errors
    /// [`RobotError`] if the file cannot be read or is not a sound robot.
    pub fn load(path: impl AsRef<Path>) -> Result<Robot, RobotError> {
        let path = path.as_ref();
        let folder = path.parent().unwrap_or(path);
        Robot::parse(&read_text(path)?, &path.display().to_string(), folder)
    }

    /// The robot that `text` describes; messages call it `file_name`, and the files that it names
    /// are below `base_dir`.
    ///
    /// # Errors
    /// [`RobotError`] if `text` is not a sound robot, or a file that it names cannot be read.
    pub fn parse(text: &str, file_name: &str, base_dir: &Path) -> Result<Robot, RobotError> {
        let files = Files {
            place: files::Place::Folder(base_dir),
            opened: &|_| (),
        };
        read(text, file_name, files, &[])
    }
}

/// Name and robot file of the built-in robot `name`.
fn built_in(name: &str) -> Option<(&'static str, &'static str)> {
    ROBOTS.iter().find(|&&(known, _)| known == name).copied()
}

fn read(text: &str, file: &str, files: Files, overrides: &[String]) -> Result<Robot, RobotError> {
    let mut document = document::parse(text, file)?;
    for (index, text) in overrides.iter().enumerate() {
        document::set(&mut document, index, text)?;
    }
    file::robot(document, files)
}
