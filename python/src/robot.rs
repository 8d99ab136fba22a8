//! Robots.

use std::borrow::Cow;
use std::fmt::Display;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::OnceLock;

use pyo3::types::{PyAnyMethods, PyDict, PyDictMethods, PyType};
use pyo3::{Bound, PyAny, PyErr, PyResult, Python, pyclass, pymethods};

use saltus::lagrangian::{Batch, FINE};
use saltus::robot::{resolve, resolve_text};

use crate::error::bad;
use crate::toml_value;

/// A robot: what a robot file describes.
#[pyclass(frozen, module = "saltus._saltus")]
pub(crate) struct Robot {
    pub(crate) model: saltus::Robot,
    toml: String,
    /// Behind a pointer: Python aligns objects to 16 bytes, and lanes need 64.
    batch: OnceLock<Box<Batch>>,
}

impl Robot {
    /// The robot `model`, which moves in its plane, as every jump does.
    fn of(model: saltus::Robot) -> PyResult<Robot> {
        if model.space.is_some() {
            let says = format!("{}: body.shape = sphere: must be wheel", model.name);
            return Err(refused(says));
        }
        Ok(Robot {
            toml: model.to_toml(),
            model,
            batch: OnceLock::new(),
        })
    }

    /// What computes its jumps, to all digits.
    pub(crate) fn batch(&self) -> &Batch {
        self.batch
            .get_or_init(|| Box::new(Batch::new(&self.model, FINE)))
    }

    /// The same with an error tolerance.
    pub(crate) fn batch_within(&self, tolerance: f64) -> Cow<'_, Batch> {
        if tolerance.total_cmp(&FINE).is_eq() {
            Cow::Borrowed(self.batch())
        } else {
            Cow::Owned(Batch::new(&self.model, tolerance))
        }
    }
}

#[pymethods]
impl Robot {
    #[new]
    #[pyo3(signature = (robot = "rats-planar", *, set = None))]
    fn new(robot: &str, set: Option<&Bound<'_, PyAny>>) -> PyResult<Robot> {
        resolve(robot, &overrides(set)?)
            .map_err(refused)
            .and_then(Robot::of)
    }

    #[classmethod]
    #[pyo3(signature = (text, *, name = "robot.toml", set = None))]
    fn from_toml(
        _: &Bound<'_, PyType>,
        text: &str,
        name: &str,
        set: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Robot> {
        resolve_text(text, name, &overrides(set)?)
            .map_err(refused)
            .and_then(Robot::of)
    }

    #[classmethod]
    #[pyo3(signature = (robot, *, set = None))]
    fn from_dict(
        _: &Bound<'_, PyType>,
        robot: &Bound<'_, PyDict>,
        set: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Robot> {
        let text = toml_value::to_toml(robot)?;
        resolve_text(&text, "robot", &overrides(set)?)
            .map_err(refused)
            .and_then(Robot::of)
    }

    #[getter]
    fn name(&self) -> &str {
        &self.model.name
    }

    #[getter]
    fn toml(&self) -> &str {
        &self.toml
    }

    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        toml_value::to_dict(py, &self.toml)
    }

    fn replace(&self, set: &Bound<'_, PyAny>) -> PyResult<Robot> {
        resolve_text(&self.toml, &self.model.name, &overrides(Some(set))?)
            .map_err(refused)
            .and_then(Robot::of)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        let from_toml = py.get_type::<Robot>().getattr("from_toml")?;
        Ok((from_toml, (self.toml.clone(),)))
    }

    fn __eq__(&self, other: &Robot) -> bool {
        self.toml == other.toml
    }

    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.toml.hash(&mut hasher);
        hasher.finish()
    }

    fn __repr__(&self) -> String {
        format!(
            "Robot({:?}, {} legs, {} kg)",
            self.model.name, self.model.body.legs, self.model.body.mass
        )
    }
}

/// What is wrong with a robot, with the argument in the place of the command's flag.
fn refused(error: impl Display) -> PyErr {
    bad(error.to_string().replace("--set ", "set "))
}

/// Overrides as the command has them: of a dictionary, a text, or several texts.
fn overrides(set: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<String>> {
    let Some(set) = set else { return Ok(vec![]) };
    if let Ok(text) = set.extract() {
        return Ok(vec![text]);
    }
    let given = || {
        bad(format_args!(
            "set = {set}: a dictionary, a text or a list of texts"
        ))
    };
    let Ok(table) = set.cast::<PyDict>() else {
        return set.extract().map_err(|_| given());
    };
    let items = table.iter().map(|(key, value)| {
        let key: String = key.extract().map_err(|_| given())?;
        let value = value.str()?.to_string();
        Ok(format!("{key}={value}"))
    });
    items.collect()
}
