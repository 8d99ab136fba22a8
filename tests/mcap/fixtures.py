#!/usr/bin/env python3
"""MCAP files as others write them: `telemetry/tests/files`, and the same at any length.

    target/mcap-python/bin/python tests/mcap/fixtures.py telemetry/tests/files

The official Python writer (mcap-ros2-support) writes one file for each compression, rosbags a rosbag2 whose storage is MCAP. All
have 40 messages of an inertial sensor, of joints and of a valve; `numbers` says what stands in them. The sensor's clock and that of
the log differ by 3 ms, and the joints come at half the rate.
"""

import math
import pathlib
import shutil
import sys
import tempfile

import numpy
from mcap.writer import CompressionType, IndexType
from mcap.writer import Writer as McapWriter
from mcap_ros2.writer import Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Bag
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)
IMU, JOINTS, VALVE = "sensor_msgs/msg/Imu", "sensor_msgs/msg/JointState", "std_msgs/msg/UInt8"
LATE = 3_000_000  # ns from a measurement to the log
START = 1_700_000_000_000_000_000  # ns
STEP = 1_000_000  # ns


def numbers(count):
    """Rows of time (ns), rate (rad/s), extension (m; none in every other row), valve (none but where it switches)."""
    for k in range(count):
        rate, extension = 5 * math.cos(0.01 * k), 0.001 * math.sin(0.3 * k)
        valve = {count // 4: 1, count // 2: 0}.get(k)
        yield START + k * STEP, rate, extension if k % 2 == 0 else None, valve


def stamp(ns):
    return {"sec": ns // 10**9, "nanosec": ns % 10**9}


def messages(count):
    """Topic, type, time and contents of every message."""
    for ns, rate, extension, valve in numbers(count):
        header = {"stamp": stamp(ns), "frame_id": "wheel"}
        vector = lambda y: {"x": 0.25, "y": y, "z": -0.5}
        yield "/imu", IMU, ns, {
            "header": header,
            "orientation": {"x": 0, "y": 0, "z": 0, "w": 1},
            "orientation_covariance": [0.0] * 9,
            "angular_velocity": vector(rate),
            "angular_velocity_covariance": [0.0] * 9,
            "linear_acceleration": vector(9.8),
            "linear_acceleration_covariance": [-1.0] + [0.0] * 8,
        }
        if extension is not None:
            yield "/joint_states", JOINTS, ns, {
                "header": header,
                "name": ["knee", "leg1"],
                "position": [1.5, extension],
                "velocity": [],
                "effort": [2.5, 3.5],
            }
        if valve is not None:
            yield "/valve", VALVE, ns, {"data": valve}


def official(path, compression, count=40):
    """A file of the official writer."""
    with open(path, "wb") as out:
        writer = Writer(out, compression=compression, chunk_size=4000 if count < 1000 else 1 << 20)
        schemas = {}
        for topic, name, ns, message in messages(count):
            if name not in schemas:
                text = STORE.generate_msgdef(name, ros_version=2)[0]
                schemas[name] = writer.register_msgdef(name, text)
            writer.write_message(topic, schemas[name], message, ns + LATE, ns + LATE)
        writer.finish()


def made(name, contents):
    """A message of rosbags' own."""
    fields = STORE.fielddefs[name][1]
    values = []
    for field, (kind, what) in fields:
        value = contents[field]
        if kind.name == "NAME":
            value = made(what, value)
        elif kind.name in ("ARRAY", "SEQUENCE") and what[0][1][0] != "string":
            value = numpy.array(value, dtype=numpy.float64)
        values.append(value)
    return STORE.types[name](*values)


def unindexed(path, count=40):
    """A file of the official writer without chunks, index and summary."""
    with open(path, "wb") as out:
        no = dict(repeat_channels=False, repeat_schemas=False, use_statistics=False, use_summary_offsets=False)
        writer = McapWriter(out, use_chunking=False, index_types=IndexType.NONE, enable_data_crcs=True, **no)
        writer.start(profile="ros2", library="fixtures")
        channels = {}
        for topic, name, ns, message in messages(count):
            if topic not in channels:
                text = STORE.generate_msgdef(name, ros_version=2)[0]
                schema = writer.register_schema(name, "ros2msg", text.encode())
                channels[topic] = writer.register_channel(topic, "cdr", schema)
            data = bytes(STORE.serialize_cdr(made(name, message), name))
            writer.add_message(channels[topic], ns + LATE, data, ns + LATE)
        writer.finish()


def rosbag2(path, count=40, **compressed):
    """The MCAP file of a rosbag2 by rosbags."""
    with tempfile.TemporaryDirectory() as folder:
        place = pathlib.Path(folder) / "bag"
        bag = Bag(place, version=9, storage_plugin=StoragePlugin.MCAP)
        if compressed:
            bag.set_compression(**compressed)
        with bag:
            connections = {}
            for topic, name, ns, message in messages(count):
                if topic not in connections:
                    connections[topic] = bag.add_connection(topic, name, typestore=STORE)
                bag.write(connections[topic], ns + LATE, STORE.serialize_cdr(made(name, message), name))
        shutil.copy(next(place.glob("*.mcap")), path)


def idl(path):
    """A message whose definition is not of ros2msg."""
    with open(path, "wb") as out:
        writer = McapWriter(out)
        writer.start(profile="ros2", library="fixtures")
        text = "module std_msgs { module msg { struct UInt8 { uint8 data; }; }; };"
        channel = writer.register_channel("/valve", "cdr", writer.register_schema(VALVE, "ros2idl", text.encode()))
        writer.add_message(channel, START, bytes([0, 1, 0, 0, 1]), START)
        writer.finish()


def all_files(folder, count=40):
    """Every file that Saltus reads; one that it does not is in the folder `foreign`."""
    folder = pathlib.Path(folder)
    (folder / "foreign").mkdir(exist_ok=True)
    idl(folder / "foreign/ros2idl.mcap")
    for name, compression in [("none", CompressionType.NONE), ("zstd", CompressionType.ZSTD), ("lz4", CompressionType.LZ4)]:
        official(folder / f"{name}.mcap", compression, count)
    unindexed(folder / "unindexed.mcap", count)
    rosbag2(folder / "rosbag2.mcap", count)
    rosbag2(folder / "rosbag2_zstd.mcap", count, mode=CompressionMode.STORAGE, fmt=CompressionFormat.ZSTD)
    return sorted(folder.glob("*.mcap"))


if __name__ == "__main__":
    for file in all_files(sys.argv[1]):
        print(file, file.stat().st_size)
