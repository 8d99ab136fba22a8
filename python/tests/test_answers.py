"""Answers, columns, robots and jumps as Python's objects: they compare, print, pickle, and do not change."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import polars
import pytest

import saltus

ROBOT = saltus.Robot("rats-boom", set=["boom.mass_kg=0.6"])
TABLE = saltus.table(omega_rad_s=[4, 5, 9], distance_m=0.6)
JUMPS = saltus.jumps("rats-planar", [4.0, 5.0, 40.0], -0.1)


@pytest.mark.parametrize(
    "thing",
    [ROBOT, saltus.jump(ROBOT, 5.0, -0.1), saltus.jump(ROBOT, 40.0, 0.5), TABLE, JUMPS, saltus.run(seconds=0.1, rows=True)],
    ids=lambda thing: type(thing).__name__,
)
def test_all_pickle(thing: Any) -> None:
    for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
        again = pickle.loads(pickle.dumps(thing, protocol))
        assert again == thing and repr(again) == repr(thing)
    assert copy.deepcopy(thing) == thing
    assert thing != 1 and thing is not None


def test_errors_pickle() -> None:
    with pytest.raises(saltus.SaltusError) as caught:
        saltus.Robot("nobody")
    again = pickle.loads(pickle.dumps(caught.value))
    assert type(again) is saltus.SaltusError and str(again) == str(caught.value)
    assert isinstance(again, ValueError)


def test_robots_are_values() -> None:
    assert ROBOT == saltus.Robot("rats-boom").replace(["boom.mass_kg=0.6"])
    assert hash(ROBOT) == hash(saltus.Robot.from_toml(ROBOT.toml))
    assert saltus.Robot.from_dict(ROBOT.to_dict()) == ROBOT
    assert ROBOT.to_dict()["boom"]["mass_kg"] == 0.6
    assert ROBOT != saltus.Robot("rats-boom")
    assert ROBOT == saltus.Robot("rats-boom", set={"boom.mass_kg": np.float64(0.6)}) == saltus.Robot("rats-boom", set="boom.mass_kg=0.6")
    assert saltus.jump(ROBOT.to_dict(), 5.0, -0.1) == saltus.jump(ROBOT, 5.0, -0.1)
    assert saltus.table(omega_rad_s=5, distance_m=0.5, robot=ROBOT.to_dict()) == saltus.table(omega_rad_s=5, distance_m=0.5, robot=ROBOT)
    with pytest.raises(AttributeError):
        ROBOT.name = "other"  # type: ignore[misc]


def test_a_dictionary_may_hold_numbers_of_numpy() -> None:
    table = saltus.Robot("rats-planar").to_dict()
    table["body"]["mass_kg"] = np.float32(2.5)
    table["body"]["legs"] = np.int64(4)
    assert saltus.Robot.from_dict(table).to_dict()["body"]["legs"] == 4


def test_jumps_without_a_flight_have_no_numbers() -> None:
    none = saltus.jump("rats-planar", 40.0, 0.5)
    assert none.outcome not in saltus.OUTCOMES[:2] and none.apex_m is None
    assert none.to_dict()["apex_m"] is None
    assert "apex_m" not in repr(none) and "<table>" in none._repr_html_()
    with pytest.raises(saltus.SaltusError, match="takes off"):
        saltus.flight("rats-planar", none)


def test_the_flight_of_a_jump_is_the_jump() -> None:
    jump = saltus.jump("rats-planar", 5.0, -0.1)
    path = saltus.flight("rats-planar", jump, points=2001)
    assert path["y_m"].max() == pytest.approx(jump.apex_m, abs=1e-6)
    assert path["x_m"][-1] == pytest.approx(jump.land_rs_m, abs=1e-12)
    assert path["y_m"][-1] == pytest.approx(0.24, abs=1e-12)
    assert path["x_m"][0] == jump.x_m
    assert np.allclose(np.diff(path["y_m"], 2) / path["t_s"][1] ** 2, -9.80665, rtol=1e-4)


def test_columns_are_read_only_and_named() -> None:
    with pytest.raises(ValueError):
        JUMPS["apex_m"][0] = 1.0
    with pytest.raises(KeyError, match="there are omega0_rad_s"):
        JUMPS["apex"]
    assert JUMPS.rows == 3 and len(JUMPS["apex_m"]) == 3
    assert np.isnan(JUMPS["apex_m"][2])


def test_arrays_of_the_caller_stay_theirs() -> None:
    omega = np.array([4.0, 5.0])
    rows = saltus.jumps("rats-planar", omega, -0.1)
    omega[0] = 9.0
    assert rows["omega0_rad_s"][0] == 4.0


def test_data_frames_take_columns() -> None:
    for frame in (pandas.DataFrame(dict(JUMPS)), JUMPS.to_pandas()):
        assert list(frame) == list(JUMPS) and frame["apex_m"][0] == JUMPS["apex_m"][0]
    assert polars.DataFrame(dict(JUMPS))["apex_m"][1] == JUMPS["apex_m"][1]
    assert TABLE.to_pandas()["status"].tolist() == TABLE.rows["status"].tolist()


def test_answers_are_read_by_name() -> None:
    assert TABLE.command == TABLE["command"] == "table"
    assert TABLE.to_dict() == dict(TABLE)
    assert not TABLE.yes and TABLE.rows.rows == 3
    assert "Answer(table: no, 3 rows" in repr(TABLE) and "<table>" in TABLE._repr_html_()
    assert "rows" in dir(TABLE) and "landing_height_m" in dir(TABLE)
    with pytest.raises(AttributeError, match="there are"):
        TABLE.row
    with pytest.raises(KeyError, match="there are"):
        TABLE["row"]
    with pytest.raises(AttributeError, match="cannot be changed"):
        TABLE.yes = True


def test_an_infeasible_plan_is_an_answer() -> None:
    high = {"approach_rate_rad_s": 5.0, "goal_from_x_m": 0.8, "goal_to_x_m": 1.0, "obstacle": [{"front_x_m": 0.4, "width_m": 0.2, "height_m": 2.0}]}
    answer = saltus.plan(high)
    assert not answer.yes and answer.status == "infeasible" and answer.nearest


def test_messages_are_kept() -> None:
    answer = saltus.table(omega_rad_s=5, distance_m=0.6, set={"leg.stroke_m": 0.6})
    assert any("stroke" in message for message in answer.messages)


def test_courses_are_files_or_dictionaries(tmp_path: Path) -> None:
    course = {"approach_rate_rad_s": 5.0, "target_x_m": 0.9}
    (tmp_path / "course.toml").write_text("approach_rate_rad_s = 5.0\ntarget_x_m = 0.9\n")
    here, there = saltus.plan(course), saltus.plan(tmp_path / "course.toml")
    assert here.jumps == there.jumps and here.course == "course.toml"
