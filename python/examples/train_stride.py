"""How many strides PPO and SAC need to learn firing angles: `saltus learn run-stride` with learners of stable-baselines3.

    pip install saltus[gym] stable-baselines3
    python train_stride.py sac --strides 2000 --seeds 5
    python train_stride.py ppo --strides 20000 --seeds 5 --draw

Each seed learns alone. Every tenth of the strides what it has learnt runs 20 times without exploration, on seeds that no
training has; a line has the median time to 1.6 m over these runs and over the seeds, and how many arrived.
"""

from __future__ import annotations

import argparse
from typing import Any

import gymnasium
import numpy as np
import stable_baselines3

import saltus.env

TRIALS = 20
HELD_OUT = 1_000_000
"""The first seed of the trials."""
SCALE = np.array([10.0, 1.0, 2.0, 0.1])
"""Typical rate (rad/s), lean (rad), speed (m/s) and pivot angle (rad)."""
LONGEST = 3.0


def environment(draw: bool) -> gymnasium.Env[Any, Any]:
    """The robot, with what it observes in numbers around 1."""
    env = saltus.env.TaskEnv("run-stride", draw=draw)
    space = gymnasium.spaces.Box(-np.inf, np.inf, SCALE.shape, dtype=np.float64)
    return gymnasium.wrappers.TransformObservation(env, lambda observed: observed / SCALE, space)


def times(model: Any, draw: bool) -> list[float]:
    """Times to the goal (s) of what `model` has learnt; the longest where it does not arrive."""
    env = environment(draw)
    found = []
    for trial in range(TRIALS):
        observed, info = env.reset(seed=HELD_OUT + trial)
        over = False
        while not over:
            observed, _, terminated, truncated, info = env.step(model.predict(observed, deterministic=True)[0])
            over = terminated or truncated
        found.append(info["arrived_s"] or LONGEST)
    return found


def learner(name: str, env: gymnasium.Env[Any, Any], seed: int) -> Any:
    """A learner with the library's usual numbers, but for episodes of five steps."""
    if name == "ppo":
        return stable_baselines3.PPO("MlpPolicy", env, n_steps=256, gamma=1.0, seed=seed, device="cpu")
    return stable_baselines3.SAC("MlpPolicy", env, learning_starts=50, gamma=0.99, seed=seed, device="cpu")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("learner", choices=["ppo", "sac"])
    parser.add_argument("--strides", type=int, default=2000, help="strides of each seed [default: 2000]")
    parser.add_argument("--seeds", type=int, default=3, help="seeds [default: 3]")
    parser.add_argument("--draw", action="store_true", help="draw each episode's robot, in training and in trials")
    given = parser.parse_args()
    models = [learner(given.learner, environment(given.draw), seed) for seed in range(given.seeds)]
    for part in range(11):
        if part > 0:
            for model in models:
                model.learn(given.strides // 10, reset_num_timesteps=False)
        found = np.array([times(model, given.draw) for model in models])
        medians = np.median(found, axis=1)
        strides = round(np.mean([model.num_timesteps for model in models]))
        print(
            f"{given.learner}, {strides} strides: median {np.median(medians):.3f} s, seeds from {medians.min():.3f} to {medians.max():.3f} s; "
            f"{(found < LONGEST).mean():.0%} arrive",
            flush=True,
        )


if __name__ == "__main__":
    main()
