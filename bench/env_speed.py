"""How fast `env.step` is, beside a Gymnasium environment of the same robot in MuJoCo.

    pip install saltus[gym] mujoco
    python bench/env_speed.py
    python bench/env_speed.py --steps 20000

MuJoCo's environment is written as Gymnasium's own are: Python around mj_step with the exported model, a decision each millisecond. First its steps
are of 1 ms and the legs have no gas (a motor gives their force), in its favour. Then they are of 0.1 ms, as its runs need to agree with themselves at
half of the step (tests/mujoco/run.py bench), without gas, and with the flow into five chambers by NumPy. Times are medians of rounds in which all take
turns.
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
    """The task `run-legs` in MuJoCo, in so many steps a millisecond."""

    def __init__(self, substeps: int, gas: bool) -> None:
        self.model = mujoco.MjModel.from_xml_string(saltus.export("mjcf", robot="rats-run"))
        self.model.opt.timestep = 1e-3 / substeps
        self.substeps, self.gas = substeps, gas
        self.pressure = np.full(self.model.nu, 101325.0)
        self.slides = [self.model.joint(f"leg_{k}").qposadr[0] for k in range(self.model.nu)]
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

    def forces(self, leg: int) -> Any:
        """Forces (N) of the gas, whose flow goes on by a step; the valve of `leg` is open."""
        ambient, area, dead, heat, seconds = 101325.0, 2.85e-4, 5.4e-6, 8.4e4, self.model.opt.timestep
        source = np.full(len(self.slides), ambient)
        if leg >= 0:
            source[leg] = 928696.0
        volume = dead + area * np.maximum(self.data.qpos[self.slides], 0.0)
        ratio = np.clip(np.minimum(source, self.pressure) / np.maximum(source, self.pressure), 0.528, 1.0)
        flow = 1.76e-6 * np.maximum(source, self.pressure) * np.sqrt(ratio**1.43 - ratio**1.71) / np.sqrt(heat)
        self.pressure += seconds * 1.4 * heat * np.sign(source - self.pressure) * flow / volume
        return area * (self.pressure - ambient)

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        if self.gas:
            for _ in range(self.substeps):
                self.data.ctrl[:] = self.forces(int(action) - 1)
                mujoco.mj_step(self.model, self.data)
        else:
            self.data.ctrl[:] = 0.0
            if action > 0:
                self.data.ctrl[action - 1] = 150.0
            mujoco.mj_step(self.model, self.data, self.substeps)
        self.left -= 1
        observed = self.observed()
        return observed, 1.0 if observed[1] > 2 else -1.0, False, self.left == 0, {}


def stepped(env: Any, actions: Any) -> float:
    """Seconds for each step."""
    env.reset(seed=1)
    begin = time.perf_counter()
    for action in actions:
        *_, terminated, truncated, _ = env.step(action)
        if terminated or truncated:
            env.reset()
    return (time.perf_counter() - begin) / len(actions)


def stepped_all(env: Any, actions: Any) -> float:
    """Seconds for each step of all robots, which begin anew by themselves."""
    env.reset(seed=1)
    begin = time.perf_counter()
    for row in actions:
        env.step(row)
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
    ours = saltus.env.TaskEnv("run-legs")
    others = {
        "1 ms, no gas": MujocoLegs(1, False),
        "0.1 ms, no gas": MujocoLegs(10, False),
        "0.1 ms, gas by NumPy": MujocoLegs(10, True),
    }
    own, *times = medians(given.rounds, *(lambda env=env: stepped(env, actions) for env in (ours, *others.values())))
    print(f"env.step of 1 ms: saltus {1e6 * own:.1f} us")
    for name, other in zip(others, times):
        print(f"  MuJoCo, {name}: {1e6 * other:.1f} us, {other / own:.2f} times")
    for task in ("run-legs", "run-zone", "run-stride"):
        vectors = [saltus.env.VectorTask(task, 64, threads=threads) for threads in (1, 2)]
        space = vectors[0].single_action_space
        shape = (given.steps // (400 if task == "run-stride" else 40), 64)
        many = random.integers(space.n, size=shape) if hasattr(space, "n") else random.uniform(0.0, 0.5, size=(*shape, 2))
        one, two = medians(given.rounds, *(lambda env=env: stepped_all(env, many) for env in vectors))
        print(f"64 robots, {task}: 1 thread {1e6 * one / 64:.1f} us, 2 threads {1e6 * two / 64:.1f} us a robot and step: {one / two:.2f} times")


if __name__ == "__main__":
    main()
