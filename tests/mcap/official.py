#!/usr/bin/env python3
"""MCAP files of Saltus in the official readers, and files of the official writers in Saltus.

    tests/mcap/check                                                        # as .ci/run does, or
    target/mcap-python/bin/python tests/mcap/official.py --binaries target/debug

1. The standard definitions are those of rosbags for ROS 2 Jazzy.
2. Files of `saltus run`, `simulate`, `verify` and `inject`: the same command gives the same bytes; `mcap` reads them
   with all checksums, `mcap-ros2-support` and `rosbags` decode every message and agree, and what was measured and how the robot
   moved are the numbers of the CSV of the same run, to the bit.
3. Files of the official writers, not compressed, zstd, lz4 and without an index, and a rosbag2: `mcap_numbers` finds the same
   numbers, to the bit; and a run that was converted to a rosbag2 has the diagnosis of its CSV file.

Exit code 1, with the reason, where one of these does not hold.
"""

import argparse
import csv
import hashlib
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy
from mcap.reader import make_reader
from mcap_ros2.reader import read_ros2_messages
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Bag

import definitions
import fixtures

ROOT = pathlib.Path(__file__).resolve().parents[2]


def command(binary, *words, codes=(0,)):
    """Standard output of a command that must end with one of these codes."""
    done = subprocess.run([binary, *map(str, words)], capture_output=True, text=True, check=False)
    if done.returncode not in codes:
        sys.exit(f"{binary.name} {' '.join(map(str, words))}: {done.returncode}\n{done.stderr}")
    return done.stdout


def expect(holds, what):
    if not holds:
        sys.exit(f"mcap: {what}")


def same(a, b):
    """Whether two numbers are the same to the bit; all that are none are alike."""
    return (math.isnan(a) and math.isnan(b)) or numpy.float64(a).tobytes() == numpy.float64(b).tobytes()


def column(rows, name):
    """A column of a CSV file; empty cells are NaN."""
    return [float(row[name]) if row[name] else math.nan for row in rows]


def table(path):
    with open(path, encoding="utf-8") as file:
        return list(csv.DictReader(file))


def twice(binary, folder, name, *words, codes=(0,)):
    """The file that a command writes, which must be the same the second time."""
    # The file says which command wrote it, and so where.
    file, both = folder / f"{name}.mcap", []
    for _ in range(2):
        file.unlink(missing_ok=True)
        command(binary, *words, "--mcap", file, codes=codes)
        both.append(file.read_bytes())
    first, second = both
    expect(first == second, f"{' '.join(map(str, words))}: the second file has other bytes")
    return file


def plain(value):
    """A decoded message as lists, whoever decoded it."""
    if isinstance(value, numpy.ndarray):
        return [plain(x) for x in value.tolist()]
    if isinstance(value, (list, tuple, bytes)):
        return [plain(x) for x in value]
    if hasattr(value, "__slots__") or hasattr(value, "__dataclass_fields__"):
        names = getattr(value, "__dataclass_fields__", None) or value.__slots__
        names = [n for n in names if not n.startswith("_") and not n.isupper()]
        return {n: plain(getattr(value, n)) for n in names}
    return value


def equal(a, b):
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(equal(a[k], b[k]) for k in a)
    if isinstance(a, list):
        return len(a) == len(b) and all(map(equal, a, b))
    if isinstance(a, float) or isinstance(b, float):
        return same(a, b)
    return a == b


def decoded(path):
    """Every message by its topic, as both decoders have it; the number of messages."""
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        expect(reader.get_header().profile == "ros2", f"{path.name}: the profile is not ros2")
        about = {m.name: m.metadata for m in reader.iter_metadata()}["saltus"]
        attached = {a.name: a.data for a in reader.iter_attachments()}
        if "robot.toml" in attached:
            found = hashlib.sha256(attached["robot.toml"]).hexdigest()
            expect(found == about["robot_sha256"], f"{path.name}: the robot has another SHA-256")
        counts = {summary.channels[k].topic: n for k, n in summary.statistics.channel_message_counts.items()}
        crcs = sum(1 for _ in reader.iter_messages(log_time_order=False))
    topics = {}
    for message in read_ros2_messages(str(path), log_time_order=False):
        topics.setdefault(message.channel.topic, []).append((message.log_time_ns, plain(message.ros_msg)))
    expect({t: len(m) for t, m in topics.items()} == counts, f"{path.name}: not every message was decoded")
    expect(crcs == summary.statistics.message_count == sum(counts.values()), f"{path.name}: messages are missing")
    others = {}
    with AnyReader([path]) as bag:
        durability = {one.durability for c in bag.connections for one in c.ext.offered_qos_profiles}
        expect(durability == {QosDurability.TRANSIENT_LOCAL}, f"{path.name}: offered as {durability}")
        for connection, ns, data in bag.messages():
            others.setdefault(connection.topic, []).append((ns, plain(bag.deserialize(data, connection.msgtype))))
    for topic, messages in topics.items():
        # rosbags sorts by time, stably.
        messages = sorted(messages, key=lambda m: m[0])
        expect(len(messages) == len(others[topic]), f"{path.name} {topic}: rosbags has {len(others[topic])} messages")
        for one, other in zip(messages, others[topic]):
            pair = drop_special(one[1]), drop_special(other[1])
            expect(one[0] == other[0] and equal(*pair), f"{path.name} {topic}: decoders differ: {one} {other}")
    print(f"{path.name}: {summary.statistics.message_count} messages on {len(counts)} topics, decoded alike")
    return topics, about


def drop_special(value):
    """A message without what only rosbags adds."""
    if isinstance(value, dict):
        return {k: drop_special(v) for k, v in value.items() if k != "__msgtype__"}
    if isinstance(value, list):
        return [drop_special(v) for v in value]
    return value


def stamps(messages):
    return [m["header"]["stamp"]["sec"] * 10**9 + m["header"]["stamp"]["nanosec"] for _, m in messages]


def is_measured(messages, rows, what):
    """Whether /measured says what the CSV file says."""
    expect(len(messages) == len(rows), f"{what}: /measured has {len(messages)} rows, the CSV file {len(rows)}")
    for name in rows[0]:
        found = [message[name] for _, message in messages]
        expect(all(map(same, found, column(rows, name))), f"{what}: {name} is not that of the CSV file")


def turned(q, v):
    """The vector v, which is given in axes that a unit quaternion turns."""
    u = numpy.array([q["x"], q["y"], q["z"]])
    return v + 2 * numpy.cross(u, numpy.cross(u, v) + q["w"] * v)


def vector(message):
    return numpy.array([message["x"], message["y"], message["z"]])


def place(message, frame, point=(0.0, 0.0, 0.0)):
    """Where a point (m) of a frame is in the world, by the transforms of a message on /tf."""
    of = {one["child_frame_id"]: one for one in message["transforms"]}
    point = numpy.array(point)
    while frame != "world":
        one = of[frame]["transform"]
        point = vector(one["translation"]) + turned(one["rotation"], point)
        frame = of[frame]["header"]["frame_id"]
    return point


def stands(binary, folder):
    """A robot at rest: its feet are on the ground, which bears its weight; the sensor feels gravity."""
    file = folder / "rest.mcap"
    # It stands until the first leg that fires moves, its delay and the filling of its chamber later.
    rest = 5_000_000  # ns
    words = ["run", "fixed", "--robot", "rats-planar", "--seconds", "0.1"]
    command(binary, *words, "--mcap", file, codes=(0, 1))
    topics, _ = decoded(file)
    frames = dict(topics["/tf"])
    weight = {}
    for ns, message in topics["/ground_reaction"]:
        if ns > rest:
            break
        foot = message["header"]["frame_id"]
        up = place(frames[ns], foot, vector(message["wrench"]["force"])) - place(frames[ns], foot)
        weight[ns] = weight.get(ns, 0.0) + up[2]
        expect(abs(place(frames[ns], foot)[2]) < 1e-6, f"rest: {foot} is off the ground")
    found = list(weight.values())
    expect(len(found) == 6, f"rest: forces at {len(found)} instants")
    expect(max(abs(f / (2.75 * 9.80665) - 1) for f in found) < 1e-6, f"rest: the ground bears {found} N")
    force = [vector(m["linear_acceleration"]) for ns, m in topics["/imu"] if ns <= rest]
    mean = numpy.linalg.norm(numpy.mean(force, axis=0))
    expect(abs(mean - 9.80665) < 0.2, f"rest: the sensor feels {mean} m/s2")


def run(binary, folder):
    words = ["run", "closed-loop", "--seconds", "2", "--robot", "rats-run"]
    file = twice(binary, folder, "run", *words)
    telemetry = folder / "telemetry"
    command(binary, *words, "--telemetry", telemetry)
    topics, about = decoded(file)
    said = f"saltus {' '.join(words)} --mcap {file}"
    expect(about["command"] == said and about["seed"] == "1", f"metadata: {about}")
    is_measured(topics["/measured"], table(telemetry / "run.csv"), "run")
    cycles, joints, legs = table(telemetry / "cycles.csv"), topics["/joint_states"], topics["/leg"]
    times = [round(float(row["time_s"]) * 1e9) for row in cycles]
    for topic in ["/joint_states", "/imu"]:
        expect(stamps(topics[topic]) == times, f"run: {topic} has other times than cycles.csv")
    names = joints[0][1]["name"]
    wanted = {"wheel_angle_rad": ("position", "wheel"), "wheel_rate_rad_s": ("velocity", "wheel")}
    wanted |= {f"extension_{k}_m": ("position", f"leg_{k}") for k in range(5)}
    for name, (field, joint) in wanted.items():
        found = [message[field][names.index(joint)] for _, message in joints]
        expect(all(map(same, found, column(cycles, name))), f"run: {name} is not that of cycles.csv")
    for k in range(5):
        found = [message["pressure_pa"][k] for _, message in legs]
        expect(all(map(same, found, column(cycles, f"pressure_{k}_pa"))), f"run: pressure {k} is not that of cycles.csv")
    heights = [place(message, "wheel")[2] for _, message in topics["/tf"]]
    differs = max(abs(h - float(row["height_m"])) for h, row in zip(heights, cycles))
    expect(differs < 1e-12, f"run: by /tf the axle is {differs} m off its height")
    # The sensor's rate is what the instruments measured: rows of the cycles, not those in which a valve shuts.
    rate = [x for x in column(table(telemetry / "run.csv"), "wheel_rate_rad_s") if not math.isnan(x)]
    found = [message["angular_velocity"]["y"] for _, message in topics["/imu"]]
    expect(all(map(same, found, rate)) and len(found) == len(rate), "run: /imu is not what run.csv has")
    expect(any("fire leg" in message["msg"] for _, message in topics["/events"]), "run: no leg fires")
    expect(topics["/robot_description"][0][1]["data"].startswith("<?xml"), "run: no description of the robot")
    return telemetry


def ball(binary, folder):
    """The run of a robot in space: place, attitude and feet by /tf are the numbers of its rows."""
    words = ["run", "disc-stable", "--robot", "rats-twelve", "--seconds", "1"]
    topics, _ = decoded(twice(binary, folder, "ball", *words))
    logs = folder / "ball-telemetry"
    command(binary, *words, "--telemetry", logs)
    is_measured(topics["/measured"], table(logs / "run.csv"), "ball")
    cycles = table(logs / "cycles.csv")
    own = [message for _, message in topics["/tf"] if message["transforms"][0]["child_frame_id"] != "estimate"]
    guess = [message for _, message in topics["/tf"] if message["transforms"][0]["child_frame_id"] == "estimate"]
    expect(len(own) == len(guess) == len(cycles), "ball: /tf has another number of cycles")
    for prefix, messages in [("", own), ("estimated_", guess)]:
        for field, letters, name in [("translation", "xyz", "{}_m"), ("rotation", "wxyz", "quaternion_{}")]:
            for letter in letters:
                found = [message["transforms"][0]["transform"][field][letter] for message in messages]
                wanted = column(cycles, prefix + name.format(letter))
                expect(all(map(same, found, wanted)), f"ball: {prefix}{field} {letter} is not that of cycles.csv")
    # A foot on level ground is as high as it is thick, or pressed in by some millimetres.
    for message, row in list(zip(own, cycles))[::50]:
        heights = [place(message, f"foot_{k}")[2] for k in range(12)]
        # Round-off says whether one that just touches counts.
        surely, at_most = (sum(height <= 0.007 + slack for height in heights) for slack in (-1e-12, 1e-12))
        expect(surely <= int(row["feet_on_ground"]) <= at_most, f"ball: by /tf {surely} to {at_most} feet are down: {row['feet_on_ground']}")
    forces = [vector(message["wrench"]["force"]) for _, message in topics["/ground_reaction"]]
    expect(forces and all(numpy.linalg.norm(force) < 5e3 for force in forces), "ball: no force, or too great a one")
    expect(any("touch-down" in message["msg"] for _, message in topics["/events"]), "ball: no foot comes down")


COURSE = """
jumps = 3
approach_rate_rad_s = 5.5
goal_from_x_m = 1.9
goal_to_x_m = 2.3
clearance_m = 0.005
friction_coefficient = 0.8
[[obstacle]]
front_x_m = 0.35
width_m = 0.15
height_m = 0.12
[[obstacle]]
front_x_m = 1.2
width_m = 0.15
height_m = 0.12
"""


def jumps(binary, folder):
    words = ["simulate", "--omega", "5", "--alpha-f", "-0.1"]
    topics, _ = decoded(twice(binary, folder, "simulate", *words))
    (row,) = csv.DictReader(command(binary, *words, "--format", "csv").splitlines())
    events = {message["msg"]: ns for ns, message in topics["/events"]}
    for event, name in [("fire", "t_fire_s"), ("lift-off", "t_liftoff_s")]:
        expect(abs(events[event] - 1e9 * float(row[name])) <= 1, f"simulate: {event} at {events[event]} ns")
    axle = [place(message, "wheel") for _, message in topics["/tf"]]
    # Between two samples, 1 ms apart, a flight rises by less than g (0.5 ms)^2 / 2.
    expect(abs(max(p[2] for p in axle) - float(row["apex_m"])) < 2e-6, "simulate: the apex by /tf is another")
    expect(abs(axle[-1][0] - float(row["land_rs_m"])) < 1e-9, "simulate: the landing by /tf is another")
    course = folder / "course.toml"
    course.write_text(COURSE)
    words = ["verify", course, "--clearance", "0", "--samples", "0", "--restart", "--tolerance", "1"]
    topics, _ = decoded(twice(binary, folder, "verify", *words, codes=(0, 1)))
    expect(len(topics["/course"][0][1]["markers"]) == 3, "verify: the course has another number of boxes")
    rows = list(csv.DictReader(command(binary, *words, "--format", "csv", codes=(0, 1)).splitlines()))
    # Each jump begins at a whole second.
    starts = [ns for ns, message in topics["/events"] if message["msg"].startswith("jump ")]
    expect(len(rows) == 3 == len(starts), f"verify: {len(rows)} jumps begin at {starts}")
    expect(all(ns % 10**9 == 0 for ns in starts), f"verify: jumps begin at {starts}")
    for row, begin, end in zip(rows, starts, starts[1:] + [math.inf]):
        times = [1e-9 * (ns - begin) for ns, _ in topics["/tf"] if begin <= ns < end]
        axle = [place(message, "wheel") for ns, message in topics["/tf"] if begin <= ns < end]
        # A step of 1 ms that an event is near to is longer. Between two samples a flight rises by g gap^2 / 8 at most.
        gap = max(b - a for a, b in zip(times, times[1:]))
        expect(gap < 2e-3, f"verify: {gap} s between two samples")
        off = abs(max(p[2] for p in axle) - float(row["apex_m"]))
        expect(off < 10 * gap**2 / 8 + 1e-6, f"verify: the apex by /tf is {off} m off: {row}")
        # On a box the last sample is up to 1 ms before the landing; on the ground it is the landing.
        near = 1e-9 if row is rows[-1] else 1e-3 * 4
        expect(abs(axle[-1][0] - float(row["land_x_m"])) < near, f"verify: the landing by /tf is another: {row}")


def injected(binary, folder):
    """Synthetic data of several kinds: the same numbers and the same diagnosis from both formats."""
    for kind, effect in [("bench", "viscous-friction=25"), ("jump", None), ("flight", None), ("outcomes", None)]:
        words = ["inject", *([effect] if effect else []), "--kind", kind, "--runs", "4"]
        places = folder / f"{kind}-csv", folder / f"{kind}-mcap"
        command(binary, *words, "--out", places[0])
        command(binary, *words, "--out", places[1], "--mcap")
        for file in sorted(places[1].glob("*.mcap")):
            topics, about = decoded(file)
            expect(about["seed"] == "1", f"metadata: {about}")
            is_measured(topics["/measured"], table(places[0] / f"{file.stem}.csv"), f"{kind} {file.name}")
        alike(binary, *places)


def answer(binary, folder, end):
    """The diagnosis of a folder without names and hashes, and its notes."""
    text = command(binary, "diagnose", folder, "--format", "json", codes=(0, 1))
    found = json.loads(text.replace(str(folder), "FOLDER").replace(end, ""))
    found["data"].pop("hash")
    return found, found["data"].pop("notes")


def alike(binary, csv_folder, *mcap_folders):
    """Whether the diagnoses of folders differ in nothing but names and hashes."""
    expected, _ = answer(binary, csv_folder, ".csv")
    for folder in mcap_folders:
        found, notes = answer(binary, folder, ".mcap")
        expect(found == expected, f"{folder.name}: the diagnosis differs from that of the CSV files")
        print(f"{folder.name}: the diagnosis is that of the CSV files; notes: {notes}")


def theirs(binary, folder):
    """Numbers of others' files, by mcap_numbers."""
    paths = ["/imu.angular_velocity.y", "/joint_states.position[leg1]", "/valve.data", "/imu.header.stamp.nanosec"]
    for count in (40, 3000):
        place = folder / f"theirs-{count}"
        place.mkdir()
        expected = [[], [], [], []]
        for ns, rate, extension, valve in fixtures.numbers(count):
            expected[0].append(rate)
            expected[3].append(float(ns % 10**9))
            expected[1] += [] if extension is None else [extension]
            expected[2] += [] if valve is None else [float(valve)]
        for file in fixtures.all_files(place, count):
            rows = list(csv.DictReader(command(binary.parent / "mcap_numbers", file, *paths).splitlines()))
            for path, wanted in zip(paths, expected):
                found = [float(row[path]) for row in rows if row[path]]
                expect(len(found) == len(wanted) and all(map(same, found, wanted)), f"{file.name}: {path}")
            print(f"{file.name}, {count}: every number found")
    for file in sorted((ROOT / "telemetry/tests/files").glob("*.mcap")):
        now = folder / "theirs-40" / file.name
        expect(file.read_bytes() == now.read_bytes(), f"{file}: is not what tests/mcap/fixtures.py writes now")


COLUMNS = {
    "pivot_angle_rad": "/joint_states.position[boom]",
    "radius_angle_rad": "/joint_states.position[boom_turn]",
    "wheel_angle_rad": "/joint_states.position[wheel]",
    "wheel_rate_rad_s": "/imu.angular_velocity.y",
}


def converted(binary, folder):
    """A run as a rosbag2 of standard messages, and its diagnosis."""
    telemetry = folder / "ticks"
    # Valves switch at whole cycles, so that all times are whole ns.
    words = ["run", "fixed", "--seconds", "4", "--disturb", "torque=5@0.5:0.7s"]
    command(binary, *words, "--telemetry", telemetry, codes=(0, 1))
    rows, store = table(telemetry / "run.csv"), fixtures.STORE
    target = folder / "ticks-mcap"
    target.mkdir()
    bag = folder / "bag"
    with Bag(bag, version=9, storage_plugin=StoragePlugin.MCAP) as out:
        of = {}

        def write(topic, name, ns, contents):
            if topic not in of:
                of[topic] = out.add_connection(topic, name, typestore=store)
            out.write(of[topic], ns + fixtures.LATE, store.serialize_cdr(fixtures.made(name, contents), name))

        before = {}
        for row in rows:
            ns = fixtures.START + round(float(row["time_s"]) * 1e9)
            header = {"stamp": fixtures.stamp(ns), "frame_id": ""}
            for k in range(1, 6):
                now = int(row[f"valve_{k}"])
                if before.get(k, 0) != now:
                    contents = {"header": header, "point": {"x": now, "y": 0, "z": 0}}
                    write(f"/valve_{k}", "geometry_msgs/msg/PointStamped", ns, contents)
                before[k] = now
            if not row["wheel_angle_rad"]:
                continue
            x = {name: float(row[name]) for name in COLUMNS}
            names = {"boom": "pivot", "boom_turn": "radius", "wheel": "wheel"}
            joints = {"header": header, "name": list(names), "velocity": [], "effort": []}
            joints["position"] = [x[f"{name}_angle_rad"] for name in names.values()]
            write("/joint_states", fixtures.JOINTS, ns, joints)
            zero = {"x": 0, "y": 0, "z": 0}
            imu = {"header": header, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}, "linear_acceleration": zero}
            imu["angular_velocity"] = {"x": 0, "y": x["wheel_rate_rad_s"], "z": 0}
            for name in ["orientation", "angular_velocity", "linear_acceleration"]:
                imu[f"{name}_covariance"] = [0.0] * 9
            write("/imu", fixtures.IMU, ns, imu)
    (target / "run.mcap").write_bytes(next(bag.glob("*.mcap")).read_bytes())
    (target / "robot.toml").write_bytes((telemetry / "robot.toml").read_bytes())
    paths = COLUMNS | {f"valve_{k}": f"/valve_{k}.point.x" for k in range(1, 6) if f"/valve_{k}" in of}
    mapping = ", ".join(f'{name} = "{path}"' for name, path in paths.items())
    text = (telemetry / "experiment.toml").read_text().replace("run.csv", "run.mcap")
    (target / "experiment.toml").write_text(f'{text}clock = "header"\ncolumns = {{ {mapping} }}\n')
    alike(binary, telemetry, target)


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--binaries", type=pathlib.Path, default=ROOT / "target/debug")
    binary = words.parse_args().binaries.resolve() / "saltus"
    expect(not definitions.differing(), f"definitions differ from rosbags': {definitions.differing()}")
    with tempfile.TemporaryDirectory() as place:
        folder = pathlib.Path(place)
        stands(binary, folder)
        run(binary, folder)
        ball(binary, folder)
        jumps(binary, folder)
        injected(binary, folder)
        theirs(binary, folder)
        converted(binary, folder)


if __name__ == "__main__":
    main()
