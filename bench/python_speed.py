"""Speed of the package beside the library alone and beside SciPy.

    (cd studies && cargo build --release --bin many_jumps)
    python bench/python_speed.py target/release/many_jumps

Needs the installed wheel and SciPy. Everything is measured in turns, because a machine has other work; what
counts are the ratios. SciPy integrates the same stance by DOP853 at a tolerance that gives 1e-9, each
regime of the orifice as a phase of its own, which ends at an event.
"""

from __future__ import annotations

import argparse
import math
import statistics
import subprocess
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import saltus

MEGA = 1e6
"""SciPy's pressures are in MPa, so that all of a state has the same size."""
ROUNDS = 5
TOLERANCE = 2e-10
"""Of SciPy, for 1e-9."""
PLANNING = 2e-9
"""Of Saltus, for 1e-9."""


class Stance:
    """The stance of a pneumatic robot, from the firing to lift-off, written down once more."""

    def __init__(self, robot: saltus.Robot) -> None:
        table = robot.to_dict()
        body, leg, around = table["body"], table["leg"], table["environment"]
        self.m, self.inertia, self.radius = body["mass_kg"], body["inertia_kg_m2"], body["wheel_radius_m"]
        self.g, self.ambient = around["gravity_m_s2"], around["ambient_pressure_pa"]
        self.supply = leg.get("supply_pressure_absolute_pa") or leg["supply_pressure_gauge_pa"] + self.ambient
        self.stroke, self.delay = leg["stroke_m"], leg["valve_delay_s"]
        self.viscous, self.dry = leg["viscous_friction_n_s_per_m"], leg["coulomb_friction_n"]
        self.area, self.dead = math.pi * leg["bore_m"] ** 2 / 4, leg["dead_volume_m3"]
        self.k, self.gas, temperature = 1.4, 287.05, leg["gas_temperature_k"]
        self.flow = leg["discharge_coefficient"] * math.pi * leg["orifice_radius_m"] ** 2 / math.sqrt(temperature)
        self.heat = self.k * self.gas * temperature
        k = self.k
        self.choked = math.sqrt(k / self.gas) * (2 / (k + 1)) ** ((k + 1) / (2 * (k - 1)))
        self.subsonic = math.sqrt(2 * k / (self.gas * (k - 1)))
        self.critical = (2 / (k + 1)) ** (k / (k - 1))

    def below(self, up: float, down: float) -> float:
        """Mass flow (kg/s) through the orifice, not choked."""
        share = (down / up) ** ((self.k - 1) / self.k)
        return up * self.flow * self.subsonic * down / up / share * math.sqrt(max(0.0, 1 - share))

    def mass_flow(self, mode: str, p: float) -> float:
        """Into the chamber (kg/s), with the valve open or closed."""
        if mode == "in, choked":
            return self.supply * self.flow * self.choked
        if mode == "in":
            return self.below(self.supply, p) if p < self.supply else -self.below(p, self.supply)
        if mode == "out, choked":
            return -p * self.flow * self.choked
        return -self.below(p, self.ambient) if p > self.ambient else self.below(self.ambient, p)

    def rates(self, mode: str) -> Callable[[float, NDArray[np.float64]], list[float]]:
        """Lean, its rate, extension, its rate, pressure."""

        def of(_: float, state: NDArray[np.float64]) -> list[float]:
            lean, rate, d, speed, p = state.tolist()
            p = max(p * MEGA, 1.0)
            r = self.radius + d
            turn = self.m * r * (self.g * math.sin(lean) - 2 * rate * speed) / (self.inertia + self.m * r * r)
            push = ((p - self.ambient) * self.area - self.viscous * speed - self.dry) / self.m
            fill = (self.heat * self.mass_flow(mode, p) - self.k * p * self.area * speed) / (self.dead + self.area * d) / MEGA
            return [rate, turn, speed, push + rate * rate * r - self.g * math.cos(lean), fill]

        return of

    def retracted(self, filling: bool) -> Callable[[float, NDArray[np.float64]], list[float]]:
        """Lean, its rate and, while the chamber fills, its pressure."""
        pull = self.m * self.g * self.radius / (self.inertia + self.m * self.radius**2)
        rise = self.heat / self.dead * self.mass_flow("in, choked", 0.0) / MEGA if filling else 0.0
        return lambda _, state: [state[1], pull * math.sin(state[0]), rise]

    def jump(self, rate: float, angle: float, valve_open: float) -> tuple[float, float]:
        """Apex and landing on level ground (m)."""

        def on(rates: Any, t: float, end: float, state: Any, events: Any) -> tuple[float, list[float], int | None]:
            path = solve_ivp(rates, (t, end), state, method="DOP853", rtol=TOLERANCE, atol=TOLERANCE, events=events)
            hit = next((k for k, at in enumerate(path.t_events or []) if len(at)), None)
            return path.t[-1], path.y[:, -1].tolist(), hit

        def breaks(_: float, s: NDArray[np.float64]) -> float:
            push = (s[2] * MEGA - self.ambient) * self.area - self.dry
            return push + self.m * (s[1] ** 2 * self.radius - self.g * math.cos(s[0]))

        off = self.delay + valve_open
        t, state, _ = on(self.retracted(False), 0.0, self.delay, [angle, rate, self.ambient / MEGA], None)
        t, state, hit = on(self.retracted(True), t, off, state, [event(breaks, 1)])
        if hit is None:
            return math.nan, math.nan
        state = [state[0], state[1], 0.0, 0.0, state[2]]
        end = event(lambda _, s: s[2] - self.stroke, 1)
        force = event(lambda _, s: (s[4] * MEGA - self.ambient) * self.area - self.viscous * s[3] - self.dry, -1)
        edges = {"in": self.critical * self.supply, "out": self.ambient / self.critical}
        for way, until in (("in", off), ("out", off + 2.0)):
            above = state[4] * MEGA > edges[way]
            while t < until:
                mode = f"{way}, choked" if above == (way == "out") else way
                cross = event(lambda _, s, edge=edges[way]: s[4] - edge / MEGA, -1 if above else 1)
                t, state, hit = on(self.rates(mode), t, until, state, [end, force, cross])
                if hit in (0, 1):
                    return self.flight(*state)
                above = above != (hit == 2)
        return math.nan, math.nan

    def flight(self, lean: float, rate: float, d: float, speed: float, _: float) -> tuple[float, float]:
        r, s, c = self.radius + d, math.sin(lean), math.cos(lean)
        x, y, vx, vy = r * s, r * c, speed * s + r * rate * c, speed * c - r * rate * s
        apex = y + max(vy, 0.0) ** 2 / 2 / self.g
        return apex, x + vx * (vy + math.sqrt(vy * vy + 2 * self.g * (y - self.radius))) / self.g


def event(of: Callable[..., float], direction: int) -> Callable[..., float]:
    """A function whose zero ends a phase."""
    of.terminal, of.direction = True, direction  # type: ignore[attr-defined]
    return of


def seconds(work: Callable[[], object]) -> float:
    """Time of a call (s)."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("library", help="the built study many_jumps")
    parser.add_argument("--count", type=int, default=1_000_000, help="jumps [default: 1000000]")
    parser.add_argument("--scipy", type=int, default=200, help="jumps of SciPy in each round [default: 200]")
    given = parser.parse_args()
    robot = saltus.Robot("rats-planar")
    omega = 3.0 + 3.0 * np.arange(given.count) / given.count
    stance = Stance(robot)
    some = omega[:: max(1, given.count // given.scipy)][: given.scipy]

    fine, ours = saltus.jumps(robot, some, -0.1), saltus.jumps(robot, some, -0.1, tolerance=PLANNING)
    theirs = np.array([stance.jump(rate, -0.1, 0.1) for rate in some])
    for name, of in (("SciPy", theirs), (f"Saltus at {PLANNING}", np.column_stack([ours["apex_m"], ours["land_rs_m"]]))):
        off = max(np.abs(of[:, k] / fine[column] - 1).max() for k, column in enumerate(("apex_m", "land_rs_m")))
        print(f"apex and landing of {len(some)} jumps, {name} against Saltus at all digits: {off:.1e}")

    library: dict[str, list[float]] = {"1": [], "2": [], "one": []}
    package: dict[str, list[float]] = {"1": [], "2": [], "one": [], "1e-9": [], "SciPy": []}
    for _ in range(ROUNDS):
        said = subprocess.run([given.library, str(given.count)], check=True, capture_output=True, text=True).stdout
        for name, line in zip(library, said.splitlines()):
            library[name].append(float(line.split()[-2]))
        for threads in ("1", "2"):
            package[threads].append(seconds(lambda: saltus.jumps(robot, omega, -0.1, threads=int(threads))))
        package["1e-9"].append(seconds(lambda: saltus.jumps(robot, omega, -0.1, threads=1, tolerance=PLANNING)))
        package["one"].append(min(seconds(lambda: [saltus.jump(robot, 3.0, -0.1) for _ in range(100)]) / 100 for _ in range(30)))
        package["SciPy"].append(seconds(lambda: [stance.jump(rate, -0.1, 0.1) for rate in some]) / len(some))

    def ratio(a: list[float], b: list[float]) -> float:
        return statistics.median(x / y for x, y in zip(a, b))

    each = [total / given.count for total in package["1e-9"]]
    print(f"{given.count} jumps, one thread: {statistics.median(package['1']):.2f} s, {ratio(package['1'], library['1']):.3f} × the library alone")
    print(f"two threads: {ratio(package['1'], package['2']):.2f} × as fast as one (the library alone: {ratio(library['1'], library['2']):.2f} ×)")
    print(f"to 1e-9: {1e6 * statistics.median(each):.2f} µs a jump; SciPy {1e3 * statistics.median(package['SciPy']):.2f} ms, {ratio(package['SciPy'], each):.0f} ×")
    over = min(package["one"]) - min(library["one"])
    print(f"one jump, least: {1e6 * min(package['one']):.2f} µs, {1e6 * over:.2f} µs above the library alone")


if __name__ == "__main__":
    main()
