"""How many robots, as they come from the workshop, keep a plan that was made for the drawing.

    python drawn_robots.py box.toml --processes 2
    python drawn_robots.py box.toml --plant rats-boom --count 1000 --processes 8

Each robot has the masses, sizes and losses of the plant, off by a normal error with the tolerance below. It jumps the
plan once, in the multi-body simulation, with the errors of its [errors]. The same seed gives the same robots, wherever
they jump.
"""

from __future__ import annotations

import argparse
import functools
import hashlib
import math
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import NamedTuple

import numpy as np

import saltus

TOLERANCES = {
    "body.mass_kg": 0.01,
    "body.inertia_kg_m2": 0.03,
    "leg.stroke_m": 0.005,
    "leg.coulomb_friction_n": 0.2,
    "leg.viscous_friction_n_s_per_m": 0.2,
    "leg.discharge_coefficient": 0.02,
    "leg.supply_pressure_gauge_pa": 0.02,
    "leg.valve_delay_s": 0.05,
}
"""Parameters that differ from robot to robot: standard deviations, as shares."""


class Flown(NamedTuple):
    """One robot's jump."""

    factors: tuple[float, ...]
    passes: bool
    land_error_m: float
    reason: str


def fly(course: str, plant: saltus.Robot, seed: int) -> Flown:
    """Draws a robot, and lets it jump the plan."""
    factors = np.random.default_rng(seed).normal(1.0, list(TOLERANCES.values()))
    believed = plant.to_dict()
    names = [name.split(".") for name in TOLERANCES]
    drawn = {f"{part}.{key}": believed[part][key] * factor for (part, key), factor in zip(names, factors)}
    answer = saltus.verify(course, plant=plant, plant_set=drawn, samples=1, seed=seed, threads=1)
    row = answer.to_dict()["rows"][-1]
    off = math.nan if row["land_error_m"] is None else row["land_error_m"]
    return Flown(tuple(factors), row["passes"], off, row["reason"] or "")


def report(flown: list[Flown]) -> str:
    """The share that passes, and which parameters move the landing."""
    count, passed = len(flown), sum(it.passes for it in flown)
    # Wilson's interval of 95 %.
    z, share = 1.96, passed / count
    middle, half = share + z * z / 2 / count, z * math.sqrt(share * (1 - share) / count + (z / 2 / count) ** 2)
    low, high = ((middle + sign * half) / (1 + z * z / count) for sign in (-1, 1))
    lines = [f"{passed} of {count} robots keep the plan: {share:.2%} ({low:.2%} to {high:.2%})"]
    off = np.array([it.land_error_m for it in flown])
    landed = np.isfinite(off)
    lines += [f"landings are off by {1e3 * off[landed].mean():.1f} ± {1e3 * off[landed].std():.1f} mm"]
    if landed.sum() > 2 * len(TOLERANCES):
        by = (np.array([it.factors for it in flown])[landed] - 1.0) / list(TOLERANCES.values())
        slopes = np.linalg.lstsq(np.column_stack([by, np.ones(len(by))]), off[landed], rcond=None)[0]
        lines += ["a standard deviation of a parameter moves the landing by"]
        order = np.argsort(-np.abs(slopes[:-1]))
        lines += [f"  {list(TOLERANCES)[k]:32} {1e3 * slopes[k]:+6.2f} mm" for k in order]
    digest = hashlib.sha256(repr(flown).encode()).hexdigest()[:16]
    return "\n".join([*lines, f"SHA-256 of all jumps: {digest}"])


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("course", help="TOML file of the course")
    parser.add_argument("--plant", default="rats-planar", help="robot that is built [default: rats-planar]")
    parser.add_argument("--count", type=int, default=100_000, help="robots [default: 100000]")
    parser.add_argument("--seed", type=int, default=1, help="of all draws [default: 1]")
    parser.add_argument("--processes", type=int, default=1)
    given = parser.parse_args()
    job = functools.partial(fly, given.course, saltus.Robot(given.plant))
    seeds = np.random.SeedSequence(given.seed).generate_state(given.count).tolist()
    with ProcessPoolExecutor(given.processes, mp_context=get_context("spawn")) as pool:
        print(report(list(pool.map(job, seeds, chunksize=16))))


if __name__ == "__main__":
    main()
