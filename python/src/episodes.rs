//! Robots that learn, in episodes that go on side by side.

use std::sync::{Arc, Mutex, PoisonError};

use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyUntypedArrayMethods,
};
use pyo3::intern;
use pyo3::types::{PyDict, PyDictMethods};
use pyo3::{Bound, PyResult, Python, pyclass, pymethods};
use saltus::gait::Draw;
use saltus::gait::GaitError;
use saltus::gait::learn::{Act, Actions, Environment, Episode, Outcome, Reward, Step, Term};
use saltus::learning::Task;
use saltus::numeric::parallel::map_on;

use crate::error::bad;
use crate::robot::Robot;

/// Observations, rewards, and which are terminated and truncated.
type Stepped<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray1<bool>>,
);

/// Episodes of a task, each of its own.
#[pyclass(frozen, module = "saltus._saltus")]
pub(crate) struct Episodes {
    environment: Arc<dyn Environment>,
    running: Vec<Mutex<Option<Box<dyn Episode>>>>,
    threads: usize,
    /// Least and greatest value of what is observed.
    bounds: Vec<[f64; 2]>,
}

/// What is observed, within its space.
fn clipped(episode: &dyn Episode, bounds: &[[f64; 2]]) -> Vec<f64> {
    let observed = episode.observation().iter().zip(bounds);
    observed
        .map(|(x, [low, high])| x.clamp(*low, *high))
        .collect()
}

/// What an episode alone gives.
type One<'py> = (
    Bound<'py, PyArray1<f64>>,
    f64,
    bool,
    bool,
    Bound<'py, PyDict>,
);

#[pymethods]
impl Episodes {
    #[new]
    fn new(
        task: &str,
        robot: &Robot,
        count: usize,
        threads: usize,
        reward: Vec<(String, f64)>,
        steps: Option<usize>,
        draw: bool,
    ) -> PyResult<Episodes> {
        let known = Task::ALL.into_iter().find(|it| it.name() == task);
        let known = known.ok_or_else(|| {
            let names = Task::ALL.map(Task::name).join(", ");
            bad(format_args!("task = {task:?}: one of {names}"))
        })?;
        let mut settings = known.settings(robot.model.clone(), known.algorithm());
        if !reward.is_empty() {
            settings.reward = Reward(reward.iter().map(term).collect::<PyResult<_>>()?);
        }
        settings.steps = steps.unwrap_or(settings.steps);
        settings.plant.draw = draw.then(|| Draw::around(&settings.plant.robot));
        let environment = settings.environment().map_err(bad)?;
        let axes = environment.observed().iter();
        Ok(Episodes {
            bounds: axes.map(|axis| [axis.low, axis.high]).collect(),
            environment: Arc::from(environment),
            running: (0..count).map(|_| Mutex::new(None)).collect(),
            threads,
        })
    }

    /// What is observed: name, unit, least and greatest value.
    #[getter]
    fn observed(&self) -> Vec<(&'static str, &'static str, f64, f64)> {
        let axes = self.environment.observed().iter();
        axes.map(|it| (it.name, it.unit, it.low, it.high)).collect()
    }

    /// Names of the actions.
    #[getter]
    fn choices(&self) -> usize {
        self.environment.actions().choices().unwrap_or(0)
    }

    /// What is chosen where actions are numbers: name, unit, least and greatest value.
    #[getter]
    fn chosen(&self) -> Vec<(&'static str, &'static str, f64, f64)> {
        match self.environment.actions() {
            Actions::Values(axes) => axes
                .iter()
                .map(|it| (it.name, it.unit, it.low, it.high))
                .collect(),
            Actions::Choices(_) => Vec::new(),
        }
    }

    /// Begins the episodes `which` with `seeds`, and gives their observations.
    fn start<'py>(
        &self,
        py: Python<'py>,
        which: Vec<usize>,
        seeds: Vec<u64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        if which.len() != seeds.len() || which.iter().any(|k| *k >= self.running.len()) {
            return Err(bad("a seed for each of the episodes there are"));
        }
        let observed = py.detach(|| {
            let pairs: Vec<(usize, u64)> = which.into_iter().zip(seeds).collect();
            let one = |k: usize| -> Result<Vec<f64>, GaitError> {
                let (place, seed) = pairs[k];
                let episode = self.environment.start(seed)?;
                let observation = clipped(episode.as_ref(), &self.bounds);
                *self.running[place]
                    .lock()
                    .unwrap_or_else(PoisonError::into_inner) = Some(episode);
                Ok(observation)
            };
            let all = map_on(self.threads, pairs.len(), one);
            all.into_iter().collect::<Result<Vec<_>, _>>()
        });
        self.array(py, observed.map_err(bad)?)
    }

    /// Does an action in each episode; those whose action is negative stay as they are.
    fn step<'py>(
        &self,
        py: Python<'py>,
        actions: PyReadonlyArray1<'py, i64>,
    ) -> PyResult<Stepped<'py>> {
        let actions = actions.as_slice().map_err(bad)?.to_vec();
        self.all(py, actions.len(), |k| {
            let choice = usize::try_from(actions[k]).ok();
            self.one(k, choice.map(Act::Choice))
        })
    }

    /// The same with numbers; episodes whose numbers are none stay as they are.
    fn step_by<'py>(
        &self,
        py: Python<'py>,
        actions: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Stepped<'py>> {
        let rows = actions.shape()[0];
        let actions = actions.as_slice().map_err(bad)?.to_vec();
        let width = actions.len() / rows.max(1);
        self.all(py, rows, |k| {
            let values = &actions[k * width..(k + 1) * width];
            let acts = values.iter().any(|x| !x.is_nan());
            self.one(k, acts.then_some(Act::Values(values)))
        })
    }

    /// A choice in episode `k` alone: its observation, reward, whether it is terminated or truncated, and what it has come to.
    fn choose<'py>(&self, py: Python<'py>, k: usize, choice: usize) -> PyResult<One<'py>> {
        self.alone(py, k, Act::Choice(choice))
    }

    /// The same with numbers.
    fn choose_by<'py>(&self, py: Python<'py>, k: usize, values: Vec<f64>) -> PyResult<One<'py>> {
        self.alone(py, k, Act::Values(&values))
    }

    /// What episode `k` has come to.
    fn outcome<'py>(&self, py: Python<'py>, k: usize) -> PyResult<Bound<'py, PyDict>> {
        let Some(running) = self.running.get(k) else {
            let count = self.running.len();
            return Err(bad(format_args!("episode {k}: one of {count}")));
        };
        let running = running.lock().unwrap_or_else(PoisonError::into_inner);
        match running.as_ref() {
            Some(episode) => told(py, &episode.outcome()),
            None => Ok(PyDict::new(py)),
        }
    }
}

/// An outcome as a dictionary.
fn told<'py>(py: Python<'py>, it: &Outcome) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item(intern!(py, "time_s"), it.time)?;
    dict.set_item(intern!(py, "angle_rad"), it.angle)?;
    dict.set_item(intern!(py, "travel_m"), it.travel)?;
    dict.set_item(intern!(py, "arrived_s"), it.arrived)?;
    dict.set_item(intern!(py, "gas_kg"), it.gas)?;
    dict.set_item(intern!(py, "firings"), it.firings)?;
    dict.set_item(intern!(py, "broken"), it.broken)?;
    Ok(dict)
}

impl Episodes {
    /// Does `one` in each of so many episodes, which must be all.
    fn all<'py>(
        &self,
        py: Python<'py>,
        given: usize,
        one: impl Fn(usize) -> Result<(Vec<f64>, Step), GaitError> + Sync,
    ) -> PyResult<Stepped<'py>> {
        let count = self.running.len();
        if given != count {
            return Err(bad(format_args!("actions: {given} rows: {count}")));
        }
        let stepped = py.detach(|| {
            let all = map_on(self.threads, count, &one);
            all.into_iter().collect::<Result<Vec<_>, _>>()
        });
        let (mut observed, mut steps) = (Vec::new(), Vec::new());
        for (observation, step) in stepped.map_err(bad)? {
            observed.push(observation);
            steps.push(step);
        }
        let of = |part: fn(&Step) -> bool| steps.iter().map(part).collect::<Vec<_>>();
        let rewards: Vec<f64> = steps.iter().map(|step| step.reward).collect();
        Ok((
            self.array(py, observed)?,
            rewards.into_pyarray(py),
            of(|step| step.terminated).into_pyarray(py),
            of(|step| step.truncated).into_pyarray(py),
        ))
    }

    fn alone<'py>(&self, py: Python<'py>, k: usize, act: Act<'_>) -> PyResult<One<'py>> {
        if k >= self.running.len() {
            return Err(bad(format_args!(
                "episode {k}: one of {}",
                self.running.len()
            )));
        }
        let done = py.detach(|| self.one(k, Some(act)));
        let (observation, step) = done.map_err(bad)?;
        Ok((
            PyArray1::from_vec(py, observation),
            step.reward,
            step.terminated,
            step.truncated,
            self.outcome(py, k)?,
        ))
    }

    fn one(&self, k: usize, act: Option<Act<'_>>) -> Result<(Vec<f64>, Step), GaitError> {
        let mut running = self.running[k]
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let missing = || GaitError::Input {
            name: "episode".into(),
            value: k as f64,
            allowed: "begun by `reset` before `step`".into(),
        };
        let episode = running.as_mut().ok_or_else(missing)?;
        let stays = Step {
            reward: 0.0,
            terminated: false,
            truncated: false,
        };
        let step = act.map_or(Ok(stays), |act| episode.step(act))?;
        Ok((clipped(episode.as_ref(), &self.bounds), step))
    }

    fn array<'py>(
        &self,
        py: Python<'py>,
        rows: Vec<Vec<f64>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let shape = [rows.len(), self.environment.observed().len()];
        PyArray1::from_vec(py, rows.concat()).reshape(shape)
    }
}

/// A term of a reward and its coefficient.
fn term((name, by): &(String, f64)) -> PyResult<(Term, f64)> {
    let term = Term::written(name);
    let term = term.ok_or_else(|| bad(format_args!("reward {name}: {}", Term::WRITTEN)))?;
    Ok((term, *by))
}
