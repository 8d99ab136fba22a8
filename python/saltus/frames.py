"""Measured data that are arrays, as the folder that the command reads."""

from __future__ import annotations

import contextlib
import os
import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ._saltus import Robot, SaltusError, to_toml

__all__ = ["Data", "folders_of"]

Data = str | os.PathLike[str] | Mapping[str, Any] | Sequence[Any] | Any
"""A folder, several, a frame of a run, or several frames: mappings of arrays, or data frames."""


@contextlib.contextmanager
def folders_of(data: Data, experiment: Mapping[str, Any] | None) -> Iterator[list[str]]:
    """The folders with the data; those of frames are there as long as they are needed."""
    items = list(data) if isinstance(data, (list, tuple)) else [data]
    if not items:
        raise SaltusError("data: is empty: a folder, a frame, or several")
    if all(isinstance(item, (str, os.PathLike)) for item in items):
        if experiment is not None:
            raise SaltusError("experiment: is for frames: a folder has its own experiment.toml")
        yield [os.fspath(item) for item in items]
        return
    if experiment is None:
        raise SaltusError("experiment: frames need it: kind, robot, and what was set for each run")
    with tempfile.TemporaryDirectory(prefix="saltus-") as place:
        folder = Path(place, "data")
        folder.mkdir()
        write(folder, items, experiment)
        try:
            yield [str(folder)]
        except SaltusError as error:
            raise SaltusError(with_frames(str(error), folder)) from None


def with_frames(text: str, folder: Path) -> str:
    """A message with frames and rows in the place of files and lines."""
    text = text.replace(f"{folder}{os.sep}", "").replace(str(folder), "data")
    text = re.sub(r"run-(\d+)\.csv:(\d+)", lambda it: f"data[{int(it[1]) - 1}], row {int(it[2]) - 2}", text)
    return re.sub(r"run-(\d+)\.csv", lambda it: f"data[{int(it[1]) - 1}]", text).replace("experiment.toml", "experiment")


def write(folder: Path, frames: Sequence[Any], experiment: Mapping[str, Any]) -> None:
    """The folder of these frames."""
    runs = experiment.get("runs", experiment.get("run", [{}] * len(frames)))
    if not isinstance(runs, (list, tuple)) or not all(isinstance(run, Mapping) for run in runs):
        raise SaltusError(f"experiment.runs: {runs!r}: a list of dictionaries, one for each frame")
    if len(runs) != len(frames):
        raise SaltusError(f"experiment.runs: {len(runs)} of them: one for each of the {len(frames)} frames")
    head = {key: value for key, value in experiment.items() if key not in ("run", "runs")}
    robot = head.get("robot")
    if isinstance(robot, Robot):
        (folder / "robot.toml").write_text(robot.toml, encoding="utf-8")
        head["robot"] = "robot.toml"
    names = [f"run-{number:02}.csv" for number in range(1, len(frames) + 1)]
    tables = [{"file": name, **run} for name, run in zip(names, runs)]
    (folder / "experiment.toml").write_text(to_toml({**head, "run": tables}), encoding="utf-8")
    for number, (name, frame) in enumerate(zip(names, frames)):
        (folder / name).write_text(csv(frame, f"data[{number}]"), encoding="utf-8")


def csv(frame: Any, called: str) -> str:
    """The CSV of a frame, with every digit; what is NaN or None is missing."""
    columns = getattr(frame, "columns", None)
    if columns is None:
        if not isinstance(frame, Mapping):
            raise SaltusError(f"{called}: {type(frame).__name__}: a mapping of arrays or a data frame")
        columns = frame.keys()
    names = [str(name) for name in columns]
    if not names:
        raise SaltusError(f"{called}: has no columns")
    arrays = [column(f"{called}[{name!r}]", frame[key]) for name, key in zip(names, columns)]
    if len({len(array) for array in arrays}) > 1:
        lengths = ", ".join(f"{name} {len(array)}" for name, array in zip(names, arrays))
        raise SaltusError(f"{called}: columns of one length, not {lengths}")
    lines = [",".join(cell(name) for name in names)]
    lines += [",".join(row) for row in zip(*arrays)]
    return "\n".join(lines) + "\n"


def column(called: str, values: Any) -> list[str]:
    """The cells of a column."""
    array = np.asarray(values)
    if array.ndim != 1:
        raise SaltusError(f"{called}: shape {array.shape}: one dimension")
    if array.dtype.kind in "biuf":
        listed = (array.astype(np.int8) if array.dtype.kind == "b" else array).tolist()
        return ["" if value != value else repr(value) for value in listed]
    if array.dtype.kind in "OUT":
        return ["" if value is None or value != value else cell(str(value)) for value in array.tolist()]
    raise SaltusError(f"{called}: {array.dtype}: numbers or texts")


def cell(text: str) -> str:
    """A text as a cell."""
    return '"' + text.replace('"', '""') + '"' if any(sign in text for sign in ',"\r\n') else text
