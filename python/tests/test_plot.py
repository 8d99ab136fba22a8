"""Plots show what the answers say."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import BOX

import saltus

pytest.importorskip("matplotlib").use("Agg")

import saltus.plot  # noqa: E402


def test_a_table() -> None:
    answer = saltus.table(omega_rad_s=[4, 5, 9], distance_m=[0.6, 0.7])
    axes = saltus.plot.table(answer)
    lines = axes.get_lines()
    assert len(lines) == 6
    assert np.array_equal(lines[0].get_ydata(), answer.rows["alpha_f_rad"][::2], equal_nan=True)
    assert saltus.plot.table(answer, axes) is axes


def test_a_map() -> None:
    answer = saltus.map(omega_rad_s=[3, 4, 5], alpha_f_rad=[-0.2, 0.0, 0.2])
    axes = saltus.plot.map(answer)
    assert [it.get_title() for it in axes] == ["rats-planar: distance", "rats-planar: apex"]
    with pytest.raises(saltus.SaltusError, match="two or more"):
        saltus.plot.map(saltus.map(omega_rad_s=3, alpha_f_rad=[-0.2, 0.0]))


def test_a_plan_lands_where_it_says() -> None:
    answer = saltus.plan(BOX)
    axes = saltus.plot.plan(answer)
    flight = axes.get_lines()[1]
    assert flight.get_xdata()[-1] == pytest.approx(answer.jumps[0]["land_x_m"], abs=1e-9)
    assert max(flight.get_ydata()) == pytest.approx(answer.jumps[0]["apex_m"], abs=1e-3)
    assert axes.patches[0].get_height() == answer.obstacles[0]["height_m"]


def test_a_diagnosis(bench: Path, tmp_path: Path) -> None:
    axes = saltus.plot.diagnosis(saltus.diagnose(bench))
    assert axes.get_title() == "coulomb-friction"
    saltus.inject(out=tmp_path / "none")
    clean = saltus.plot.diagnosis(saltus.diagnose(tmp_path / "none"))
    assert clean.get_title() == "nothing wrong"


def test_other_answers_are_refused() -> None:
    with pytest.raises(saltus.SaltusError, match="map: table: an answer of saltus.map"):
        saltus.plot.map(saltus.table(omega_rad_s=5, distance_m=0.6))
