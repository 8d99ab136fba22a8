"""Ctrl-C ends work within 0.2 s, leaves no file, and the interpreter's lock is free meanwhile."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import saltus

AFTER = 0.5
"""Time (s) of the signal: all of these take longer."""
WITHIN = 0.2

LONG: dict[str, Callable[[Path, Path], object]] = {
    "jumps": lambda at, bench: saltus.jumps("rats-planar", np.linspace(2, 6, 3_000_000), -0.1, threads=1),
    "table": lambda at, bench: saltus.table(omega_rad_s=np.linspace(2, 6, 3000), distance_m=np.linspace(0.5, 0.7, 100), plot=at),
    "map": lambda at, bench: saltus.map(omega_rad_s=np.linspace(2, 6, 1000), alpha_f_rad=np.linspace(-0.5, 0.5, 1000)),
    "verify": lambda at, bench: saltus.verify(law=(-0.12, 0.38), omega_rad_s=5, distance_m=0.6, plant="rats-boom", samples=100_000),
    "run": lambda at, bench: saltus.run(seconds=600, mcap=at),
    "robots": lambda at, bench: saltus.run(seconds=60, robots=1000),
    "diagnose": lambda at, bench: saltus.diagnose(bench, most=6, report=at),
    "design": lambda at, bench: saltus.design(bench.parent / "plan.toml", effect={"coulomb-friction": 25}),
}


@pytest.fixture(autouse=True)
def heard() -> Iterator[None]:
    """Ctrl-C is heard, even where a shell has started the tests in its background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize("name", LONG)
def test_control_c_ends_work(name: str, tmp_path: Path, bench: Path) -> None:
    (bench.parent / "plan.toml").write_text(
        'kind = "outcomes"\nrobot = "rats-planar"\nnoise = { distance_mm = 10, apex_mm = 10 }\n'
        "[[jump]]\napproach_rate_rad_s = 4\nfiring_angle_rad = -0.1\nvalve_open_s = 0.1\nrepeat = 500\n"
    )
    pressed: list[float] = []

    def press() -> None:
        pressed.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(AFTER, press)
    timer.start()
    at = tmp_path / ("run.mcap" if name == "run" else "out.html" if name == "diagnose" else "out.svg")
    try:
        with pytest.raises(KeyboardInterrupt):
            LONG[name](at, bench)
        late = time.monotonic() - pressed[0]
    finally:
        timer.cancel()
    assert late < WITHIN
    assert not at.exists()
    # What is left of the work does not disturb the next.
    assert saltus.jump("rats-planar", 5.0, -0.1).outcome == "stroke"
    time.sleep(0.3)
    assert not at.exists()


def test_other_threads_go_on_during_work() -> None:
    turns = 0
    over = threading.Event()

    def count() -> None:
        nonlocal turns
        while not over.is_set():
            turns += 1
            time.sleep(0.001)

    other = threading.Thread(target=count)
    other.start()
    saltus.jumps("rats-planar", np.linspace(2, 6, 300_000), -0.1, threads=1)
    over.set()
    other.join()
    assert turns > 50


def test_threads_of_python_work_side_by_side() -> None:
    omega = np.linspace(2, 6, 2000)
    alone = saltus.jumps("rats-planar", omega, -0.1)
    together: list[saltus.Columns] = []
    workers = [threading.Thread(target=lambda: together.append(saltus.jumps("rats-planar", omega, -0.1))) for _ in range(8)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert together == [alone] * 8
