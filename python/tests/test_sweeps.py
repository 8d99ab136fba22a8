"""A sweep gives the same bytes wherever it runs, and loses nothing with a worker."""

from __future__ import annotations

import functools
import hashlib
import os
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import pytest

import saltus
from saltus.sweeps import seed_of

LAW = {"law": (-0.1245, 0.38), "omega_rad_s": 5, "distance_m": 0.6, "threads": 1, "samples": 10}


def jobs(count: int = 12) -> list[Callable[..., saltus.Answer]]:
    """Verifications over pressures and frictions."""
    return [
        functools.partial(saltus.verify, **LAW, set={"leg.supply_pressure_gauge_psi": 90 + 5 * k}, friction=0.4 + 0.05 * k) for k in range(count)
    ]


def sha256(answers: list[saltus.Answer]) -> str:
    return hashlib.sha256("\n".join(answer.json for answer in answers).encode()).hexdigest()


@pytest.fixture(scope="module")
def here() -> str:
    return sha256(saltus.sweep(jobs(), seed=7))


def test_threads_and_processes_give_the_same_bytes(here: str) -> None:
    with ThreadPoolExecutor(2) as pool:
        assert sha256(saltus.sweep(jobs(), pool, seed=7)) == here
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        assert sha256(saltus.sweep(jobs(), pool, seed=7)) == here


@pytest.mark.parametrize("workers", [1, 2])
def test_dask_gives_the_same_bytes(workers: int, here: str) -> None:
    distributed = pytest.importorskip("distributed")
    with distributed.Client(n_workers=workers, threads_per_worker=1, dashboard_address=None) as client:
        assert sha256(saltus.sweep(jobs(), client, seed=7)) == here


def or_dies(note: str, job: Callable[..., saltus.Answer], seed: int) -> saltus.Answer:
    """A job whose worker dies at the first try."""
    if not os.path.exists(note):
        Path(note).touch()
        os._exit(1)
    time.sleep(0.05)
    return job(seed=seed)


def test_dask_loses_nothing_with_a_worker(here: str, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    note = str(tmp_path / "died")
    work: list[Any] = jobs()
    work[5] = functools.partial(or_dies, note, work[5])
    with distributed.Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
        assert sha256(saltus.sweep(work, client, seed=7)) == here
    assert Path(note).exists()


def test_ray_gives_the_same_bytes(here: str) -> None:
    ray = pytest.importorskip("ray")
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    try:
        assert sha256(saltus.sweep(jobs(), ray, seed=7)) == here
    finally:
        ray.shutdown()


def test_ray_loses_nothing_with_a_worker(here: str, tmp_path: Path) -> None:
    ray = pytest.importorskip("ray")
    note = str(tmp_path / "died")
    work: list[Any] = jobs()
    work[5] = functools.partial(or_dies, note, work[5])
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    try:
        assert sha256(saltus.sweep(work, ray, seed=7)) == here
    finally:
        ray.shutdown()


def test_errors_come_back_from_workers() -> None:
    bad = functools.partial(saltus.verify, **{**LAW, "samples": -1})
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool, pytest.raises(saltus.SaltusError, match="samples"):
        saltus.sweep([bad], pool)


def test_seeds_are_of_the_job_alone() -> None:
    seeds = [seed_of(7, k) for k in range(1000)]
    assert len(set(seeds)) == 1000 and all(0 <= seed < 2**52 for seed in seeds)
    assert seeds[3] == seed_of(7, 3) != seed_of(8, 3)
    assert saltus.sweep([lambda seed: seed] * 4, seed=7) == seeds[:4]
    assert saltus.sweep([]) == []
