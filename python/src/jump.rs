//! Jumps: one, or arrays of them.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::atomic::Ordering;

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::types::{PyAnyMethods, PyDict, PyDictMethods};
use pyo3::{Bound, PyAny, PyResult, Python, pyclass, pyfunction, pymethods};
use saltus::lagrangian::Batch;
use saltus::numeric::parallel::in_chunks;
use saltus::planner::flight_after;
use saltus::{DragFlight, Flight, Launch, LiftOff, Outcome, StanceError};

use crate::detached::detached;
use crate::error::bad;
use crate::robot::Robot;

/// Jumps that are computed side by side: as many as by `saltus simulate`, for the same bits.
const SIDE_BY_SIDE: usize = 256;
/// Columns of numbers of a jump.
const COLUMNS: usize = 14;

/// Every outcome, in the order of `saltus.OUTCOMES`.
const OUTCOMES: [Outcome; 6] = [
    Outcome::Stroke,
    Outcome::Force,
    Outcome::Stall,
    Outcome::NoBreakAway,
    Outcome::EarlyLiftOff,
    Outcome::FallBack,
];

/// Of a jump's pickle.
type State = (&'static str, Vec<Option<f64>>);

/// Outcomes by their place in `OUTCOMES`, and the columns of numbers.
type Arrays<'py> = (Bound<'py, PyArray1<u8>>, Vec<Bound<'py, PyArray1<f64>>>);

/// A jump of these numbers: given ones, and those of what comes of it.
macro_rules! jump {
    ($($given:ident)*; $($number:ident)*) => {
        /// One jump.
        #[pyclass(frozen, module = "saltus._saltus", get_all)]
        pub(crate) struct Jump {
            outcome: &'static str,
            $($given: f64,)*
            $($number: Option<f64>,)*
        }

        /// Names of the numbers of a jump, in order.
        const NAMES: [&str; COLUMNS + 4] =
            [$(stringify!($given),)* $(stringify!($number),)*];

        impl Jump {
            /// Of an outcome and the numbers by [`NAMES`], NaN where there is none.
            fn of(outcome: &'static str, numbers: [f64; COLUMNS + 4]) -> Jump {
                let [$($given,)* $($number,)*] = numbers;
                let known = |number: f64| (!number.is_nan()).then_some(number);
                Jump { outcome, $($given,)* $($number: known($number),)* }
            }

            /// The numbers by [`NAMES`].
            fn numbers(&self) -> [Option<f64>; COLUMNS + 4] {
                [$(Some(self.$given),)* $(self.$number,)*]
            }
        }
    };
}

jump! {
    omega_rad_s start_lean_rad alpha_f_rad valve_open_s;
    t_fire_s t_liftoff_s phi_rad omega_liftoff_rad_s d_m d_dot_m_s pressure_pa
    x_m y_m vx_m_s vy_m_s apex_m land_rs_m land_0_m
}

impl Jump {
    fn plain(&self) -> (&'static str, [u64; COLUMNS + 4]) {
        let bits = self
            .numbers()
            .map(|number| number.unwrap_or(f64::NAN).to_bits());
        (self.outcome, bits)
    }
}

#[pymethods]
impl Jump {
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("outcome", self.outcome)?;
        for (name, number) in NAMES.iter().zip(self.numbers()) {
            dict.set_item(name, number)?;
        }
        Ok(dict)
    }

    /// What a pickle calls.
    #[staticmethod]
    fn _of(outcome: &str, numbers: Vec<Option<f64>>) -> PyResult<Jump> {
        let outcome = OUTCOMES.iter().find(|it| it.name() == outcome);
        let numbers = <[_; COLUMNS + 4]>::try_from(numbers).ok();
        match (outcome, numbers) {
            (Some(outcome), Some(numbers)) => Ok(Jump::of(
                outcome.name(),
                numbers.map(|number| number.unwrap_or(f64::NAN)),
            )),
            _ => Err(bad("this is no pickle of a jump")),
        }
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, State)> {
        let of = py.get_type::<Jump>().getattr("_of")?;
        Ok((of, (self.outcome, self.numbers().to_vec())))
    }

    fn __eq__(&self, other: &Jump) -> bool {
        self.plain() == other.plain()
    }

    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.plain().hash(&mut hasher);
        hasher.finish()
    }

    fn __repr__(&self) -> String {
        let known = NAMES.iter().zip(self.numbers());
        let known = known.filter_map(|(name, number)| Some(format!(", {name}={:?}", number?)));
        format!("Jump({:?}{})", self.outcome, known.collect::<String>())
    }

    fn _repr_html_(&self) -> String {
        let known = NAMES.iter().zip(self.numbers());
        let rows = known.filter_map(|(name, number)| {
            Some(format!("<tr><th>{name}</th><td>{:.6}</td></tr>", number?))
        });
        format!(
            "<table><tr><th>outcome</th><td>{}</td></tr>{}</table>",
            self.outcome,
            rows.collect::<String>()
        )
    }
}

/// One jump of a robot.
#[pyfunction]
#[pyo3(signature = (robot, omega_rad_s, alpha_f_rad, *, valve_open_s = 0.1, start_lean_rad = None))]
pub(crate) fn jump(
    robot: &Robot,
    omega_rad_s: f64,
    alpha_f_rad: f64,
    valve_open_s: f64,
    start_lean_rad: Option<f64>,
) -> PyResult<Jump> {
    let launch = Launch {
        rate: omega_rad_s,
        lean: start_lean_rad.unwrap_or(alpha_f_rad),
        firing_angle: alpha_f_rad,
        valve_open: valve_open_s,
    };
    let end = robot.batch().jumps(&[launch]).swap_remove(0);
    let end = end.map_err(|source| bad(reason(&launch, &source)))?;
    let (outcome, after) = row(robot, &end);
    let mut numbers = [f64::NAN; COLUMNS + 4];
    numbers[..4].copy_from_slice(&[launch.rate, launch.lean, alpha_f_rad, valve_open_s]);
    numbers[4..].copy_from_slice(&after);
    Ok(Jump::of(outcome.name(), numbers))
}

/// Many jumps of a robot: the launches as columns of the same length, in; outcomes (places in
/// `OUTCOMES`) and the columns of numbers, NaN where there is none, out.
#[pyfunction]
pub(crate) fn jumps<'py>(
    py: Python<'py>,
    robot: &Bound<'py, Robot>,
    launches: Vec<PyReadonlyArray1<'py, f64>>,
    threads: usize,
    tolerance: f64,
) -> PyResult<Arrays<'py>> {
    let launches = read(&launches)?;
    let robot = robot.clone().unbind();
    let count = launches.len();
    let parts = detached(py, move |stop| {
        let robot = robot.get();
        let batch = robot.batch_within(tolerance);
        in_chunks(&launches, SIDE_BY_SIDE, threads.max(1), |chunk| {
            let go = !stop.load(Ordering::Relaxed);
            if go {
                part(robot, &batch, chunk)
            } else {
                Ok(Part::default())
            }
        })
    })?;
    let mut outcomes = Vec::with_capacity(count);
    let mut columns: [Vec<f64>; COLUMNS] = std::array::from_fn(|_| Vec::with_capacity(count));
    for part in parts {
        let part = part.map_err(|(at, launch, source)| {
            let at = outcomes.len() + at;
            bad(format_args!("jump {at}: {}", reason(&launch, &source)))
        })?;
        outcomes.extend(part.outcomes);
        for (column, of_part) in columns.iter_mut().zip(part.columns) {
            column.extend(of_part);
        }
    }
    let columns = columns.map(|column| PyArray1::from_vec(py, column));
    Ok((PyArray1::from_vec(py, outcomes), columns.into()))
}

/// Results of launches that were computed side by side.
#[derive(Default)]
struct Part {
    outcomes: Vec<u8>,
    columns: [Vec<f64>; COLUMNS],
}

fn part(
    robot: &Robot,
    batch: &Batch,
    launches: &[Launch],
) -> Result<Part, (usize, Launch, StanceError)> {
    let mut part = Part::default();
    for (at, end) in batch.jumps(launches).into_iter().enumerate() {
        let end = end.map_err(|source| (at, launches[at], source))?;
        let (outcome, numbers) = row(robot, &end);
        part.outcomes.push(outcome as u8);
        for (column, number) in part.columns.iter_mut().zip(numbers) {
            column.push(number);
        }
    }
    Ok(part)
}

/// The launches of columns: rate, firing angle, valve time, lean.
fn read(columns: &[PyReadonlyArray1<'_, f64>]) -> PyResult<Vec<Launch>> {
    let columns: PyResult<Vec<&[f64]>> = columns
        .iter()
        .map(|column| column.as_slice().map_err(bad))
        .collect();
    let [rates, angles, times, leans] = columns?[..] else {
        return Err(bad("four columns"));
    };
    let count = rates.len();
    if [angles, times, leans].iter().any(|it| it.len() != count) {
        return Err(bad("the columns have different lengths"));
    }
    let launch = |k: usize| Launch {
        rate: rates[k],
        lean: leans[k],
        firing_angle: angles[k],
        valve_open: times[k],
    };
    Ok((0..count).map(launch).collect())
}

/// What comes of a stance: outcome and numbers of a row of `saltus simulate`, NaN where empty.
fn row(robot: &Robot, end: &LiftOff) -> (Outcome, [f64; COLUMNS]) {
    let Some(flight) = flight_after(&robot.model, end) else {
        let mut row = [f64::NAN; COLUMNS];
        row[0] = end.time_fire;
        return (end.outcome, row);
    };
    let Flight { x, y, vx, vy, .. } = flight.vacuum;
    let land = |height| flight.range_to_height(height).unwrap_or(f64::NAN);
    let row = [
        end.time_fire,
        end.time,
        end.lean,
        end.rate,
        end.extension,
        end.extension_rate,
        end.pressure,
        x,
        y,
        vx,
        vy,
        flight.apex_height(),
        land(robot.model.body.radius),
        land(0.0),
    ];
    (end.outcome, row)
}

/// The flight after a lift-off at this place (m) with these speeds (m/s).
fn flight_of(robot: &saltus::Robot, [x, y, vx, vy]: [f64; 4]) -> DragFlight<f64> {
    DragFlight {
        vacuum: Flight {
            x,
            y,
            vx,
            vy,
            gravity: robot.axle_gravity(),
        },
        drag: robot.environment.drag,
    }
}

/// The flight after a jump, from lift-off until the wheel's centre comes down to `height`: times
/// from lift-off, and places.
#[pyfunction]
pub(crate) fn flight<'py>(
    py: Python<'py>,
    robot: &Robot,
    jump: &Jump,
    points: usize,
    height: f64,
) -> PyResult<[Bound<'py, PyArray1<f64>>; 3]> {
    let (Some(x), Some(y), Some(vx), Some(vy)) = (jump.x_m, jump.y_m, jump.vx_m_s, jump.vy_m_s)
    else {
        return Err(bad(format_args!(
            "outcome {:?}: a jump that takes off",
            jump.outcome
        )));
    };
    let flight = flight_of(&robot.model, [x, y, vx, vy]);
    let end = flight.time_to_height(height).map_err(bad)?;
    let mut columns: [Vec<f64>; 3] = std::array::from_fn(|_| Vec::with_capacity(points));
    for (t, x, y) in flight.samples(0.0, end, points) {
        for (column, number) in columns.iter_mut().zip([t, x, y]) {
            column.push(number);
        }
    }
    Ok(columns.map(|column| PyArray1::from_vec(py, column)))
}

/// Why a jump cannot be computed.
fn reason(launch: &Launch, source: &StanceError) -> String {
    format!(
        "omega_rad_s {}, alpha_f_rad {}, valve_open_s {}, start_lean_rad {}: {source}",
        launch.rate, launch.firing_angle, launch.valve_open, launch.lean
    )
}
