"""Where the jobs of an example run, by its flags."""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any


def add_flags(parser: argparse.ArgumentParser) -> None:
    """`--processes` and `--dask`."""
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--processes", type=int, metavar="COUNT", help="processes of this machine [default: this one alone]")
    where.add_argument("--dask", metavar="ADDRESS", help="scheduler of Dask, as tcp://host:8786; `local` starts one here")


@contextlib.contextmanager
def client(given: argparse.Namespace) -> Iterator[Any]:
    """What `saltus.sweep` takes as client."""
    if given.dask is not None:
        from distributed import Client

        with Client(None if given.dask == "local" else given.dask) as dask:
            yield dask
    elif given.processes is not None:
        with ProcessPoolExecutor(given.processes, mp_context=get_context("spawn")) as pool:
            yield pool
    else:
        yield None
