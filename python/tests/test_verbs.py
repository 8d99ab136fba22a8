"""Every verb gives the bytes of the command, takes all its flags, and says what it says."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import BOX, ROOT, Command

import saltus
from saltus._words import flag_of


CALLS: dict[str, tuple[Callable[[], saltus.Answer], list[str]]] = {
    "simulate": (
        lambda: saltus.simulate(omega_rad_s=[4.0, 5.0], alpha_f_rad=-0.1, set={"leg.supply_pressure_gauge_psi": 100}),
        "simulate --omega 4,5 --alpha-f -0.1 --set leg.supply_pressure_gauge_psi=100".split(),
    ),
    "table": (
        lambda: saltus.table(omega_rad_s=np.linspace(3, 6, 4), distance_m=[0.6, 0.7], start_lean_rad="firing"),
        "table --omega 3,4,5,6 --distance 0.6,0.7 --start-lean firing".split(),
    ),
    "table on a plant": (
        lambda: saltus.table(omega_rad_s=5, distance_m=0.6, plant="rats-boom", plant_set={"boom.mass_kg": 0.6}, threads=1),
        "table --omega 5 --distance 0.6 --plant rats-boom --plant-set boom.mass_kg=0.6".split(),
    ),
    "law": (
        lambda: saltus.law(omega_rad_s=[4, 5, 6], distance_m=0.6, firing_angles_rad=(-0.6, 0.6)),
        "law --omega 4,5,6 --distance 0.6 --firing-angles=-0.6:0.6".split(),
    ),
    "filling": (
        lambda: saltus.filling(omega_rad_s=4.5, alpha_f_rad=-0.1, clear_m=0.1, set={"tank.volume_l": 0.5}),
        "filling --omega 4.5 --alpha-f=-0.1 --clear 0.1 --set tank.volume_l=0.5".split(),
    ),
    "map": (
        lambda: saltus.map(omega_rad_s=[4, 5], alpha_f_rad=[-0.1, 0.1], friction=True),
        "map --omega 4,5 --alpha-f=-0.1,0.1 --friction".split(),
    ),
    "plan": (lambda: saltus.plan(BOX), ["plan", str(BOX)]),
    "verify": (
        lambda: saltus.verify(BOX, plant="rats-boom", samples=10, seed=4),
        ["verify", str(BOX), *"--plant rats-boom --samples 10 --seed 4".split()],
    ),
    "verify a law": (
        lambda: saltus.verify(law=(-0.12, 0.38), omega_rad_s=[4, 5], distance_m=0.6, samples=5),
        "verify --law=-0.12,0.38 --omega 4,5 --distance 0.6 --samples 5".split(),
    ),
    "run": (lambda: saltus.run(seconds=2, disturb=["torque=5@0.5:0.7s"]), "run closed-loop --seconds 2 --disturb torque=5@0.5:0.7s".split()),
    "robots": (lambda: saltus.run(seconds=1, robots=3, gait="fixed"), "run fixed --seconds 1 --robots 3".split()),
    "jump": (
        lambda: saltus.jump_over("0.02x0.1@1:3", runs=2, rounds=1, robots=2),
        "jump --obstacle 0.02x0.1@1:3 --runs 2 --rounds 1 --robots 2".split(),
    ),
    "learn": (
        lambda: saltus.learn("run-zone", episodes=2, seeds=2, lambda_=0.8, reward={"rate": 1, "threshold:2": 0.5}),
        "learn run-zone --episodes 2 --seeds 2 --lambda 0.8 --reward rate=1 --reward threshold:2=0.5".split(),
    ),
    "learn strides": (
        lambda: saltus.learn("run-stride", algorithm="sarsa", episodes=3, seeds=1, state={"wheel_rate": (-5, 20, 8)}),
        "learn run-stride --algorithm sarsa --episodes 3 --seeds 1 --state wheel_rate=-5:20:8".split(),
    ),
}


@pytest.mark.parametrize("name", CALLS)
def test_the_bytes_of_the_command(name: str, command: Command) -> None:
    call, words = CALLS[name]
    answer, said = call(), command(*words, "--format", "json")
    assert said.code in (0, 1), said.err
    assert answer.json == said.out
    assert answer.yes == (said.code == 0)
    assert sorted(answer.messages) == sorted(said.err.splitlines())


def test_diagnose_and_fit_give_the_bytes_of_the_command(command: Command, bench: Path) -> None:
    for answer, verb in ((saltus.diagnose(bench, known={"gravity": (9.81, 0.01)}), "diagnose"), (saltus.fit(bench), "fit")):
        more = ["--known", "gravity=9.81±0.01"] if verb == "diagnose" else []
        said = command(verb, str(bench), *more, "--format", "json")
        assert (answer.json, answer.yes) == (said.out, said.code == 0)


def test_design_gives_the_bytes_of_the_command(command: Command, tmp_path: Path) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(
        'kind = "outcomes"\nrobot = "rats-planar"\nnoise = { distance_mm = 10, apex_mm = 10 }\n'
        "[[jump]]\napproach_rate_rad_s = 4\nfiring_angle_rad = -0.1\nvalve_open_s = 0.1\nrepeat = 6\n"
    )
    answer = saltus.design(plan, effect={"coulomb-friction": 25}, seed=2)
    said = command("design", str(plan), "--effect", "coulomb-friction=25", "--seed", "2", "--format", "json")
    assert answer.json == said.out


def test_inject_writes_the_files_of_the_command(command: Command, tmp_path: Path) -> None:
    words = "viscous-friction=25 --kind bench --runs 3 --seed 9 --out".split()
    saltus.inject({"viscous-friction": 25}, kind="bench", runs=3, seed=9, out=tmp_path / "python")
    assert command("inject", *words, str(tmp_path / "shell")).code == 0
    names = sorted(file.name for file in (tmp_path / "python").iterdir())
    assert names == sorted(file.name for file in (tmp_path / "shell").iterdir())
    for name in names:
        assert (tmp_path / "python" / name).read_bytes() == (tmp_path / "shell" / name).read_bytes(), name


def test_what_was_learnt_runs_and_is_exported(command: Command, tmp_path: Path) -> None:
    policy = tmp_path / "policy.json"
    policy.write_text(saltus.learn("run-zone", episodes=6, seeds=2).json)
    answer = saltus.run(policy=policy, seconds=1)
    assert answer.json == command("run", "policy", str(policy), *"--seconds 1 --format json".split()).out
    about = saltus.export_policy(policy, out=tmp_path / "python")
    assert command("export", "policy", str(policy), "--out", tmp_path / "shell").out == about
    assert (tmp_path / "python" / "saltus_policy.h").read_bytes() == (tmp_path / "shell" / "saltus_policy.h").read_bytes()


@pytest.mark.parametrize("what", ["mjcf", "urdf"])
def test_export_gives_the_text_of_the_command(what: str, command: Command) -> None:
    ours = saltus.export(what, robot=saltus.Robot("rats-boom", set=["boom.mass_kg=0.6"]))
    assert ours.splitlines()[1:] == command("export", what, "--robot", "rats-boom", "--set", "boom.mass_kg=0.6").out.splitlines()[1:]


def test_export_writes_the_controller_of_the_command(command: Command, tmp_path: Path) -> None:
    saltus.export("rust", out=tmp_path / "a.rs", distance_m=[0.5, 0.6], omega_rad_s=[4, 5, 6])
    assert command(*"export rust --distance 0.5,0.6 --omega 4,5,6 --out".split(), tmp_path / "b.rs").code == 0

    def without_command(file: Path) -> list[str]:
        return [line for line in file.read_text().splitlines() if not line.startswith("//")]

    assert without_command(tmp_path / "a.rs") == without_command(tmp_path / "b.rs")


def test_a_robot_of_python_is_the_robot_of_its_file(command: Command, tmp_path: Path) -> None:
    robot = saltus.Robot("rats-planar", set=["body.mass_kg=2.5"])
    (tmp_path / "robot.toml").write_text(robot.toml)
    said = command(*"table --omega 5 --distance 0.6 --format json --robot".split(), tmp_path / "robot.toml")
    assert saltus.table(omega_rad_s=5, distance_m=0.6, robot=robot).rows == saltus.table(
        omega_rad_s=5, distance_m=0.6, robot=tmp_path / "robot.toml"
    ).rows
    assert saltus.table(omega_rad_s=5, distance_m=0.6, robot=robot).json == said.out


def test_jumps_are_those_of_simulate(command: Command) -> None:
    omega, alpha = np.linspace(2, 7, 21), np.linspace(-0.5, 0.5, 21)
    rows = saltus.jumps("rats-planar", omega[:, None], alpha, threads=2)
    grid = saltus.simulate(omega_rad_s=omega, alpha_f_rad=alpha)
    for name in rows:
        theirs = np.array([jump[name] if jump[name] is not None else np.nan for jump in grid.jumps])
        assert np.array_equal(rows[name], theirs, equal_nan=rows[name].dtype.kind == "f"), name
    one = saltus.jump("rats-planar", omega[3], alpha[4])
    assert (one.apex_m, one.land_0_m) == (rows["apex_m"][3 * 21 + 4], rows["land_0_m"][3 * 21 + 4])


LEFT_OUT = {"--help", "--version", "--format", "--out"}
"""Answers come as objects in place of reports."""
OTHERWISE = {
    "simulate": {"--batch"},
}
"""`jumps` takes arrays."""
FUNCTIONS: dict[str, list[Any]] = {
    "simulate": [saltus.simulate],
    "table": [saltus.table],
    "law": [saltus.law],
    "filling": [saltus.filling],
    "map": [saltus.map],
    "plan": [saltus.plan],
    "verify": [saltus.verify],
    **{f"run {gait}": [saltus.run] for gait in "fixed open-loop closed-loop curve smooth speed disc disc-stable steer recover policy".split()},
    "jump": [saltus.jump_over],
    "learn": [saltus.learn],
    "diagnose": [saltus.diagnose],
    "design": [saltus.design],
    "inject": [saltus.inject],
    "fit": [saltus.fit],
    "export c": [saltus.export],
    "export rust": [saltus.export],
    **{f"export gait {gait}": [saltus.export_gait] for gait in "fixed open-loop closed-loop curve smooth speed disc-stable steer".split()},
    "export policy": [saltus.export_policy],
    "export mjcf": [saltus.export],
    "export urdf": [saltus.export],
}


def flags(command: Command, verb: str) -> set[str]:
    return set(re.findall(r"^\s+(?:-\w, )?(--[a-z][a-z-]*)", command("help", *verb.split()).out, re.MULTILINE))


def arguments(*functions: Any) -> set[str]:
    return {flag_of(name) for function in functions for name in inspect.signature(function).parameters}


@pytest.mark.parametrize("verb", FUNCTIONS)
def test_every_flag_is_an_argument(verb: str, command: Command) -> None:
    missing = flags(command, verb) - arguments(*FUNCTIONS[verb]) - LEFT_OUT
    assert missing == OTHERWISE.get(verb, set())


def test_every_verb_is_here(command: Command) -> None:
    listed = re.findall(r"^  ([a-z]+)  ", command("help").out, re.MULTILINE)
    assert set(listed) - {"help", "completions"} == {verb.split()[0] for verb in FUNCTIONS}


def test_files_are_written_whole(command: Command, tmp_path: Path) -> None:
    plot, mcap = tmp_path / "plan.svg", tmp_path / "run.mcap"
    saltus.plan(BOX, plot=plot)
    saltus.run(seconds=0.5, gait="fixed", mcap=mcap)
    assert plot.read_bytes().startswith(b"<svg") and mcap.read_bytes().startswith(b"\x89MCAP")
    assert command(*"run fixed --seconds 0.5 --mcap".split(), tmp_path / "shell.mcap").code in (0, 1)


def test_a_run_has_its_cycles() -> None:
    rows = saltus.run(seconds=0.5, gait="fixed", rows=True).rows
    assert rows.rows == 500 and rows["time_s"][1] == pytest.approx(0.001)
