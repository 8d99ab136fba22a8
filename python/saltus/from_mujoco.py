"""Starts a robot file from a model of MuJoCo.

    python -m saltus.from_mujoco robot.xml --out robot.toml

Masses, moments of inertia, radius, strokes and losses of the joints come from the model (MJCF, or URDF
as MuJoCo reads it). What a model of MuJoCo does not know, as the valve and the friction of the ground,
stands in the file as `# MEASURE` lines; `saltus` refuses the file until those without a default are
filled in. The file has all mass of the model, or the model is refused: a link with mass that has no place
in a robot file is named. Needs the package `mujoco`, 3.3 or later.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ._mujoco import MASSLESS, SAME, Boom, Found, Vector, find
from ._saltus import SaltusError

__all__ = ["convert", "main"]

PNEUMATIC = {
    "valve_delay_ms": "from the command to the first move of the leg",
    "bore_mm": "of the cylinder",
    "dead_volume_cm3": "of the chamber with the leg retracted, hoses up to the valve included",
    "supply_pressure_gauge_psi": "above ambient",
    "discharge_coefficient": "of the valve: `saltus fit` gets it from benchtop firings",
    "orifice_radius_mm": "of the valve",
    "gas": '"air", "co2" or another of docs/robots.md',
    "gas_temperature_k": "",
}
SPRING = {"release_delay_ms": "from the command to the first move of the leg"}


def convert(model: str | os.PathLike[str], *, wheel: str | None = None) -> str:
    """The robot file of a model of MuJoCo, as text with `# MEASURE` lines.

    `wheel` names the body that the legs slide in; by default it is found by its legs. The file has the
    mass of the whole model; what was merged for that, and what else does not fit, is in its `# NOTE`
    lines. Raises `SaltusError` where the model cannot be read, has no such body, or has a body with mass
    for which a robot file has no place.
    """
    return text(find(os.fspath(model), wheel))


def text(found: Found) -> str:
    """The robot file."""
    lines = ["# Started by saltus.from_mujoco. Fill in what is marked MEASURE, and check the rest against the robot."]
    lines += [f"# NOTE: {note}." for note in found.notes]
    lines += ["", f"name = {json.dumps(found.name)}", "", "[body]"]
    lines += wheel_lines(found) if found.space is None else space_lines(found, *found.space)
    lines += ["", "[leg]", *leg_lines(found)]
    if found.boom is not None:
        lines += ["", "[boom]", *boom_lines(found.boom)]
    foot = found.legs[0].foot if found.legs else 0.0
    lines += ["", "[foot]", line("radius_m", foot if foot > 1e-4 else 0.0, "of the sphere that touches the ground; 0: a point")]
    lines += ["", "[ground]", measure("static_friction", "of the foot on your ground; left out: it does not slip")]
    lines += [measure("restitution", "of a foot's impact; left out: 0")]
    lines += ["", "[environment]", line("gravity_m_s2", found.gravity), line("ambient_pressure_pa", 101325, "standard")]
    lines += ["", "[errors]"]
    lines += [measure(key, "one standard deviation; left out: 0") for key in ("rate_rad_s", "firing_angle_rad")]
    return "\n".join(lines) + "\n"


def wheel_lines(found: Found) -> list[str]:
    """The body of a robot in a plane."""
    lines = [line("mass_kg", found.mass, "with all legs"), line("inertia_kg_m2", found.inertia, "about the axle, legs retracted")]
    lines += [line("wheel_radius_m", found.radius, "foot to axle with the leg retracted")]
    lines += [f"legs = {len(found.legs)}"] if found.legs else [measure("legs", "how many there are")]
    distance, angle = found.imbalance
    if distance > SAME:
        lines += [line("imbalance_m", distance, "centre of mass of the wheel"), line("imbalance_angle_rad", angle)]
    return lines


def space_lines(found: Found, moments: Vector, center: Vector) -> list[str]:
    """The body of a robot in space, and where its legs point."""
    six = [moments[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    lines = ['shape = "sphere"', line("mass_kg", found.mass, "with all legs")]
    lines += [several("inertia_kg_m2", six, "xx, yy, zz, xy, xz, yz about the place where the legs meet, with all legs")]
    lines += [line("wheel_radius_m", found.radius, "from there to a foot with the leg retracted")]
    if float(np.linalg.norm(center)) > SAME:
        lines += [several("center_of_mass_m", center, "of the body without its legs")]
    return [*lines, "", "[legs]", "directions = [", *(f"    {row(leg.axis)}," for leg in found.legs), "]"]


def boom_lines(boom: Boom) -> list[str]:
    """The section of the boom."""
    lines = [line("mass_kg", boom.mass), line("length_m", boom.length), line("radius_m", boom.radius)]
    if boom.bend is not None:
        stiffness, damping = boom.bend
        if stiffness > 0.0:
            lines += [line("bending_stiffness_n_m_per_rad", stiffness), line("bending_damping_time_s", damping / stiffness)]
        else:
            lines += [measure("bending_stiffness_n_m_per_rad", "the joint halfway has none; left out: rigid")]
    if boom.counterweight is not None:
        distance, mass = boom.counterweight
        lines += ["", "[boom.counterweight]", line("distance_m", distance), line("mass_kg", mass)]
    return lines


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


def several(key: str, values: Iterable[float], says: str) -> str:
    """A key with a list of numbers."""
    return f"{key} = {row(values)}{comment(says)}"


def row(values: Iterable[float]) -> str:
    """Numbers as a list of TOML."""
    return f"[{', '.join(f'{value:.12g}' for value in values)}]"


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
        found = find(given.model, given.wheel)
        made = text(found)
        if given.out is None:
            print(made, end="")
        else:
            write(Path(given.out), made)
    except (SaltusError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    for note in found.notes:
        print(f"note: {note}.", file=sys.stderr)
    count = made.count("# MEASURE")
    print(f"{given.out or 'screen'}: {count} lines are marked MEASURE", file=sys.stderr)
    return 0


def write(path: Path, content: str) -> None:
    """Writes a file whole or not at all."""
    if not path.parent.is_dir():
        raise SaltusError(f"{path}: cannot be written: its folder is not there")
    with tempfile.NamedTemporaryFile("w", dir=path.parent, delete=False, encoding="utf-8") as file:
        file.write(content)
    os.chmod(file.name, 0o644)
    os.replace(file.name, path)


if __name__ == "__main__":
    sys.exit(main())
