"""A robot with five pneumatic legs in MuJoCo, the gaits of the thesis, and runs from rest: see run.py."""

import collections
import ctypes
import dataclasses
import math
import pathlib
import random
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
WINDOW = 0.15  # s, over which a speed is measured


def rats_run(**changes):
    """The tables of rats-boom as it runs: feet of 7 mm, friction of the ground, and less friction of the legs with a spring.

    `changes` are dotted keys with __ for the dot.
    """
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


def drawn(seed, index, across):
    """Robot `index` of an ensemble: friction 1 to 9.7 N, the spring the rest of 9.7 N at mid stroke."""
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
        ground__across_friction=across,
    )


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
    """Builds the library in `folder` and loads it."""
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

    def __init__(self, binary, tables, step=STEP, ratio=RATIO, soft=False):
        # The names of jump.Robot's files do not matter after it has read them.
        with tempfile.TemporaryDirectory() as folder:
            super().__init__(*export(binary, tables, folder))
        self.layout = Layout()
        LOOP.prepare(self.model._address, ctypes.byref(self.layout), step, ratio, TOLERANCE)
        if soft:
            self.model.pair_solimp[:] = self.model.jnt_solimp[:] = mujoco.MjOption().o_solimp
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

    def contact_speed(self, k):
        """Speed (m/s) of the lowest point of foot k along its travel, with kinematics up to date."""
        m, d = self.model, self.data
        mujoco.mj_comPos(m, d)
        at, jacobian = d.geom_xpos[self.feet[k]].copy(), np.zeros((3, m.nv))
        at[2] -= self.foot_radius
        mujoco.mj_jac(m, d, jacobian, None, at, m.geom_bodyid[self.feet[k]])
        # The travel is across the arm from the base to the foot.
        x, y = (0.0, 1.0) if self.boom is None else (at[0], at[1] + self.boom)
        return (jacobian[0] @ d.qvel * y - jacobian[1] @ d.qvel * x) / math.hypot(x, y)

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

# What `saltus run` calls them.
SALTUS = {
    "fixed": ["fixed"],
    "pushed": ["fixed", "--disturb", "torque=5@0.5:0.7s"],
    "open-1.43": ["open-loop", "--centre", "printed"],
    "open-3.0": ["open-loop", "--centre", "seconds"],
    "one-line": ["closed-loop", "--lines", "one"],
    "two-lines": ["closed-loop", "--lines", "two"],
    "two-lines-jump": ["closed-loop", "--lines", "jump"],
}


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
