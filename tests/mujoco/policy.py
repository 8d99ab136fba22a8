"""What `saltus learn` learnt, flown in MuJoCo: see run.py policy."""

import collections
import json
import math
import random
import re
import statistics
import subprocess

from running import COUNT, GYRO_NOISE, GYRO_TAPS, TICK, Runner, rats_run

GOAL, LONGEST = 1.6, 3.0  # m, s
ZONE = -0.3  # rad, where the active zone begins
SPEED_OVER = 20  # ticks, over which the boom's encoder gives a speed
BOOM = 2 * math.pi / 1600  # rad, of the boom's encoders: table 3.1
GRID = 6, 3  # firing angles and valve opening times of a table of strides
OPENINGS = 0.1  # s, the longest


class Learnt:
    """The policy of the best seed of a file, or of the seed that is named."""

    def __init__(self, path, seed=None):
        file = json.loads(path.read_text())
        self.file = file.get("policy", file)
        tables = self.file["tables"]
        # Of a score: sum of rewards, steps, steps outside, time, angle, travel, when it arrived.
        arrived = lambda table: table["score"][6] or 100.0 - table["score"][5]
        self.table = min(tables, key=arrived) if seed is None else next(it for it in tables if it["seed"] == seed)
        self.values = [0.0] * self.table["table_size"]
        for place, value in self.table["values"]:
            self.values[place] = value
        self.task = self.file["task"]

    def choice(self, observed):
        state = count = 0
        for axis, x in zip(self.file["states"], observed):
            count = axis["steps"]
            step = math.floor((x - axis["from"]) / (axis["to"] - axis["from"]) * count)
            state = state * count + min(max(step, 0), count - 1)
        actions = len(self.values) // math.prod(axis["steps"] for axis in self.file["states"])
        row = self.values[state * actions : (state + 1) * actions]
        return row.index(max(row))


class Controller:
    """What decides by a policy, at each tick."""

    def __init__(self, learnt, robot, rng):
        self.learnt, self.robot, self.rng = learnt, robot, rng
        self.samples = collections.deque(maxlen=GYRO_TAPS)
        self.travels = collections.deque(maxlen=SPEED_OVER + 1)
        self.entry, self.firing, self.ticks = None, None, 0

    def tick(self):
        robot, learnt, q = self.robot, self.learnt, self.robot.data.qpos
        angle = COUNT * round(q[robot.lean] / COUNT)
        self.samples.append(robot.readings()[3] + self.rng.gauss(0, GYRO_NOISE))
        omega = statistics.mean(self.samples)
        self.travels.append(robot.boom * BOOM * round(q[0] / BOOM))
        between = 2 * math.pi / robot.count
        entry = math.floor((angle - ZONE) / between + 1e-9)
        lean = angle - entry * between
        enters, self.entry = entry != self.entry, entry
        if learnt.task == "run-zone":
            if self.ticks % 5 == 0 and learnt.choice([math.remainder(angle, 2 * math.pi), omega]) == 1:
                robot.fire(entry % robot.count, 0.005)
        else:
            if enters:
                self.firing = self.stride(omega, lean, BOOM * round(q[1] / BOOM))
            if self.firing and self.firing[1] > 0 and lean >= self.firing[0]:
                robot.fire(entry % robot.count, self.firing[1])
                self.firing = None
        self.ticks += 1

    def stride(self, omega, lean, pivot):
        """Firing angle and valve opening time of the leg that has entered the zone."""
        way = self.travels[-1] - self.travels[0]
        speed = way / (max(len(self.travels) - 1, 1) * TICK)
        angles, times = GRID
        choice = self.learnt.choice([omega, lean, speed, pivot])
        pitch = 2 * math.pi / self.robot.count
        return ZONE + pitch * (choice // times) / (angles - 1), OPENINGS * (choice % times) / (times - 1)


def time_to_goal(robot, learnt, rng):
    """From rest on two legs (s); infinite where it does not arrive."""
    robot.rest()
    control, each = Controller(learnt, robot, rng), round(TICK / robot.step)
    for n in range(round(LONGEST / TICK)):
        control.tick()
        robot.advance(each)
        if robot.travel() >= GOAL:
            return (n + 1) * TICK
    return math.inf


def ours(binary, path, seed, across):
    """The same by `saltus run`."""
    words = [binary, "run", "policy", str(path), "--seconds", str(LONGEST), "--seed", str(seed)]
    words += ["--set", f"ground.across_friction={across}"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    found = re.search(r"1\.6 m +reached at ([0-9.]+) s", done.stdout)
    return float(found[1]) if found else math.inf


def compare(options):
    """Time to 1.6 m of a policy, here and in Saltus' own simulation: medians over starts whose sensors' noise differs.

    The friction across the travel is the same in both. Where it is not 0, MuJoCo's cone takes from the friction along the travel what a foot
    slips across it; Saltus has a law for each direction.
    """
    learnt, starts = Learnt(options.policy), 4 if options.fast else options.starts
    robot = Runner(options.binary, rats_run(ground__across_friction=options.across), options.step, options.ratio, options.soft)
    theirs = [time_to_goal(robot, learnt, random.Random(f"policy {k}")) for k in range(starts)]
    own = [ours(options.binary, options.policy, 1 + k, options.across) for k in range(starts)]
    there, here = statistics.median(theirs), statistics.median(own)
    if math.isinf(there) and math.isinf(here):
        apart, said = 0.0, "in neither does half of them"
    else:
        apart = math.inf if math.isinf(there) or math.isinf(here) else there / here - 1
        said = f"{100 * apart:+.1f} %"
    arrive = lambda times: sum(math.isfinite(time) for time in times)
    print(
        f"{learnt.task} by {learnt.file['algorithm']}, seed {learnt.table['seed']}: MuJoCo {there:.3f} s ({arrive(theirs)} of {starts} arrive), "
        f"Saltus {here:.3f} s ({arrive(own)} of {starts}); {said}"
    )
    return int(abs(apart) > 0.1)
