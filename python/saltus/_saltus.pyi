"""What is written in Rust: robots, jumps, and the command in this process."""

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

__all__ = ["Episodes", "Jump", "Robot", "SaltusError", "__version__", "command", "flight", "jump", "jumps", "to_toml"]

__version__: str

_Overrides: TypeAlias = Mapping[str, Any] | Sequence[str]

class SaltusError(ValueError):
    """Bad input. The text names what is wrong, its value and what is allowed."""

@final
class Robot:
    """A robot: what a robot file describes. It cannot be changed; `replace` gives another.

    `robot` is the name of a built-in robot or the path of a TOML file; `set` has overrides as in
    `{"leg.stroke_m": 0.05}` or `["leg.stroke_mm=50"]`.
    """

    def __new__(cls, robot: str = "rats-planar", *, set: _Overrides | None = ...) -> Robot: ...
    @classmethod
    def from_toml(cls, text: str, *, name: str = "robot.toml", set: _Overrides | None = ...) -> Robot:
        """The robot of a robot file's text; messages call it `name`."""

    @classmethod
    def from_dict(cls, robot: dict[str, Any], *, set: _Overrides | None = ...) -> Robot:
        """The robot of a dictionary like that of `to_dict`."""

    @property
    def name(self) -> str:
        """Its name."""

    @property
    def toml(self) -> str:
        """Its robot file in SI units, which stands alone and reads back to the last bit."""

    def to_dict(self) -> dict[str, Any]:
        """Its robot file as a dictionary."""

    def replace(self, set: _Overrides) -> Robot:
        """A copy with overrides."""

    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, tuple[str]]: ...

@final
class Jump:
    """One jump. What is at lift-off or after it is None without a flight."""

    @property
    def omega_rad_s(self) -> float:
        """Approach rate (rad/s)."""

    @property
    def start_lean_rad(self) -> float:
        """Lean at which the stance starts (rad)."""

    @property
    def alpha_f_rad(self) -> float:
        """Firing angle (rad)."""

    @property
    def valve_open_s(self) -> float:
        """Valve opening time (s); without effect for a spring."""

    @property
    def outcome(self) -> str:
        """One of `OUTCOMES`; the first two fly."""

    @property
    def t_fire_s(self) -> float | None:
        """Time of the firing (s) from the start of the stance; None if the leg does not fire."""

    @property
    def t_liftoff_s(self) -> float | None:
        """Time of the lift-off (s)."""

    @property
    def phi_rad(self) -> float | None:
        """Lean at lift-off (rad)."""

    @property
    def omega_liftoff_rad_s(self) -> float | None:
        """Lean rate at lift-off (rad/s)."""

    @property
    def d_m(self) -> float | None:
        """Extension of the leg at lift-off (m)."""

    @property
    def d_dot_m_s(self) -> float | None:
        """Rate of extension at lift-off (m/s)."""

    @property
    def pressure_pa(self) -> float | None:
        """Pressure in the chamber at lift-off (Pa, absolute)."""

    @property
    def x_m(self) -> float | None:
        """Place of the wheel's centre at lift-off, forward of the foot (m)."""

    @property
    def y_m(self) -> float | None:
        """Height of the wheel's centre at lift-off (m)."""

    @property
    def vx_m_s(self) -> float | None:
        """Forward speed at lift-off (m/s)."""

    @property
    def vy_m_s(self) -> float | None:
        """Upward speed at lift-off (m/s)."""

    @property
    def apex_m(self) -> float | None:
        """Greatest height of the wheel's centre (m)."""

    @property
    def land_rs_m(self) -> float | None:
        """Distance from the foot to where the wheel touches level ground (m)."""

    @property
    def land_0_m(self) -> float | None:
        """Distance at which the centre comes down to height 0 (m): the thesis' reading."""

    def to_dict(self) -> dict[str, Any]:
        """All of this by name."""

    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, tuple[Any, ...]]: ...
    def _repr_html_(self) -> str: ...

@final
class Episodes:
    """Episodes of a task, which go on side by side: what `saltus.env` is made of."""

    def __new__(
        cls,
        task: str,
        robot: Robot,
        count: int,
        threads: int,
        reward: list[tuple[str, float]],
        steps: int | None,
        draw: bool,
    ) -> Episodes: ...
    @property
    def observed(self) -> list[tuple[str, str, float, float]]:
        """What is observed: name, unit, least and greatest value."""

    @property
    def choices(self) -> int:
        """How many actions there are; 0 where actions are numbers."""

    @property
    def chosen(self) -> list[tuple[str, str, float, float]]:
        """What is chosen where actions are numbers: name, unit, least and greatest value."""

    def start(self, which: list[int], seeds: list[int]) -> NDArray[np.float64]:
        """Begins episodes, and gives their observations."""

    def step(
        self, actions: NDArray[np.int64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_]]:
        """An action in each: observations, rewards, terminated, truncated. A negative one leaves an episode as it is."""

    def step_by(
        self, actions: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_]]:
        """The same with rows of numbers; a row without numbers leaves an episode as it is."""

    def choose(self, k: int, choice: int) -> tuple[NDArray[np.float64], float, bool, bool, dict[str, Any]]:
        """A choice in episode `k` alone."""

    def choose_by(self, k: int, values: list[float]) -> tuple[NDArray[np.float64], float, bool, bool, dict[str, Any]]:
        """The same with numbers."""

    def outcome(self, k: int) -> dict[str, Any]:
        """What an episode has come to."""

def jump(
    robot: Robot,
    omega_rad_s: float,
    alpha_f_rad: float,
    *,
    valve_open_s: float = 0.1,
    start_lean_rad: float | None = None,
) -> Jump:
    """One jump; `saltus.jump` also takes a robot by its name."""

def jumps(
    robot: Robot, launches: list[NDArray[np.float64]], threads: int, tolerance: float
) -> tuple[NDArray[np.uint8], list[NDArray[np.float64]]]:
    """Many jumps: rates, firing angles, valve times and leans in; outcomes and columns out."""

def flight(
    robot: Robot, jump: Jump, points: int, height: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Times and places of the wheel's centre in the flight after a jump."""

def command(words: list[str], files: dict[str, str] = ...) -> tuple[bool, str, list[str]]:
    """Runs the command with these words: whether the answer is yes, the report, the messages.

    `files` has the text of robots, courses and tables by the name that the words have for them.
    """

def to_toml(table: dict[str, Any]) -> str:
    """A dictionary as the text of a TOML file."""
