"""The robot that Saltus exports comes back, other models give what they can, and no mass is lost."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import saltus

mujoco = pytest.importorskip("mujoco")

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


def total_mass(robot: dict[str, Any]) -> float:
    """All mass of a robot file (kg)."""
    boom = robot.get("boom", {})
    return float(robot["body"]["mass_kg"] + boom.get("mass_kg", 0.0) + boom.get("counterweight", {}).get("mass_kg", 0.0))


ROBOTS = [
    ("rats-planar", []),
    ("rats-boom", []),
    ("rats-run", []),
    ("rats-twelve", []),
    ("rats-boom", ["body.imbalance_mm=2", "body.imbalance_angle_deg=30", "body.legs=7", "leg.mass_kg=0.2"]),
    ("rats-boom", ["boom.counterweight={mass_kg=0.3, distance_m=0.4}"]),
    ("rats-boom", ["boom.counterweight={mass_kg=2, distance_m=0.7}", "boom.bending_stiffness_n_m_per_rad=2000", "boom.bending_damping_time_ms=1"]),
    ("spring-hopper", ["leg.mass_kg=0.1", "leg.center_m=0.12", "leg.rod_length_m=0.1", "leg.rod_radius_m=0.01"]),
]


@pytest.mark.parametrize("kind", ["mjcf", "urdf"])
@pytest.mark.parametrize(("name", "changes"), ROBOTS)
def test_what_saltus_exports_comes_back(name: str, changes: list[str], kind: str, tmp_path: Path) -> None:
    first = exported(kind, name, tmp_path, changes)
    text = from_mujoco.convert(first)
    back = tomllib.loads(text)
    # Of a URDF the links without mass have 1e-9 kg each, fourteen at most.
    near = 1e-9 if kind == "mjcf" else 2e-6
    if name != "rats-twelve":
        believed, found = numbers(saltus.Robot(name, set=changes).to_dict()), numbers(back)
        seen = {key for key in found if key in believed}
        assert {"body.mass_kg", "body.inertia_kg_m2", "body.wheel_radius_m", "body.legs", "leg.stroke_m"} <= seen
        for key in seen:
            assert found[key] == pytest.approx(believed[key], rel=near, abs=1e-9), key
        assert all(found[key] == pytest.approx(0.0, abs=1e-9) for key in found.keys() - seen)

    # With a drive in place of what has to be measured it is a robot again, whose bodies move as those of the first.
    lines = (line for line in text.splitlines() if not line.startswith(("stiffness_n_per_m", "compression_m")) or "[leg.return_spring]" in text)
    driven = "\n".join('kind = "constant"\nforce_n = 100\nrelease_delay_ms = 1' if line.startswith("kind =") else line for line in lines)
    (tmp_path / "again.toml").write_text(driven)
    one, other = (mujoco.MjModel.from_xml_path(str(exported("mjcf", *each))) for each in ((name, tmp_path, changes), (tmp_path / "again.toml", tmp_path, [])))
    assert total_mass(back) == pytest.approx(one.body_mass.sum(), rel=1e-7)
    if one.nq != other.nq:
        # A URDF does not say how stiff a boom is that bends: left out, it is rigid.
        assert kind == "urdf" and "# bending_stiffness_n_m_per_rad =  # MEASURE" in text
        return
    assert one.body_mass == pytest.approx(other.body_mass, rel=1e-6, abs=1e-9)
    assert np.abs(moved(one) - moved(other)).max() < near * np.abs(moved(one)).max()
    assert one.jnt_range == pytest.approx(other.jnt_range, abs=1e-12)
    assert one.dof_damping == pytest.approx(other.dof_damping, rel=1e-9)
    assert one.dof_frictionloss == pytest.approx(other.dof_frictionloss, rel=1e-9)
    if kind == "mjcf":
        assert np.ravel(one.jnt_stiffness) == pytest.approx(np.ravel(other.jnt_stiffness), rel=1e-9)
    for foot in range(2):
        assert one.geom(f"foot_{foot}").pos == pytest.approx(other.geom(f"foot_{foot}").pos, abs=1e-8)


def exported(kind: str, robot: str | Path, folder: Path, changes: list[str]) -> Path:
    file = folder / ("robot.xml" if kind == "mjcf" else "robot.urdf")
    saltus.export(kind, out=file, robot=str(robot), set=changes)
    return file


def moved(model: Any) -> Any:
    """Mass matrix of a model with its legs out."""
    data = mujoco.MjData(model)
    data.qpos[-model.nu :] = np.linspace(0.01, 0.04, model.nu)
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, full, data.qM) if hasattr(data, "qM") else mujoco.mj_fullM(model, data, full)
    return full


HUB = """<robot name="hub"><link name="base_link"><inertial><mass value="2"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.015" iyz="0" izz="0.01"/></inertial>
<collision><geometry><sphere radius="0.1"/></geometry></collision></link>
{legs}</robot>"""
HUB_LEG = """<link name="leg_{k}"><inertial><mass value="0.1"/><origin xyz="0 0 {up}0.1"/><inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-5"/></inertial>
<collision><origin xyz="0 0 {up}0.2"/><geometry><sphere radius="0.01"/></geometry></collision></link>
<joint name="leg_{k}" type="prismatic"><parent link="base_link"/><child link="leg_{k}"/><axis xyz="0 0 {up}1"/><limit lower="0" upper="0.06" effort="10" velocity="1"/></joint>
"""


def test_the_root_link_of_a_urdf_is_free(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """MuJoCo welds it to the world, where its mass is no more."""
    file = tmp_path / "hub.urdf"
    file.write_text(HUB.format(legs="".join(HUB_LEG.format(k=k, up=up) for k, up in enumerate("-+"))))
    assert from_mujoco.main([str(file)]) == 0
    shown = capsys.readouterr()
    robot = tomllib.loads(shown.out)
    assert robot["body"]["mass_kg"] == pytest.approx(2.2) and robot["body"]["legs"] == 2
    assert robot["leg"]["stroke_m"] == pytest.approx(0.06) and robot["body"]["wheel_radius_m"] == pytest.approx(0.21)
    # About y: 0.015 of the hub, and of each leg 1e-4 and 0.1 kg at 0.1 m.
    assert robot["body"]["inertia_kg_m2"] == pytest.approx(0.015 + 2 * (1e-4 + 1e-3))
    assert "note: base_link has no joint to the world: it is taken as free" in shown.err


def test_a_body_above_the_legs_is_refused_by_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "torso.xml"
    file.write_text(
        '<mujoco><worldbody><body name="torso"><freejoint/><geom size=".2" mass="10"/><body name="hip"><joint name="hip_y" type="hinge" axis="0 1 0"/>'
        '<geom size=".05" mass="1"/><body name="foot"><joint type="slide" axis="0 0 -1" range="0 .1"/><geom pos="0 0 -.3" size=".02" mass=".2"/></body></body></body></worldbody></mujoco>'
    )
    assert from_mujoco.main([str(file)]) == 2
    message = capsys.readouterr().err
    assert "torso.xml: no place in a robot file for the mass of torso (10 kg): hip, which has the legs, moves on it on the joint hip_y" in message
    # With it as the wheel, the mass of all is there, and what was merged is named.
    text = from_mujoco.convert(file, wheel="torso")
    assert tomllib.loads(text)["body"]["mass_kg"] == pytest.approx(11.2)
    assert "as they move and are no legs that slide: hip (1 kg), foot (0.2 kg)" in text


@dataclass
class Part:
    """A body of a drawn model: `joint` is its joint to the one that carries it."""

    name: str
    joint: str
    mass: float
    """Of an inertial, or 0."""
    ball: float
    """Radius (m) of a sphere of the density of water, in place of an inertial; or 0."""
    place: tuple[float, float, float]
    axis: tuple[float, float, float] = (0.0, 1.0, 0.0)
    on_it: list[Part] = field(default_factory=list)

    def own_mass(self) -> float:
        return self.mass if self.mass > 0.0 else 1000.0 * 4.0 / 3.0 * np.pi * self.ball**3

    def all(self) -> list[Part]:
        return [self, *(part for own in self.on_it for part in own.all())]

    def mjcf(self) -> str:
        joints = {
            "fixed": "",
            "floating": "<freejoint/>",
            "continuous": f'<joint name="j_{self.name}" type="hinge" axis="{spaced(self.axis)}"/>',
            "prismatic": f'<joint name="j_{self.name}" type="slide" axis="{spaced(self.axis)}" range="0 .1"/>',
        }
        moments = spaced(3 * (0.01 * self.mass,))
        mass = f'<inertial pos="0 0 0" mass="{self.mass!r}" diaginertia="{moments}"/>' if self.mass > 0.0 else ""
        shape = f'<geom type="sphere" size="{self.ball!r}"/>' if self.ball > 0.0 else ""
        return f'<body name="{self.name}" pos="{spaced(self.place)}">{joints[self.joint]}{mass}{shape}{"".join(part.mjcf() for part in self.on_it)}</body>'

    def urdf(self, carrier: str | None) -> str:
        moment = repr(0.01 * self.mass)
        mass = f'<inertial><mass value="{self.mass!r}"/><inertia ixx="{moment}" iyy="{moment}" izz="{moment}" ixy="0" ixz="0" iyz="0"/></inertial>' if self.mass > 0.0 else ""
        shape = f'<collision><geometry><sphere radius="{self.ball!r}"/></geometry></collision>' if self.ball > 0.0 else ""
        joint = (
            f'<joint name="j_{self.name}" type="{self.joint}"><parent link="{carrier}"/><child link="{self.name}"/><origin xyz="{spaced(self.place)}"/>'
            f'<axis xyz="{spaced(self.axis)}"/><limit lower="0" upper="0.1" effort="1" velocity="1"/></joint>'
        )
        return f'<link name="{self.name}">{mass}{shape}</link>{joint if carrier else ""}{"".join(part.urdf(self.name) for part in self.on_it)}'


def spaced(values: tuple[float, ...]) -> str:
    return " ".join(repr(float(value)) for value in values)


def drawn(draw: np.random.Generator) -> tuple[Part, list[str], list[str]]:
    """A robot; the bodies that a robot file has no place for, and those that move and are no legs."""
    names = iter(f"link_{k}" for k in range(100))

    def part(joint: str, on_it: list[Part], axis: tuple[float, float, float] = (0.0, 1.0, 0.0)) -> Part:
        has_inertial = draw.random() < 0.6
        place = tuple(float(x) for x in draw.uniform(-0.2, 0.2, 3))
        mass = float(draw.uniform(0.1, 5.0)) if has_inertial else 0.0
        ball = 0.0 if has_inertial and draw.random() < 0.5 else float(draw.uniform(0.02, 0.1))
        return Part(next(names), joint, mass, ball, (place[0], place[1], place[2]), axis, on_it)

    def fixed() -> list[Part]:
        return [part("fixed", []) for _ in range(int(draw.integers(0, 3)))]

    count = int(draw.integers(1, 7))
    angles = 2.0 * np.pi * np.arange(count) / count
    legs = [part("prismatic", fixed(), (float(np.sin(angle)), 0.0, -float(np.cos(angle)))) for angle in angles]
    # Some slide in a tube of their own, which is fixed to the hub.
    tubes = [part("fixed", [leg]) if draw.random() < 0.3 else leg for leg in legs]
    arms = [part("continuous", fixed()) for _ in range(int(draw.integers(0, 2)))]
    hub = part("fixed", [*tubes, *arms, *fixed()])
    top, lost, joint = hub, [], str(draw.choice(["fixed", "fixed", "continuous"]))
    for _ in range(int(draw.integers(0, 3))):
        above = part("fixed", [top])
        top.joint = joint
        if joint != "fixed" or lost:
            lost.append(above.name)
            lost += [own.name for own in above.on_it if own is not top]
        top, joint = above, str(draw.choice(["fixed", "continuous"]))
    return top, lost, [body.name for arm in arms for body in arm.all()]


@pytest.mark.parametrize("kind", ["mjcf", "urdf"])
def test_no_mass_is_lost(kind: str, tmp_path: Path) -> None:
    """Drawn robots: the file has all mass of the model, or a refusal names each body whose mass it would lose."""
    draw = np.random.default_rng(12)
    file = tmp_path / ("robot.xml" if kind == "mjcf" else "robot.urdf")
    refused = taken = merged = 0
    for _ in range(60):
        top, lost, arms = drawn(draw)
        if kind == "mjcf":
            top.joint = str(draw.choice(["floating", "fixed"]))
            file.write_text(f"<mujoco><worldbody>{top.mjcf()}</worldbody></mujoco>")
        else:
            file.write_text(f'<robot name="drawn">{top.urdf(None)}</robot>')
        bodies = top.all()
        try:
            text = from_mujoco.convert(file)
        except saltus.SaltusError as error:
            refused += 1
            assert lost and all(f"{name} (" in str(error) for name in lost), (lost, str(error))
            continue
        assert not lost, (lost, text)
        taken += 1
        merged += len(arms) > 0
        robot = tomllib.loads(text)
        assert total_mass(robot) == pytest.approx(sum(body.own_mass() for body in bodies), rel=1e-9)
        assert robot["body"]["legs"] == sum(body.joint == "prismatic" for body in bodies)
        assert robot["leg"]["stroke_m"] == pytest.approx(0.1)
        notes = "".join(line for line in text.splitlines() if line.startswith("# NOTE"))
        assert all(f"{name} (" in notes for name in arms)
        if kind == "urdf":
            guessed = [body.name for body in bodies if body.mass == 0.0]
            assert all(f"{name} (" in notes for name in guessed)
    assert min(refused, taken, merged) >= 5


def test_what_stands_in_the_world_is_refused_by_name(tmp_path: Path) -> None:
    robot = '<body name="hub"><freejoint/><geom size=".1" mass="1"/><body><joint type="slide" axis="0 0 -1" range="0 .05"/><geom pos="0 0 -.1" size=".01"/></body></body>'
    (tmp_path / "scene.xml").write_text(f'<mujoco><worldbody><geom type="plane" size="1 1 1"/><body name="table"><geom size=".1" mass="7"/></body>{robot}</worldbody></mujoco>')
    with pytest.raises(saltus.SaltusError, match=r"mass of table \(7 kg\): it is fixed to the world; give a joint to what moves"):
        from_mujoco.convert(tmp_path / "scene.xml")
    (tmp_path / "ball.xml").write_text(f'<mujoco><worldbody><body name="ball"><freejoint/><geom size=".1" mass="7"/></body>{robot}</worldbody></mujoco>')
    with pytest.raises(saltus.SaltusError, match=r"mass of ball \(7 kg\): it is neither on hub"):
        from_mujoco.convert(tmp_path / "ball.xml")


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
    assert "no legs that slide: the body of joint knee (1 kg)" in text
    assert tomllib.loads(text)["body"]["mass_kg"] == pytest.approx(5)
    with pytest.raises(saltus.SaltusError, match="missing key"):
        saltus.Robot.from_toml(text)


def test_bad_models_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "good.xml").write_text('<mujoco><worldbody><body name="torso"><geom size=".1"/></body></worldbody></mujoco>')
    assert from_mujoco.main([str(tmp_path / "good.xml"), "--out", str(tmp_path / "nowhere" / "out.toml")]) == 2
    assert "out.toml: cannot be written: its folder is not there" in capsys.readouterr().err
    (tmp_path / "bad.xml").write_text("<mujoco>")
    assert from_mujoco.main([str(tmp_path / "bad.xml"), "--out", str(tmp_path / "out.toml")]) == 2
    assert "bad.xml" in capsys.readouterr().err and not (tmp_path / "out.toml").exists()
    assert from_mujoco.main([str(tmp_path / "none.xml")]) == 2
    with pytest.raises(saltus.SaltusError, match="wheel = 'hub'"):
        (tmp_path / "one.xml").write_text('<mujoco><worldbody><body name="torso"><geom size=".1"/></body></worldbody></mujoco>')
        from_mujoco.convert(tmp_path / "one.xml", wheel="hub")
