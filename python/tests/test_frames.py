"""Data of frames are data of a folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas
import polars
import pytest

import saltus

tomllib = pytest.importorskip("tomllib")


def frames_of(folder: Path, read: Any) -> tuple[list[Any], dict[str, Any]]:
    experiment = tomllib.loads((folder / "experiment.toml").read_text())
    runs = experiment.pop("run")
    robot = saltus.Robot(str(folder / experiment["robot"])) if (folder / experiment["robot"]).exists() else experiment["robot"]
    frames = [read(folder / run.pop("file")) for run in runs]
    return frames, {**experiment, "robot": robot, "runs": runs}


def mapping(path: Path) -> dict[str, np.ndarray[Any, Any]]:
    return dict(saltus.Columns.of_csv(path))


READERS = {"mapping": mapping, "pandas": pandas.read_csv, "polars": polars.read_csv}


@pytest.mark.parametrize("kind", READERS)
def test_a_diagnosis_of_frames_is_that_of_the_folder(kind: str, bench: Path) -> None:
    frames, experiment = frames_of(bench, READERS[kind])
    from_folder, from_frames = saltus.diagnose(bench), saltus.diagnose(frames, experiment=experiment)
    assert from_frames.causes == from_folder.causes
    assert from_frames.gain == from_folder.gain
    assert saltus.fit(frames, experiment=experiment).parameters == saltus.fit(bench).parameters


def test_one_frame_is_one_run(bench: Path) -> None:
    frames, experiment = frames_of(bench, mapping)
    experiment["runs"] = experiment["runs"][:1]
    assert saltus.fit(frames[0], experiment=experiment).data["runs"] == 1


def test_bad_frames_are_refused(bench: Path) -> None:
    frames, experiment = frames_of(bench, mapping)
    one = {**experiment, "runs": experiment["runs"][:1]}

    def refused(data: Any, text: str, how: Any = one) -> None:
        with pytest.raises(saltus.SaltusError, match=text):
            saltus.diagnose(data, experiment=how)

    first = frames[0]
    time = next(iter(first))
    refused([], "is empty")
    refused(frames, "1 of them: one for each of the 12 frames")
    refused({**first, time: first[time][:-1]}, "columns of one length")
    refused({**first, time: first[time][:, None]}, r"shape \(\d+, 1\): one dimension")
    refused({**first, time: first[time] * 1j}, "complex128: numbers or texts")
    refused({name: first[name] for name in first if name != time}, f"{time}")
    refused({}, "has no columns")
    refused(3, "a mapping of arrays or a data frame")
    refused(first, "frames need it", None)
    refused(first, "a list of dictionaries", {**one, "runs": 3})
    refused(str(bench), "is for frames")
    late = first[time].copy()
    late[3] = late[2]
    refused(first, "^experiment:.*load_mass", {**one, "runs": [{}]})
    refused({**first, time: late}, r"data\[0\], row 3")
