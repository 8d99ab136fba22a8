"""Jumps in MuJoCo: the model that `saltus export mjcf` writes, driven by a pneumatic chamber integrated here.

Nothing of Saltus is computed here or called: the chamber is written from docs/model.md, "Pneumatic drive", and the
robot's numbers are read from its file.
"""

import dataclasses
import math
import pathlib
import tomllib

import mujoco
import numpy as np

PSI = 6894.757293168  # Pa


@dataclasses.dataclass(frozen=True)
class Launch:
    """How a jump begins; SI units and radians."""

    rate: float
    lean: float
    firing_angle: float
    valve_open: float


@dataclasses.dataclass
class Result:
    """What a jump came to; lengths in m, times in s, SI units throughout."""

    apex: float = math.nan
    landing: float = math.nan  # travel where the axle comes down to its standing height
    fire: float = math.nan
    lift_off: float = math.nan
    extension: float = math.nan  # of the leg at lift-off
    airborne: float = math.nan  # when the foot was 1 mm up, and the ground was taken away
    slip: float = 0.0  # greatest distance of the standing foot from its foothold, along the travel
    sink: float = 0.0  # greatest depth of the foot in the ground
    overshoot: float = 0.0  # of the end stop
    steps: int = 0
    force: list = dataclasses.field(default_factory=list)  # of the drive in each step (N)
    rows: list = dataclasses.field(default_factory=list)  # at each tick: time, valve, lean, pivot, turn, gyro


class Chamber:
    """The gas behind the piston of a leg.

    dP/dt = n R T/V m' - n P/V A d',  V = V0 + A d, adiabatic (n = k) where the robot's file has no other exponent; m' through one
    orifice, from the supply while the valve is energised, to the atmosphere while it is not, and through a leak to the atmosphere.
    """

    def __init__(self, leg, environment):
        gases = {"air": (1.4, 287.05), "co2": (1.289, 188.924)}
        if leg["gas"] not in gases:
            raise SystemExit(f"leg.gas = {leg['gas']}: must be one of {', '.join(gases)}")
        self.kappa, self.constant = gases[leg["gas"]]
        self.exponent = leg.get("polytropic_exponent", self.kappa)
        self.leak = leg.get("leak_area_m2", 0.0)
        self.temperature = leg["gas_temperature_k"]
        self.ambient = environment["ambient_pressure_pa"]
        self.supply = self.ambient + PSI * leg["supply_pressure_gauge_psi"]
        self.area = math.pi * (leg["bore_mm"] * 1e-3) ** 2 / 4
        self.dead_volume = leg["dead_volume_m3"]
        self.orifice = leg["discharge_coefficient"] * math.pi * (leg["orifice_radius_mm"] * 1e-3) ** 2
        k, r = self.kappa, self.constant
        self.choked = math.sqrt(k / r) * (2 / (k + 1)) ** ((k + 1) / (2 * (k - 1)))
        self.subsonic = math.sqrt(2 * k / (r * (k - 1)))
        self.critical = (2 / (k + 1)) ** (k / (k - 1))

    def flow(self, up, down, area):
        """Mass flow (kg/s) through `area` (m2) from the pressure `up` to `down` (Pa); negative where `down` is the greater."""
        if down > up:
            return -self.flow(down, up, area)
        gain = up * area / math.sqrt(self.temperature)
        ratio = down / up
        if ratio <= self.critical:
            return gain * self.choked
        k = self.kappa
        return gain * self.subsonic * ratio ** (1 / k) * math.sqrt(max(0.0, 1 - ratio ** ((k - 1) / k)))

    def rate(self, pressure, extension, speed, energised):
        """dP/dt (Pa/s)."""
        volume = self.dead_volume + self.area * extension
        flow = self.flow(self.supply if energised else self.ambient, pressure, self.orifice)
        if self.leak > 0:
            flow -= self.flow(pressure, self.ambient, self.leak)
        heat = self.constant * self.temperature * flow
        return self.exponent * (heat - pressure * self.area * speed) / volume

    def advance(self, pressure, start, end, extension, speed, energised):
        """The pressure (Pa) at `end` (s): the extension goes linearly from what it is at `start`. Runge-Kutta, substeps <= 50 us."""
        if end <= start:
            return pressure
        count = max(1, math.ceil((end - start) / 5e-5))
        h = (end - start) / count
        for i in range(count):
            d = extension + speed * i * h
            at = lambda p, part: self.rate(p, d + part * h * speed, speed, energised)
            a = at(pressure, 0.0)
            b = at(pressure + 0.5 * h * a, 0.5)
            c = at(pressure + 0.5 * h * b, 0.5)
            e = at(pressure + h * c, 1.0)
            pressure += h * (a + 2 * b + 2 * c + e) / 6
        return pressure


class Robot:
    """A robot in MuJoCo, with what its file says of its legs."""

    def __init__(self, file, xml):
        with open(file, "rb") as handle:
            self.file = tomllib.load(handle)
        self.model = mujoco.MjModel.from_xml_string(pathlib.Path(xml).read_text())
        self.data = mujoco.MjData(self.model)
        self.chamber = Chamber(self.file["leg"], self.file["environment"])
        self.delay = 1e-3 * self.file["leg"]["valve_delay_ms"]
        self.stroke = self.file["leg"]["stroke_m"]
        self.radius = self.file["body"]["wheel_radius_m"]
        self.boom = self.file.get("boom", {}).get("length_m")
        model = self.model
        index = lambda kind, name: mujoco.mj_name2id(model, kind, name)
        joint = lambda name: index(mujoco.mjtObj.mjOBJ_JOINT, name)
        self.lean = model.jnt_qposadr[joint("wheel")]
        self.lean_rate = model.jnt_dofadr[joint("wheel")]
        self.leg = model.jnt_qposadr[joint("leg_0")]
        self.leg_rate = model.jnt_dofadr[joint("leg_0")]
        self.foot = index(mujoco.mjtObj.mjOBJ_GEOM, "foot_0")
        self.axle_site = index(mujoco.mjtObj.mjOBJ_SITE, "axle")
        self.latch = index(mujoco.mjtObj.mjOBJ_EQUALITY, "latch_0")

    def axle(self):
        """Travel and height of the axle (m), the travel along the boom's arc."""
        q = self.data.qpos
        if self.boom is None:
            return q[0], q[1]
        return self.boom * q[0], self.data.site_xpos[self.axle_site][2]

    def foot_place(self):
        """Travel and gap (m) of foot 0 on level ground."""
        x, y, z = self.data.geom_xpos[self.foot]
        travel = x if self.boom is None else self.boom * math.atan2(x, y + self.boom)
        return np.array([travel, z - self.model.geom_size[self.foot][0]])

    def stand(self, lean, rate):
        """Puts the robot on foot 0, at travel 0, retracted and turning about it."""
        m, d = self.model, self.data
        mujoco.mj_resetData(m, d)
        d.qpos[:] = 0
        d.qpos[self.lean] = lean
        if self.boom is None:
            d.qpos[1] = self.radius
        places = lambda: (mujoco.mj_kinematics(m, d), self.foot_place())[1]
        for _ in range(20):
            here, slopes = places(), np.zeros((2, 2))
            for k in range(2):
                d.qpos[k] += 1e-6
                slopes[:, k] = (places() - here) / 1e-6
                d.qpos[k] -= 1e-6
            d.qpos[:2] -= np.linalg.solve(slopes, here)
        mujoco.mj_forward(m, d)
        jacobian = np.zeros((3, m.nv))
        bottom = d.geom_xpos[self.foot] - [0, 0, m.geom_size[self.foot][0]]
        mujoco.mj_jac(m, d, jacobian, None, bottom, m.geom_bodyid[self.foot])
        still = jacobian[[0, 2]]  # At the foothold the travel is along x.
        d.qvel[self.lean_rate] = rate
        d.qvel[:2] = np.linalg.solve(still[:, :2], -rate * still[:, self.lean_rate])
        mujoco.mj_forward(m, d)

    def readings(self):
        """Lean, pivot and turn (rad), and what a gyro on the wheel of a tilted boom says (rad/s)."""
        q, v = self.data.qpos, self.data.qvel
        return [q[self.lean], q[1], q[0], v[self.lean_rate] + v[0] * math.sin(q[1])]

    def jump(self, launch, step, end=3.0, tick=None, aloft=None):
        """Flies `launch` in steps of `step` (s); with a `tick` (s) the command comes at one, and a row is kept at each.

        From the first tick in the air on, steps are `aloft` long, if that is given.
        """
        m, d, chamber = self.model, self.data, self.chamber
        m.opt.timestep = step
        m.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
        self.stand(launch.lean, launch.rate)
        result = Result()
        pressure = chamber.ambient
        opens = closes = math.inf
        every = round(tick / step) if tick else 0
        reading = lambda time: [time, int(time >= result.fire and time < result.fire + launch.valve_open), *self.readings()]
        if d.qpos[self.lean] >= launch.firing_angle:
            result.fire, opens = 0.0, self.delay
            closes = opens + launch.valve_open
        n, steps, begun, off, risen = 0, 0, 0.0, False, False
        if tick:
            result.rows.append(reading(0.0))
        axle = before = self.axle()
        while begun + n * step < end:
            time, extension, lean = begun + n * step, d.qpos[self.leg], d.qpos[self.lean]
            if time + step > opens and d.eq_active[self.latch]:
                d.eq_active[self.latch] = 0
            # The force in the middle of the step, from where the leg is going.
            speed = d.qvel[self.leg_rate]
            middle = self.gas(pressure, time, time + 0.5 * step, extension, speed, opens, closes)
            d.ctrl[0] = (middle - chamber.ambient) * chamber.area
            result.force.append(d.ctrl[0])
            mujoco.mj_step(m, d)
            n, steps = n + 1, steps + 1
            now = begun + n * step
            speed = (d.qpos[self.leg] - extension) / step
            pressure = self.gas(pressure, time, now, extension, speed, opens, closes)
            mujoco.mj_kinematics(m, d)
            before, axle = axle, self.axle()
            if opens == math.inf and d.qpos[self.lean] >= launch.firing_angle and (not tick or n % every == 0):
                passed = (launch.firing_angle - lean) / (d.qpos[self.lean] - lean)
                result.fire = now if tick else time + step * passed
                opens = result.fire + self.delay
                closes = opens + launch.valve_open
            if tick and n % every == 0:
                result.rows.append(reading(now))
            result.overshoot = max(result.overshoot, d.qpos[self.leg] - self.stroke)
            travel, gap = self.foot_place()
            if not off:
                if gap <= 0:
                    result.slip = max(result.slip, abs(travel))
                    result.sink = max(result.sink, -gap)
                    result.lift_off = math.nan
                elif math.isnan(result.lift_off):
                    # It may come down again, as a leg under pressure does from a soft stop; the last time counts.
                    result.lift_off, result.extension = now, d.qpos[self.leg]
                if gap > 1e-3:
                    # From here on there is no ground, as in Saltus' jump.
                    off, result.airborne = True, now
                    m.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
            if axle[1] < before[1] and off and not risen:
                risen = True
                result.apex = before[1]
            if risen:
                result.apex = max(result.apex, axle[1])
                if axle[1] <= self.radius:
                    part = (before[1] - self.radius) / (before[1] - axle[1])
                    result.landing = before[0] + part * (axle[0] - before[0])
                    break
            if off and aloft and n % every == 0:
                begun, n, step, aloft = now, 0, aloft, None
                every, m.opt.timestep = round(tick / step), step
        result.steps = steps
        return result

    def gas(self, pressure, start, end, extension, speed, opens, closes):
        """The pressure (Pa) at `end`, past the valve's opening and closing on the way; until it opens the leg is latched."""
        if end <= opens:
            return pressure
        for first, last, energised in ((opens, closes, True), (closes, math.inf, False)):
            begin, stop = max(start, first), min(end, last)
            if begin < stop:
                at = extension + speed * (begin - start)
                pressure = self.chamber.advance(pressure, begin, stop, at, speed, energised)
        return pressure
