"""Plans the jumps of legged robots, proves its plans, and names what a simulation gets wrong.

    >>> import saltus
    >>> round(saltus.jump("rats-planar", 5.0, -0.1).apex_m, 3)
    0.556

Every verb of the command `saltus` is a function here, with the same numbers to the last bit. Units
are in the names: `omega_rad_s` is a rate in rad/s.
"""

from ._saltus import SaltusError, __version__
from .answers import Answer, Columns
from .jumps import OUTCOMES, Jump, Robot, flight, jump, jumps
from .verbs import design, diagnose, export, export_gait, export_policy, filling, fit, inject, jump_over, law, learn, map, plan, run, simulate, table, verify

__all__ = [
    "OUTCOMES",
    "Answer",
    "Columns",
    "Jump",
    "Robot",
    "SaltusError",
    "__version__",
    "design",
    "diagnose",
    "export",
    "export_gait",
    "export_policy",
    "filling",
    "fit",
    "flight",
    "inject",
    "jump",
    "jump_over",
    "jumps",
    "law",
    "learn",
    "map",
    "plan",
    "run",
    "simulate",
    "table",
    "verify",
]

_GONE = {
    "parkour": "a study of the repository: cd studies && cargo run --release --bin parkour",
    "plot": "draw the rows of an answer by Matplotlib",
    "sweep": "map functools.partial(saltus.verify, …, seed=…) over concurrent.futures or a client of Dask",
}


def __getattr__(name: str) -> object:
    raise AttributeError(f"saltus.{name} is gone: {_GONE[name]}" if name in _GONE else f"saltus has no {name}")
