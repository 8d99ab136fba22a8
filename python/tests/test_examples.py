"""The examples run, and give the same wherever their jobs do."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from conftest import BOX, ROOT

EXAMPLES = ROOT / "python" / "examples"


def run(name: str, *words: str) -> str:
    done = subprocess.run([sys.executable, EXAMPLES / name, *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_drawn_robots_are_the_same_everywhere() -> None:
    here = run("drawn_robots.py", str(BOX), "--count", "12")
    assert "of 12 robots keep the plan" in here
    assert run("drawn_robots.py", str(BOX), "--count", "12", "--processes", "2") == here


def test_landing_scatter_draws_its_map(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    said = run("landing_scatter.py", str(tmp_path / "map.svg"), "--cells", "2", "--samples", "3")
    assert said.startswith("4 cells") and (tmp_path / "map.svg").read_text().startswith("<?xml")
