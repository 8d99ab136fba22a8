"""From a given state of a running robot to the next touch-down in MuJoCo: see run.py."""

import math

import mujoco
import numpy as np

SETTLED = 5e-3  # s: a foot that is in the air from here on may touch down
ALOFT = 2e-2  # m: a foot that was this high is in the air
LEFT = 1e-5  # m: a foot that was less high did not leave the ground, which is soft here
SLIPS, STICKS = 5e-3, 1e-3  # m/s, of the contact point along the travel: a foot slips from the one on, and stands below the other
LIMIT = 2.0  # s: without a touch-down until here there is none

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

Each state goes on until a foot touches down that was more than 20 mm above the ground at some time 5 ms or more after the state.
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
                                    liftK, landK  foot K leaves the ground (by more than 10 um), comes back to it and was less than
                                                 20 mm high, or less than 5 ms after the state
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
        self.standing = self.sliding = self.stop = self.left = None
        self.aloft = [False] * n
        self.now = self.before = None

    def look(self):
        """Takes in the state at this time; the leg that touches down and when, or None."""
        robot, d = self.robot, self.robot.data
        self.before = self.now
        gaps = robot.gaps()
        self.now = d.time, d.qpos.copy(), d.qvel.copy(), [leg.pressure for leg in robot.legs], gaps
        if self.before is None:
            # A rigid ground's feet stand at a gap of 0, give or take.
            self.standing = [gap <= 1e-6 for gap in gaps]
            self.left = [0.0] * self.robot.count
        found = self.feet(gaps)
        self.stops()
        if found is None:
            self.slips()
        return found

    def feet(self, gaps):
        """What feet leave the ground and come back; the one that touches down, and when."""
        for k, gap in enumerate(gaps):
            if self.before is not None and self.before[4][k] <= 0 < gap:
                self.left[k] = self.crossing(k)
            if self.standing[k] and gap > LEFT:
                self.standing[k] = False
                self.note(f"lift{k}", self.left[k])
            elif not self.standing[k] and gap <= 0:
                at = self.crossing(k)
                if self.aloft[k]:
                    return k, at
                self.standing[k] = True
                self.note(f"land{k}", at)
            above = not self.standing[k] and self.robot.data.time >= SETTLED and gap > ALOFT
            self.aloft[k] = not self.standing[k] and (self.aloft[k] or above)
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

    def slips(self):
        """Which of the standing feet slip, by the speed of their lowest point along the travel."""
        sliding = [False] * self.robot.count
        for k, stands in enumerate(self.standing):
            was = self.sliding is not None and self.sliding[k]
            sliding[k] = bool(stands and abs(self.robot.contact_speed(k)) > (STICKS if was else SLIPS))
            if self.sliding is not None and stands and was != sliding[k]:
                self.note(f"{'slip' if sliding[k] else 'stand'}{k}")
        self.sliding = sliding


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
