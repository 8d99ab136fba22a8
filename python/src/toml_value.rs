//! Robot files and courses as Python's dictionaries.

use pyo3::types::{PyAnyMethods, PyBool, PyDict, PyDictMethods, PyFloat, PyInt, PyString};
use pyo3::{Bound, IntoPyObjectExt, Py, PyAny, PyResult, Python, pyfunction};
use toml::{Table, Value};

use crate::error::bad;

/// How deep a dictionary may be nested: a list that holds itself has no end.
const DEEPEST: usize = 16;

/// A dictionary as the text of a TOML file.
#[pyfunction]
pub(crate) fn to_toml(table: &Bound<'_, PyDict>) -> PyResult<String> {
    toml::to_string(&table_of(table, "", 0)?).map_err(bad)
}

/// The text of a TOML file as a dictionary.
pub(crate) fn to_dict<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyDict>> {
    let table: Table = text.parse().map_err(bad)?;
    dict(py, &table)
}

fn dict<'py>(py: Python<'py>, table: &Table) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (key, value) in table {
        dict.set_item(key, object(py, value)?)?;
    }
    Ok(dict)
}

fn object(py: Python<'_>, value: &Value) -> PyResult<Py<PyAny>> {
    match value {
        Value::String(text) => text.into_py_any(py),
        Value::Integer(number) => number.into_py_any(py),
        Value::Float(number) => number.into_py_any(py),
        Value::Boolean(is) => is.into_py_any(py),
        Value::Datetime(when) => when.to_string().into_py_any(py),
        Value::Array(all) => {
            let all: PyResult<Vec<_>> = all.iter().map(|value| object(py, value)).collect();
            all?.into_py_any(py)
        }
        Value::Table(table) => dict(py, table)?.into_py_any(py),
    }
}

fn table_of(dict: &Bound<'_, PyDict>, within: &str, depth: usize) -> PyResult<Table> {
    let mut table = Table::new();
    for (key, value) in dict.iter() {
        let key: String = key
            .extract()
            .map_err(|_| bad(format_args!("{within}: keys are texts, not {key}")))?;
        let name = format!("{within}{}{key}", if within.is_empty() { "" } else { "." });
        table.insert(key, value_of(&value, &name, depth + 1)?);
    }
    Ok(table)
}

fn value_of(value: &Bound<'_, PyAny>, name: &str, depth: usize) -> PyResult<Value> {
    if depth > DEEPEST {
        return Err(bad(format_args!(
            "{name}: nested more than {DEEPEST} times"
        )));
    }
    if let Ok(table) = value.cast::<PyDict>() {
        return table_of(table, name, depth).map(Value::Table);
    }
    if value.is_instance_of::<PyString>() {
        return value.extract().map(Value::String);
    }
    if value.is_instance_of::<PyBool>() {
        return value.extract().map(Value::Boolean);
    }
    if value.is_instance_of::<PyInt>() {
        return value
            .extract()
            .map(Value::Integer)
            .map_err(|_| bad(format_args!("{name}: {value}: a whole number of 64 bits")));
    }
    if value.is_instance_of::<PyFloat>() {
        return value.extract().map(Value::Float);
    }
    // Numbers of NumPy, then lists, tuples and arrays.
    if let Ok(number) = value.extract() {
        return Ok(Value::Integer(number));
    }
    if let Ok(number) = value.extract() {
        return Ok(Value::Float(number));
    }
    let items = value.try_iter().map_err(|_| {
        bad(format_args!(
            "{name}: {value}: texts, numbers, booleans, lists and dictionaries"
        ))
    })?;
    let items = items.map(|item| value_of(&item?, name, depth + 1));
    items.collect::<PyResult<_>>().map(Value::Array)
}
