#!/usr/bin/env python3
"""Jumps of MuJoCo as measured data: one effect hidden in each set, and what `saltus diagnose` says of it.

    python3 -m venv target/mujoco && target/mujoco/bin/pip install -r tests/mujoco/requirements.txt
    cargo build --release -p saltus-cli
    target/mujoco/bin/python tests/mujoco/diagnose.py            # or the names of some sets
    target/mujoco/bin/python tests/mujoco/diagnose.py --rough none-{1..40} mass-{1..3}

The robot is rats-boom with its file changed; MuJoCo has the bodies that `saltus export mjcf` writes and the chamber of jump.py, in
steps of 25 us. A set has twelve jumps that are logged at 1 kHz by encoders with counts of 7.854 and 3.927 mrad and a gyro with a
noise of 0.03 rad/s. The operator believes in rats-boom, whose foot cannot slip; MuJoCo's coefficient of friction is 1. A set is right if its effect
is the one cause that is named, alone or with two rivals at most. Exit code 1 if one is not. A number after a name gives other
jumps.

Sets with --rough come from a coarser simulation: friction of 0.005 across the travel, steps of 40 us, and of 0.2 ms in flight. What
that leaves after the fit is 0.23 standard deviations of a reading, root mean square (with a friction of 0.02, 0.41): the
simulator's error, and no effect.
"""

import argparse
import json
import math
import multiprocessing
import pathlib
import random
import subprocess
import sys
import tempfile
import tomllib

import mujoco

from jump import PSI, Launch, Robot

ROOT = pathlib.Path(__file__).resolve().parents[2]
STEP, ROUGH, ALOFT, TICK = 2.5e-5, 4e-5, 2e-4, 1e-3  # s
ACROSS = 0.005  # coefficient of friction of a rough set
WHEEL, BOOM, GYRO = 7.854e-3, 3.927e-3, 0.03  # rad, rad, rad/s
COLUMNS = "wheel_angle_rad", "pivot_angle_rad", "radius_angle_rad", "wheel_rate_rad_s"

# Name: what is to be said, and what is changed: keys of the robot file, a sensor, or a joint of MuJoCo's model.
SETS = {
    "none": ("none", {}),
    "supply-pressure": ("supply-pressure", {"leg.supply_less_psi": 4.0}),
    "valve-delay": ("valve-delay", {"leg.valve_delay_ms": 13.0}),
    "valve-discharge": ("valve-discharge", {"leg.discharge_coefficient": 0.52}),
    "chamber-leak": ("chamber-leak", {"leg.leak_area_m2": 4e-7}),
    "dead-volume": ("dead-volume", {"leg.dead_volume_m3": 7e-6}),
    "viscous-friction": ("viscous-friction", {"leg.viscous_friction_n_s_per_m": 12.0}),
    "coulomb-friction": ("coulomb-friction", {"leg.coulomb_friction_n": 16.0}),
    "return-spring": ("return-spring", {"leg.return_spring": {"stiffness_n_per_m": 200.0, "preload_n": 0.0}}),
    "gas-type": ("gas-type", {"leg.gas": "co2"}),
    "heat-transfer": ("heat-transfer", {"leg.polytropic_exponent": 1.15}),
    "mass": ("mass", {"body.mass_kg": 2.9}),
    "inertia": ("inertia", {"body.inertia_kg_m2": 0.085}),
    "imbalance": ("imbalance", {"body.imbalance_mm": 5.0, "body.imbalance_angle_deg": 60.0}),
    "boom-inertia": ("boom-inertia", {"boom.mass_kg": 0.75}),
    "axle-friction": ("axle-friction", {"body.axle_friction_n_m": 0.12}),
    "foot-slip": ("foot-slip", {"ground.static_friction": 0.35, "ground.kinetic_friction": 0.35}),
    "foot-rolling": ("foot-rolling", {"foot.radius_m": 0.012}),
    "ground-slope": ("ground-slope", {"ground.tilt_deg": 1.5}),
    "boom-flex": ("boom-flex", {"boom.bending_stiffness_n_m_per_rad": 700.0, "boom.bending_damping_time_ms": 1.0}),
    "gravity": ("gravity", {"environment.gravity_m_s2": 9.5}),
    "counterweight": ("counterweight", {"boom.counterweight": {"mass_kg": 0.5, "distance_m": 0.6}}),
    "encoder-scale": ("encoder-scale", {"sensor": ("pivot_angle_rad", lambda x, old: 1.08 * x)}),
    "sensor-offset": ("sensor-offset", {"sensor": ("wheel_angle_rad", lambda x, old: x + 0.03)}),
    "sensor-delay": ("sensor-delay", {"sensor": ("radius_angle_rad", lambda x, old: old(0.012))}),
    "axle-damping": ("unknown", {"damping": ("wheel", 0.02)}),
    "pivot-damping": ("unknown", {"damping": ("boom", 6.0)}),
    "pivot-spring": ("unknown", {"stiffness": ("boom", 40.0)}),
}


def dump(tables):
    """A robot file."""
    value = lambda x: json.dumps(x) if isinstance(x, str) else "inf" if x == math.inf else repr(x).lower() if isinstance(x, bool) else repr(x)
    inline = lambda x: "{ " + ", ".join(f"{k} = {value(v)}" for k, v in x.items()) + " }" if isinstance(x, dict) else value(x)
    top = "".join(f"{k} = {value(v)}\n" for k, v in tables.items() if not isinstance(v, dict))
    return top + "".join(
        f"\n[{name}]\n" + "".join(f"{k} = {inline(v)}\n" for k, v in table.items()) for name, table in tables.items() if isinstance(table, dict)
    )


def firings(rng):
    """Twelve launches with the supply (psi) of each."""
    launch = lambda: Launch(rng.uniform(3, 6), rng.uniform(-0.45, -0.2), rng.uniform(-0.1, 0.2), round(rng.uniform(0.04, 0.1), 3))
    return [(launch(), rng.choice([100, 110, 120])) for _ in range(12)]


def base(name):
    """The name of a set without its number."""
    stem, _, number = name.rpartition("-")
    return stem if number.isdigit() else name


def flown(robot, launch, rough):
    """Rows of a jump; none if it is not one."""
    result = robot.jump(launch, ROUGH, tick=TICK, aloft=ALOFT) if rough else robot.jump(launch, STEP, tick=TICK)
    return result.rows if math.isfinite(result.landing) and result.extension > 0.02 else None


def sensed(rows, column, law):
    """What the sensors say of exact `rows`."""
    out = []
    for row in rows:
        values = list(row[2:])
        if column is not None:
            def old(delay, now=row[0]):
                at = max(now - delay, 0.0) / TICK
                k = min(int(at), len(rows) - 2)
                a, b = rows[k][2 + column], rows[k + 1][2 + column]
                return a + (at - k) * (b - a)
            values[column] = law(values[column], old)
        out.append((row[0], row[1], values))
    return out


def make(name, binary, folder, rough):
    """The folder of a set."""
    _, changes = SETS[base(name)]
    rng = random.Random(name)
    file = tomllib.loads((ROOT / "robots/rats-boom.toml").read_text())
    file["ground"]["static_friction"] = file["ground"]["kinetic_friction"] = 1.0
    if rough:
        file["ground"]["across_friction"] = ACROSS
    keys = {key: value for key, value in changes.items() if "." in key}
    less = keys.pop("leg.supply_less_psi", 0.0)
    for key, value in keys.items():
        section, last = key.split(".")
        file.setdefault(section, {})[last] = value
    changed, xml = folder / f"{name}.toml", folder / f"{name}.xml"
    changed.write_text(dump(file))
    subprocess.run([binary, "export", "mjcf", "--robot", changed, "--out", xml], check=True, stdout=subprocess.DEVNULL)
    robot = Robot(changed, xml)
    for what in ("damping", "stiffness"):
        if what in changes:
            joint, value = changes[what]
            index = mujoco.mj_name2id(robot.model, mujoco.mjtObj.mjOBJ_JOINT, joint)
            if what == "damping":
                robot.model.dof_damping[robot.model.jnt_dofadr[index]] = value
            else:
                robot.model.jnt_stiffness[index] = value
    column, law = changes.get("sensor", (None, None))
    column = COLUMNS.index(column) if column else None
    where = folder / name
    where.mkdir()
    text = ['kind = "jump"', 'robot = "rats-boom"', "[noise]", f"wheel_rate_rad_s = {GYRO}", "[resolution]"]
    text += [f"{c} = {count}" for c, count in zip(COLUMNS, (WHEEL, BOOM, BOOM))]
    runs = 0
    for launch, supply in firings(rng):
        robot.chamber.supply = robot.chamber.ambient + PSI * (supply - less)
        rows = flown(robot, launch, rough)
        if rows is None:
            continue
        runs += 1
        lines = [",".join(("time_s", "valve", *COLUMNS))]
        for time, valve, values in sensed(rows, column, law):
            read = [round(x / count) * count for x, count in zip(values, (WHEEL, BOOM, BOOM))]
            lines.append(f"{time:.3f},{valve}," + ",".join(f"{x:.6f}" for x in [*read, values[3] + rng.gauss(0, GYRO)]))
        (where / f"run-{runs:02}.csv").write_text("\n".join(lines) + "\n")
        text += ["[[run]]", f'file = "run-{runs:02}.csv"', f"supply_pressure_gauge_pa = {PSI * supply}"]
    (where / "experiment.toml").write_text("\n".join(text) + "\n")
    return where


def judged(name, binary, folder, rough):
    """Whether a set is right, and a line about it."""
    truth, _ = SETS[base(name)]
    where = make(name, binary, folder, rough)
    done = subprocess.run([binary, "diagnose", where, "--format", "json"], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        return False, done.stderr.strip()
    causes = json.loads(done.stdout)["causes"]
    sets = [[cause["id"], *cause["rivals"]] for cause in causes]
    said = "; ".join(
        " or ".join([cause["id"] + (f" of {cause['column']}" if "column" in cause else ""), *cause["rivals"]])
        + "".join(f", {k} {v:.5g} ± {cause['standard_errors'][k] or math.nan:.2g}" for k, v in cause["parameters"].items())
        for cause in causes
    )
    right = not sets if truth == "none" else ["unknown"] in sets if truth == "unknown" else len(sets) == 1 and truth in sets[0]
    return right, said or "nothing"


def one(task):
    name, binary, folder, rough = task
    return name, *judged(name, binary, pathlib.Path(folder), rough)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sets", nargs="*", help=f"some of: {', '.join(SETS)}")
    parser.add_argument("--binary", default=str(ROOT / "target/release/saltus"), help="the command saltus")
    parser.add_argument("--rough", action="store_true", help="coarser simulation, with an error that is no effect")
    parser.add_argument("--keep", type=pathlib.Path, help="keep the folders here")
    options = parser.parse_args()
    names = options.sets or [name for name in SETS if name != "none"] + ["none-1", "none-2", "none-3"]
    for name in names:
        if base(name) not in SETS:
            parser.error(f"{name} is none of the sets: {', '.join(SETS)}")
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or temporary
        pathlib.Path(folder).mkdir(parents=True, exist_ok=True)
        wrong = 0
        with multiprocessing.Pool(2) as pool:
            for name, right, said in pool.imap(one, [(name, options.binary, str(folder), options.rough) for name in names]):
                wrong += not right
                print(f"{'ok   ' if right else 'WRONG'} {name}: {said}", flush=True)
    print(f"{len(names) - wrong} of {len(names)} right")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
