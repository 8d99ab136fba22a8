"""A map of how far landings scatter, over the supply pressure and the friction of the ground.

    python landing_scatter.py scatter.png --processes 2

The robot on its boom fires by a law for 0.6 m. For each pressure and friction it jumps with the errors of its [errors],
in the multi-body simulation. The law is made anew for each pressure, for the planar model at that pressure. Needs
Matplotlib.
"""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import NamedTuple

import numpy as np

import saltus

RATES = (4.0, 5.0)
DISTANCE = 0.6


class Cell(NamedTuple):
    """Landings at one pressure and one friction (m)."""

    off: float
    scatter: float
    share: float


def cell(psi: float, friction: float, samples: int, seed: int) -> Cell:
    """Jumps at one pressure and one friction."""
    supply = {"leg.supply_pressure_gauge_psi": psi}
    law = saltus.law(omega_rad_s=np.linspace(*RATES, 5), distance_m=DISTANCE, set=supply, threads=1).laws[0]
    answer = saltus.verify(
        law=(law["slope_s"], law["intercept_rad"]),
        omega_rad_s=RATES,
        distance_m=DISTANCE,
        set=supply,
        plant="rats-boom",
        plant_set=supply,
        friction=friction,
        samples=samples,
        seed=seed,
        threads=1,
    )
    rows = [row for row in answer.to_dict()["rows"] if row["errors"]]
    off = np.array([row["land_error_m"] for row in rows if row["land_error_m"] is not None])
    return Cell(float(off.mean()), float(off.std()), sum(row["passes"] for row in rows) / len(rows)) if len(off) else Cell(np.nan, np.nan, 0.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("out", help="picture to write, .png or .svg")
    parser.add_argument("--cells", type=int, default=9, help="pressures, and frictions [default: 9]")
    parser.add_argument("--samples", type=int, default=20, help="jumps for each rate in a cell [default: 20]")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--processes", type=int, default=1)
    given = parser.parse_args()
    psi, friction = np.linspace(80, 140, given.cells), np.linspace(0.3, 1.0, given.cells)
    places = [(p, mu) for mu in friction.tolist() for p in psi.tolist()]
    seeds = np.random.SeedSequence(given.seed).generate_state(len(places)).tolist()
    with ProcessPoolExecutor(given.processes, mp_context=get_context("spawn")) as pool:
        cells = list(pool.map(cell, *zip(*places), [given.samples] * len(places), seeds))

    from matplotlib.figure import Figure

    figure = Figure(figsize=(12, 4.5), layout="constrained")
    for axes, name, label in zip(figure.subplots(1, 2), ("off", "scatter"), ("mean error", "standard deviation")):
        values = 1e3 * np.array([getattr(it, name) for it in cells]).reshape(given.cells, given.cells)
        drawn = axes.contourf(psi, friction, np.ma.masked_invalid(values), levels=12)
        figure.colorbar(drawn, ax=axes, label="mm")
        axes.set(xlabel="supply pressure (psi, gauge)", ylabel="friction coefficient of the ground", title=f"{label} of the landing")
    figure.savefig(given.out)
    worst = max(cells, key=lambda it: it.scatter)
    print(f"{len(cells)} cells; the greatest scatter is {1e3 * worst.scatter:.1f} mm; {given.out}")


if __name__ == "__main__":
    main()
