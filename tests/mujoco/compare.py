#!/usr/bin/env python3
"""The same jumps in Saltus' multi-body simulation and in MuJoCo, and what is between them.

    python3 -m venv target/mujoco && target/mujoco/bin/pip install -r tests/mujoco/requirements.txt
    cargo build && (cd studies && cargo build --bin jumps)
    target/mujoco/bin/python tests/mujoco/compare.py            # or --fast, as .ci/run does

Both sides take the robot from its file: MuJoCo the bodies that `saltus export mjcf` writes and a chamber integrated in
jump.py, Saltus its own simulation (`studies/src/bin/jumps.rs`). The robots are rats-boom, and the same without its boom.
MuJoCo's time step is halved from run to run, and its constraints are as stiff as each step allows; differences are taken to
the last run, and `settled` is what the last halving still changed.

The ground's coefficient of friction is 1 on both sides. Saltus' own, infinite, gives the same jumps, but MuJoCo's cone of friction
is convex: it holds on to a foot that leaves at the speed v_n while it moves along at v_t until v_n > mu v_t. A leg of lean phi that
is picked up at its end stop has v_t/v_n = tan phi, so that with mu above cot phi MuJoCo pulls at a foot that is in the air: at
6 rad/s and a firing angle of 0 (phi = 0.31, cot phi = 3.1), the landing of rats-free is off by 2 mm at mu = 3, 16 mm at 4, 90 mm at 1000.

Where the foot stands, apices must agree to 3 mm and landings to 10 mm; where it slips, differences are only printed. Exit code 1 if
a jump misses, 2 if it cannot be flown.
"""

import argparse
import csv
import io
import pathlib
import re
import subprocess
import sys
import tempfile

from jump import Launch, Robot

ROOT = pathlib.Path(__file__).resolve().parents[2]
APEX, LANDING = 3e-3, 10e-3  # m
SLIP = 1e-3  # m: a foot that moved less stood
STEPS = [4e-4, 2e-4, 1e-4, 5e-5]  # s
FAST = [2e-4, 1e-4]  # s


def launches():
    """Twenty launches, rates 3 to 6 rad/s, firing angles -0.25 to 0.1 rad, every fifth valve open for 40 ms only; and four with
    a valve so short that the force of the leg falls to 0 before the end of the stroke."""
    golden = 0.6180339887498949
    angle = lambda i: round(-0.25 + 0.35 * ((i * golden) % 1.0), 4)
    rate = lambda i: round(3 + 3 * i / 19, 4)
    spread = [Launch(rate(i), -0.3, angle(i), 0.04 if i % 5 == 2 else 0.1) for i in range(20)]
    short = [(5, -0.1, 0.012), (5, -0.1, 0.02), (4, 0.05, 0.01), (4, 0.05, 0.016)]
    return spread + [Launch(rate, -0.3, angle, opening) for rate, angle, opening in short]


def without_boom(text):
    """The robot file `text` without its section [boom]."""
    return re.sub(r"\[boom\]\n(?:(?!\[).*\n)*", "", text).replace("rats-boom", "rats-free")


def with_friction(text, coefficient):
    """The robot file `text` with this coefficient of friction along the travel."""
    return re.sub(r"static_friction = \S+", f"static_friction = {coefficient}", text)


def run(*words):
    """Standard output of a command; ends the program where it fails."""
    try:
        done = subprocess.run(words, capture_output=True, text=True, check=False)
    except OSError as error:
        sys.exit(f"{words[0]}: {error.strerror}: build it first, see --help")
    if done.returncode != 0:
        print(f"{' '.join(words)}: {done.stderr.strip()}", file=sys.stderr)
        sys.exit(2)
    return done.stdout


def saltus_jumps(binaries, file, folder):
    """Saltus' side: a row for each launch."""
    plan = folder / "launches.csv"
    lines = [f"{one.rate},{one.lean},{one.firing_angle},{one.valve_open}" for one in launches()]
    plan.write_text("\n".join(["rate_rad_s,lean_rad,firing_angle_rad,valve_open_s", *lines]) + "\n")
    return list(csv.DictReader(io.StringIO(run(str(binaries / "jumps"), str(file), str(plan)))))


def compare(name, file, binaries, folder, steps, out):
    """Flies all launches of one robot; the number of misses."""
    xml = folder / f"{name}.xml"
    run(str(binaries / "saltus"), "export", "mjcf", "--robot", str(file), "--out", str(xml))
    robot, misses = Robot(file, xml), 0
    print(f"\n{name}: MuJoCo less Saltus, mm; time steps {', '.join(f'{1e6 * s:g}' for s in steps)} us")
    print("  rate  angle valve | Saltus apex  landing ends by | apex  (settled) landing (settled)  slip   sink  stop |")
    for launch, row in zip(launches(), saltus_jumps(binaries, file, folder)):
        runs = [robot.jump(launch, step) for step in steps]
        last, former = runs[-1], runs[-2]
        apex, landing = float(row["apex_m"]), float(row["landing_m"])
        ends = "stroke" if row["at_end_stop"] == "true" else "force"
        differences = last.apex - apex, last.landing - landing
        stands = abs(float(row["slipped_m"])) < SLIP and last.slip < SLIP
        within = abs(differences[0]) <= APEX and abs(differences[1]) <= LANDING
        verdict = ("ok" if within else "MISS") if stands else "slips"
        misses += verdict == "MISS"
        print(
            f"{launch.rate:6.3f} {launch.firing_angle:6.3f} {launch.valve_open:5.3f} |"
            f" {apex:10.4f} {landing:8.4f} {ends:>7} |"
            f" {1e3 * differences[0]:6.3f} ({1e3 * (last.apex - former.apex):6.3f})"
            f" {1e3 * differences[1]:7.3f} ({1e3 * (last.landing - former.landing):6.3f})"
            f" {1e3 * last.slip:6.3f} {1e3 * last.sink:6.3f} {1e3 * last.overshoot:6.3f} |"
            f" {verdict}",
            flush=True,
        )
        for step, one in zip(steps, runs):
            out.writerow(
                [name, launch.rate, launch.firing_angle, launch.valve_open, step, ends]
                + [apex, landing, one.apex, one.landing, float(row["lift_off_s"]), one.lift_off]
                + [float(row["lift_off_extension_m"]), one.extension, float(row["fire_s"]), one.fire]
                + [one.slip, one.sink, one.overshoot]
            )
    return misses


COLUMNS = (
    "robot,rate_rad_s,firing_angle_rad,valve_open_s,step_s,ends,saltus_apex_m,saltus_landing_m,mujoco_apex_m,mujoco_landing_m,"
    "saltus_lift_off_s,mujoco_lift_off_s,saltus_extension_m,mujoco_extension_m,saltus_fire_s,mujoco_fire_s,slip_m,sink_m,overshoot_m"
)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fast", action="store_true", help="two coarse time steps instead of four")
    parser.add_argument("--binaries", type=pathlib.Path, default=ROOT / "target/debug", help="where saltus and jumps are")
    parser.add_argument("--friction", default="1", help="coefficient along the travel; inf is 2 in MuJoCo")
    parser.add_argument("--csv", type=pathlib.Path, help="write every run to this file")
    options = parser.parse_args()
    steps, table = (FAST if options.fast else STEPS), io.StringIO()
    out = csv.writer(table, lineterminator="\n")
    out.writerow(COLUMNS.split(","))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        text = with_friction((ROOT / "robots/rats-boom.toml").read_text(), options.friction)
        boom, free = folder / "rats-boom.toml", folder / "rats-free.toml"
        boom.write_text(text)
        free.write_text(without_boom(text))
        misses = sum(
            compare(robot, file, options.binaries, folder, steps, out) for robot, file in (("rats-free", free), ("rats-boom", boom))
        )
    if options.csv:
        options.csv.write_text(table.getvalue())
    print(f"\n{misses} jumps miss")
    sys.exit(1 if misses else 0)


if __name__ == "__main__":
    main()
