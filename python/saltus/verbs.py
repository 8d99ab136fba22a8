"""The verbs of the command, each as a function.

An argument is the flag of the same name, with its unit: `omega_rad_s` is `--omega`, and
`saltus help VERB` says more of each. `robot` is a `Robot`, the name of a built-in one or a file;
`set` overrides its parameters, as in `{"leg.stroke_m": 0.05}`. Numbers keep every digit. What is
written to files (`plot`, `mcap`, …) appears whole or not at all.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from ._saltus import SaltusError
from ._words import Place, ask, items, words_of
from .answers import Answer, Columns
from .frames import Data, folders_of
from .jumps import RobotLike

__all__ = [
    "design",
    "diagnose",
    "export",
    "export_gait",
    "filling",
    "fit",
    "inject",
    "jump_over",
    "law",
    "learn",
    "map",
    "plan",
    "run",
    "simulate",
    "table",
    "verify",
]

PathLike = str | os.PathLike[str]
Overrides = Mapping[str, Any] | Sequence[str]
Span = tuple[float, float]


def simulate(
    *,
    omega_rad_s: ArrayLike,
    alpha_f_rad: ArrayLike,
    valve_open_s: ArrayLike | None = None,
    start_lean_rad: float | str | None = None,
    threads: int | None = None,
    mcap: PathLike | None = None,
    plot: PathLike | None = None,
    robot: RobotLike | None = None,
    set: Overrides = (),
) -> Answer:
    """Jumps with every combination of the given values, each with what the ground bears and where its
    energy goes. For many jumps `jumps` is quicker."""
    return ask("simulate", (), locals())


def table(
    *,
    omega_rad_s: ArrayLike,
    distance_m: ArrayLike | None = None,
    clearance_m: ArrayLike | None = None,
    obstacle_m: tuple[float, float, float] | None = None,
    landing_height_m: float | str | None = None,
    valve_open_s: float | None = None,
    start_lean_rad: float | str | None = None,
    firing_angles_rad: Span | None = None,
    plant: RobotLike | None = None,
    plant_set: Overrides = (),
    threads: int | None = None,
    plot: PathLike | None = None,
    robot: RobotLike | None = None,
    set: Overrides = (),
) -> Answer:
    """The firing angles that reach distances, or keep clearances over an obstacle, over approach rates.

    `answer.yes` is true if every row is feasible."""
    return ask("table", (), locals())


def law(
    *,
    omega_rad_s: ArrayLike,
    distance_m: ArrayLike | None = None,
    clearance_m: ArrayLike | None = None,
    obstacle_m: tuple[float, float, float] | None = None,
    landing_height_m: float | str | None = None,
    valve_open_s: float | None = None,
    start_lean_rad: float | str | None = None,
    firing_angles_rad: Span | None = None,
    tolerance_m: float | None = None,
    plant: RobotLike | None = None,
    plant_set: Overrides = (),
    threads: int | None = None,
    plot: PathLike | None = None,
    robot: RobotLike | None = None,
    set: Overrides = (),
) -> Answer:
    """The linear law α_f = A ω + B that reaches a distance or a clearance."""
    return ask("law", (), locals())


def filling(
    *,
    omega_rad_s: float,
    alpha_f_rad: float,
    clear_m: float | None = None,
    pause_s: float | None = None,
    landing_height_m: float | str | None = None,
    valve_open_s: float | None = None,
    start_lean_rad: float | str | None = None,
    plot: PathLike | None = None,
    robot: RobotLike | None = None,
    set: Overrides = (),
) -> Answer:
    """How far a filling of a robot's tank carries: jumps, and metres, until one does not count.

    `answer.yes` is true if any jump counts."""
    return ask("filling", (), locals())


def map(
    *,
    omega_rad_s: ArrayLike,
    alpha_f_rad: ArrayLike,
    landing_height_m: float | str | None = None,
    valve_open_s: float | None = None,
    start_lean_rad: float | str | None = None,
    friction: bool = False,
    plant: RobotLike | None = None,
    plant_set: Overrides = (),
    threads: int | None = None,
    plot: PathLike | None = None,
    robot: RobotLike | None = None,
    set: Overrides = (),
) -> Answer:
    """Distance and apex over approach rates and firing angles. `friction` adds what each stance needs."""
    return ask("map", (), locals())


def plan(
    course: Place,
    *,
    plant: RobotLike | None = None,
    plant_set: Overrides = (),
    share: float | None = None,
    samples: int | None = None,
    seed: int | None = None,
    friction: ArrayLike | None = None,
    threads: int | None = None,
    plot: PathLike | None = None,
    robot: RobotLike | None = None,
    set: Overrides = (),
) -> Answer:
    """The plan of a course: a TOML file, or a dictionary with the same keys.

    With `share` it holds in that share of runs with errors drawn. An infeasible course is an answer:
    see `answer.status` and `answer.nearest`."""
    arguments = locals()
    return ask("plan", (course,), {name: value for name, value in arguments.items() if name != "course"})


def verify(
    subject: Place | None = None,
    *,
    correct: bool = False,
    law: tuple[float, float] | None = None,
    omega_rad_s: ArrayLike | None = None,
    distance_m: float | None = None,
    obstacle_m: tuple[float, float, float] | None = None,
    landing_height_m: float | str | None = None,
    valve_open_s: float | None = None,
    start_lean_rad: float | str | None = None,
    restart: bool = False,
    plant: RobotLike | None = None,
    plant_set: Overrides = (),
    friction: ArrayLike | None = None,
    samples: int | None = None,
    scatter: float | None = None,
    seed: int | None = None,
    tolerance_m: float | None = None,
    clearance_m: float | None = None,
    share: float | None = None,
    threads: int | None = None,
    animate: PathLike | None = None,
    mcap: PathLike | None = None,
    plot: PathLike | None = None,
    robot: RobotLike | None = None,
    set: Overrides = (),
) -> Answer:
    """Flies a course (file or dictionary), a table (.csv) or a law in the multi-body simulation, with
    errors drawn. `answer.yes` is true if it passes; `answer.rows` has each jump."""
    arguments = {name: value for name, value in locals().items() if name != "subject"}
    return ask("verify", () if subject is None else (subject,), arguments)


def run(
    gait: str = "closed-loop",
    *,
    heading_rad: float | None = None,
    path: PathLike | None = None,
    truth: bool = False,
    policy: PathLike | None = None,
    firing_angle_rad: float | None = None,
    valve_open_s: float | None = None,
    from_rad: float | None = None,
    to_rad: float | None = None,
    steepness_per_s: float | None = None,
    shift: float | None = None,
    centre: str | None = None,
    lines: str | None = None,
    switch_rad_s: float | None = None,
    first_slope_s: float | None = None,
    top_rate_rad_s: float | None = None,
    knots: Sequence[tuple[float, float, float]] | None = None,
    aim: str | None = None,
    speed: Sequence[Span] | None = None,
    zone_rad: float | None = None,
    direction: str | None = None,
    taps: ArrayLike | None = None,
    seconds: float | None = None,
    disturb: Sequence[str] = (),
    step_s: float | None = None,
    exact: bool = False,
    seed: int | None = None,
    robots: int | None = None,
    drawn_across: float | None = None,
    telemetry: PathLike | None = None,
    believed: RobotLike | None = None,
    rows: bool = False,
    threads: int | None = None,
    animate: PathLike | None = None,
    mcap: PathLike | None = None,
    plot: PathLike | None = None,
    robot: RobotLike | None = None,
    set: Overrides = (),
) -> Answer:
    """A run of a robot whose legs are fired in turn. A stall is an answer: `answer.yes` is false.

    `gait` is that of the command; each takes flags of its own. `policy`, a file that `saltus learn --out` wrote, runs in its place. `knots` are (rate, angle, time), `speed` (time, speed in m/s). With `rows` the answer has a row
    for each cycle, as `--format csv` does (one robot in its plane). `heading_rad`, `path` (a CSV file) and `truth` are of a
    robot in space."""
    arguments = {name: value for name, value in locals().items() if name not in ("gait", "policy", "rows")}
    verb = f"run {gait}" if policy is None else "run policy"
    file: tuple[PathLike, ...] = () if policy is None else (policy,)
    if not rows:
        return ask(verb, file, arguments)
    if telemetry is not None:
        answer = ask(verb, file, arguments)
        return Answer(answer.json, answer.yes, answer.messages, Columns.of_csv(Path(telemetry, "cycles.csv")))
    with tempfile.TemporaryDirectory(prefix="saltus-") as folder:
        answer = ask(verb, file, {**arguments, "telemetry": Path(folder, "run")})
        return Answer(answer.json, answer.yes, answer.messages, Columns.of_csv(Path(folder, "run", "cycles.csv")))


def jump_over(
    obstacle: str,
    *,
    legs: int | None = None,
    sought_on: int | None = None,
    generations: int | None = None,
    runs: int | None = None,
    rounds: int | None = None,
    room: float | None = None,
    robots: int | None = None,
    seed: int | None = None,
    threads: int | None = None,
    robot: RobotLike | None = None,
    set: Overrides = (),
) -> Answer:
    """A jump over a box out of a run: the verb `saltus jump`. `obstacle` is HEIGHTxLENGTH@FRONT in m,
    as in "0.1x0.21@1:6"."""
    return ask("jump", (), locals())


def learn(
    task: str,
    *,
    algorithm: str | None = None,
    alpha: float | None = None,
    gamma: float | None = None,
    lambda_: float | None = None,
    epsilon: float | None = None,
    decay: float | None = None,
    reward: Mapping[str, float] | Sequence[str] = (),
    state: Mapping[str, tuple[float, float, int]] | Sequence[str] = (),
    episodes: int | None = None,
    steps: int | None = None,
    seeds: int | None = None,
    seed: int | None = None,
    draw: bool = False,
    disturb: Sequence[str] = (),
    resume: PathLike | None = None,
    threads: int | None = None,
    plot: PathLike | None = None,
    robot: RobotLike | None = None,
    set: Overrides = (),
) -> Answer:
    """A robot that learns: `task` is "run-legs", "climb", "run-zone", "run-stride" or "jump-stride".

    `reward` has coefficients, as in `{"rate": 1, "gas": 100}`; `state` has from, to and number of the steps of what is
    observed, as in `{"wheel_rate": (-5, 20, 25)}`. `answer.policy` is what `resume` goes on from,
    once `answer.json` is in a file. For learners of your own see `saltus.env`."""
    arguments = {name: value for name, value in locals().items() if name != "task"}
    return ask("learn", (task,), arguments)


def diagnose(
    data: Data,
    *,
    experiment: Mapping[str, Any] | None = None,
    robot: RobotLike | None = None,
    set: Overrides = (),
    extend: PathLike | None = None,
    report: PathLike | None = None,
    evidence: PathLike | None = None,
    check: PathLike | None = None,
    model_error: float | None = None,
    known: Mapping[str, Any] | Sequence[str] = (),
    most: int | None = None,
    seed: int | None = None,
    replan: Place | None = None,
    plant: RobotLike | None = None,
    plant_set: Overrides = (),
) -> Answer:
    """What a simulation gets wrong about measured data.

    `data` is a folder, several, or a frame of a run (a mapping of arrays, a data frame of pandas or
    polars), or several frames; then `experiment` has the keys of experiment.toml, as in
    `{"kind": "bench", "robot": "rats-planar", "runs": [{"load_mass_kg": 2.2, …}]}`. `known` has
    values with standard deviations, as in `{"gravity": (9.81, 0.02)}`. `answer.yes` is true if
    nothing is wrong; `answer.causes` names what is. With `check` it is true if that file of evidence holds."""
    arguments = {name: value for name, value in locals().items() if name not in ("data", "experiment")}
    with folders_of(data, experiment) as folders:
        return ask("diagnose", folders, arguments)


def design(
    plan: PathLike,
    *,
    effect: Mapping[str, Any] | Sequence[str] = (),
    propose: int | None = None,
    model_error: float | None = None,
    known: Mapping[str, Any] | Sequence[str] = (),
    most: int | None = None,
    seed: int | None = None,
    robot: RobotLike | None = None,
    set: Overrides = (),
) -> Answer:
    """What a planned experiment can tell: how often a diagnosis would name each effect."""
    arguments = {name: value for name, value in locals().items() if name != "plan"}
    return ask("design", (plan,), arguments)


def inject(
    effects: Mapping[str, Any] | Sequence[str] | str = (),
    *,
    out: PathLike,
    kind: str | None = None,
    runs: int | None = None,
    mcap: bool = False,
    seed: int | None = None,
    robot: RobotLike | None = None,
    set: Overrides = (),
) -> Answer:
    """Data with hidden effects, as a folder: `inject({"coulomb-friction": 25}, out="synthetic")`."""
    arguments = {name: value for name, value in locals().items() if name != "effects"}
    return ask("inject", items("effects", effects), arguments)


def fit(
    data: Data,
    *,
    experiment: Mapping[str, Any] | None = None,
    parameters: Sequence[str] | None = None,
    robot_out: PathLike | None = None,
    robot: RobotLike | None = None,
    set: Overrides = (),
) -> Answer:
    """Parameters of a leg from benchtop firings, with standard errors. `data` as for `diagnose`."""
    arguments = {name: value for name, value in locals().items() if name not in ("data", "experiment")}
    with folders_of(data, experiment) as folders:
        return ask("fit", folders, arguments)


def export(
    what: str,
    *,
    out: PathLike | None = None,
    name: str | None = None,
    distance_m: ArrayLike | None = None,
    omega_rad_s: ArrayLike | None = None,
    alpha_f_rad: ArrayLike | None = None,
    landing_height_m: float | str | None = None,
    valve_open_s: float | None = None,
    start_lean_rad: float | str | None = None,
    valve_range_s: Span | None = None,
    newton: int | None = None,
    extra_delay_s: float | None = None,
    tolerance_m: float | None = None,
    real: str | None = None,
    plant: RobotLike | None = None,
    plant_set: Overrides = (),
    threads: int | None = None,
    robot: RobotLike | None = None,
    set: Overrides = (),
) -> str:
    """The robot for another program: `what` is "c", "rust", "mjcf" or "urdf". Gives the text that the
    command prints: the model where `out` is not given, else a report.

    A controller (c, rust) needs `out`, a folder or a file. It raises `SaltusError` if no cell of the
    tables can be used.
    """
    arguments = {name: value for name, value in locals().items() if name != "what"}
    if not isinstance(what, str) or what not in ("c", "rust", "mjcf", "urdf"):
        raise SaltusError(f"what = {what!r}: c, rust, mjcf or urdf")
    yes, report, _ = words_of(f"export {what}", (), arguments, ())
    if not yes:
        raise SaltusError(report)
    return report


def export_gait(
    gait: str,
    *,
    out: PathLike,
    firing_angle_rad: float | None = None,
    valve_open_s: float | None = None,
    from_rad: float | None = None,
    to_rad: float | None = None,
    steepness_per_s: float | None = None,
    shift: float | None = None,
    centre: str | None = None,
    lines: str | None = None,
    switch_rad_s: float | None = None,
    first_slope_s: float | None = None,
    top_rate_rad_s: float | None = None,
    knots: Sequence[tuple[float, float, float]] | None = None,
    aim: str | None = None,
    zone_rad: float | None = None,
    taps: ArrayLike | None = None,
    real: str | None = None,
    robot: RobotLike | None = None,
    set: Overrides = (),
) -> str:
    """What decides on a running robot, in C: the gaits of `run` that a robot's own processor knows. Gives what heads
    the files in the folder `out`."""
    arguments = {name: value for name, value in locals().items() if name != "gait"}
    return words_of(f"export gait {gait}", (), arguments, ())[1]


def export_policy(
    policy: PathLike,
    *,
    out: PathLike,
    real: str | None = None,
) -> str:
    """What was learnt, for a controller, in C. Gives what heads the files in the folder `out`."""
    arguments = {name: value for name, value in locals().items() if name != "policy"}
    return words_of("export policy", (policy,), arguments, ())[1]
