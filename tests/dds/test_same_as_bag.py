"""A recording gives what the live topic gave: the node and `ringcal calibrate` on a bag of the same messages agree to the last digit."""

import subprocess
from pathlib import Path

import yaml
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from conftest import Start
from ringcal_process import BINARY, BOARD
from robot import Camera, Robot
from sequence import Sequence

MESSAGE = "sensor_msgs/msg/Image"


def record(path: Path, topic: str, messages: list[bytes]) -> None:
    store = get_typestore(Stores.ROS2_HUMBLE)
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection(topic, MESSAGE, typestore=store)
        for at, message in enumerate(messages):
            writer.write(connection, at, message)


def test_a_bag_played_to_the_node_and_calibrated_offline_gives_the_same_numbers(
    start: Start, robot: Robot, sequence: Sequence, tmp_path: Path
) -> None:
    names = ("-r", "image:=/recorded/image", "-r", "__node:=recorded")
    start("-p", f"save_dir:={tmp_path / 'live'}", "-p", "camera_name:=camera", *names)
    camera = Camera(robot, "/recorded", "/recorded/image")
    images = [camera.image(frame.pixels) for frame in sequence.frames]
    for image in images:
        camera.show(image)
    # a frame that was lost on the way was sent again: what the node answered is what it saw
    by_stamp = {(image.header.stamp.sec, image.header.stamp.nanosec): image for image in images}
    seen = [by_stamp[c.header.stamp.sec, c.header.stamp.nanosec] for c in camera.centres]
    calibrated = camera.trigger("calibrate")
    assert calibrated.success, calibrated.message
    saved = camera.trigger("save")
    assert saved.success, saved.message
    (live,) = (tmp_path / "live").glob("*.yaml")

    record(tmp_path / "bag", "/recorded/image", [serialize_message(image) for image in seen])
    command = [BINARY, "calibrate", tmp_path / "bag", "--board", BOARD, "--output", tmp_path / "offline"]
    subprocess.run(command, check=True, capture_output=True)
    offline = tmp_path / "offline" / "camera_info.yaml"
    assert yaml.safe_load(offline.read_text()) == yaml.safe_load(live.read_text())
