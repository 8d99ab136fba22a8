"""The robot that Saltus exports to MuJoCo comes back, and other models give what they can."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

import saltus

pytest.importorskip("mujoco")

from saltus import from_mujoco  # noqa: E402

UNSEEN = {"name", "kind", "gas", "environment", "errors", "ground", "sensors", "struts"}
"""What a model of MuJoCo does not say."""


def numbers(table: dict[str, object], within: str = "") -> dict[str, float]:
    flat: dict[str, float] = {}
    for key, value in table.items():
        if key in UNSEEN:
            continue
        if isinstance(value, dict):
            flat |= numbers(value, f"{within}{key}.")
        elif isinstance(value, (int, float)):
            flat[within + key] = value
    return flat


@pytest.mark.parametrize(
    "robot",
    [
        saltus.Robot("rats-boom"),
        saltus.Robot("rats-run"),
        saltus.Robot("rats-boom", set=["body.imbalance_mm=2", "body.imbalance_angle_deg=30", "body.legs=7", "leg.mass_kg=0.2"]),
        saltus.Robot("spring-hopper", set=["leg.mass_kg=0.1", "leg.center_m=0.12", "leg.rod_length_m=0.1", "leg.rod_radius_m=0.01"]),
    ],
    ids=lambda robot: robot.name,
)
def test_what_saltus_exports_comes_back(robot: saltus.Robot, tmp_path: Path) -> None:
    saltus.export("mjcf", out=tmp_path / "robot.xml", robot=robot)
    back = numbers(tomllib.loads(from_mujoco.convert(tmp_path / "robot.xml")))
    believed = numbers(robot.to_dict())
    seen = {key for key in back if key in believed}
    assert {"body.mass_kg", "body.inertia_kg_m2", "body.wheel_radius_m", "body.legs", "leg.stroke_m", "leg.mass_kg"} <= seen
    for key in seen:
        assert back[key] == pytest.approx(believed[key], rel=1e-9, abs=1e-9), key
    assert all(back[key] == pytest.approx(0.0, abs=1e-9) for key in back.keys() - seen)


def test_a_sprung_leg_becomes_a_spring(tmp_path: Path) -> None:
    (tmp_path / "hopper.xml").write_text(
        '<mujoco><worldbody><body name="hub" pos="0 0 .2"><joint type="hinge" axis="0 1 0"/><geom size=".1" mass="1"/>'
        '<body name="leg"><joint name="leg" type="slide" axis="0 0 -1" range="0 .05" stiffness="2000" springref=".06" damping="2"/>'
        '<geom type="capsule" fromto="0 0 -.1 0 0 -.19" size=".01" mass=".1"/></body></body></worldbody></mujoco>'
    )
    robot = tomllib.loads(from_mujoco.convert(tmp_path / "hopper.xml"))
    assert robot["leg"]["kind"] == "spring" and robot["leg"]["stiffness_n_per_m"] == 2000
    assert robot["leg"]["compression_m"] == pytest.approx(0.06)
    assert robot["body"]["wheel_radius_m"] == pytest.approx(0.2) and robot["foot"]["radius_m"] == pytest.approx(0.01)
    done = from_mujoco.convert(tmp_path / "hopper.xml").replace("# release_delay_ms =", "release_delay_ms = 3")
    assert saltus.jump(saltus.Robot.from_toml(done), 4.0, 0.0).outcome == "stroke"


def test_legs_that_turn_are_named(tmp_path: Path) -> None:
    (tmp_path / "leg.xml").write_text(
        '<mujoco><worldbody><body name="torso"><freejoint/><geom size=".1" mass="4"/>'
        '<body><joint name="knee" type="hinge" axis="0 1 0"/><geom size=".05" mass="1"/></body></body></worldbody></mujoco>'
    )
    text = from_mujoco.convert(tmp_path / "leg.xml")
    assert "no leg slides" in text and "knee" in text
    assert tomllib.loads(text)["body"]["mass_kg"] == pytest.approx(5)
    with pytest.raises(saltus.SaltusError, match="missing key"):
        saltus.Robot.from_toml(text)


def test_bad_models_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "bad.xml").write_text("<mujoco>")
    assert from_mujoco.main([str(tmp_path / "bad.xml"), "--out", str(tmp_path / "out.toml")]) == 2
    assert "bad.xml" in capsys.readouterr().err and not (tmp_path / "out.toml").exists()
    assert from_mujoco.main([str(tmp_path / "none.xml")]) == 2
    with pytest.raises(saltus.SaltusError, match="wheel = 'hub'"):
        (tmp_path / "one.xml").write_text('<mujoco><worldbody><body name="torso"><geom size=".1"/></body></worldbody></mujoco>')
        from_mujoco.convert(tmp_path / "one.xml", wheel="hub")
