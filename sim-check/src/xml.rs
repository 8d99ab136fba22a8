//! XML as it is written: what MJCF and URDF have in common.

use std::fmt::{Display, Write};

use nalgebra::Matrix3;

use crate::spatial::Vec3;

/// Radius (m) of the sphere that stands for a foot that is a point.
pub(crate) const POINT: f64 = 1e-5;

/// Least moment of inertia (kg m²): MuJoCo takes none that is 0.
pub(crate) const LEAST_INERTIA: f64 = 1e-12;

/// A part's name, without what is awkward to type.
pub(crate) fn plain(name: &str) -> String {
    name.replace('\'', "").replace(' ', "_")
}

/// Moments of inertia (kg m²) that are none of them less than [`LEAST_INERTIA`].
pub(crate) fn bodily(inertia: &Matrix3<f64>) -> Matrix3<f64> {
    let lacking = LEAST_INERTIA - inertia.symmetric_eigenvalues().min();
    inertia + Matrix3::identity() * lacking.max(0.0)
}

/// `x`, or if that is 0 what stands for it.
pub(crate) fn positive_or(x: f64, other: f64) -> f64 {
    if x > 0.0 { x } else { other }
}

pub(crate) fn number(x: f64) -> String {
    // Written -0, it would be read so too; but nobody wants to see it.
    if x == 0.0 { "0".into() } else { format!("{x}") }
}

pub(crate) fn numbers(list: &[f64]) -> String {
    list.iter()
        .map(|x| number(*x))
        .collect::<Vec<_>>()
        .join(" ")
}

pub(crate) fn vector(v: &Vec3) -> String {
    numbers(v.as_slice())
}

/// XML as it is written: an element is given as its name and its attributes, as they stand in the
/// file. A text of the user's in them must be [`escaped`].
#[derive(Default)]
pub(crate) struct Xml {
    pub(crate) text: String,
    depth: usize,
}

impl Xml {
    fn line(&mut self, text: &str) {
        let indent = 2 * self.depth;
        let _ = writeln!(self.text, "{:indent$}{text}", "");
    }

    pub(crate) fn open(&mut self, element: impl Display) {
        self.line(&format!("<{element}>"));
        self.depth += 1;
    }

    pub(crate) fn close(&mut self, name: &str) {
        self.depth -= 1;
        self.line(&format!("</{name}>"));
    }

    pub(crate) fn leaf(&mut self, element: impl Display) {
        self.line(&format!("<{element}/>"));
    }

    pub(crate) fn comment(&mut self, lines: &[&str]) {
        // Two dashes end a comment.
        let text = lines
            .iter()
            .map(|line| allowed(line))
            .collect::<Vec<_>>()
            .join("\n     ");
        let text = text.replace("--", "- -").replace("--", "- -");
        self.line(&format!("<!-- {text} -->"));
    }
}

/// `text` without the characters that XML has no way to write.
fn allowed(text: &str) -> String {
    text.chars()
        .map(|c| {
            if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') {
                ' '
            } else {
                c
            }
        })
        .collect()
}

/// `text` as it stands in an attribute.
pub(crate) fn escaped(text: &str) -> String {
    let entities = [
        ('&', "&amp;"),
        ('<', "&lt;"),
        ('>', "&gt;"),
        ('"', "&quot;"),
    ];
    let mut out = String::new();
    for c in allowed(text).chars() {
        match entities.iter().find(|(e, _)| *e == c) {
            Some((_, entity)) => out.push_str(entity),
            None => out.push(c),
        }
    }
    out
}
