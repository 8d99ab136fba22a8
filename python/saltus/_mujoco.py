"""What a model of MuJoCo says of a robot: its body, its legs, and the boom that holds it.

Bodies that no joint parts are one group, as one rigid body. Every body with mass is a part of the group
that the legs slide in, of what it carries, or of its boom; any other is refused by its name, so that no
mass is lost.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._saltus import SaltusError

__all__ = ["MASSLESS", "SAME", "Boom", "Found", "Leg", "find"]

Vector = NDArray[np.float64]

SAME = 1e-6
"""Relative difference up to which two legs are the same, share of the model's mass that counts as none, and
length (m) that counts as 0."""
MASSLESS = 1e-5
"""Share of the robot's mass below which a leg has none: simulators need some."""
STANDARD_GRAVITY = 9.80665
"""Gravity (m/s²) where a file says none, as a URDF."""
FLAT = 1e-3
"""Sine of the angle up to which a leg is in the plane of the others."""


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
class Boom:
    """The boom that holds the axle, a cylinder; lengths in m."""

    mass: float
    length: float
    radius: float
    counterweight: tuple[float, float] | None = None
    """Distance behind the base, and mass."""
    bend: tuple[float, float] | None = None
    """Stiffness (N m/rad) and damping (N m s/rad) of its hinge halfway."""


@dataclass
class Found:
    """What the model says."""

    name: str
    mass: float
    inertia: float
    imbalance: tuple[float, float]
    """Distance (m) and angle (rad) of the wheel's centre of mass."""
    legs: list[Leg]
    boom: Boom | None
    radius: float
    gravity: float
    space: tuple[Vector, Vector] | None
    """Of a robot whose legs are not in one plane: moments of inertia (kg m², a matrix) about the place where
    the legs meet, and centre of mass (m) without the legs from there."""
    notes: list[str] = field(default_factory=list)


def find(path: str, wheel: str | None) -> Found:
    """What the model of this file says."""
    spec = read(path)
    notes = []
    model = compiled(spec, path)
    hub = wheel_of(model, path, wheel, sliding(model))
    if model.body_weldid[hub] == 0:
        root = hub
        while model.body_parentid[root] != 0:
            root = int(model.body_parentid[root])
        own(spec, root).add_freejoint()
        model = compiled(spec, path)
        notes.append(f"{label(model, root)} has no joint to the world: it is taken as free, as the root link of a URDF is")
    notes += guessed(spec, model, path)
    return measured(Rig(model, path, hub), notes)


def read(path: str) -> Any:
    """The model of a file, before it is compiled."""
    try:
        mujoco = importlib.import_module("mujoco")
    except ImportError:
        raise SaltusError("saltus.from_mujoco needs MuJoCo: pip install mujoco") from None
    try:
        if Path(path).suffix in (".xml", ".urdf"):
            spec = mujoco.MjSpec.from_file(path)
        else:
            # MuJoCo reads no other name.
            spec = mujoco.MjSpec.from_string(Path(path).read_text(encoding="utf-8"))
            spec.modelfiledir = str(Path(path).parent)
        # Else bodies without a joint lose their names, and those in the world their mass.
        spec.compiler.fusestatic = False
    except AttributeError:
        raise SaltusError(f"saltus.from_mujoco needs MuJoCo 3.3 or later, not {mujoco.__version__}: pip install -U mujoco") from None
    except ValueError as error:
        raise SaltusError(f"{path}: {error}") from None
    return spec


def compiled(spec: Any, path: str) -> Any:
    """The model that MuJoCo makes of it."""
    try:
        return spec.compile()
    except ValueError as error:
        raise SaltusError(f"{path}: {error}") from None


def own(spec: Any, body: int) -> Any:
    """The body of a compiled model before it was compiled."""
    return next(one for one in spec.bodies if one.id == body)


def guessed(spec: Any, model: Any, path: str) -> list[str]:
    """Links of a URDF whose mass MuJoCo guesses."""
    if not is_urdf(path):
        return []
    guesses = [k for k in range(1, model.nbody) if not own(spec, k).explicitinertial and model.body_mass[k] > 0.0]
    if not guesses:
        return []
    return [f"no inertial, so that MuJoCo takes the mass of the collision shapes at 1000 kg/m³: {listed(model, guesses)}"]


def is_urdf(path: str) -> bool:
    """Whether MuJoCo reads the file as URDF, whose root element is `robot`."""
    text = Path(path).read_text(encoding="utf-8", errors="replace")
    return "<robot" in text and "<mujoco" not in text.split("<robot")[0]


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
        # Each leg may have a tube of its own, so that groups are counted, then bodies in the one of most legs.
        carriers = [int(model.body_parentid[model.jnt_bodyid[k]]) for k in slides]
        groups = [int(model.body_weldid[k]) for k in carriers]
        most = max(sorted(set(groups)), key=groups.count)
        carriers = [k for k, group in zip(carriers, groups) if group == most]
        top = max(sorted(set(carriers)), key=carriers.count)
        return top if carriers.count(top) > 1 or most == 0 else most
    roots = [k for k in range(1, model.nbody) if model.body_parentid[k] == 0]
    return max(roots, key=lambda k: float(model.body_subtreemass[k]))


def sliding(model: Any) -> list[int]:
    """The joints of legs: a body slides by each, and nothing moves on that body."""
    mujoco = importlib.import_module("mujoco")
    slides = [k for k in range(model.njnt) if model.jnt_type[k] == mujoco.mjtJoint.mjJNT_SLIDE]
    return [k for k in slides if is_leaf(model, int(model.jnt_bodyid[k]))]


def is_leaf(model: Any, body: int) -> bool:
    """Whether nothing moves on this body, and another body carries it."""
    on_it = [k for k in range(1, model.nbody) if k != body and is_below(model, k, body)]
    return not any(model.body_jntnum[k] for k in on_it) and model.body_parentid[body] != 0 and model.body_jntnum[body] == 1


def is_below(model: Any, body: int, top: int) -> bool:
    """Whether `top` carries `body`, or is it."""
    while body not in (top, 0):
        body = int(model.body_parentid[body])
    return body == top


def label(model: Any, body: int) -> str:
    """A body by its name; else by a joint or its number."""
    if name := model.body(body).name:
        return str(name)
    first = int(model.body_jntadr[body])
    joint = model.joint(first).name if model.body_jntnum[body] else ""
    return f"the body of joint {joint}" if joint else f"body {body}"


def listed(model: Any, bodies: list[int]) -> str:
    """Bodies with their masses."""
    return ", ".join(f"{label(model, k)} ({model.body_mass[k]:.6g} kg)" for k in bodies)


class Rig:
    """A compiled model with the body that its legs slide in, legs retracted."""

    def __init__(self, model: Any, path: str, hub: int) -> None:
        self.mujoco = importlib.import_module("mujoco")
        self.model, self.path = model, path
        self.top = int(model.body_weldid[hub])
        """First body of the wheel's group: it has the group's joints."""
        self.data = self.mujoco.MjData(model)
        self.slides = [k for k in sliding(model) if model.body_weldid[model.body_parentid[model.jnt_bodyid[k]]] == self.top]
        for joint in self.slides:
            if model.jnt_limited[joint]:
                self.data.qpos[model.jnt_qposadr[joint]] = model.jnt_range[joint][0]
        self.mujoco.mj_forward(model, self.data)
        self.place, self.axis = self.axle(hub)

    def bodies(self, *groups: int) -> list[int]:
        """The bodies of rigid groups."""
        return [k for k in range(1, self.model.nbody) if self.model.body_weldid[k] in groups]

    def below(self, top: int) -> list[int]:
        """A body and what it carries."""
        return [k for k in range(1, self.model.nbody) if is_below(self.model, k, top)]

    def joints(self, body: int) -> list[int]:
        """The joints of a body."""
        first = int(self.model.body_jntadr[body])
        return list(range(first, first + int(self.model.body_jntnum[body])))

    def is_hinge(self, joint: int) -> bool:
        """Whether a joint turns about one axis."""
        return bool(self.model.jnt_type[joint] == self.mujoco.mjtJoint.mjJNT_HINGE)

    def mass(self, bodies: list[int]) -> float:
        """Mass of bodies."""
        return float(sum(self.model.body_mass[k] for k in bodies))

    def center(self, bodies: list[int]) -> Vector:
        """Centre of mass of bodies."""
        moment = sum((self.model.body_mass[k] * np.array(self.data.xipos[k]) for k in bodies), np.zeros(3))
        return np.asarray(moment / self.mass(bodies), dtype=np.float64)

    def inertia(self, bodies: list[int], place: Vector) -> Vector:
        """Moments of inertia of bodies about a place: a matrix in the world's axes."""
        total = np.zeros((3, 3))
        for k in bodies:
            turn = self.data.ximat[k].reshape(3, 3)
            off = self.data.xipos[k] - place
            total += turn @ np.diag(self.model.body_inertia[k]) @ turn.T
            total += self.model.body_mass[k] * ((off @ off) * np.eye(3) - np.outer(off, off))
        return total

    def axle(self, hub: int) -> tuple[Vector, Vector]:
        """A point of the axle, and its direction.

        The last hinge of the wheel; else where the legs meet, and across them, or along y.
        """
        hinges = [k for k in self.joints(self.top) if self.is_hinge(k)]
        if hinges:
            return np.array(self.data.xanchor[hinges[-1]]), np.array(self.data.xaxis[hinges[-1]])
        place, axis = np.array(self.data.xpos[hub]), np.array([0.0, 1.0, 0.0])
        if not self.slides:
            return place, axis
        ways = np.array([self.data.xaxis[k] for k in self.slides])
        # Least squares of the distances from the legs' lines. What they leave open stays as it is.
        across = [np.eye(3) - np.outer(way, way) for way in ways]
        off = sum((part @ (self.tip_center(k) - place) for part, k in zip(across, self.slides)), np.zeros(3))
        place = place + np.linalg.pinv(np.sum(across, axis=0), rcond=FLAT) @ off
        _, sizes, rows = np.linalg.svd(ways)
        spread = np.append(sizes, np.zeros(3))[:3] / sizes[0]
        if spread[1] > FLAT:
            axis = rows[2] * (1.0 if rows[2][int(np.argmax(np.abs(rows[2])))] > 0.0 else -1.0)
        elif abs(rows[0] @ axis) > FLAT:
            axis = crosswise(rows[0])
        return place, axis

    def tip(self, joint: int) -> tuple[float, int]:
        """How far the leg of a joint reaches from the world's origin along itself, and by which shape; -1: none."""
        parts, way = self.below(int(self.model.jnt_bodyid[joint])), self.data.xaxis[joint]
        shapes = [geom for geom in range(self.model.ngeom) if self.model.geom_bodyid[geom] in parts]
        return max(((self.reach(geom, np.zeros(3), way), geom) for geom in shapes), default=(0.0, -1))

    def tip_center(self, joint: int) -> Vector:
        """Centre of the shape at the tip of a leg; without shapes the leg's centre of mass."""
        geom = self.tip(joint)[1]
        return np.array(self.data.geom_xpos[geom] if geom >= 0 else self.data.subtree_com[self.model.jnt_bodyid[joint]])

    def reach(self, geom: int, place: Vector, axis: Vector) -> float:
        """How far a geom reaches from a point in a direction."""
        turned = self.data.geom_xmat[geom].reshape(3, 3).T @ axis
        size, kind = self.model.geom_size[geom], self.model.geom_type[geom]
        kinds = self.mujoco.mjtGeom
        middle = float((self.data.geom_xpos[geom] - place) @ axis)
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
            mesh = int(self.model.geom_dataid[geom])
            first, count = int(self.model.mesh_vertadr[mesh]), int(self.model.mesh_vertnum[mesh])
            return middle + float(np.max(self.model.mesh_vert[first : first + count] @ turned))
        return middle + float(size @ np.abs(turned))


def measured(rig: Rig, notes: list[str]) -> Found:
    """What a rig says, and what of it does not fit a robot of Saltus."""
    model = rig.model
    boom, parts = boom_of(rig, notes)
    refuse_others(rig, parts)
    legs = [leg_of(rig, joint) for joint in rig.slides]
    carried = rig.below(rig.top)
    moments = rig.inertia(carried, rig.place)
    found = Found(
        name=Path(rig.path).stem,
        mass=rig.mass(carried),
        inertia=float(rig.axis @ moments @ rig.axis),
        imbalance=imbalance_of(rig, legs),
        legs=legs,
        boom=boom,
        radius=max((leg.reach for leg in legs), default=0.0) or reach_of_wheel(rig),
        gravity=STANDARD_GRAVITY if is_urdf(rig.path) else float(np.linalg.norm(model.opt.gravity)),
        space=(moments, rig.center(rig.bodies(rig.top)) - rig.place) if is_in_space(rig, legs) else None,
    )
    found.notes = [*notes, *merged(rig), *notes_of(model, found)]
    return found


def is_in_space(rig: Rig, legs: list[Leg]) -> bool:
    """Whether legs are not all across the axle."""
    return any(abs(leg.axis @ rig.axis) > FLAT for leg in legs)


def refuse_others(rig: Rig, boom: list[int]) -> None:
    """Refuses bodies with mass that are neither the wheel's group, nor on it, nor its boom."""
    model, own = rig.model, {*rig.below(rig.top), *boom}
    least = SAME * rig.mass(list(range(1, model.nbody)))
    others = [k for k in range(1, model.nbody) if k not in own and model.body_mass[k] > least]
    if not others:
        return
    wheel, several = label(model, rig.top), len(others) > 1
    if all(model.body_weldid[k] == 0 for k in others):
        cause = f"{'they are' if several else 'it is'} fixed to the world"
        cure = "give a joint to what moves (in a URDF a floating joint from a root link without mass), and no mass to what does not"
    elif any(is_below(model, rig.top, k) for k in others):
        joints = ", ".join(str(model.joint(k).name or k) for k in rig.joints(rig.top))
        cause = f"{wheel}, which has the legs, moves on {'them' if several else 'it'} on the joint {joints}"
        cure = "a robot file has one body with its legs, free or on a boom: take the joint out if it does not move, or name another body by --wheel"
    else:
        cause = f"{'they are' if several else 'it is'} neither on {wheel}, which has the legs, nor its boom"
        cure = "take them out of the file, or name another body by --wheel"
    raise SaltusError(f"{rig.path}: no place in a robot file for the mass of {listed(model, others)}: {cause}; {cure}")


def merged(rig: Rig) -> list[str]:
    """Bodies that move on the wheel and are no legs."""
    model = rig.model
    legs = [k for joint in rig.slides for k in rig.below(int(model.jnt_bodyid[joint]))]
    others = [k for k in rig.below(rig.top) if model.body_weldid[k] != rig.top and k not in legs and model.body_mass[k] > 0.0]
    if not others:
        return []
    return [f"counted in the body as if fixed to it, as they move and are no legs that slide: {listed(model, others)}"]


def imbalance_of(rig: Rig, legs: list[Leg]) -> tuple[float, float]:
    """Where the centre of mass of the wheel alone is: off the axle, and forwards from the first leg."""
    wheel = rig.bodies(rig.top)
    if rig.mass(wheel) <= 0.0:
        return 0.0, 0.0
    off = rig.center(wheel) - rig.place
    off -= rig.axis * (off @ rig.axis)
    zero = legs[0].axis if legs else np.array([0.0, 0.0, -1.0])
    distance = float(np.linalg.norm(off))
    # A lean forwards moves what is below the axle backwards.
    return distance, float(np.arctan2(np.cross(off, zero) @ rig.axis, zero @ off)) if distance > SAME else 0.0


def leg_of(rig: Rig, joint: int) -> Leg:
    """The leg of a sliding joint."""
    model, data = rig.model, rig.data
    body = int(model.jnt_bodyid[joint])
    axis = np.array(data.xaxis[joint])
    dof = int(model.jnt_dofadr[joint])
    low, high = model.jnt_range[joint]
    parts = rig.below(body)
    mass, center = rig.mass(parts), np.array(data.subtree_com[body])
    moments = rig.inertia(parts, center)
    along, across = (float(way @ moments @ way) for way in (axis, crosswise(axis)))
    geom = rig.tip(joint)[1]
    round_tip = geom >= 0 and any(model.geom_type[geom] == kind for kind in (rig.mujoco.mjtGeom.mjGEOM_SPHERE, rig.mujoco.mjtGeom.mjGEOM_CAPSULE))
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
        center=float((center - rig.place) @ axis),
        rod=rod_of(mass, along, across),
        reach=rig.reach(geom, rig.place, axis) if geom >= 0 else 0.0,
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


def reach_of_wheel(rig: Rig) -> float:
    """The radius of what is on the wheel, across its axle."""
    side = crosswise(rig.axis)
    ways = [np.cos(angle) * side + np.sin(angle) * np.cross(rig.axis, side) for angle in np.linspace(0, 2 * np.pi, 73)]
    on_it = rig.below(rig.top)
    geoms = [geom for geom in range(rig.model.ngeom) if rig.model.geom_bodyid[geom] in on_it]
    return max((rig.reach(geom, rig.place, way) for geom in geoms for way in ways), default=0.0)


def boom_of(rig: Rig, notes: list[str]) -> tuple[Boom | None, list[int]]:
    """The boom that holds the axle, and its bodies: on two hinges in the world, and perhaps a third halfway.

    Notes what of it is no cylinder with a point mass behind its base.
    """
    groups: list[int] = []
    group = int(rig.model.body_weldid[rig.model.body_parentid[rig.top]])
    while group != 0:
        groups.insert(0, group)
        group = int(rig.model.body_weldid[rig.model.body_parentid[group]])
    joints = [joint for group in groups for joint in rig.joints(group)]
    if len(joints) not in (2, 3) or not all(rig.is_hinge(joint) for joint in joints):
        return None, []
    base = np.array(rig.data.xanchor[joints[1]])
    length = float(np.linalg.norm(rig.place - base))
    inner = int(rig.model.jnt_bodyid[joints[1]])
    outer = int(rig.model.jnt_bodyid[joints[2]]) if len(joints) == 3 else None
    parts = rig.bodies(inner)
    mass = rig.mass(parts)
    if length < SAME or mass <= 0.0 or outer == inner:
        return None, []
    way = (rig.place - base) / length
    moments = rig.inertia(parts, base)
    along, across = (float(axis @ moments @ axis) for axis in (way, crosswise(way)))
    offset = float((rig.center(parts) - base) @ way)
    if outer is None:
        rod = rod_with_point(mass, length, offset, across - 0.5 * along)
        boom = Boom(mass, length, float(np.sqrt(2.0 * along / mass)))
    else:
        beyond = rig.mass(rig.bodies(outer))
        parts += rig.bodies(outer)
        rod = beyond, mass - beyond
        boom = Boom(mass + beyond, length, float(np.sqrt(2.0 * along / mass)))
        joint = joints[2]
        boom.bend = (
            float(np.ravel(rig.model.jnt_stiffness[joint])[0]),
            float(np.ravel(rig.model.dof_damping[rig.model.jnt_dofadr[joint]])[0]),
        )
        span = 0.5 * length
        if rod is not None and abs(rod_moment(rod, span, mass * offset) - (across - 0.5 * along)) > SAME * mass * length**2:
            rod = None
    if rod is None or rod[1] < -SAME * mass:
        notes.append(f"counted as a cylinder of its mass, whose centre and moments of inertia are others: {listed(rig.model, parts)}")
        return boom, parts
    own, point = rod
    boom.radius = float(np.sqrt(2.0 * along / own))
    boom.mass = own if outer is None else 2.0 * own
    reach = length if outer is None else 0.5 * length
    if point > SAME * mass:
        boom.counterweight = (0.5 * own * reach - mass * offset) / point, point
    return boom, parts


def rod_with_point(mass: float, length: float, center: float, moment: float) -> tuple[float, float] | None:
    """Masses of a rod from 0 to `length` and of a point behind 0, with this mass, centre and moment about 0 in all.

    None where no such bodies have them. With the rod's mass b the point's is m − b, its distance l has
    (m − b) l = b L/2 − m c, and (m − b) l² is the moment less b L²/3: a quadratic equation in b, of which
    the greater root is above m.
    """
    near = SAME * length
    if abs(center - 0.5 * length) < near and abs(moment - mass * length**2 / 3.0) < mass * length * near:
        return mass, 0.0
    half = (mass * length**2 / 3.0 + moment - length * mass * center) / 2.0
    square = half**2 - length**2 / 12.0 * (mass * moment - (mass * center) ** 2)
    if square < 0.0:
        return None
    rod = (half - float(np.sqrt(square))) * 12.0 / length**2
    point = mass - rod
    return (rod, point) if rod > 0.0 and point > 0.0 and 0.5 * rod * length > mass * center else None


def rod_moment(parts: tuple[float, float], length: float, moment: float) -> float:
    """Moment of inertia about 0 of a rod and a point behind 0 with these masses, and `moment` = mass times centre of both."""
    rod, point = parts
    lever = 0.5 * rod * length - moment
    return rod * length**2 / 3.0 + (lever**2 / point if point > SAME * rod else 0.0)


def notes_of(model: Any, found: Found) -> list[str]:
    """What of the model does not fit a robot of Saltus."""
    notes = []
    legs = found.legs
    if not legs:
        joints = ", ".join(f"{model.joint(k).name or k}" for k in range(model.njnt))
        notes.append(f"no leg slides (joints: {joints}): Saltus knows legs that slide along their length")
        return notes
    same = {"mass": "mass", "centre of mass": "center", "stroke": "stroke", "damping": "damping", "dry friction": "friction", "reach": "reach"}
    for name, of in same.items():
        values = [getattr(leg, of) for leg in legs]
        if any(value is None for value in values):
            notes.append(f"legs without a limit: {name}")
        elif max(values) - min(values) > SAME * max(abs(value) for value in values):
            notes.append(f"legs differ in {name} ({min(values):.6g} to {max(values):.6g}): those of {legs[0].name} are taken")
    turn = 2.0 * np.pi / len(legs)
    angles = sorted(float(np.arccos(np.clip(legs[0].axis @ leg.axis, -1.0, 1.0))) for leg in legs)
    even = sorted(min(k * turn, 2.0 * np.pi - k * turn) for k in range(len(legs)))
    if found.space is None and not np.allclose(angles, even, atol=1e-3):
        notes.append(f"legs are not spaced evenly: {', '.join(f'{np.degrees(angle):.3g}°' for angle in angles)} from {legs[0].name}")
    if model.dof_armature.any():
        notes.append("armature (reflected inertia of motors) is left out")
    return notes
