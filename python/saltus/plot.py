"""Answers drawn by Matplotlib: `pip install saltus[plot]`.

    >>> import saltus, saltus.plot
    >>> axes = saltus.plot.table(saltus.table(omega_rad_s=[4, 5, 6], distance_m=0.6))
    >>> axes.figure.savefig("table.png")

Each function takes an answer and the axes to draw on, by default new ones, and gives the axes.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._saltus import SaltusError
from .answers import Answer
from .jumps import RobotLike, flight, jump, robot_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["diagnosis", "map", "plan", "table"]

LANDING, APEX, BAD, GROUND = "#1f5fa8", "#2a7f3f", "#b03030", "0.75"
LEVELS = 12


def table(answer: Answer, axes: Axes | None = None) -> Axes:
    """Firing angles over approach rates, of `saltus.table`: a line for each distance or clearance.

    Solid: the early angle; dashed: the late one; crosses: where nothing reaches, the nearest.
    """
    check("table", answer, "table")
    on = axes_or_new(axes)
    rows = answer.rows
    measure = f"{answer.measure}_m"
    for k, wanted in enumerate(np.unique(rows[measure])):
        part = rows[measure] == wanted
        omega = rows["omega_rad_s"][part]
        colour = f"C{k % 10}"
        on.plot(omega, rows["alpha_f_rad"][part], "o-", color=colour, markersize=3, label=f"{wanted:g} m")
        on.plot(omega, rows["alpha_f_late_rad"][part], "o--", color=colour, markersize=3)
        on.plot(omega, rows["nearest_alpha_f_rad"][part], "x", color=colour)
    on.set(xlabel="approach rate ω (rad/s)", ylabel="firing angle α_f (rad)", title=f"{answer.robot}: firing angles")
    on.legend(title=answer.measure)
    return on


def map(answer: Answer, axes: Iterable[Axes] | None = None) -> list[Axes]:
    """Distance and apex over approach rate and firing angle, of `saltus.map`, on two axes.

    Where a jump has no flight the map is blank.
    """
    check("map", answer, "map")
    pair = list(axes) if axes is not None else new(2)
    if len(pair) != 2:
        raise SaltusError(f"axes: {len(pair)} of them: two, for distance and apex")
    rows = answer.rows
    omega, x = np.unique(rows["omega_rad_s"], return_inverse=True)
    alpha, y = np.unique(rows["alpha_f_rad"], return_inverse=True)
    if len(omega) < 2 or len(alpha) < 2:
        raise SaltusError(f"answer: {len(omega)} rates and {len(alpha)} angles: two or more of each")
    for on, name in zip(pair, ("distance", "apex")):
        values: NDArray[np.float64] = np.full((len(alpha), len(omega)), np.nan)
        values[y, x] = rows[f"{name}_m"]
        filled = on.contourf(omega, alpha, np.ma.masked_invalid(values), levels=LEVELS)
        on.figure.colorbar(filled, ax=on, label=f"{name} (m)")
        on.set(xlabel="approach rate ω (rad/s)", ylabel="firing angle α_f (rad)", title=f"{answer.robot}: {name}")
    return pair


def plan(answer: Answer, axes: Axes | None = None, *, robot: RobotLike | None = None) -> Axes:
    """A plan, of `saltus.plan`, from the side: ground, obstacles, and the flight of each jump.

    `robot` is that of the plan: by default the built-in one of the plan's name. Flights are those of
    the planar model.
    """
    check("plan", answer, "plan")
    on = axes_or_new(axes)
    chosen = robot_of(answer.robot if robot is None else robot)
    radius = chosen.to_dict()["body"]["wheel_radius_m"]
    on.axhline(0.0, color=GROUND, zorder=0)
    for box in answer.obstacles:
        on.bar(box["front_x_m"], box["height_m"], box["width_m"], align="edge", color=GROUND)
    for row in answer.jumps:
        flown = jump(
            chosen,
            row["omega_rad_s"],
            row["alpha_f_rad"],
            valve_open_s=row["valve_open_s"],
            start_lean_rad=row["phi0_rad"],
        )
        path = flight(chosen, flown, land_height_m=radius + row["land_y_m"] - row["foot_y_m"])
        on.plot(row["foot_x_m"] + path["x_m"], row["foot_y_m"] + path["y_m"], color=LANDING)
        on.plot(row["foot_x_m"], row["foot_y_m"], "k^", markersize=6)
        on.plot(row["land_x_m"], row["land_y_m"], "v", color=LANDING if row["holds"] else BAD)
        off = row["land_sd_m"]
        if off is not None:
            on.errorbar(row["land_x_m"], row["land_y_m"], xerr=2 * off, color=LANDING, capsize=3)
    on.set_ylim(bottom=-radius / 4.0)
    on.set(xlabel="x (m)", ylabel="height of the axle (m)", title=f"{answer.robot}: {answer.status}", aspect="equal")
    return on


def diagnosis(answer: Answer, axes: Axes | None = None) -> Axes:
    """What is wrong, of `saltus.diagnose`: how far each channel is from the model, before the correction and after it.

    A bar is the RMS of what is left, in units of the noise: 1 is a model that says all. The title names
    the causes.
    """
    check("diagnosis", answer, "diagnose")
    on = axes_or_new(axes)
    gain = answer.gain or {}
    if not gain:
        on.text(0.5, 0.5, "the model explains the data", ha="center", transform=on.transAxes)
    names = list(gain)
    place = np.arange(len(names))
    for shift, when, colour in ((-0.2, "before", BAD), (0.2, "after", APEX)):
        heights = [gain[name][f"rms_{when}"] / gain[name]["noise"] for name in names]
        on.bar(place + shift, heights, 0.4, label=when, color=colour)
    on.axhline(1.0, color="k", linewidth=0.8)
    on.set_xticks(place, names)
    found = ", ".join(cause["id"] for cause in answer.causes) or "nothing wrong"
    on.set(ylabel="RMS on held-out runs (noise)", title=found)
    if names:
        on.set_yscale("log")
        on.legend()
    return on


def check(what: str, answer: Answer, verb: str) -> None:
    """Refuses what is not an answer of `saltus.verb`."""
    command = answer.get("command") if isinstance(answer, Answer) else None
    if command != verb:
        raise SaltusError(f"{what}: {command or type(answer).__name__}: an answer of saltus.{verb}")


def axes_or_new(axes: Axes | None) -> Axes:
    """The axes to draw on."""
    return new(1)[0] if axes is None else axes


def new(count: int) -> list[Axes]:
    """New axes, side by side."""
    try:
        from matplotlib import pyplot
    except ImportError:
        raise SaltusError("saltus.plot needs Matplotlib: pip install saltus[plot]") from None
    made: Any = pyplot.subplots(1, count, squeeze=False, figsize=(6.4 * count, 4.8), layout="constrained")[1]
    return list(made[0])
