"""Environments of Gymnasium: its own checks pass, many are as one, and seeds give the same."""

from __future__ import annotations

import pickle
import warnings
from typing import Any

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

import saltus  # noqa: E402
import saltus.env  # noqa: E402


@pytest.mark.parametrize("name", saltus.env.IDS)
def test_gymnasium_finds_nothing_wrong(name: str) -> None:
    from gymnasium.utils.env_checker import check_env

    env = gymnasium.make(name)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=True)


def drawn(space: Any, random: np.random.Generator, count: int) -> Any:
    """Actions of a space."""
    if isinstance(space, gymnasium.spaces.Discrete):
        return random.integers(space.n, size=count)
    return random.uniform(-1.0, 1.0, size=(count, *space.shape))


def episode(env: Any, seed: int, steps: int) -> list[Any]:
    random = np.random.default_rng(seed)
    rows = [env.reset(seed=seed)[0].tolist()]
    for _ in range(steps):
        observation, reward, terminated, truncated, info = env.step(drawn(env.action_space, random, 1)[0])
        rows.append((observation.tolist(), reward, terminated, truncated, info["travel_m"]))
        if terminated or truncated:
            rows.append(env.reset()[0].tolist())
    return rows


@pytest.mark.parametrize("task", ["run-zone", "run-stride"])
def test_seeds_give_the_same_episodes(task: str) -> None:
    env = saltus.env.TaskEnv(task, draw=True)
    one, again, other = episode(env, 1, 400), episode(env, 1, 400), episode(env, 2, 400)
    assert one == again != other


@pytest.mark.parametrize("name", ["Saltus/RunZone-v0", "Saltus/RunStride-v0", "Saltus/JumpStride-v0"])
def test_many_are_as_one(name: str) -> None:
    many = gymnasium.make_vec(name, num_envs=5, threads=2, draw=True, steps=60)
    assert many.metadata["autoreset_mode"] is gymnasium.vector.AutoresetMode.NEXT_STEP
    ones = [saltus.env.TaskEnv(saltus.env.IDS[name], draw=True, steps=60) for _ in range(5)]
    together = many.reset(seed=7)[0]
    alone = [env.reset(seed=7 + k)[0] for k, env in enumerate(ones)]
    assert np.array_equal(together, alone)
    random = np.random.default_rng(1)
    over = [False] * 5
    for _ in range(150):
        actions = drawn(many.single_action_space, random, 5)
        observed, rewards, terminated, truncated, _ = many.step(actions)
        for k, env in enumerate(ones):
            if over[k]:
                row: tuple[Any, ...] = (env.reset()[0], 0.0, False, False)
            else:
                row = env.step(actions[k])[:4]
            over[k] = row[2] or row[3]
            assert np.array_equal(observed[k], row[0])
            assert (rewards[k], terminated[k], truncated[k]) == row[1:]


def test_threads_do_not_matter() -> None:
    def run(threads: int) -> list[Any]:
        many = saltus.env.VectorTask("run-legs", 6, threads=threads)
        rows = [many.reset(seed=3)[0].tolist()]
        for k in range(50):
            rows.append([part.tolist() for part in many.step(np.full(6, k % 6))[:4]])
        return rows

    assert run(1) == run(3)


def test_bad_input_is_named() -> None:
    env = saltus.env.TaskEnv("run-zone")
    with pytest.raises(saltus.SaltusError, match="begun by `reset`"):
        env.step(0)
    env.reset(seed=1)
    for action in (2, -1, 0.5, "fire", None):
        with pytest.raises(saltus.SaltusError, match="action = "):
            env.step(action)
    for call, text in (
        (lambda: saltus.env.TaskEnv("run"), "task = \"run\": one of run-legs"),
        (lambda: saltus.env.TaskEnv(reward={"speed": 1}), "reward speed"),
        (lambda: saltus.env.TaskEnv(reward={"rate": "much"}), "reward 'rate' = 'much'"),
        (lambda: saltus.env.TaskEnv(robot="nobody"), "nobody"),
        (lambda: saltus.env.TaskEnv(steps=0), "time of an episode"),
        (lambda: saltus.env.VectorTask("run-zone", 0), "num_envs = 0"),
        (lambda: saltus.env.VectorTask("run-zone", 2).step(np.array([0, 1])), "begun by `reset`"),
    ):
        with pytest.raises(saltus.SaltusError, match=text):
            call()
    many = saltus.env.VectorTask("run-zone", 2)
    many.reset(seed=1)
    for actions in ([0], [0, 2], [0.0, 1.0], np.zeros((2, 1), dtype=np.int64)):
        with pytest.raises(saltus.SaltusError, match="actions = "):
            many.step(actions)


def test_numbers_outside_the_space_are_named() -> None:
    env = saltus.env.TaskEnv("run-stride")
    env.reset(seed=1)
    for action in ([0.0], [1.1, 0.0], [float("nan"), 0.0], 1, "fire", None, [[0.0, 0.0]]):
        with pytest.raises(saltus.SaltusError, match="action = "):
            env.step(action)
    assert env.actions == ["firing_angle_rad", "valve_open_s"]
    many = saltus.env.VectorTask("run-stride", 2)
    many.reset(seed=1)
    with pytest.raises(saltus.SaltusError, match="2 rows of 2 numbers"):
        many.step(np.zeros((2, 3)))


def test_a_stride_is_that_of_its_numbers() -> None:
    env = saltus.env.TaskEnv("run-stride")
    env.reset(seed=1)
    # In the middle of the ranges: the leg on which it stands fires, and it runs.
    info: dict[str, Any] = {}
    for _ in range(2):
        *_, info = env.step([0.1, 0.0])
    assert info["firings"] >= 1 and info["travel_m"] > 0.1
    # The least opening time is none: no leg fires.
    env.reset(seed=1)
    observed, _, terminated, _, info = env.step([0.1, -1.0])
    assert terminated and info["firings"] == 0 and abs(observed[0]) < 0.5


def test_after_the_end_there_is_no_step() -> None:
    env = saltus.env.TaskEnv("run-zone", steps=2)
    env.reset(seed=1)
    env.step(0)
    assert env.step(0)[3]
    with pytest.raises(saltus.SaltusError, match="the episode is over"):
        env.step(0)


def test_the_reward_is_what_was_asked_for() -> None:
    env = saltus.env.TaskEnv("run-legs", reward={"threshold:-100": 2, "time": 1000})
    env.reset(seed=1)
    assert env.step(0)[1] == 1.0


def learnt(seed: int) -> Any:
    return saltus.learn("run-zone", episodes=3, seeds=1, seed=seed).policy["tables"][0]


def test_a_seed_learns_the_same_alone_and_in_other_processes() -> None:
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    together = saltus.learn("run-zone", episodes=3, seeds=3, seed=4, threads=2).policy["tables"]
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        assert list(pool.map(learnt, (4, 5, 6))) == together


def test_a_table_is_scored_as_in_rust() -> None:
    policy = saltus.learn("run-stride", episodes=40, seeds=1, seed=7).policy
    table, axes = policy["tables"][0], policy["states"]
    episodes = saltus._saltus.Episodes("run-stride", saltus.Robot("rats-run"), 1, 1, [], None, False)
    (_, _, low, high), (_, _, _, longest) = episodes.chosen
    # Six firing angles and three valve opening times.
    firings = [[low + (high - low) / 5 * (k // 3), longest / 2 * (k % 3)] for k in range(18)]
    values = [0.0] * table["table_size"]
    for place, value in table["values"]:
        values[place] = value

    def firing(observed: Any) -> list[float]:
        state = 0
        for axis, x in zip(axes, observed, strict=True):
            step = int((x - axis["from"]) / (axis["to"] - axis["from"]) * axis["steps"] // 1)
            state = state * axis["steps"] + min(max(step, 0), axis["steps"] - 1)
        row = values[18 * state : 18 * state + 18]
        return firings[row.index(max(row))]

    def trial(k: int) -> Any:
        # The seed of the k-th trial of the learner with seed 7.
        observed, over = episodes.start([0], [(7 * 0x9E3779B97F4A7C15 + 2**40 + k) % 2**64])[0], False
        while not over:
            observed, _, terminated, truncated, info = episodes.choose_by(0, firing(observed))
            over = terminated or truncated
        return info

    trials = sorted((trial(k) for k in range(5)), key=lambda it: 100 - it["arrived_s"] if it["arrived_s"] else it["travel_m"])
    info = trials[2]
    _, _, _, time, angle, travel, arrived, gas, firings_done, broken = table["score"]
    assert (info["time_s"], info["arrived_s"], info["firings"], info["broken"]) == (time, arrived, firings_done, broken)
    assert info["travel_m"] == pytest.approx(travel, abs=1e-9) and info["gas_kg"] == pytest.approx(gas, rel=1e-9)
    assert info["angle_rad"] == pytest.approx(angle, abs=1e-9)


def test_learn_and_environments_are_the_same_robot() -> None:
    answer = saltus.learn("run-zone", episodes=3, seeds=1)
    assert answer.policy["tables"][0]["curve"][0][1] <= 360
    assert pickle.loads(pickle.dumps(answer)) == answer
