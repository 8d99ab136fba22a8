#!/usr/bin/env python3
"""What a jump of rats-boom costs in MuJoCo, as CSV on standard output.

    python3 -m venv target/mujoco && target/mujoco/bin/pip install -r tests/mujoco/requirements.txt
    cargo build -p saltus-cli
    target/mujoco/bin/python bench/mujoco_speed.py > mujoco.csv

Only MuJoCo's own work is timed: the force of the leg over time is computed first, in one fine run with the chamber of
tests/mujoco/jump.py, and so are the instants of firing; then whole jumps are flown in one call of mujoco.rollout, on one
thread, without sensors. Times are CPU times, the least of several rounds.
"""

import argparse
import pathlib
import sys
import tempfile
import time

import mujoco
import mujoco.rollout
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/mujoco"))

import compare  # noqa: E402
from jump import Robot  # noqa: E402

STEPS = [2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5]  # s
LIMIT = 5e-6  # s: the step of what errors are taken to
FORCE = 2.5e-5  # s: the step of the run that gives the forces
INTEGRATORS = {
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    "RK4": mujoco.mjtIntegrator.mjINT_RK4,
}
LATE = 0.01  # s: how much later than the fine run a coarse one may land
ROUNDS, LEAST = 3, 0.2  # rounds of at least so many seconds


class Flight:
    """A launch with its force over time."""

    def __init__(self, robot, launch):
        result = robot.jump(launch, FORCE)
        self.robot, self.launch = robot, launch
        self.duration = result.steps * FORCE
        self.times = FORCE * (np.arange(result.steps) + 0.5)
        self.force = np.array(result.force)
        self.opens, self.airborne = result.fire + robot.delay, result.airborne

    def controls(self, step):
        """A motor's force and the latches' states for each step to just past the landing."""
        model = self.robot.model
        count = int(np.ceil((self.duration + LATE) / step))
        rows = np.zeros((count, model.nu + model.neq))
        rows[:, 0] = np.interp(step * (np.arange(count) + 0.5), self.times, self.force)
        rows[:, model.nu :] = 1
        rows[step * np.arange(1, count + 1) > self.opens, model.nu + self.robot.latch] = 0
        return rows

    def fly(self, step, copies=1):
        """CPU time (s) of a jump in steps of `step`, and where it lands (m)."""
        robot, model, data = self.robot, self.robot.model, self.robot.data
        model.opt.timestep = step
        model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
        robot.stand(self.launch.lean, self.launch.rate)
        full = int(mujoco.mjtState.mjSTATE_FULLPHYSICS)
        state = np.zeros((copies, mujoco.mj_stateSize(model, full)))
        mujoco.mj_getState(model, data, state[0], full)
        state[:] = state[0]
        control = self.controls(step)
        cut = int(np.ceil(self.airborne / step))
        stance, stood = roll(model, data, state, control[:cut])
        # In flight there is no ground, as in Saltus' jump.
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
        flight, flown = roll(model, data, stood[:, -1], control[cut:])
        states = np.concatenate([stood[0], flown[0]])
        return (stance + flight) / copies, self.landing(states[:, 1 : 1 + model.nq]), len(control)

    def landing(self, q):
        """Travel (m) where the axle comes down to the height of standing."""
        boom = self.robot.boom
        heights, travel = boom * np.sin(q[:, 1]), boom * q[:, 0]
        top = int(np.argmax(heights))
        down = top + np.flatnonzero(heights[top:] <= 0)
        if len(down) == 0:
            return float("nan")
        i = down[0]
        part = heights[i - 1] / (heights[i - 1] - heights[i])
        return travel[i - 1] + part * (travel[i] - travel[i - 1])

    def timed(self, step):
        """Least CPU time (s) of a jump, its landing (m) and its steps."""
        spent, landing, count = self.fly(step)
        copies = max(1, min(50, int(LEAST / max(spent, 1e-6))))
        return min([spent] + [self.fly(step, copies)[0] for _ in range(ROUNDS)]), landing, count


def roll(model, data, state, control):
    """CPU time (s) of flying `state`, one row for each copy, through `control`; and every state on the way."""
    states = np.zeros((len(state), len(control), state.shape[1]))
    sensors = np.zeros((len(state), len(control), model.nsensordata))
    spec = int(mujoco.mjtState.mjSTATE_CTRL) | int(mujoco.mjtState.mjSTATE_EQ_ACTIVE)
    state, control = np.ascontiguousarray(state), np.ascontiguousarray(control[None])
    begin = time.process_time()
    mujoco.rollout.rollout(model, [data], state, control, control_spec=spec, state=states, sensordata=sensors)
    return time.process_time() - begin, states


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binaries", type=pathlib.Path, default=ROOT / "target/debug", help="where saltus is")
    parser.add_argument("--launches", type=int, default=5, help="how many of compare.py's twenty to fly")
    options = parser.parse_args()
    file = ROOT / "robots/rats-boom.toml"
    with tempfile.TemporaryDirectory() as folder:
        xml = pathlib.Path(folder) / "rats-boom.xml"
        compare.run(str(options.binaries / "saltus"), "export", "mjcf", "--robot", str(file), "--out", str(xml))
        robot = Robot(file, xml)
    robot.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
    every = compare.launches()[:20]
    flights = [Flight(robot, every[i]) for i in np.linspace(0, len(every) - 1, options.launches).astype(int)]
    print("solver,integrator,step_s,steps_per_jump,cpu_s_per_jump,steps_per_s,landing_error_rms_m,landing_error_greatest_m")
    for name, integrator in INTEGRATORS.items():
        robot.model.opt.integrator = integrator
        limits = [flight.fly(LIMIT)[1] for flight in flights]
        for step in STEPS:
            runs = [flight.timed(step) for flight in flights]
            spent, count = np.mean([r[0] for r in runs]), np.mean([r[2] for r in runs])
            errors = np.array([r[1] - limit for r, limit in zip(runs, limits)])
            rms, greatest = np.sqrt(np.mean(errors**2)), np.max(np.abs(errors))
            print(
                f"mujoco {mujoco.__version__},{name},{step:g},{count:.0f},{spent:.4g},{count / spent:.4g},{rms:.3g},{greatest:.3g}",
                flush=True,
            )


if __name__ == "__main__":
    main()
