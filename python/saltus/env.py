"""Robots that learn, as environments of Gymnasium: `pip install saltus[gym]`.

    >>> import gymnasium, saltus.env
    >>> env = gymnasium.make("Saltus/RunZone-v0")
    >>> observation, info = env.reset(seed=1)
    >>> observation, reward, terminated, truncated, info = env.step(1)
    >>> sorted(info)
    ['angle_rad', 'arrived_s', 'broken', 'firings', 'gas_kg', 'time_s', 'travel_m']

`Saltus/RunLegs-v0`, `Saltus/Climb-v0`, `Saltus/RunZone-v0`, `Saltus/RunStride-v0` and `Saltus/JumpStride-v0` are the tasks of `saltus learn`.
By stride an action is two numbers from -1 to 1: firing angle and valve opening time, from the least to the greatest. `gymnasium.make_vec`
gives `VectorTask`, whose episodes run on threads of Rust.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, SupportsFloat

import numpy as np
from numpy.typing import NDArray

from ._saltus import Episodes, SaltusError
from .jumps import RobotLike, count_of, robot_of

try:
    import gymnasium
    from gymnasium.vector import AutoresetMode, VectorEnv
except ImportError:
    raise SaltusError("saltus.env needs Gymnasium: pip install saltus[gym]") from None

__all__ = ["IDS", "TaskEnv", "VectorTask"]

IDS = {
    "Saltus/RunLegs-v0": "run-legs",
    "Saltus/Climb-v0": "climb",
    "Saltus/RunZone-v0": "run-zone",
    "Saltus/RunStride-v0": "run-stride",
    "Saltus/JumpStride-v0": "jump-stride",
}
"""Environments and their tasks."""

Observation = NDArray[np.float64]
Reward = Mapping[str, float] | None
"""Terms with coefficients, as in `{"rate": 1, "threshold:2": 1}`; None: those of the thesis."""


def terms_of(reward: Reward) -> list[tuple[str, float]]:
    """Terms with their coefficients."""
    terms: list[tuple[str, float]] = []
    for name, by in (reward or {}).items():
        try:
            terms.append((name, float(by)))
        except (TypeError, ValueError):
            raise SaltusError(f"reward {name!r} = {by!r}: a number, as in {{'threshold:2': 1}}") from None
    return terms


def spaces_of(episodes: Episodes) -> tuple[Any, Any]:
    """What is observed, and what can be done."""
    low, high = (np.array([axis[k] for axis in episodes.observed]) for k in (2, 3))
    observed = gymnasium.spaces.Box(low, high, dtype=np.float64)
    if episodes.choices:
        return observed, gymnasium.spaces.Discrete(episodes.choices)
    return observed, gymnasium.spaces.Box(-1.0, 1.0, (len(episodes.chosen),), dtype=np.float64)


class _Task:
    """A task's episodes, and its actions as Rust has them."""

    def __init__(
        self, task: str, count: int, threads: int, robot: RobotLike, reward: Reward, steps: int | None, draw: bool
    ) -> None:
        self.episodes = Episodes(task, robot_of(robot), count, threads, terms_of(reward), steps, draw)
        self.count = count
        self.choices = self.episodes.choices
        self._low, self._high = (np.array([axis[k] for axis in self.episodes.chosen]) for k in (2, 3))

    def step(self, actions: Any, stays: NDArray[np.bool_]) -> Any:
        """An action for each episode but those that stay as they are."""
        given = np.asarray(actions)
        if self.choices:
            if given.shape != (self.count,) or given.dtype.kind not in "iu" or ((given < 0) | (given >= self.choices)).any():
                raise SaltusError(f"actions = {given!r}: {self.count} whole numbers from 0 to {self.choices - 1}")
            return self.episodes.step(np.where(stays, -1, given).astype(np.int64))
        width = len(self._low)
        if given.shape != (self.count, width) or given.dtype.kind not in "iuf" or not (np.abs(given) <= 1.0).all():
            raise SaltusError(f"actions = {given!r}: {self.count} rows of {width} numbers from -1 to 1")
        values = self.values(given)
        values[stays] = np.nan
        return self.episodes.step_by(np.ascontiguousarray(values))

    def values(self, given: NDArray[Any]) -> NDArray[np.float64]:
        """Numbers from -1 to 1 as values."""
        values = self._low + (given.astype(np.float64) + 1.0) / 2.0 * (self._high - self._low)
        clipped: NDArray[np.float64] = np.clip(values, self._low, self._high)
        return clipped


class TaskEnv(gymnasium.Env[Observation, Any]):
    """A robot with a task. Observations are in the order and units of `axes`."""

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(
        self,
        task: str = "run-zone",
        *,
        robot: RobotLike = "rats-run",
        reward: Reward = None,
        steps: int | None = None,
        draw: bool = False,
    ) -> None:
        self._task = _Task(task, 1, 1, robot, reward, steps, draw)
        self._episodes = self._task.episodes
        self.observation_space, self.action_space = spaces_of(self._episodes)
        self.axes = [f"{name}_{unit}" for name, unit, _, _ in self._episodes.observed]
        """Names of what is observed, with units."""
        self.actions = [f"{name}_{unit}" for name, unit, _, _ in self._episodes.chosen]
        """Names of what is chosen, with units, where actions are numbers."""

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observation, dict[str, Any]]:
        """Begins an episode. The seed is that of all that follow, until another is given."""
        super().reset(seed=seed)
        return self._episodes.start([0], [drawn(self.np_random)])[0], self._episodes.outcome(0)

    def step(self, action: Any) -> tuple[Observation, SupportsFloat, bool, bool, dict[str, Any]]:
        """Does an action, one of `action_space`."""
        if self._task.choices:
            if isinstance(action, (int, np.integer)) and 0 <= action < self._task.choices:
                return self._episodes.choose(0, int(action))
        else:
            given = np.asarray(action)
            if given.shape == self.action_space.shape and given.dtype.kind in "iuf" and (np.abs(given) <= 1.0).all():
                return self._episodes.choose_by(0, self._task.values(given).tolist())
        raise SaltusError(f"action = {action!r}: one of {self.action_space}")


class VectorTask(VectorEnv[Observation, NDArray[Any], NDArray[Any]]):
    """Many robots with the same task, on threads of Rust. Robot k does what the `TaskEnv` of seed `seed + k` does."""

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        task: str = "run-zone",
        num_envs: int = 1,
        *,
        threads: int | None = None,
        robot: RobotLike = "rats-run",
        reward: Reward = None,
        steps: int | None = None,
        draw: bool = False,
    ) -> None:
        import os

        self.num_envs = count_of("num_envs", num_envs, 1)
        used = count_of("threads", threads, os.cpu_count() or 1)
        self._task = _Task(task, self.num_envs, used, robot, reward, steps, draw)
        self._episodes = self._task.episodes
        self.single_observation_space, self.single_action_space = spaces_of(self._episodes)
        self.observation_space = gymnasium.vector.utils.batch_space(self.single_observation_space, self.num_envs)
        self.action_space = gymnasium.vector.utils.batch_space(self.single_action_space, self.num_envs)
        self._random: list[np.random.Generator] = []
        self._over = np.zeros(self.num_envs, dtype=np.bool_)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins all episodes."""
        if isinstance(seed, (int, np.integer)):
            seed = [int(seed) + k for k in range(self.num_envs)]
        if seed is not None or not self._random:
            seeds: list[int | None] = [None] * self.num_envs if seed is None else [*seed]
            self._random = [gymnasium.utils.seeding.np_random(it)[0] for it in seeds]
        self._over[:] = False
        return self._start(range(self.num_envs)), {}

    def step(
        self, actions: NDArray[Any]
    ) -> tuple[Observation, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """An action for each robot. One whose episode is over begins the next in place of it, with reward 0."""
        observed, rewards, terminated, truncated = self._task.step(actions, self._over)
        begun = np.flatnonzero(self._over)
        if len(begun):
            observed[begun] = self._start(begun.tolist())
        self._over = terminated | truncated
        return observed, rewards, terminated, truncated, {}

    def outcomes(self) -> list[dict[str, Any]]:
        """What each episode has come to."""
        return [self._episodes.outcome(k) for k in range(self.num_envs)]

    def _start(self, which: Sequence[int] | range) -> Observation:
        return self._episodes.start(list(which), [drawn(self._random[k]) for k in which])


def drawn(random: np.random.Generator) -> int:
    """The seed of an episode."""
    return int(random.integers(2**63))


def _register() -> None:
    for name, task in IDS.items():
        if name not in gymnasium.registry:
            gymnasium.register(
                id=name,
                entry_point="saltus.env:TaskEnv",
                vector_entry_point="saltus.env:VectorTask",
                kwargs={"task": task},
                disable_env_checker=True,
                order_enforce=False,
            )


_register()
