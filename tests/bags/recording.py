"""Simulated frames as rosbag2 recordings, written by the package `rosbags`."""

import json
import os
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

ROOT = Path(__file__).parents[2]
BINARY = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "ringcal"
BOARD = ROOT / "config" / "a4.yaml"
VIEWS, FRAMES_PER_VIEW = 25, 3
START_NS = 1_700_000_000_000_000_000
PERIOD_NS = 33_333_333

STORE = get_typestore(Stores.ROS2_HUMBLE)
RAW, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"


@dataclass(frozen=True)
class Frames:
    """What the camera saw, frame by frame, and its true parameters."""

    pixels: list[np.ndarray]
    camera: dict[str, float]

    @classmethod
    def simulate(cls, folder: Path) -> "Frames":
        options = (
            f"--views {VIEWS} --frames-per-view {FRAMES_PER_VIEW} --width 320 --height 240 --fx 330 --fy 328 --cx 163 --cy 117 "
            "--distortion=-0.1,0.03,0,0,0 --blur-sigma 1.5 --noise 0.01 --seed 3"
        )
        command = [BINARY, "simulate", "--board", BOARD, "--output", folder, *options.split()]
        subprocess.run(command, check=True, capture_output=True)
        truth = json.loads((folder / "truth.json").read_text())
        pixels = [np.asarray(Image.open(folder / view["source"])) for view in truth["views"]]
        return cls(pixels, truth["camera"]["parameters"])

    def film(self, times: int) -> list[np.ndarray]:
        """Every pose held for `times` as long: its frames again and again."""
        views = [self.pixels[at : at + FRAMES_PER_VIEW] for at in range(0, len(self.pixels), FRAMES_PER_VIEW)]
        return [frame for view in views for frame in view * times]


def header(at: int):
    time = START_NS + at * PERIOD_NS
    stamp = STORE.types["builtin_interfaces/msg/Time"](sec=time // 10**9, nanosec=time % 10**9)
    return STORE.types["std_msgs/msg/Header"](stamp=stamp, frame_id="camera")


def raw(at: int, pixels: np.ndarray) -> bytes:
    height, width = pixels.shape
    message = STORE.types[RAW](
        header=header(at), height=height, width=width, encoding="mono8", is_bigendian=0, step=width, data=pixels.reshape(-1)
    )
    return bytes(STORE.serialize_cdr(message, RAW))


def encoded(at: int, picture: bytes) -> bytes:
    data = np.frombuffer(picture, dtype=np.uint8)
    message = STORE.types[COMPRESSED](header=header(at), format="mono8; png compressed ", data=data)
    return bytes(STORE.serialize_cdr(message, COMPRESSED))


def write(
    path: Path,
    topics: dict[str, tuple[str, Iterable[bytes]]],
    storage: StoragePlugin = StoragePlugin.MCAP,
    compression: CompressionMode = CompressionMode.NONE,
) -> Path:
    """Writes a bag: by topic the message type and the messages."""
    writer = Writer(path, version=9, storage_plugin=storage)
    writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        for topic, (message_type, messages) in topics.items():
            connection = writer.add_connection(topic, message_type, typestore=STORE)
            for at, message in enumerate(messages):
                writer.write(connection, START_NS + at * PERIOD_NS, message)
    return path


def of_raw(frames: Iterable[np.ndarray]) -> tuple[str, Iterable[bytes]]:
    return RAW, (raw(at, pixels) for at, pixels in enumerate(frames))


def data_file(bag: Path) -> Path:
    """The only file of a bag beside its metadata.yaml."""
    (file,) = [path for path in bag.iterdir() if path.name != "metadata.yaml"]
    return file


def ringcal(*arguments: object) -> subprocess.CompletedProcess:
    return subprocess.run([BINARY, *map(str, arguments)], capture_output=True, text=True)


def calibrate(folder: Path, *arguments: object) -> tuple[dict, str]:
    """Calibrates in one command; calibration.json and what was said on the way."""
    done = ringcal("calibrate", *arguments, "--board", BOARD, "--output", folder / "out")
    assert done.returncode == 0, done.stderr
    return json.loads((folder / "out" / "calibration.json").read_text()), done.stderr
