#!/usr/bin/env python3
"""The robot that `saltus export urdf` writes, against the one of `saltus export mjcf`, both read by MuJoCo.

    target/mujoco/bin/python tests/mujoco/urdf.py --binaries target/debug

Total mass, mass matrix (all inertias, at once) and the place and axes of every body must be the same in three poses of each
robot. What URDF adds, links without mass, has 1e-9 kg each, so that equal means to 1e-8 of the greatest entry. Exit code 1 where
something differs.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

import mujoco
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
ROBOTS = [
    ["rats-planar"],
    ["rats-boom"],
    ["rats-run"],
    ["spring-hopper"],
    ["table-hopper"],
    ["rats-boom", "--set", "boom.bending_stiffness_n_m_per_rad=2000"],
    ["rats-boom", "--set", "body.imbalance_mm=2", "--set", "body.imbalance_angle_deg=30"],
]
NEAR = 1e-8


def model(binary, kind, robot, folder):
    """The model that a robot's file of this kind gives."""
    file = folder / f"robot.{kind}"
    subprocess.run([binary, "export", kind, "--robot", *robot, "--out", file], check=True, stdout=subprocess.DEVNULL)
    return mujoco.MjModel.from_xml_path(str(file))


def motion(one, q):
    """Mass matrix, and place and axes of each body by its name, at coordinates q."""
    data = mujoco.MjData(one)
    data.qpos[:] = q
    mujoco.mj_forward(one, data)
    full = np.zeros((one.nv, one.nv))
    mujoco.mj_fullM(one, full, data.qM) if hasattr(data, "qM") else mujoco.mj_fullM(one, data, full)
    names = [one.body(k).name for k in range(1, one.nbody)]
    return full, {name: np.append(data.body(name).xpos, data.body(name).xmat) for name in names}


def joints(one):
    return [one.joint(k).name for k in range(one.njnt)]


def compare(binary, robot, folder):
    """The greatest difference, as a share of the greatest entry."""
    theirs, ours = (model(binary, kind, robot, folder) for kind in ("mjcf", "urdf"))
    assert joints(theirs) == joints(ours), (joints(theirs), joints(ours))
    worst = abs(theirs.body_mass.sum() - ours.body_mass.sum()) / theirs.body_mass.sum()
    draw = np.random.default_rng(1)
    for _ in range(3):
        q = draw.uniform(-1, 1, ours.nq)
        # Legs are out by a part of their stroke.
        q[-theirs.nu :] = draw.uniform(0, 0.05, theirs.nu)
        (m, places), (n, others) = motion(theirs, q), motion(ours, q)
        worst = max(worst, abs(m - n).max() / abs(m).max())
        worst = max(worst, *(abs(place - others[name]).max() for name, place in places.items()))
    return worst


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--binaries", type=pathlib.Path, default=ROOT / "target/debug")
    binary = words.parse_args().binaries / "saltus"
    misses = 0
    with tempfile.TemporaryDirectory() as folder:
        for robot in ROBOTS:
            worst = compare(binary, robot, pathlib.Path(folder))
            misses += worst > NEAR
            print(f"{' '.join(robot):60} differs by {worst:.1e} {'ok' if worst <= NEAR else 'MISS'}")
    return int(misses > 0)


if __name__ == "__main__":
    sys.exit(main())
