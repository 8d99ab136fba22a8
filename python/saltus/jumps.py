"""One jump, and arrays of them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _saltus
from ._saltus import Jump, Robot, SaltusError
from .answers import Columns

__all__ = ["OUTCOMES", "Jump", "Robot", "RobotLike", "flight", "jump", "jumps", "robot_of"]

OUTCOMES = ("stroke", "force", "stall", "no-break-away", "early-lift-off", "fall-back")
"""How a stance ends: lift-off at the end of the stroke, or because the force fell to 0; then those
without a flight."""

NUMBERS = (
    "t_fire_s",
    "t_liftoff_s",
    "phi_rad",
    "omega_rad_s",
    "d_m",
    "d_dot_m_s",
    "pressure_pa",
    "x_m",
    "y_m",
    "vx_m_s",
    "vy_m_s",
    "apex_m",
    "land_rs_m",
    "land_0_m",
)

FINEST, COARSEST = 1e-13, 1e-4
"""Limits of the integrator's tolerance; that of the command is 1e-12."""

RobotLike = Robot | str | os.PathLike[str] | Mapping[str, Any]
"""A robot, the name of a built-in one, the path of a robot file, or a dictionary like that of `Robot.to_dict`."""


def robot_of(robot: RobotLike, argument: str = "robot") -> Robot:
    """The robot that is meant."""
    if isinstance(robot, Robot):
        return robot
    if isinstance(robot, Mapping):
        return Robot.from_dict(dict(robot))
    if not isinstance(robot, (str, os.PathLike)):
        raise SaltusError(f"{argument} = {robot!r}: a Robot, a name, a file or a dictionary")
    return Robot(os.fspath(robot))


def jump(
    robot: RobotLike,
    omega_rad_s: float,
    alpha_f_rad: float,
    *,
    valve_open_s: float = 0.1,
    start_lean_rad: float | None = None,
) -> Jump:
    """One jump of a robot that approaches at `omega_rad_s` and fires at the lean `alpha_f_rad`.

    The stance starts, and the rate counts, at the firing angle or at `start_lean_rad`. The numbers
    are those of `saltus simulate`. A jump that does not take off is an answer: see `outcome`.
    """
    # A robot that is one already costs nothing.
    chosen = robot if isinstance(robot, Robot) else robot_of(robot)
    return _saltus.jump(chosen, omega_rad_s, alpha_f_rad, valve_open_s=valve_open_s, start_lean_rad=start_lean_rad)


def jumps(
    robot: RobotLike,
    omega_rad_s: ArrayLike,
    alpha_f_rad: ArrayLike,
    *,
    valve_open_s: ArrayLike = 0.1,
    start_lean_rad: ArrayLike | None = None,
    threads: int | None = None,
    tolerance: float = 1e-12,
) -> Columns:
    """Many jumps at once: the arguments are numbers or arrays, broadcast as NumPy does.

    The columns are those of `saltus simulate`, a row for each jump, in C order of the broadcast
    arrays: `omega0_rad_s`, `phi0_rad`, `alpha_f_rad`, `valve_open_s`, `outcome`, …, `land_0_m`. They
    do not depend on `threads` (by default as many as the machine has).

    `tolerance` is the relative error that the integrator allows. By default all digits are those of
    the command, right to ten and more. At 2e-9 apex and landing are right to 1e-9, in half the time.
    """
    chosen = robot_of(robot)
    given = {"omega_rad_s": omega_rad_s, "alpha_f_rad": alpha_f_rad, "valve_open_s": valve_open_s}
    given["start_lean_rad"] = alpha_f_rad if start_lean_rad is None else start_lean_rad
    arrays = {name: numbers(name, value) for name, value in given.items()}
    try:
        shape = np.broadcast_shapes(*(array.shape for array in arrays.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
        raise SaltusError(f"{shapes}: shapes that NumPy broadcasts to one") from None
    flat = [np.ascontiguousarray(np.broadcast_to(array, shape)).reshape(-1) for array in arrays.values()]
    within = float(numbers("tolerance", tolerance))
    if not FINEST <= within <= COARSEST:
        raise SaltusError(f"tolerance = {tolerance!r}: from {FINEST} to {COARSEST}")
    codes, columns = _saltus.jumps(chosen, flat, count_of("threads", threads, os.cpu_count() or 1), within)
    omega, alpha, valve, lean = flat
    head = {"omega0_rad_s": omega, "phi0_rad": lean, "alpha_f_rad": alpha, "valve_open_s": valve}
    # Arrays of the caller are not made read-only.
    own = {name: array.copy() if any(np.shares_memory(array, it) for it in arrays.values()) else array for name, array in head.items()}
    return Columns({**own, "outcome": np.array(OUTCOMES)[codes], **dict(zip(NUMBERS, columns))})


def flight(robot: RobotLike, jump: Jump, *, points: int = 101, land_height_m: float | None = None) -> Columns:
    """The flight after a jump: `t_s` from lift-off, and `x_m`, `y_m` of the wheel's centre from the foot.

    It ends where the centre comes down to `land_height_m`, by default the wheel's radius. Raises
    `SaltusError` for a jump that does not take off, and for a height above its apex.
    """
    chosen = robot_of(robot)
    height = chosen.to_dict()["body"]["wheel_radius_m"] if land_height_m is None else land_height_m
    count = count_of("points", points, 101)
    t, x, y = _saltus.flight(chosen, jump, count, float(numbers("land_height_m", height)))
    return Columns({"t_s": t, "x_m": x, "y_m": y})


def numbers(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """An argument as an array of finite numbers."""
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "iuf":
            raise TypeError
        array = array.astype(np.float64, copy=False)
    except (TypeError, ValueError, OverflowError):
        kind = getattr(value, "dtype", type(value).__name__)
        raise SaltusError(f"{name}: {kind}: real numbers") from None
    bad = ~np.isfinite(array)
    if bad.any():
        at = tuple(int(k[0]) for k in np.nonzero(np.atleast_1d(bad)))
        raise SaltusError(f"{name}{list(at)} = {np.atleast_1d(array)[at]}: finite numbers (shape {array.shape})")
    return array


def count_of(name: str, value: int | None, default: int) -> int:
    """A whole number from 1, or the default."""
    if value is None:
        return default
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 1 <= value <= 4096:
        raise SaltusError(f"{name} = {value!r}: a whole number from 1 to 4096")
    return int(value)
