#!/usr/bin/env python3
"""The thesis' robot running in MuJoCo: five pneumatic legs that are fired in turn.

    python3 -m venv target/mujoco && target/mujoco/bin/pip install -r tests/mujoco/requirements.txt
    cargo build --release -p saltus-cli
    target/mujoco/bin/python tests/mujoco/run.py check            # or speeds, ensemble, touch_downs, ball, ball_speed, policy, bench

The bodies come from `saltus export mjcf`, the numbers of the legs from the robot's file; nothing else is Saltus'. All legs are free
sliders with end stops at 0 and the stroke, dry and viscous friction, a return spring, and a chamber each. The chambers are
integrated in loop.c next to mj_step, in steps of 50 us at most; a C compiler (cc) builds it at each start. Contacts and end stops
have the damping ratio 3, so that nothing rebounds, and a time constant of two steps. Friction is along and across the travel of
each foot around the boom's base (MuJoCo's own frame stands still); the cone is MuJoCo's ellipse over the two.

The controller runs at 1 kHz. The lean of leg k is phi - 2 pi k/n. The leg whose lean lies in the active zone [z0, z0 + 2 pi/n) fires
once an entry, as soon as its lean is at least alpha_f; an entry begins when the leg in the zone changes. Firing opens the valve for
t_v, and the delay of the robot's file comes before opening and closing. phi comes from the wheel's encoder (nearest of 800 counts a
turn), omega from the gyro (noise 0.1 rad/s, mean of the last five samples).

With alpha_f = 0.1 rad there are two ways of running: high bounces at 1.8 m/s, where legs fire in the air, and a fast one at 3.4 m/s
(spring) or 4.6 m/s (friction alone). Step, impedance (--soft) and restitution (--ratio) decide into which one a start falls. A comparison of
single runs says nothing therefore; touch_downs compares from one state to the next touch-down.

Robot files have the keys and units of robots/rats-boom.toml (leg.bore_mm, not leg.bore_in).
"""

import argparse
import copy
import csv
import ctypes
import dataclasses
import json
import math
import multiprocessing
import pathlib
import random
import statistics
import subprocess
import sys
import tempfile
import tomllib

import mujoco
import numpy as np

import ball as in_space
import running
from policy import compare
from running import GAITS, RATIO, ROOT, SALTUS, STEP, TICK, WINDOW, Controller, Gas, Leg, Runner
from running import drawn, export, rats_run, run, spring
from touchdown import COORDINATES, STATES, answer_columns, touch_down

RUNS = 1.5  # m/s: a robot with this mean speed over the last LAST runs
LAST = 4.0  # s
FAST_ENOUGH = 3.2  # m/s: the thesis' top speed


def pooled(task, tasks, jobs):
    """The results of `task`, in order."""
    if jobs == 1:
        return [task(one) for one in tasks]
    with multiprocessing.get_context("fork").Pool(jobs) as pool:
        return pool.map(task, tasks, chunksize=1)


SPEEDS = {"friction 9.7 N": (9.7, spring(0, 0)), "friction 1 N, spring 7 N + 60 N/m": (1.0, spring(60, 7.0))}


def speed_run(task):
    binary, friction, back, begin, seconds, step, ratio, soft = task
    robot = Runner(binary, rats_run(leg__coulomb_friction_n=friction, leg__return_spring=back), step, ratio, soft)
    return run(robot, dataclasses.replace(GAITS["pushed"], pushed=begin), seconds, random.Random(0))


def speeds(options):
    """Mean speed of alpha_f = 0.1 rad, t_v = 40 ms after a push; several runs, whose pushes begin 10 ms apart."""
    runs = 3 if options.fast else options.runs
    seconds = 6.0 if options.fast else 10.5
    print("pushed at 0.5 s, 0.51 s, ...; of those that run (m/s): mean over the whole run after 0.5 s, over its last 4 s")
    for name, (friction, back) in SPEEDS.items():
        numerics = options.step, options.ratio, options.soft
        tasks = [(options.binary, friction, back, round(0.5 + 0.01 * k, 2), seconds, *numerics) for k in range(runs)]
        done = pooled(speed_run, tasks, options.jobs)
        going = [one for one in done if one.speed(one.end() - LAST, one.end()) > RUNS]
        if not going:
            print(f"{name}: none of {runs} runs")
            continue
        whole = [one.speed(0.5, one.end()) for one in going]
        last = [one.speed(one.end() - LAST, one.end()) for one in going]
        gas = statistics.median(1e3 * one.gas / one.travel[-1] for one in going)
        print(
            f"{name}: {len(going)} of {runs} run; {statistics.mean(whole):.2f} [{min(whole):.2f} {max(whole):.2f}],"
            f" {statistics.mean(last):.2f} [{min(last):.2f} {max(last):.2f}]; gas {gas:.3f} g/m",
            flush=True,
        )
    return 0


def wilson(k, n, z=1.96):
    """95 % interval of a share, in percent."""
    centre, half = (k + z * z / 2) / (n + z * z), z * math.sqrt(k * (n - k) / n + z * z / 4) / (n + z * z)
    return max(0.0, 100 * (centre - half)), min(100.0, 100 * (centre + half))


def ours(binary, file, gait, seconds):
    """Saltus' run of a robot file: mean speed (m/s) over the last LAST, and when 3.2 m/s were reached (s)."""
    words = [binary, "run", *SALTUS[gait], "--robot", file, "--seconds", str(seconds), "--format", "json"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):  # 1: it stalled
        sys.exit(f"saltus run: {done.stderr.strip()}")
    answer = json.loads(done.stdout)
    reached = answer["reached_3_2_m_s_s"]
    return answer["mean_speed_last_4_s_m_s"], math.inf if reached is None else reached


def ensemble_run(task):
    """One robot with all gaits: for each, speed at the end and when 3.2 m/s were reached, in MuJoCo and in Saltus."""
    options, index, gaits, seconds = task
    tables, rows = drawn(options.seed, index, options.across), {}
    robot = Runner(options.binary, tables, options.step, options.ratio, options.soft)
    with tempfile.TemporaryDirectory() as folder:
        file, _ = export(options.binary, tables, folder)
        for name in gaits:
            one = run(robot, GAITS[name], seconds, random.Random(f"gyro {options.seed} {index} {name}"))
            theirs = one.speed(seconds - LAST, seconds), one.reached(FAST_ENOUGH)
            rows[name] = theirs, ours(options.binary, file, name, seconds)
    return rows


def ensemble(options):
    """Which of the same drawn robots run, in MuJoCo and in Saltus, for each gait."""
    robots, seconds = (6 if options.fast else options.robots), (6.0 if options.fast else 9.0)
    gaits = options.gaits or (["pushed", "two-lines"] if options.fast else list(GAITS))
    done = pooled(ensemble_run, [(options, k, gaits, seconds) for k in range(robots)], options.jobs)
    if options.csv:
        with open(options.csv, "w", newline="") as handle:
            out = csv.writer(handle, lineterminator="\n")
            out.writerow("seed,robot,gait,simulation,speed_at_end_m_s,reached_3_2_m_s_s".split(","))
            rows = ((k, name, *both) for k, one in enumerate(done) for name in gaits for both in zip(("MuJoCo", "Saltus"), one[name]))
            out.writerows([options.seed, k, name, simulation, *values] for k, name, simulation, values in rows)
    numerics = f"step {1e6 * options.step:g} us, damping ratio {options.ratio:g}{', soft' * options.soft}"
    print(f"{robots} robots, seed {options.seed}, {seconds:g} s, friction across {options.across:g}, MuJoCo with {numerics}")
    print(f"{'gait':15} {'simulation':10} {'run':>5} {'95 % interval':>14} | speed of runners, m/s | within 3 s at 3.2 m/s | same answer")
    for name in gaits:
        sides = [list(zip(*side)) for side in zip(*[one[name] for one in done])]
        same = sum((theirs > RUNS) == (ours > RUNS) for theirs, ours in zip(sides[0][0], sides[1][0]))
        for simulation, (end, reached) in zip(("MuJoCo", "Saltus"), sides):
            runners = [v for v in end if v > RUNS]
            low, high = wilson(len(runners), robots)
            spread = f"{statistics.median(runners):.2f} ({min(runners):.2f}, {max(runners):.2f})" if runners else "-"
            soon = f"{100 * sum(t <= 3 for t in reached) / robots:.0f} %"
            share = f"{name:15} {simulation:10} {100 * len(runners) / robots:4.0f}% {low:6.0f} to {high:3.0f}%"
            print(f"{share} | {spread:21} | {soon:>21} | {same} of {robots}", flush=True)
    return 0


def touch_downs(options):
    """From each state of STATES.csv to the next touch-down."""
    tables = tomllib.loads(options.robot.read_text()) if options.robot else rats_run()
    robot = Runner(options.binary, tables, options.step, options.ratio, options.soft)
    handle = open(options.out, "w", newline="") if options.out else sys.stdout
    with open(options.states, newline="") as source, handle:
        out = csv.DictWriter(handle, answer_columns(robot.count), lineterminator="\n")
        out.writeheader()
        for number_, row in enumerate(csv.DictReader(source)):
            if options.fast and number_ == 5:
                break
            answer = {"row": number_, **touch_down(robot, row)}
            out.writerow({k: f"{v:.9g}" if isinstance(v, float) else v for k, v in answer.items()})
    return 0


def against(options):
    """Whether the touch-downs of ANSWER.csv are those of Saltus' own simulation in OURS.csv.

    OURS.csv and the states are written by `cd studies && cargo run --release --bin touch_downs`. The same leg, the axle's speed
    to 1 % and the lean to 0.01 rad in 90 % of the states; the rest are listed with the switches of contact on their way.
    """
    with open(options.ours, newline="") as ours, open(options.answer, newline="") as answer:
        pairs = list(zip(csv.DictReader(ours), csv.DictReader(answer)))
    off = lambda ours, theirs, name: abs(float(ours[name]) - float(theirs[name]))
    agree = lambda ours, theirs: (
        ours["leg"] == theirs["leg"]
        and off(ours, theirs, "travel_speed_m_s") <= 0.01 * abs(float(theirs["travel_speed_m_s"]))
        and off(ours, theirs, "phi") <= 0.01
    )
    others = [(ours, theirs) for ours, theirs in pairs if not (theirs["leg"] and agree(ours, theirs))]
    print(f"{len(pairs) - len(others)} of {len(pairs)} touch-downs agree to 1 % in speed and 0.01 rad in lean")
    for ours, theirs in others:
        print(f"row {theirs['row']}: leg {ours['leg']} and {theirs['leg']}; {theirs['switches'] or 'no switch of contact'}")
    unnamed = sum(not theirs["switches"] for _, theirs in others)
    return int(len(others) > 0.1 * len(pairs) or unnamed > 0)


def policy(options):
    """Time to 1.6 m of what `saltus learn` learnt, here and in Saltus; exit code 1 where the medians are more than 10 % apart."""
    return compare(options)


def states(options):
    """Writes the states of a running robot (a drawn phase of each of several runs), to try touch_downs with."""
    rng, robot = random.Random(options.seed), Runner(options.binary, rats_run(), options.step)
    names = COORDINATES + [f"d{k}" for k in range(robot.count)]
    legs = range(robot.count)
    columns = names + [f"{name}_rate" for name in names] + [f"p{k}" for k in legs]
    columns += [f"open_{what}{k}" for k in legs for what in ("from", "until")]
    out = csv.writer(sys.stdout, lineterminator="\n")
    out.writerow(columns)
    for _ in range(options.count):
        robot.rest()
        control = Controller(GAITS["two-lines"], robot, rng)
        for _ in range(rng.randrange(100, 3000)):
            control.tick()
            robot.advance(round(TICK / robot.step))
        d, now, places = robot.data, robot.data.time, [*range(3), *robot.slides]
        ahead = [[pair for pair in robot.coming[k] if pair[1] > now] for k in legs]
        openings = [x for pairs in ahead for x in ([t - now for t in pairs[0]] if pairs else ["", ""])]
        out.writerow([*d.qpos[places], *d.qvel[places], *[leg.pressure for leg in robot.legs], *openings])
    return 0


def bench(options):
    """Time for a step of MuJoCo with the chambers, all in C, in one thread.

    The robot starts with the fixed gait and a push. It is the exported model with implicitfast steps, the elliptic cone, MuJoCo's
    default tolerance, free legs and no sensors; times are processor time, the best of three runs. The mean speed shows what a coarse
    step does to the run.
    """
    seconds = 5.0 if options.fast else 60.0
    with tempfile.TemporaryDirectory() as folder:
        program = running.build(folder, bench=True)
        tables = rats_run()
        robot = Runner(options.binary, tables)
        robot.rest()
        _, xml = export(options.binary, tables, folder)
        print("step us, of gas | us a step: all, of which gas | us for 1 ms | mean speed m/s | contacts")
        for step, substep in ((1e-3, 1e-3), (1e-3, 5e-4), (1e-3, 2.5e-4), (5e-4, 2.5e-4), (2.5e-4, 1.25e-4), (1e-4, 5e-5)):
            gas = copy.copy(robot.gas)
            gas.substep = substep
            start = robot.data.qpos[1], robot.data.qpos[robot.lean]
            words = [step, seconds, options.tolerance, robot.delay, *start, *(getattr(gas, name) for name in Gas.names)]
            best = None
            for _ in range(1 if options.fast else 3):
                done = subprocess.run([program, xml, *map(repr, map(float, words))], capture_output=True, text=True, check=True)
                values = [float(word) for word in done.stdout.split()]
                best = values if best is None or values[0] < best[0] else best
            whole, gas_part, turn, contacts = best
            print(
                f"{1e6 * step:7.0f} {1e6 * substep:7.0f} | {1e6 * whole:7.2f} {1e6 * gas_part:7.2f} | {1e3 / step * whole:8.1f} |"
                f" {robot.boom * turn:6.2f} | {contacts:.2f}",
                flush=True,
            )
    return 0


def check_gas(options):
    """loop.c's chamber against jump.py's."""
    tables = rats_run()
    robot, worst, rng = Runner(options.binary, tables), 0.0, random.Random(1)
    for _ in range(200):
        p, d, v = rng.uniform(1e5, 9e5), rng.uniform(0, 0.05), rng.uniform(-1, 3)
        leg = Leg(p, 2e-4, 7e-4, 0.0)
        running.LOOP.gas(ctypes.byref(robot.gas), ctypes.byref(leg), 0.0, 1e-3, d, v)
        at = lambda t: d + v * t
        for begin, end, on in ((0, 2e-4, False), (2e-4, 7e-4, True), (7e-4, 1e-3, False)):
            p = robot.chamber.advance(p, begin, end, at(begin), v, on)
        worst = max(worst, abs(leg.pressure / p - 1))
    return "chamber of loop.c against that of jump.py: greatest relative difference", worst, worst < 1e-9


def check_rolling(options):
    """Unfired five-leg wheel down a slope of 0.25 rad: limit cycle and multiplier in closed form (McGeer 1990, rimless wheel)."""
    tables = rats_run()
    del tables["boom"]
    tables["foot"] = {"radius_mm": 0}
    tables["ground"] = {}
    robot, slope = Runner(options.binary, tables, options.step, options.ratio), 0.25
    robot.model.eq_active0[:] = 1  # legs held
    g = robot.file["environment"]["gravity_m_s2"]
    robot.model.opt.gravity[:] = g * math.sin(slope), 0, -g * math.cos(slope)
    mass, inertia, r = robot.file["body"]["mass_kg"], robot.file["body"]["inertia_kg_m2"], robot.radius
    about = inertia + mass * r * r
    eta = (inertia + mass * r * r * math.cos(2 * math.pi / 5)) / about
    gain = 4 * mass * g * r * math.sin(math.pi / 5) * math.sin(slope)  # 2 dE
    cycle = math.sqrt(gain / about / (1 - eta * eta))
    rates = impacts(robot, 3.0, 14)
    squares = np.array(rates) ** 2
    # omega^2 before impacts goes to its limit by the factor eta^2 each time.
    factors = (squares[1:4] - squares[-1]) / (squares[0:3] - squares[-1])
    off, multiplier = rates[-1] - cycle, statistics.mean(factors)
    right = abs(off) < 0.01 and abs(multiplier - eta * eta) < 0.01
    return (
        f"rolling: rate before impact {rates[-1]:.4f} (closed form {cycle:.4f}) rad/s,"
        f" multiplier {multiplier:.4f} (closed form {eta * eta:.4f}); off",
        off,
        right,
    )


def impacts(robot, rate, count):
    """Rates before the first `count` impacts of a wheel that rolls from the start at `rate`, standing on leg 0 at lean 0."""
    robot.reset()
    robot.data.qvel[0], robot.data.qvel[2] = rate * robot.radius, rate
    robot.data.qpos[1] = robot.radius
    robot.put_on_ground()
    rates, coming, gap, spin = [], 1, 1.0, rate
    while len(rates) < count and robot.data.time < 20:
        robot.advance(1)
        gap_before, gap = gap, robot.gaps()[coming]
        spin_before, spin = spin, robot.data.qvel[2]
        if gap <= 0:
            # The ground has not acted yet; the rate is that at a gap of 0.
            rates.append(spin_before + gap_before / (gap_before - gap) * (spin - spin_before))
            coming = (coming + 1) % robot.count
            gap = 1.0
    return rates


def check_energy(options):
    """Work of gas, push and losses against the change of kinetic and potential energy, over a start."""
    robot = Runner(options.binary, rats_run(), options.step)
    m, d = robot.model, robot.data
    m.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    robot.rest()
    control = Controller(GAITS["two-lines"], robot, random.Random(1))
    done = dict.fromkeys(("gas", "damping", "constraints"), 0.0)
    energy = lambda: (mujoco.mj_forward(m, d), d.energy.sum())[1]
    start, ticks = energy(), 500 if options.fast else 2500
    for n in range(ticks * round(TICK / robot.step)):
        if n % round(TICK / robot.step) == 0:
            control.tick()
        before = d.qvel.copy()
        robot.advance(1)
        middle = 0.5 * (before + d.qvel) * robot.step
        done["gas"] += d.qfrc_actuator @ middle
        done["damping"] -= (m.dof_damping * d.qvel) @ middle  # implicit: at the end of the step
        done["constraints"] += d.qfrc_constraint @ middle
    change = energy() - start
    off = (change - sum(done.values())) / done["gas"]
    said = ", ".join(f"{name} {value:.2f} J" for name, value in done.items())
    right = abs(off) < 0.02 and done["constraints"] < 0 and done["damping"] < 0
    speed = robot.data.qvel[0] * robot.boom
    return f"energy over {ticks * TICK:g} s to {speed:.2f} m/s: {said}, change {change:.2f} J; off by a share of", off, right


def check_rest(options):
    """A robot at rest on two legs stays there."""
    robot = Runner(options.binary, rats_run(), options.step)
    robot.rest()
    start = robot.data.qpos.copy()
    robot.advance(round(1 / robot.step))
    drift = np.abs(robot.data.qpos - start).max()
    return "at rest for 1 s: greatest change of a coordinate", drift, drift < 1e-4


def check(options):
    """What a simulator must do right whatever it is compared with."""
    wrong = 0
    for one in (check_gas, check_rest, check_rolling, check_energy):
        text, value, right = one(options)
        wrong += not right
        print(f"{'ok   ' if right else 'WRONG'} {text} {value:.3g}", flush=True)
    return 1 if wrong else 0


def ball(options):
    return in_space.touch_downs(options)


ball.__doc__ = in_space.touch_downs.__doc__


def ball_speed(options):
    return in_space.speed(options)


ball_speed.__doc__ = in_space.speed.__doc__


def parser():
    formatter = argparse.RawDescriptionHelpFormatter
    top = argparse.ArgumentParser(description=__doc__, formatter_class=formatter)
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("--fast", action="store_true", help="a small part, for continuous integration")
    common.add_argument("--binary", default=str(ROOT / "target/release/saltus"), help="the command saltus")
    common.add_argument("--step", type=float, default=STEP, help="time step of MuJoCo (s)")
    common.add_argument("--ratio", type=float, default=RATIO, help="damping ratio of contacts and end stops")
    common.add_argument("--soft", action="store_true", help="MuJoCo's own impedance of contacts and end stops, 0.9 to 0.95, not 0.9999")
    common.add_argument("--jobs", type=int, default=1, help="processes")
    commands = top.add_subparsers(dest="command", required=True)

    def add(call, **more):
        words = {"help": call.__doc__.splitlines()[0], "description": call.__doc__, **more}
        command = commands.add_parser(call.__name__, parents=[common], formatter_class=formatter, **words)
        command.set_defaults(call=call)
        return command

    add(check)
    add(speeds).add_argument("--runs", type=int, default=8, help="for each leg")
    many = add(ensemble)
    many.add_argument("--robots", type=int, default=40)
    many.add_argument("--seed", type=int, default=1)
    many.add_argument("--across", type=float, default=0.0, help="friction coefficient across the travel")
    many.add_argument("--gaits", nargs="*", choices=list(GAITS), help="some of them")
    many.add_argument("--csv", type=pathlib.Path, help="write every run to this file")
    touch = add(touch_downs, epilog=STATES)
    beside = add(against)
    beside.add_argument("ours", metavar="OURS.csv")
    beside.add_argument("answer", metavar="ANSWER.csv", help="of touch_downs")
    touch.add_argument("states", type=pathlib.Path, metavar="STATES.csv")
    touch.add_argument("--robot", type=pathlib.Path, help="robot file; the default is rats-boom as it runs")
    touch.add_argument("--out", type=pathlib.Path, help="write to this file instead of standard output")
    learnt = add(policy)
    learnt.add_argument("policy", type=pathlib.Path, metavar="POLICY.json", help="of `saltus learn run-zone` or `run-stride`")
    learnt.add_argument("--starts", type=int, default=30)
    learnt.add_argument("--across", type=float, default=0.0, help="friction coefficient across the travel, in both")
    rolls = add(ball)
    rolls.add_argument("--study", default=str(ROOT / "target/release/ball_touch_downs"), help="the study of this name, built")
    rolls.add_argument("--count", type=int, default=200)
    rolls.add_argument("--seed", type=int, default=1)
    rolls.add_argument("--ours-step", type=float, default=2.5e-5, help="time step of Saltus (s)")
    rolls.add_argument("--ball-step", type=float, default=2.5e-5, help="time step of MuJoCo (s)")
    quick = add(ball_speed)
    quick.add_argument("--study", default=str(ROOT / "target/release/ball_touch_downs"), help="the study of this name, built")
    quick.add_argument("--ours", default=str(ROOT / "target/release/ball_speed"), help="the study of this name, built")
    quick.add_argument("--count", type=int, default=100)
    quick.add_argument("--seed", type=int, default=1)
    quick.add_argument("--rounds", type=int, default=5)
    some = add(states)
    some.add_argument("--count", type=int, default=10)
    some.add_argument("--seed", type=int, default=1)
    add(bench).add_argument("--tolerance", type=float, default=1e-8, help="of MuJoCo's solver; 1e-8 is its default")
    return top


def main():
    options = parser().parse_args()
    with tempfile.TemporaryDirectory() as folder:
        running.load(folder)
        sys.exit(options.call(options))


if __name__ == "__main__":
    main()
