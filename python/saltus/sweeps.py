"""Many jobs over threads, processes or machines."""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable, Iterable
from concurrent.futures import Executor
from typing import Any, TypeVar

from ._saltus import SaltusError

__all__ = ["seed_of", "sweep"]

T = TypeVar("T")

RETRIES = 3
"""How often a job is done again whose worker died."""


def sweep(jobs: Iterable[Callable[..., T]], client: Any = None, *, seed: int | None = None) -> list[T]:
    """The results of `jobs`, in their order, whoever computes them.

    A job is called without arguments; `functools.partial(saltus.verify, "box.toml", threads=1)` makes
    one that pickles. With `seed`, job k is called with `seed=` a number of its own, which depends on
    `seed` and k alone. The same jobs give the same bytes everywhere.

    `client`: None works through them here. A `dask.distributed.Client` does it on its workers, and does
    the jobs of a dead worker again. A `concurrent.futures` executor, or the module `ray`, does too. Say
    `threads=1` in jobs whose workers have one core each.
    """
    work: list[Callable[..., T]] = []
    for k, job in enumerate(jobs):
        if not callable(job):
            raise SaltusError(f"jobs[{k}] = {job!r}: something to call, as functools.partial(saltus.verify, …)")
        work.append(job if seed is None else functools.partial(job, seed=seed_of(seed, k)))
    if client is None:
        return [job() for job in work]
    if isinstance(client, Executor):
        return [future.result() for future in [client.submit(job) for job in work]]
    if hasattr(client, "gather") and hasattr(client, "submit"):
        futures = [client.submit(job, pure=False, retries=RETRIES) for job in work]
        results: list[T] = client.gather(futures)
        return results
    if hasattr(client, "remote") and hasattr(client, "get"):
        call = client.remote(max_retries=RETRIES)(_call)
        of_ray: list[T] = client.get([call.remote(job) for job in work])
        return of_ray
    raise SaltusError(f"client = {client!r}: None, a Dask client, an executor of concurrent.futures, or the module ray")


def seed_of(seed: int, job: int) -> int:
    """The seed of a job: 52 bits that depend on the sweep's seed and the job's place alone."""
    digest = hashlib.sha256(f"saltus {seed} {job}".encode()).digest()
    return int.from_bytes(digest[:8], "little") >> 12


def _call(job: Callable[[], T]) -> T:
    return job()
