#!/usr/bin/env python3
"""The standard message definitions of `telemetry/definitions`, as rosbags has them for ROS 2 Jazzy.

    target/mcap-python/bin/python tests/mcap/definitions.py            # compares; exit code 1 where one differs
    target/mcap-python/bin/python tests/mcap/definitions.py --write    # writes them
"""

import pathlib
import sys

from rosbags.typesys import Stores, get_typestore

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "telemetry/definitions"
NAMES = [
    "geometry_msgs/msg/WrenchStamped",
    "rcl_interfaces/msg/Log",
    "sensor_msgs/msg/Imu",
    "sensor_msgs/msg/JointState",
    "std_msgs/msg/String",
    "tf2_msgs/msg/TFMessage",
    "visualization_msgs/msg/MarkerArray",
]


def definitions():
    """The text of each file by its name."""
    store = get_typestore(Stores.ROS2_JAZZY)
    return {name.replace("/msg/", "_") + ".msg": store.generate_msgdef(name, ros_version=2)[0] for name in NAMES}


def differing():
    """Names of the files that are not what they should be; those that nobody asked for, too."""
    wanted = definitions()
    there = {file.name: file.read_text() for file in FOLDER.iterdir()}
    return sorted(name for name in wanted.keys() | there.keys() if wanted.get(name) != there.get(name))


if __name__ == "__main__":
    if "--write" in sys.argv:
        for name, text in definitions().items():
            (FOLDER / name).write_text(text)
    if found := differing():
        sys.exit(f"not as rosbags has them: {', '.join(found)}")
