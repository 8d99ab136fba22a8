#!/usr/bin/env python3
"""The thesis' robot running in MuJoCo: five pneumatic legs that are fired in turn.

    python3 -m venv target/mujoco && target/mujoco/bin/pip install -r tests/mujoco/requirements.txt
    cargo build --release -p saltus-cli
    target/mujoco/bin/python tests/mujoco/run.py check            # or speeds, ensemble, touch_downs, bench

The bodies come from `saltus export mjcf`, the numbers of the legs from the robot's file; nothing else is Saltus'. All legs are free
sliders with end stops at 0 and the stroke, dry and viscous friction, a return spring, and a chamber each. The chambers are
integrated in loop.c next to mj_step, in steps of 50 us at most; a C compiler (cc) builds it at each start. Contacts and end stops
have the damping ratio 3, so that nothing rebounds, and a time constant of two steps. Friction is along and across the travel of
each foot around the boom's base (MuJoCo's own frame stands still); the cone is MuJoCo's ellipse over the two.

The controller runs at 1 kHz. The lean of leg k is phi - 2 pi k/n. The leg whose lean lies in the active zone [z0, z0 + 2 pi/n) fires
once an entry, as soon as its lean is at least alpha_f; an entry begins when the leg in the zone changes. Firing opens the valve for
t_v, and the delay of the robot's file comes before opening and closing. phi comes from the wheel's encoder (nearest of 800 counts a
turn), omega from the gyro (noise 0.1 rad/s, mean of the last five samples).

Robot files have the keys and units of robots/rats-boom.toml (leg.bore_mm, not leg.bore_in).
"""

import argparse
import collections
import copy
import csv
import ctypes
import dataclasses
import itertools
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

from diagnose import dump
from jump import Robot

ROOT = pathlib.Path(__file__).resolve().parents[2]
HERE = pathlib.Path(__file__).resolve().parent
STEP, TICK = 1e-4, 1e-3  # s
RATIO = 3.0  # damping ratio of contacts and end stops: no rebound
TOLERANCE = 1e-12  # of MuJoCo's solver
SUBSTEP = 5e-5  # s, of the gas
COUNT = 2 * math.pi / 800  # rad, of the wheel's encoder: table 3.1
GYRO_NOISE, GYRO_TAPS = 0.1, 5  # rad/s; samples in the mean
TOP = 13.3  # rad/s: 3.2 m/s, where alpha_f has reached its last value
RUNS = 1.5  # m/s: a robot with this mean speed over the last LAST runs
LAST = 4.0  # s
FAST_ENOUGH, WINDOW = 3.2, 0.15  # m/s, s: the thesis' top speed, and over what time it is measured
# Of touch_downs:
SETTLED = 5e-3  # s: a foot that is in the air from here on may touch down
ALOFT = 1e-4  # m: a foot that was this high is in the air
SLIPS, STICKS = 5e-3, 1e-3  # m/s, of the contact point along the travel: a foot slips from the one on, and stands below the other
LIMIT = 2.0  # s: without a touch-down until here there is none


# ---------------------------------------------------------------------------------------------------------------- robots


def rats_run(**changes):
    """The tables of rats-boom as it runs: 7 mm feet, friction of the ground, and less friction of the legs with a spring. `changes` are
    dotted keys with __ for the dot."""
    file = tomllib.loads((ROOT / "robots/rats-boom.toml").read_text())
    file["name"] = "rats-run"
    file["foot"] = {"radius_mm": 7}
    file["ground"] = {"static_friction": 0.9, "kinetic_friction": 0.9, "across_friction": 0.1}
    file["leg"]["coulomb_friction_n"] = 3.0
    file["leg"]["return_spring"] = {"stiffness_n_per_m": 60.0, "preload_n": 4.9}
    for key, value in changes.items():
        section, name = key.split("__")
        file[section][name] = value
    return file


def spring(stiffness, preload):
    """A return spring of a robot file."""
    return {"stiffness_n_per_m": stiffness, "preload_n": preload}


def drawn(seed, index):
    """Robot `index` of an ensemble: friction 1 to 9.7 N, the spring the rest of 9.7 N at mid stroke (READING, finding 2)."""
    rng = random.Random(f"{seed} {index}")
    friction, stiffness = rng.uniform(1, 9.7), rng.uniform(0, 160)
    supply, ground = rng.gauss(120, 3), rng.uniform(0.6, 1.2)
    rest, middle = 9.7 - friction, 0.03
    if rest < stiffness * middle:
        stiffness = rest / middle
    return rats_run(
        leg__coulomb_friction_n=friction,
        leg__return_spring=spring(stiffness, max(0.0, rest - stiffness * middle)),
        leg__supply_pressure_gauge_psi=supply,
        ground__static_friction=ground,
        ground__kinetic_friction=ground,
        ground__across_friction=0.02,
    )


# ---------------------------------------------------------------------------------------------------- the compiled inner loop


class Gas(ctypes.Structure):
    """What all legs share: Gas of loop.c."""

    names = "kappa exponent heat root ambient supply area dead_volume orifice leak choked subsonic critical preload substep".split()
    _fields_ = [(name, ctypes.c_double) for name in names]


class Leg(ctypes.Structure):
    """One leg: Leg of loop.c."""

    _fields_ = [(name, ctypes.c_double) for name in ("pressure", "opens", "closes", "drawn")]


class Layout(ctypes.Structure):
    """Coordinates of the legs: Layout of loop.c."""

    _fields_ = [("legs", ctypes.c_int), *((name, ctypes.c_int * 64) for name in ("qpos", "dof", "motor"))]


def build(folder, bench=False):
    """loop.c, compiled against the MuJoCo of this Python: a library, or the program of `bench`."""
    package = pathlib.Path(mujoco.__file__).parent
    library = sorted(package.glob("libmujoco.so.*"))[0]
    out = pathlib.Path(folder) / ("bench" if bench else "libloop.so")
    kind = ["-DBENCH"] if bench else ["-shared", "-fPIC"]
    words = ["cc", "-std=c99", "-O2", "-Wall", "-Wextra", *kind, f"-I{package / 'include'}", str(HERE / "loop.c"), "-o", str(out)]
    subprocess.run([*words, str(library), f"-Wl,-rpath,{package}", "-lm"], check=True)
    return out


LOOP = None  # the library, once it is loaded


def load(folder):
    global LOOP
    LOOP = ctypes.CDLL(str(build(folder)))
    pointer, real = ctypes.c_void_p, ctypes.c_double
    LOOP.prepare.argtypes = [pointer, pointer, real, real, real]
    LOOP.advance.argtypes = [pointer, pointer, pointer, pointer, pointer, ctypes.c_int]
    LOOP.gas.argtypes = [pointer, pointer, real, real, real, real]


def export(binary, tables, folder):
    """Robot file and model file of a robot."""
    name = tables["name"]
    file, xml = pathlib.Path(folder) / f"{name}.toml", pathlib.Path(folder) / f"{name}.xml"
    file.write_text(dump(tables))
    done = subprocess.run([binary, "export", "mjcf", "--robot", file, "--out", xml], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{binary} export mjcf: {done.stderr.strip()}")
    return file, xml


class Runner(Robot):
    """A robot all of whose legs are free, with what runs it."""

    def __init__(self, binary, tables, step=STEP, ratio=RATIO):
        # The names of jump.Robot's files do not matter after it has read them.
        with tempfile.TemporaryDirectory() as folder:
            super().__init__(*export(binary, tables, folder))
        self.layout = Layout()
        LOOP.prepare(self.model._address, ctypes.byref(self.layout), step, ratio, TOLERANCE)
        self.step, self.count = step, self.layout.legs
        self.slides = [self.layout.qpos[k] for k in range(self.count)]
        self.slide_rates = [self.layout.dof[k] for k in range(self.count)]
        self.feet = [mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_GEOM, f"foot_{k}") for k in range(self.count)]
        self.foot_radius = self.model.geom_size[self.feet[0]][0]
        self.gas = gas_of(self.chamber, self.file["leg"])
        self.reset()

    def reset(self):
        """At the origin, legs retracted, chambers at ambient pressure."""
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = 0
        self.legs = (Leg * self.count)(*[Leg(self.chamber.ambient, math.inf, math.inf, 0.0) for _ in range(self.count)])
        self.coming = [[] for _ in range(self.count)]  # openings of each valve: when it opens and when it closes

    def rest(self):
        """At rest on two legs: leg 0 leans backwards by half of the angle between legs, leg 1 forwards."""
        self.reset()
        self.data.qpos[self.lean] = math.pi / self.count
        self.put_on_ground()

    def put_on_ground(self):
        """Sets the height of the axle such that the lowest foot touches the ground."""
        q = self.data.qpos
        for _ in range(20):
            gap, arm = self.gaps().min(), 1.0 if self.boom is None else self.boom * math.cos(q[1])
            q[1] -= gap / arm
        mujoco.mj_forward(self.model, self.data)

    def gaps(self):
        """Height of each foot above the ground (m)."""
        mujoco.mj_kinematics(self.model, self.data)
        return self.data.geom_xpos[self.feet, 2] - self.foot_radius

    def travel(self):
        """Of the axle (m)."""
        return self.data.qpos[0] * (1.0 if self.boom is None else self.boom)

    def fire(self, leg, opening):
        """Commands the valve of a leg now for `opening` (s)."""
        opens = self.data.time + self.delay
        last = self.coming[leg][-1] if self.coming[leg] else None
        if last and last[1] >= opens:
            last[1] = max(last[1], opens + opening)
        else:
            self.coming[leg].append([opens, opens + opening])

    def advance(self, steps):
        """Makes `steps` steps; a valve opens or closes at most once in each, on time."""
        for leg, openings in zip(self.legs, self.coming):
            while openings and openings[0][1] < self.data.time:
                openings.pop(0)
            leg.opens, leg.closes = openings[0] if openings else (math.inf, math.inf)
        LOOP.advance(
            self.model._address, self.data._address, ctypes.byref(self.layout), ctypes.byref(self.gas), self.legs, steps
        )

    def drawn(self):
        """Gas taken from the supply so far (kg)."""
        return sum(leg.drawn for leg in self.legs)


def gas_of(chamber, leg):
    """The numbers of jump.Chamber for loop.c."""
    back = leg.get("return_spring", {})
    constant = back.get("preload_n", 0.0) if back.get("stiffness_n_per_m", 0.0) == 0 else 0.0
    return Gas(
        chamber.kappa, chamber.exponent, chamber.constant * chamber.temperature, math.sqrt(chamber.temperature),
        chamber.ambient, chamber.supply, chamber.area, chamber.dead_volume, chamber.orifice, chamber.leak,
        chamber.choked, chamber.subsonic, chamber.critical, constant, SUBSTEP,
    )  # fmt: skip


# ------------------------------------------------------------------------------------------------------------------ gaits


@dataclasses.dataclass(frozen=True)
class Gait:
    """How legs are fired: `law` gives alpha_f (rad) from the time (s) and omega (rad/s)."""

    law: object
    zone: float = 0.0  # rad, where the active zone begins
    valve_open: float = 0.04  # s
    push: float = 0.0  # N m on the wheel for 0.2 s
    pushed: float = 0.5  # s, from when on


def open_loop(centre, first=0.35, last=0.0):
    """alpha_f = A tanh(2.1 t - C) + D (thesis 5.1.3), given by the time (s) of its centre."""
    a, d = (last - first) / 2, (last + first) / 2
    return lambda t, omega: a * math.tanh(2.1 * (t - centre)) + d


def one_line(first=0.35, last=-0.1):
    """From `first` at rest to `last` at TOP, and `last` beyond."""
    return lambda t, omega: max(last, first + (last - first) / TOP * omega)


def two_lines(jump, first=0.35, last=-0.1, slope=-0.01, switch=5.0):
    """C omega + D below w_s, E omega + F above. Continuous: E leads to `last` at TOP. With a jump: E is the single line's slope
    and F = C w_s + D. Never less than `last`."""
    knee = slope * switch + first
    steep = (last - first) / TOP if jump else (last - knee) / (TOP - switch)
    beyond = (lambda w: steep * w + knee) if jump else (lambda w: steep * (w - switch) + knee)
    return lambda t, omega: max(last, slope * omega + first if omega < switch else beyond(omega))


FIXED = lambda t, omega: 0.1

GAITS = {
    "fixed": Gait(FIXED),
    "pushed": Gait(FIXED, push=5.0),
    "open-1.43": Gait(open_loop(3.0 / 2.1)),
    "open-3.0": Gait(open_loop(3.0)),
    "one-line": Gait(one_line(), zone=-0.3),
    "two-lines": Gait(two_lines(jump=False), zone=-0.3),
    "two-lines-jump": Gait(two_lines(jump=True), zone=-0.3),
}

# READING, finding 2: share that runs, in percent, without rebound.
READING = {"fixed": 5, "pushed": 50, "open-1.43": 12, "open-3.0": 62, "one-line": 62, "two-lines": 62, "two-lines-jump": 62}


class Controller:
    """The state machine of thesis 5.1, called at each tick."""

    def __init__(self, gait, robot, rng):
        self.gait, self.robot, self.rng = gait, robot, rng
        self.samples = collections.deque(maxlen=GYRO_TAPS)
        self.entry, self.fired, self.firings = None, False, 0

    def tick(self):
        robot, gait = self.robot, self.gait
        angle = COUNT * round(robot.data.qpos[robot.lean] / COUNT)
        self.samples.append(robot.readings()[3] + self.rng.gauss(0, GYRO_NOISE))
        omega = sum(self.samples) / len(self.samples)
        between = 2 * math.pi / robot.count
        entry = math.floor((angle - gait.zone) / between + 1e-9)
        if entry != self.entry:
            self.entry, self.fired = entry, False
        if not self.fired and angle - entry * between >= gait.law(robot.data.time, omega):
            robot.fire(entry % robot.count, gait.valve_open)
            self.fired, self.firings = True, self.firings + 1


@dataclasses.dataclass
class Run:
    """What came of a run."""

    travel: list  # m, at each tick
    gas: float  # kg
    firings: int

    def speed(self, start, end):
        """Mean (m/s) between two times (s)."""
        return (self.travel[round(end / TICK)] - self.travel[round(start / TICK)]) / (end - start)

    def end(self):
        """Time (s) of the last tick."""
        return (len(self.travel) - 1) * TICK

    def reached(self, speed):
        """When the mean over WINDOW first was `speed`, in s; infinite where it never was."""
        n = round(WINDOW / TICK)
        steps = np.array(self.travel[n:]) - np.array(self.travel[:-n])
        there = np.flatnonzero(steps >= speed * WINDOW)
        return (there[0] + n) * TICK if len(there) else math.inf


def run(robot, gait, seconds, rng):
    """From rest on two legs."""
    robot.rest()
    control, travel = Controller(gait, robot, rng), [0.0]
    wheel, each = robot.lean_rate, round(TICK / robot.step)
    for n in range(round(seconds / TICK)):
        control.tick()
        pushing = gait.pushed <= (n + 0.5) * TICK < gait.pushed + 0.2
        robot.data.qfrc_applied[wheel] = gait.push if pushing else 0.0
        robot.advance(each)
        travel.append(robot.travel())
    return Run(travel, robot.drawn(), control.firings)


# --------------------------------------------------------------------------------------------------------------- commands


def pooled(task, tasks, jobs):
    """The results of `task`, in order."""
    if jobs == 1:
        return [task(one) for one in tasks]
    with multiprocessing.get_context("fork").Pool(jobs) as pool:
        return pool.map(task, tasks, chunksize=1)


SPEEDS = {"friction 9.7 N": (9.7, spring(0, 0), "3.8-4.0"), "friction 1 N, spring 7 N + 60 N/m": (1.0, spring(60, 7.0), "3.4-3.6")}


def speed_run(task):
    binary, friction, back, begin, seconds, step = task
    robot = Runner(binary, rats_run(leg__coulomb_friction_n=friction, leg__return_spring=back), step)
    return run(robot, dataclasses.replace(GAITS["pushed"], pushed=begin), seconds, random.Random(0))


def speeds(options):
    """Mean speed of alpha_f = 0.1 rad, t_v = 40 ms after a push; several runs, whose pushes begin 10 ms apart."""
    runs = 3 if options.fast else options.runs
    seconds = 6.0 if options.fast else 10.5
    print("pushed at 0.5 s, 0.51 s, ...; of those that run (m/s): mean over the whole run after 0.5 s, over its last 4 s")
    for name, (friction, back, reading) in SPEEDS.items():
        tasks = [(options.binary, friction, back, round(0.5 + 0.01 * k, 2), seconds, options.step) for k in range(runs)]
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
            f" {statistics.mean(last):.2f} [{min(last):.2f} {max(last):.2f}] (READING {reading}); gas {gas:.3f} g/m",
            flush=True,
        )
    return 0


def wilson(k, n, z=1.96):
    """95 % interval of a share, in percent."""
    centre, half = (k + z * z / 2) / (n + z * z), z * math.sqrt(k * (n - k) / n + z * z / 4) / (n + z * z)
    return max(0.0, 100 * (centre - half)), min(100.0, 100 * (centre + half))


def ensemble_run(task):
    """One robot with all gaits: for each, speed at the end, at 1.6 s, and when 3.2 m/s were reached."""
    binary, seed, index, gaits, seconds, step, ratio = task
    robot, rows = Runner(binary, drawn(seed, index), step, ratio), {}
    for name in gaits:
        one = run(robot, GAITS[name], seconds, random.Random(f"gyro {seed} {index} {name}"))
        rows[name] = one.speed(seconds - LAST, seconds), one.speed(1.6 - WINDOW, 1.6), one.reached(FAST_ENOUGH)
    return rows


def ensemble(options):
    """Share of drawn robots that run, for each gait."""
    robots, seconds = (6 if options.fast else options.robots), (6.0 if options.fast else 9.0)
    gaits = options.gaits or (["pushed", "two-lines"] if options.fast else list(GAITS))
    tasks = [(options.binary, options.seed, k, gaits, seconds, options.step, options.ratio) for k in range(robots)]
    done = pooled(ensemble_run, tasks, options.jobs)
    if options.csv:
        with open(options.csv, "w", newline="") as handle:
            out = csv.writer(handle, lineterminator="\n")
            out.writerow("seed,robot,gait,speed_at_end_m_s,speed_at_1_6_s_m_s,reached_3_2_m_s_s".split(","))
            out.writerows([options.seed, k, name, *one[name]] for k, one in enumerate(done) for name in gaits)
    print(f"{robots} robots, seed {options.seed}, {seconds:g} s, step {1e6 * options.step:g} us, damping ratio {options.ratio:g}")
    print(f"{'gait':15} {'run':>5} {'95 % interval':>14} READING | speed of runners   | at 1.6 s     | 3.2 m/s: median, within 3 s")
    for name in gaits:
        end, early, reached = zip(*[one[name] for one in done])
        running = [v for v in end if v > RUNS]
        low, high = wilson(len(running), robots)
        spread = f"{statistics.median(running):.1f} [{min(running):.1f} {max(running):.1f}]" if running else "-"
        soon = 100 * sum(t <= 3 for t in reached) / robots
        print(
            f"{name:15} {100 * len(running) / robots:4.0f}% {low:6.0f} to {high:3.0f}% {READING[name]:6d}% | {spread:18} |"
            f" {statistics.median(early):4.1f} ({max(early):3.1f})   | {statistics.median(reached):4.1f} s, {soon:.0f} %"
        )
    return 0


COORDINATES = ["psi", "theta", "phi"]
STATES = """\
Columns of STATES.csv (SI units, radians; one row a state; other columns are ignored; legs are 0 to n-1, n = 5):
    psi theta phi d0 .. d4          turn (forward) and pivot (up) of the boom, lean of leg 0, extensions
    psi_rate theta_rate phi_rate d0_rate .. d4_rate
    p0 .. p4                        absolute pressures in the chambers (Pa)
    open_from0 open_until0 .. open_from4 open_until4
                                    when the valve of a leg lets the supply in, in s from the state on, the valve's delay already
                                    counted; a valve that is open has a time <= 0; both empty: it stays at rest
A robot without a boom has travel (m) for psi and height of the axle less the wheel's radius (m) for theta.

Each state goes on until a foot touches down that was more than 0.1 mm above the ground at some time 5 ms or more after the state.
Columns of the answer (one row a state, in order; empty where no foot touches down within 2 s):
    row                             0, 1, ...: the row of STATES.csv
    touch_down_s                    when the foot's gap comes to 0, in s from the state on
    leg                             whose foot it is
    travel_speed_m_s height_speed_m_s
                                    of the axle, just before the impact: L psi_rate, and upwards
    phi omega                       lean of leg 0 and its rate, just before the impact
    psi theta d0 .. d4 psi_rate theta_rate d0_rate .. d4_rate p0 .. p4
                                    the rest of that state
    contacts                        which feet stand just before it, as in 0+1
    switches                        what happened on the way, as in 0.0123:lift0;0.0150:slip1:
                                    liftK, landK  foot K leaves the ground, comes back to it (also by less than 0.1 mm)
                                    slipK, standK the contact point of foot K moves along the travel at more than 5 mm/s, less than 1 mm/s
                                    outK, inK     leg K comes to the end of its stroke, to its stop at 0 (within 10 um)
                                    offK          it leaves either (by more than 20 um)
"""


def number(text):
    """A cell; None where it is empty."""
    return float(text) if text and text.strip() else None


class Watch:
    """Follows a state until the next touch-down, step by step."""

    def __init__(self, robot):
        self.robot, n = robot, robot.count
        self.switches = []
        self.standing = self.sliding = self.stop = None
        self.aloft = [False] * n
        self.now = self.before = None

    def look(self):
        """Takes in the state at this time; the leg that touches down and when, or None."""
        robot, d = self.robot, self.robot.data
        self.before = self.now
        gaps = robot.gaps()
        self.now = d.time, d.qpos.copy(), d.qvel.copy(), [leg.pressure for leg in robot.legs], gaps
        self.stops()
        self.slips(gaps)
        standing = [gap <= 0 for gap in gaps]
        if self.before is None:
            # A rigid ground's feet stand at a gap of 0, give or take.
            self.standing = [gap <= 1e-6 for gap in gaps]
            return None
        for k, (was, is_) in enumerate(zip(self.standing, standing)):
            if was and not is_:
                self.note(f"lift{k}", self.crossing(k))
            elif is_ and not was:
                at = self.crossing(k)
                if self.aloft[k]:
                    return k, at
                self.note(f"land{k}", at)
            self.aloft[k] = not is_ and (self.aloft[k] or (d.time >= SETTLED and gaps[k] > ALOFT))
        self.standing = standing
        return None

    def part(self, k):
        """Where in the last step the gap of foot k was 0."""
        a, b = self.before[4][k], self.now[4][k]
        return a / (a - b) if a != b and 0 <= a / (a - b) <= 1 else 1.0

    def crossing(self, k):
        return self.before[0] + self.part(k) * (self.now[0] - self.before[0])

    def note(self, what, time=None):
        self.switches.append((self.now[0] if time is None else time, what))

    def stops(self):
        stroke, where = self.robot.stroke, []
        for k, d in enumerate(self.now[1][self.robot.slides]):
            close = 1e-5 if self.stop is None or self.stop[k] == "off" else 2e-5
            where.append("in" if d < close else "out" if d > stroke - close else "off")
        if self.stop is not None:
            for k, (was, is_) in enumerate(zip(self.stop, where)):
                if was != is_:
                    self.note(f"{is_}{k}")
        self.stop = where

    def slips(self, gaps):
        """Speed of the lowest point of each foot along its travel."""
        sliding = [False] * self.robot.count
        for k, gap in enumerate(gaps):
            if gap > 0:
                continue
            was = self.sliding is not None and self.sliding[k]
            sliding[k] = abs(self.robot.contact_speed(k)) > (STICKS if was else SLIPS)
            if self.sliding is not None and was != sliding[k]:
                self.note(f"{'slip' if sliding[k] else 'stand'}{k}")
        self.sliding = sliding


def contact_speed(robot, k):
    """Speed (m/s) of the lowest point of foot k along its travel; kinematics are up to date."""
    m, d = robot.model, robot.data
    mujoco.mj_comPos(m, d)
    at, jacobian = d.geom_xpos[robot.feet[k]].copy(), np.zeros((3, m.nv))
    at[2] -= robot.foot_radius
    mujoco.mj_jac(m, d, jacobian, None, at, m.geom_bodyid[robot.feet[k]])
    x, y = (at[0], at[1] + robot.boom) if robot.boom else (0.0, 1.0)
    return (jacobian[0] @ d.qvel * y - jacobian[1] @ d.qvel * x) / math.hypot(x, y)


Runner.contact_speed = contact_speed


def set_state(robot, row):
    """Puts the robot into the state of a row."""
    robot.reset()
    q, v, n = robot.data.qpos, robot.data.qvel, robot.count
    places = [*range(3), *robot.slides]
    names = COORDINATES + [f"d{k}" for k in range(n)]
    for name, place in zip(names, places):
        q[place], v[place] = float(row[name]), float(row[f"{name}_rate"])
    if robot.boom is None:
        q[1] += robot.radius
    for k in range(n):
        robot.legs[k].pressure = float(row[f"p{k}"])
        opens, closes = number(row.get(f"open_from{k}")), number(row.get(f"open_until{k}"))
        if opens is not None and closes is not None:
            robot.coming[k] = [[opens, closes]]
    mujoco.mj_forward(robot.model, robot.data)


def touch_down(robot, row):
    """The answer to one state: a dictionary, all but empty where no foot touches down."""
    set_state(robot, row)
    watch = Watch(robot)
    found = watch.look()
    while found is None and robot.data.time < LIMIT:
        robot.advance(1)
        found = watch.look()
    said = ";".join(f"{time:.6f}:{what}" for time, what in watch.switches)
    if found is None:
        return {"switches": said}
    leg, time = found
    part, (a, b) = watch.part(leg), (watch.before, watch.now)
    mix = lambda i: np.asarray(a[i]) + part * (np.asarray(b[i]) - np.asarray(a[i]))
    q, v, p = mix(1), mix(2), mix(3)
    if robot.boom is None:
        q[1] -= robot.radius
    arm = 1.0 if robot.boom is None else robot.boom
    out = {"touch_down_s": time, "leg": leg, "travel_speed_m_s": arm * v[0]}
    out["height_speed_m_s"] = v[1] * (1.0 if robot.boom is None else robot.boom * math.cos(q[1]))
    out.update(psi=q[0], theta=q[1], phi=q[2], psi_rate=v[0], theta_rate=v[1], omega=v[2])
    for k in range(robot.count):
        out[f"d{k}"], out[f"d{k}_rate"], out[f"p{k}"] = q[robot.slides[k]], v[robot.slide_rates[k]], p[k]
    out["contacts"] = "+".join(str(k) for k in range(robot.count) if watch.standing[k])
    out["switches"] = said
    return out


def answer_columns(n):
    each = lambda pattern: [pattern.format(k) for k in range(n)]
    return (
        ["row", "touch_down_s", "leg", "travel_speed_m_s", "height_speed_m_s", "phi", "omega", "psi", "theta", *each("d{}")]
        + ["psi_rate", "theta_rate", *each("d{}_rate"), *each("p{}"), "contacts", "switches"]
    )


def touch_downs(options):
    """From each state of STATES.csv to the next touch-down."""
    tables = tomllib.loads(options.robot.read_text()) if options.robot else rats_run()
    robot = Runner(options.binary, tables, options.step, options.ratio)
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


def random_states(options):
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
    """Time for a step of MuJoCo with the chambers, all in C, in one thread."""
    seconds = 5.0 if options.fast else 60.0
    with tempfile.TemporaryDirectory() as folder:
        program = build(folder, bench=True)
        tables = rats_run()
        robot = Runner(options.binary, tables)
        robot.rest()
        _, xml = export(options.binary, tables, folder)
        print("step us | us a step: all, of which gas | us for 1 ms | mean speed m/s | contacts")
        for step, substep in ((1e-3, 2.5e-4), (5e-4, 2.5e-4), (2.5e-4, 1.25e-4), (1e-4, 5e-5)):
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
                f"{1e6 * step:7.0f} | {1e6 * whole:7.2f} {1e6 * gas_part:7.2f} | {1e3 / step * whole:8.1f} |"
                f" {robot.boom * turn:6.2f} | {contacts:.2f}",
                flush=True,
            )
    return 0


# ------------------------------------------------------------------------------------------------------------------ checks


def check_gas(options):
    """loop.c's chamber against jump.py's."""
    tables = rats_run()
    robot, worst, rng = Runner(options.binary, tables), 0.0, random.Random(1)
    for _ in range(200):
        p, d, v = rng.uniform(1e5, 9e5), rng.uniform(0, 0.05), rng.uniform(-1, 3)
        leg = Leg(p, 2e-4, 7e-4, 0.0)
        LOOP.gas(ctypes.byref(robot.gas), ctypes.byref(leg), 0.0, 1e-3, d, v)
        at = lambda t: d + v * t
        for begin, end, on in ((0, 2e-4, False), (2e-4, 7e-4, True), (7e-4, 1e-3, False)):
            p = robot.chamber.advance(p, begin, end, at(begin), v, on)
        worst = max(worst, abs(leg.pressure / p - 1))
    return "chamber of loop.c against that of jump.py: greatest relative difference", worst, worst < 1e-9


def check_rolling(options):
    """Unfired five-leg wheel down a slope of 0.25 rad: limit cycle and multiplier in closed form (READING, finding 8)."""
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
    print(rates, factors)
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
    rates, stands, was = [], 0, 0.0
    while len(rates) < count and robot.data.time < 20:
        robot.advance(1)
        low = [k for k, gap in enumerate(robot.gaps()) if gap <= 0 and k != stands]
        if low and low[0] == (stands + 1) % robot.count:
            rates.append(was)
            stands = low[0]
        was = robot.data.qvel[2]
    return rates


def check_energy(options):
    """Work of gas, push and losses against the change of kinetic and potential energy, over a start."""
    robot = Runner(options.binary, rats_run(), options.step)
    m, d = robot.model, robot.data
    m.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    robot.rest()
    control, gait = Controller(GAITS["two-lines"], robot, random.Random(1)), GAITS["two-lines"]
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
    return f"energy over {ticks * TICK:g} s at {robot.data.qvel[0] * robot.boom:.2f} m/s: {said}, change {change:.2f} J; off by a share of the gas'", off, right


def check_flight(options):
    """Without gas and in the air, nothing but friction of the legs takes energy; and the boom's robot at rest stays at rest."""
    robot = Runner(options.binary, rats_run(), options.step)
    robot.rest()
    start = robot.data.qpos.copy()
    robot.advance(round(1 / robot.step))
    drift = np.abs(robot.data.qpos - start).max()
    return "at rest for 1 s: greatest change of a coordinate", drift, drift < 1e-4


def check(options):
    """What a simulator must do right whatever it is compared with."""
    wrong = 0
    for one in (check_gas, check_flight, check_rolling, check_energy):
        text, value, right = one(options)
        wrong += not right
        print(f"{'ok   ' if right else 'WRONG'} {text} {value:.3g}", flush=True)
    return 1 if wrong else 0


def parser():
    formatter = argparse.RawDescriptionHelpFormatter
    top = argparse.ArgumentParser(description=__doc__, formatter_class=formatter)
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("--fast", action="store_true", help="a small part, for continuous integration")
    common.add_argument("--binary", default=str(ROOT / "target/release/saltus"), help="the command saltus")
    common.add_argument("--step", type=float, default=STEP, help="time step of MuJoCo (s)")
    common.add_argument("--ratio", type=float, default=RATIO, help="damping ratio of contacts and end stops")
    common.add_argument("--jobs", type=int, default=1, help="processes")
    commands = top.add_subparsers(dest="command", required=True)
    add = lambda name, call, **more: (
        lambda p: (p.set_defaults(call=call), p)[1]
    )(commands.add_parser(name, parents=[common], help=call.__doc__, formatter_class=formatter, **more))
    add("check", check)
    add("speeds", speeds).add_argument("--runs", type=int, default=8, help="for each leg")
    many = add("ensemble", ensemble)
    many.add_argument("--robots", type=int, default=40)
    many.add_argument("--seed", type=int, default=1)
    many.add_argument("--gaits", nargs="*", choices=list(GAITS), help="some of them")
    many.add_argument("--csv", type=pathlib.Path, help="write every run to this file")
    touch = add("touch_downs", touch_downs, description=touch_downs.__doc__, epilog=STATES)
    touch.add_argument("states", type=pathlib.Path, metavar="STATES.csv")
    touch.add_argument("--robot", type=pathlib.Path, help="robot file; the default is rats-boom as it runs")
    touch.add_argument("--out", type=pathlib.Path, help="write to this file instead of standard output")
    some = add("states", random_states)
    some.add_argument("--count", type=int, default=10)
    some.add_argument("--seed", type=int, default=1)
    add("bench", bench).add_argument("--tolerance", type=float, default=1e-8, help="of MuJoCo's solver; 1e-8 is its default")
    return top


def main():
    options = parser().parse_args()
    with tempfile.TemporaryDirectory() as folder:
        load(folder)
        sys.exit(options.call(options))


if __name__ == "__main__":
    main()
