"""Starts a robot file from a model of MuJoCo.

    python -m saltus.from_mujoco robot.xml --out robot.toml

Masses, moments of inertia, radius, strokes and losses of the joints come from the model (MJCF, or URDF
as MuJoCo reads it). What a model of MuJoCo does not know, as the valve and the friction of the ground,
stands in the file as `# MEASURE` lines; `saltus` refuses the file until those without a default are
filled in. Needs the package `mujoco`.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._saltus import SaltusError

__all__ = ["convert", "main"]

Vector = NDArray[np.float64]

SAME = 1e-6
"""Relative difference up to which two legs are the same, and length (m) that counts as 0."""
MASSLESS = 1e-5
"""Share of the robot's mass below which a leg has none: simulators need some."""

PNEUMATIC = {
    "valve_delay_ms": "from the command to the first move of the leg",
    "bore_mm": "of the cylinder",
    "dead_volume_cm3": "of the chamber with the leg retracted, hoses up to the valve included",
    "supply_pressure_gauge_psi": "above ambient",
    "discharge_coefficient": "of the valve: `saltus fit` gets it from benchtop firings",
    "orifice_radius_mm": "of the valve",
    "gas": '"air", "co2" or "nitrogen"',
    "gas_temperature_k": "",
}
SPRING = {"release_delay_ms": "from the command to the first move of the leg"}


@dataclass
class Leg:
    """One leg that slides; lengths in m."""

    name: str
    axis: Vector
    stroke: float | None
    damping: float
    friction: float
    stiffness: float
    pull: float
    """Force of the joint's spring on the retracted leg (N), inwards."""
    mass: float
    center: float
    """Centre of mass from the axle, along the leg."""
    rod: tuple[float, float] | None
    """Length and radius of the cylinder with the same moments of inertia."""
    reach: float
    """From the axle to the tip."""
    foot: float
    """Radius of the tip; 0 for a point."""


@dataclass
class Found:
    """What the model says."""

    name: str
    mass: float
    inertia: float
    imbalance: tuple[float, float]
    """Distance (m) and angle (rad) of the wheel's centre of mass."""
    legs: list[Leg]
    boom: tuple[float, float, float] | None
    """Mass, length, radius."""
    radius: float
    gravity: float
    notes: list[str] = field(default_factory=list)


def convert(model: str | os.PathLike[str], *, wheel: str | None = None) -> str:
    """The robot file of a model of MuJoCo, as text with `# MEASURE` lines.

    `wheel` names the body that the legs slide in; by default it is found by its legs. Raises
    `SaltusError` where the model cannot be read or has no such body.
    """
    return text(find(os.fspath(model), wheel))


def find(path: str, wheel: str | None) -> Found:
    """What the model of this file says."""
    try:
        mujoco = importlib.import_module("mujoco")
    except ImportError:
        raise SaltusError("saltus.from_mujoco needs MuJoCo: pip install mujoco") from None
    try:
        model = mujoco.MjModel.from_xml_path(path)
    except ValueError as error:
        raise SaltusError(f"{path}: {error}") from None
    data = mujoco.MjData(model)
    slides = [k for k in range(model.njnt) if model.jnt_type[k] == mujoco.mjtJoint.mjJNT_SLIDE and is_leaf(model, model.jnt_bodyid[k])]
    hub = wheel_of(model, path, wheel, slides)
    slides = [k for k in slides if model.body_parentid[model.jnt_bodyid[k]] == hub]
    for joint in slides:
        if model.jnt_limited[joint]:
            data.qpos[model.jnt_qposadr[joint]] = model.jnt_range[joint][0]
    mujoco.mj_forward(model, data)
    place, axis = axle_of(mujoco, model, data, hub)
    legs = [leg_of(mujoco, model, data, joint, place) for joint in slides]
    subtree = [k for k in range(model.nbody) if is_below(model, k, hub)]
    found = Found(
        name=Path(path).stem,
        mass=float(model.body_subtreemass[hub]),
        inertia=sum(inertia_about(model, data, k, place, axis) for k in subtree),
        imbalance=imbalance_of(data, hub, place, axis, legs),
        legs=legs,
        boom=boom_of(mujoco, model, data, hub, place),
        radius=max((leg.reach for leg in legs), default=0.0) or reach_of_wheel(mujoco, model, data, hub, place, axis),
        gravity=float(np.linalg.norm(model.opt.gravity)),
    )
    found.notes = notes_of(model, found)
    return found


def wheel_of(model: Any, path: str, wheel: str | None, slides: list[int]) -> int:
    """The body that the legs slide in."""
    names = [model.body(k).name for k in range(1, model.nbody)]
    if wheel is not None:
        if wheel not in names:
            raise SaltusError(f"wheel = {wheel!r}: a body of {path}: {', '.join(names)}")
        return int(model.body(wheel).id)
    if model.nbody < 2:
        raise SaltusError(f"{path}: has no body")
    if slides:
        parents = [int(model.body_parentid[model.jnt_bodyid[k]]) for k in slides]
        return max(set(parents) - {0} or {1}, key=parents.count)
    roots = [k for k in range(1, model.nbody) if model.body_parentid[k] == 0]
    return max(roots, key=lambda k: float(model.body_subtreemass[k]))


def is_leaf(model: Any, body: int) -> bool:
    """Whether nothing moves on this body, and another body that moves carries it."""
    carries = [k for k in range(1, model.nbody) if model.body_parentid[k] == body and model.body_jntnum[k] > 0]
    return not carries and model.body_parentid[body] != 0 and model.body_jntnum[body] == 1


def is_below(model: Any, body: int, top: int) -> bool:
    """Whether `top` carries `body`, or is it."""
    while body not in (top, 0):
        body = int(model.body_parentid[body])
    return body == top


def axle_of(mujoco: Any, model: Any, data: Any, hub: int) -> tuple[Vector, Vector]:
    """A point of the axle, and its direction: the last hinge of the wheel, or y through its origin."""
    first, count = int(model.body_jntadr[hub]), int(model.body_jntnum[hub])
    for joint in range(first + count - 1, first - 1, -1):
        if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE:
            return np.array(data.xanchor[joint]), np.array(data.xaxis[joint])
    return np.array(data.xpos[hub]), np.array([0.0, 1.0, 0.0])


def inertia_about(model: Any, data: Any, body: int, place: Vector, axis: Vector) -> float:
    """Moment of inertia of a body about a line."""
    turned = data.ximat[body].reshape(3, 3).T @ axis
    off = np.cross(data.xipos[body] - place, axis)
    return float(turned @ (model.body_inertia[body] * turned) + model.body_mass[body] * (off @ off))


def imbalance_of(data: Any, hub: int, place: Vector, axis: Vector, legs: list[Leg]) -> tuple[float, float]:
    """Where the centre of mass of the wheel alone is: off the axle, and forwards from the first leg."""
    off = np.array(data.xipos[hub]) - place
    off -= axis * (off @ axis)
    zero = legs[0].axis if legs else np.array([0.0, 0.0, -1.0])
    distance = float(np.linalg.norm(off))
    # A lean forwards moves what is below the axle backwards.
    return distance, float(np.arctan2(np.cross(off, zero) @ axis, zero @ off)) if distance > SAME else 0.0


def leg_of(mujoco: Any, model: Any, data: Any, joint: int, place: Vector) -> Leg:
    """The leg of a sliding joint."""
    body = int(model.jnt_bodyid[joint])
    axis = np.array(data.xaxis[joint])
    dof = int(model.jnt_dofadr[joint])
    low, high = model.jnt_range[joint]
    parts = [k for k in range(model.nbody) if is_below(model, k, body)]
    mass = float(sum(model.body_mass[k] for k in parts))
    center = np.array(data.subtree_com[body])
    along, across = (sum(inertia_about(model, data, k, center, way) for k in parts) for way in (axis, crosswise(axis)))
    tips = [(reach(mujoco, model, data, geom, place, axis), geom) for geom in range(model.ngeom) if model.geom_bodyid[geom] in parts]
    tip, geom = max(tips, default=(0.0, -1))
    round_tip = geom >= 0 and any(model.geom_type[geom] == kind for kind in (mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_CAPSULE))
    rest = float(model.qpos_spring[model.jnt_qposadr[joint]] - data.qpos[model.jnt_qposadr[joint]])
    stiffness = float(np.ravel(model.jnt_stiffness[joint])[0])
    return Leg(
        name=model.joint(joint).name or model.body(body).name,
        axis=axis,
        stroke=float(high - low) if model.jnt_limited[joint] else None,
        damping=float(np.ravel(model.dof_damping[dof])[0]),
        friction=float(model.dof_frictionloss[dof]),
        stiffness=stiffness,
        pull=-stiffness * rest,
        mass=mass,
        center=float((center - place) @ axis),
        rod=rod_of(mass, along, across),
        reach=tip,
        foot=float(model.geom_size[geom][0]) if round_tip else 0.0,
    )


def crosswise(axis: Vector) -> Vector:
    """A direction across another."""
    other = np.eye(3)[int(np.argmin(np.abs(axis)))]
    way = np.cross(axis, other)
    return np.asarray(way / np.linalg.norm(way), dtype=np.float64)


def rod_of(mass: float, along: float, across: float) -> tuple[float, float] | None:
    """Length and radius of the cylinder with these moments of inertia, along and across its axis."""
    if mass <= 0.0:
        return None
    square = 12.0 * across / mass - 6.0 * along / mass
    return (float(np.sqrt(square)), float(np.sqrt(2.0 * along / mass))) if square > 0.0 else None


def reach(mujoco: Any, model: Any, data: Any, geom: int, place: Vector, axis: Vector) -> float:
    """How far a geom reaches from a point in a direction."""
    turned = data.geom_xmat[geom].reshape(3, 3).T @ axis
    size, kind = model.geom_size[geom], model.geom_type[geom]
    kinds = mujoco.mjtGeom
    middle = float((data.geom_xpos[geom] - place) @ axis)
    side = float(np.hypot(turned[0], turned[1]))
    if kind == kinds.mjGEOM_SPHERE:
        return middle + float(size[0])
    if kind == kinds.mjGEOM_CAPSULE:
        return middle + float(size[0] + size[1] * abs(turned[2]))
    if kind == kinds.mjGEOM_CYLINDER:
        return middle + float(size[0] * side + size[1] * abs(turned[2]))
    if kind == kinds.mjGEOM_ELLIPSOID:
        return middle + float(np.linalg.norm(size * turned))
    if kind == kinds.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        return middle + float(np.max(model.mesh_vert[first : first + count] @ turned))
    return middle + float(size @ np.abs(turned))


def reach_of_wheel(mujoco: Any, model: Any, data: Any, hub: int, place: Vector, axis: Vector) -> float:
    """The radius of what is on the wheel, across its axle."""
    ways = [np.cos(angle) * crosswise(axis) + np.sin(angle) * np.cross(axis, crosswise(axis)) for angle in np.linspace(0, 2 * np.pi, 73)]
    geoms = [geom for geom in range(model.ngeom) if is_below(model, model.geom_bodyid[geom], hub)]
    return max((reach(mujoco, model, data, geom, place, way) for geom in geoms for way in ways), default=0.0)


def boom_of(mujoco: Any, model: Any, data: Any, hub: int, place: Vector) -> tuple[float, float, float] | None:
    """The boom that holds the axle: a body on two hinges in the world."""
    body = int(model.body_parentid[hub])
    first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    hinges = [k for k in range(first, first + count) if model.jnt_type[k] == mujoco.mjtJoint.mjJNT_HINGE]
    if body == 0 or model.body_parentid[body] != 0 or len(hinges) != 2 or count != 2:
        return None
    base = np.array(data.xanchor[hinges[0]])
    length = float(np.linalg.norm(place - base))
    mass = float(model.body_mass[body])
    along = inertia_about(model, data, body, np.array(data.xipos[body]), (place - base) / length)
    return mass, length, float(np.sqrt(2.0 * along / mass))


def notes_of(model: Any, found: Found) -> list[str]:
    """What of the model does not fit a robot of Saltus."""
    notes = []
    legs = found.legs
    if not legs:
        joints = ", ".join(f"{model.joint(k).name or k}" for k in range(model.njnt))
        notes.append(f"no leg slides (joints: {joints}): Saltus knows legs that slide along their length")
        return notes
    for name, of in (("mass", "mass"), ("stroke", "stroke"), ("damping", "damping"), ("dry friction", "friction"), ("reach", "reach")):
        values = [getattr(leg, of) for leg in legs]
        if any(value is None for value in values):
            notes.append(f"legs without a limit: {name}")
        elif max(values) - min(values) > SAME * max(map_abs(values)):
            notes.append(f"legs differ in {name} ({min(values):.6g} to {max(values):.6g}): those of {legs[0].name} are taken")
    turn = 2.0 * np.pi / len(legs)
    angles = sorted(float(np.arccos(np.clip(legs[0].axis @ leg.axis, -1.0, 1.0))) for leg in legs)
    even = sorted(min(k * turn, 2.0 * np.pi - k * turn) for k in range(len(legs)))
    if not np.allclose(angles, even, atol=1e-3):
        notes.append(f"legs are not spaced evenly: {', '.join(f'{np.degrees(angle):.3g}°' for angle in angles)} from {legs[0].name}")
    if model.dof_armature.any():
        notes.append("armature (reflected inertia of motors) is left out")
    return notes


def map_abs(values: list[float]) -> list[float]:
    """Absolute values."""
    return [abs(value) for value in values]


def text(found: Found) -> str:
    """The robot file."""
    lines = ["# Started by saltus.from_mujoco. Fill in what is marked MEASURE, and check the rest against the robot."]
    lines += [f"# NOTE: {note}." for note in found.notes]
    lines += ["", f'name = "{found.name}"', "", "[body]"]
    lines += [line("mass_kg", found.mass, "with all legs"), line("inertia_kg_m2", found.inertia, "about the axle, legs retracted")]
    lines += [line("wheel_radius_m", found.radius, "foot to axle with the leg retracted")]
    lines += [f"legs = {len(found.legs)}"] if found.legs else [measure("legs", "how many there are")]
    distance, angle = found.imbalance
    if distance > SAME:
        lines += [line("imbalance_m", distance, "centre of mass of the wheel"), line("imbalance_angle_rad", angle)]
    lines += ["", "[leg]", *leg_lines(found)]
    if found.boom is not None:
        mass, length, radius = found.boom
        lines += ["", "[boom]", line("mass_kg", mass), line("length_m", length), line("radius_m", radius)]
    foot = found.legs[0].foot if found.legs else 0.0
    lines += ["", "[foot]", line("radius_m", foot if foot > 1e-4 else 0.0, "of the sphere that touches the ground; 0: a point")]
    lines += ["", "[ground]", measure("static_friction", "of the foot on your ground; left out: it does not slip")]
    lines += [measure("restitution", "of a foot's impact; left out: 0")]
    lines += ["", "[environment]", line("gravity_m_s2", found.gravity), line("ambient_pressure_pa", 101325, "standard")]
    lines += ["", "[errors]"]
    lines += [measure(key, "one standard deviation; left out: 0") for key in ("rate_rad_s", "firing_angle_rad")]
    return "\n".join(lines) + "\n"


def leg_lines(found: Found) -> list[str]:
    """The section of the legs."""
    if not found.legs:
        return [measure(key, "") for key in ("kind", "stroke_mm")]
    leg = found.legs[0]
    drives = leg.stiffness > 0.0 and leg.pull < 0.0
    lines = [f'kind = "{"spring" if drives else "pneumatic"}"{"" if drives else comment("or spring, constant, table: docs/robots.md")}']
    lines += [line("stroke_m", leg.stroke) if leg.stroke is not None else measure("stroke_mm", "the joint has no limit")]
    lines += [line("viscous_friction_n_s_per_m", leg.damping, "the joint's damping")]
    lines += [line("coulomb_friction_n", leg.friction, "the joint's frictionloss")]
    if leg.mass > MASSLESS * found.mass:
        lines += [line("mass_kg", leg.mass, "of the moving part"), line("center_m", leg.center, "from the axle to its centre of mass")]
        if leg.rod is not None:
            lines += [line("rod_length_m", leg.rod[0], "of the cylinder with its moments of inertia"), line("rod_radius_m", leg.rod[1])]
    if drives:
        lines += [line("stiffness_n_per_m", leg.stiffness), line("compression_m", -leg.pull / leg.stiffness)]
    lines += [measure(key, says) for key, says in (SPRING if drives else PNEUMATIC).items()]
    if leg.stiffness > 0.0 and not drives:
        lines += ["", "[leg.return_spring]", line("stiffness_n_per_m", leg.stiffness), line("preload_n", leg.pull)]
    return lines


def line(key: str, value: float, says: str = "") -> str:
    """A key with a number, to twelve digits: what a model says is not better known."""
    return f"{key} = {value:.12g}{comment(says)}"


def measure(key: str, says: str) -> str:
    """A key that has to be measured."""
    return f"# {key} ={comment(f'MEASURE: {says}' if says else 'MEASURE')}"


def comment(says: str) -> str:
    """A remark at the end of a line."""
    return f"  # {says}" if says else ""


def main(words: list[str] | None = None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser(prog="python -m saltus.from_mujoco", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("model", help="MJCF or URDF file")
    parser.add_argument("--wheel", metavar="BODY", help="body that the legs slide in [default: found by its legs]")
    parser.add_argument("--out", metavar="FILE", help="robot file to write [default: the screen]")
    given = parser.parse_args(words)
    try:
        made = convert(given.model, wheel=given.wheel)
        if given.out is None:
            print(made, end="")
        else:
            write(Path(given.out), made)
    except (SaltusError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    count = made.count("# MEASURE")
    print(f"{given.out or 'screen'}: {count} lines are marked MEASURE", file=sys.stderr)
    return 0


def write(path: Path, content: str) -> None:
    """Writes a file whole or not at all."""
    with tempfile.NamedTemporaryFile("w", dir=path.parent, delete=False, encoding="utf-8") as file:
        file.write(content)
    os.chmod(file.name, 0o644)
    os.replace(file.name, path)


if __name__ == "__main__":
    sys.exit(main())
