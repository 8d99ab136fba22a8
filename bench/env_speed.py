"""How fast `env.step` is, beside a Gymnasium environment of the same robot in MuJoCo.

    pip install saltus[gym] mujoco
    python bench/env_speed.py
    python bench/env_speed.py --steps 20000

MuJoCo's environment is written as Gymnasium's own are: Python around mj_step with the exported model, every millisecond. It has no gas in
the legs (a motor gives their force) and its steps are of 1 ms, the coarsest that anyone would take: each choice in its favour. Times are medians of
rounds in which both take turns.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from typing import Any

import gymnasium
import mujoco
import numpy as np

import saltus
import saltus.env


class MujocoLegs(gymnasium.Env[Any, Any]):
    """The task `run-legs` in MuJoCo."""

    def __init__(self) -> None:
        self.model = mujoco.MjModel.from_xml_string(saltus.export("mjcf", robot="rats-run"))
        self.model.opt.timestep = 1e-3
        self.model.eq_active0[:] = 0
        self.data = mujoco.MjData(self.model)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (4,), dtype=np.float64)
        self.action_space = gymnasium.spaces.Discrete(1 + self.model.nu)
        self.left = 0

    def observed(self) -> Any:
        q, v = self.data.qpos, self.data.qvel
        return np.array([(q[2] + np.pi) % (2 * np.pi) - np.pi, v[2], q[1], v[1]])

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        mujoco.mj_resetDataKeyframe(self.model, self.data, 0)
        self.data.qpos[2] = np.pi / 5
        self.left = 1000
        return self.observed(), {}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        self.data.ctrl[:] = 0.0
        if action > 0:
            self.data.ctrl[action - 1] = 150.0
        mujoco.mj_step(self.model, self.data)
        self.left -= 1
        observed = self.observed()
        return observed, 1.0 if observed[1] > 2 else -1.0, False, self.left == 0, {}


def stepped(env: Any, actions: Any) -> float:
    """Seconds for each step."""
    env.reset(seed=1)
    begin = time.perf_counter()
    for action in actions:
        *_, terminated, truncated, _ = env.step(action)
        if np.any(terminated) or np.any(truncated):
            env.reset()
    return (time.perf_counter() - begin) / len(actions)


def medians(rounds: int, *timed: Callable[[], float]) -> list[float]:
    times = [[one() for one in timed] for _ in range(rounds)]
    return [statistics.median(column) for column in zip(*times)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=4000, help="steps of a round [default: 4000]")
    parser.add_argument("--rounds", type=int, default=5, help="rounds [default: 5]")
    given = parser.parse_args()
    random = np.random.default_rng(1)
    actions = random.integers(6, size=given.steps)
    ours, theirs = saltus.env.TaskEnv("run-legs"), MujocoLegs()
    own, other = medians(given.rounds, lambda: stepped(ours, actions), lambda: stepped(theirs, actions))
    print(f"env.step: saltus {1e6 * own:.1f} us, MuJoCo {1e6 * other:.1f} us: {other / own:.2f} times")
    many = random.integers(6, size=(given.steps // 20, 64))
    vectors = [saltus.env.VectorTask("run-legs", 64, threads=threads) for threads in (1, 2)]
    one, two = medians(given.rounds, *(lambda env=env: stepped(env, many) for env in vectors))
    print(f"64 robots: 1 thread {1e6 * one / 64:.1f} us, 2 threads {1e6 * two / 64:.1f} us a robot and step: {one / two:.2f} times")


if __name__ == "__main__":
    main()
