"""A program that uses the package: `mypy --strict` has nothing to say of it."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

import saltus


def heights(robot: saltus.Robot, rates: NDArray[np.float64]) -> NDArray[np.float64]:
    rows: saltus.Columns = saltus.jumps(robot, rates, -0.1, threads=1)
    return np.asarray(rows["apex_m"], dtype=np.float64)


def main() -> None:
    robot = saltus.Robot("rats-planar", set=["leg.supply_pressure_gauge_psi=100"])
    jump = saltus.jump(robot, 5.0, -0.1, start_lean_rad=-0.1)
    if jump.apex_m is not None:
        print(f"{jump.outcome}: {jump.apex_m:.3f} m")
    print(heights(robot, np.linspace(3.0, 6.0, 4)).max())
    answer = saltus.table(omega_rad_s=np.linspace(3, 6, 4), distance_m=[0.6, 0.7], robot=robot)
    print(answer.yes, answer.rows["alpha_f_rad"])
    jobs = [functools.partial(saltus.verify, law=(-0.12, 0.38), omega_rad_s=rate, distance_m=0.6, samples=5) for rate in (4.0, 5.0)]
    print([job().yes for job in jobs])
    try:
        saltus.plan({"approach_rate_rad_s": -5.0})
    except saltus.SaltusError as error:
        print(error)


if __name__ == "__main__":
    main()
