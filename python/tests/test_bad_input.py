"""Bad input is a SaltusError that names the argument, its value and what is allowed; nothing crashes."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import saltus

REFUSED: list[tuple[Callable[[], object], str]] = [
    (lambda: saltus.Robot("nobody"), "nobody"),
    (lambda: saltus.Robot("rats-planar", set=["body.mass_kg=-1"]), r"body\.mass_kg"),
    (lambda: saltus.Robot.from_dict({"name": "x", "body": {1: 2}}), "keys are texts"),
    (lambda: saltus.Robot.from_dict({"name": "x", "body": {"mass_kg": object()}}), r"body\.mass_kg"),
    (lambda: saltus.Robot.from_dict({"name": "x", "legs": 2**70}), "legs: .*64 bits"),
    (lambda: saltus.Robot("rats-planar", set=3), "set = 3: a dictionary, a text or a list of texts"),  # type: ignore[arg-type]
    (lambda: saltus.jump(5.0, 5.0, 0.0), "robot = 5.0: a Robot, a name, a file or a dictionary"),  # type: ignore[arg-type]
    (lambda: saltus.table(omega_rad_s=5, distance_m=0.6, plant=3), "plant = 3: a Robot"),  # type: ignore[arg-type]
    (lambda: saltus.verify(saltus.plan({"approach_rate_rad_s": 5.0, "target_x_m": 0.9})), "an answer of saltus.plan: a course"),
    (lambda: saltus.plan(3), "3: the path of a file"),  # type: ignore[arg-type]
    (lambda: saltus.jump("rats-planar", math.nan, 0.0), "omega_rad_s NaN"),
    (lambda: saltus.jump("rats-planar", 5.0, math.inf), "alpha_f_rad inf"),
    (lambda: saltus.jump("rats-planar", 5.0, 0.0, valve_open_s=-1.0), "valve_open_s -1"),
    (lambda: saltus.jumps("rats-planar", [5.0, math.nan], 0.0), r"omega_rad_s\[1\] = nan: finite numbers \(shape \(2,\)\)"),
    (lambda: saltus.jumps("rats-planar", [5.0, 4.0], [0.0, 0.1, 0.2]), r"omega_rad_s \(2,\), alpha_f_rad \(3,\)"),
    (lambda: saltus.jumps("rats-planar", "5", 0.0), "omega_rad_s: str: real numbers"),
    (lambda: saltus.jumps("rats-planar", [5 + 1j], 0.0), "omega_rad_s: list: real numbers"),
    (lambda: saltus.jumps("rats-planar", np.array([True]), 0.0), "omega_rad_s: bool: real numbers"),
    (lambda: saltus.jumps("rats-planar", [[5.0], [4.0, 3.0]], 0.0), "omega_rad_s: list: real numbers"),
    (lambda: saltus.jumps("rats-planar", 5.0, 0.0, threads=0), "threads = 0: a whole number from 1 to 4096"),
    (lambda: saltus.jumps("rats-planar", 5.0, 0.0, threads=-3), "threads = -3"),
    (lambda: saltus.jumps("rats-planar", 5.0, 0.0, tolerance=0.0), "tolerance = 0.0: from 1e-13 to 0.0001"),
    (lambda: saltus.jumps("rats-planar", 5.0, 0.0, valve_open_s=[0.1, -0.1]), "jump 1: .*valve_open_s -0.1"),
    (lambda: saltus.table(omega_rad_s=[math.nan], distance_m=0.6), "omega_rad_s.*nan"),
    (lambda: saltus.table(omega_rad_s=[], distance_m=0.6), "omega_rad_s: is empty"),
    (lambda: saltus.table(omega_rad_s=np.ones((2, 2)), distance_m=0.6), r"omega_rad_s: shape \(2, 2\): one dimension"),
    (lambda: saltus.table(omega_rad_s=5), "distance_m"),
    (lambda: saltus.table(omega_rad_s=None, distance_m=0.6), "omega_rad_s"),
    (lambda: saltus.table(omega_rad_s=5, distance_m=0.6, threads=0), "threads"),
    (lambda: saltus.table(omega_rad_s=5, distance_m=True), "distance_m"),
    (lambda: saltus.table(omega_rad_s={"a": 1}, distance_m=0.6), "omega_rad_s = {'a': 1}: a number"),
    (lambda: saltus.plan("no-such-course.toml"), "no-such-course.toml"),
    (lambda: saltus.plan({"approach_rate_rad_s": 5.0, "jumps": 0}), "course.toml.*jumps"),
    (lambda: saltus.plan({"aproach_rate_rad_s": 5.0}), "aproach_rate_rad_s"),
    (lambda: saltus.verify(law=(1.0, 2.0), omega_rad_s=5, distance_m=0.6, samples=-1), "samples"),
    (lambda: saltus.verify(law=(1.0,), omega_rad_s=5, distance_m=0.6), "law"),  # type: ignore[arg-type]
    (lambda: saltus.run(seconds=-1), "seconds"),
    (lambda: saltus.run(gait="trot"), "trot.*gait"),
    (lambda: saltus.run(seed=-1), "seed"),
    (lambda: saltus.run(set={"leg.strok_m": 1}), "leg.strok_m"),
    (lambda: saltus.diagnose("no-such-folder"), "no-such-folder"),
    (lambda: saltus.inject({"gremlins": 1}, out="/nonexistent/place"), "gremlins"),
    (lambda: saltus.export("stl"), "what = 'stl': c, rust, mjcf or urdf"),
]


@pytest.mark.parametrize("number", range(len(REFUSED)))
def test_what_is_wrong_is_named(number: int) -> None:
    call, text = REFUSED[number]
    with pytest.raises(saltus.SaltusError, match=text) as caught:
        call()
    assert "--" not in str(caught.value), "flags are the command's"


def test_files_with_bytes_that_are_no_text(tmp_path: Any) -> None:
    (tmp_path / "robot.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(saltus.SaltusError, match="robot.toml"):
        saltus.Robot(str(tmp_path / "robot.toml"))


THINGS: list[Any] = [
    None, True, 0, -1, 3, 10**30, 0.0, -0.0, 5.0, -0.1, 1e-320, 1e300, math.nan, math.inf, -math.inf, "", "firing", "wheel", "rats-boom",
    "5", b"5", "\x00", "\ud800", "a" * 3000, [], [5.0], [5.0, -1.0], (4, 5), [[1.0]], {}, {"a": 1}, {"body.mass_kg": 3}, set(), object(),
    np.float64(5), np.float32(-0.1), np.int8(3), np.array([]), np.array([5.0, 4.0]), np.ones((2, 3)), np.zeros((0, 4)), np.array(["x"]),
    np.array([None]), np.ones(4)[::2], np.asfortranarray(np.ones((2, 2))), np.ones(3, dtype=">f8"), 1 + 2j, range(3), saltus.Robot("rats-planar"),
]  # fmt: skip


def draw(seed: random.Random) -> object:
    """One call with arguments that anything may be."""
    thing = lambda: seed.choice(THINGS)
    robot = seed.choice(["rats-planar", saltus.Robot("spring-hopper"), thing()])
    calls: list[Callable[[], object]] = [
        lambda: saltus.jump(robot, thing(), thing(), valve_open_s=seed.choice([0.1, thing()]), start_lean_rad=seed.choice([None, thing()])),
        lambda: saltus.jumps(robot, thing(), thing(), valve_open_s=seed.choice([0.1, thing()]), threads=seed.choice([1, thing()])),
        lambda: saltus.Robot(thing(), set=thing()),
        lambda: saltus.Robot.from_dict(thing()),
        lambda: saltus.Robot.from_toml(thing(), name=thing()),
        lambda: saltus._saltus.jumps(robot, thing(), thing(), thing()),
        lambda: saltus._saltus.jumps(saltus.Robot("rats-planar"), [np.array(it) for it in (thing(), thing(), [1.0], [1.0])], thing(), 1e-9),
        lambda: saltus._saltus.command(thing(), thing()),
        lambda: saltus._saltus.command([str(thing()), str(thing())], {}),
        lambda: saltus._saltus.flight(saltus.Robot("rats-planar"), saltus.jump("rats-planar", 5.0, -0.1), seed.choice([0, 1, 5]), thing()),
        lambda: saltus._saltus.to_toml(thing()),
        lambda: saltus.Jump._of(thing(), thing()),  # type: ignore[attr-defined]
    ]
    slow: list[Callable[[], object]] = [
        lambda: saltus.table(omega_rad_s=thing(), distance_m=thing(), set=thing(), threads=1),
        lambda: saltus.simulate(omega_rad_s=thing(), alpha_f_rad=thing(), robot=thing(), threads=1),
        lambda: saltus.plan(thing(), set=thing(), threads=1),
        lambda: saltus.diagnose(thing(), experiment=thing(), known=thing()),
        lambda: saltus.export(thing(), distance_m=thing(), threads=1),
    ]
    return seed.choice(slow if seed.random() < 0.1 else calls)()


@pytest.mark.parametrize("part", range(10))
def test_ten_thousand_random_calls(part: int) -> None:
    seed = random.Random(part)
    answers = 0
    for _ in range(10_000):
        try:
            draw(seed)
            answers += 1
        except (saltus.SaltusError, TypeError, OverflowError, AttributeError, UnicodeEncodeError, KeyError) as error:
            assert type(error) in (saltus.SaltusError, TypeError, OverflowError, AttributeError, UnicodeEncodeError, KeyError)
    assert answers > 100
