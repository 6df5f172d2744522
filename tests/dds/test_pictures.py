"""The pictures for people: made only for those who look."""

import io

import numpy as np
import pytest
from PIL import Image as Picture
from sensor_msgs.msg import CompressedImage, Image

from robot import Camera, Robot
from sequence import Sequence


@pytest.mark.parametrize("topic", ["debug_image", "enhanced_image"])
def test_compressed_pictures_are_jpeg_of_the_frame_s_size(
    camera: Camera, robot: Robot, sequence: Sequence, topic: str
) -> None:
    name = f"/ringcal/{topic}/compressed"
    received = robot.listen(CompressedImage, name)
    message = _shown(camera, sequence, received)
    assert "jpeg" in message.format
    assert bytes(message.data[:3]) == b"\xff\xd8\xff"
    picture = Picture.open(io.BytesIO(bytes(message.data)))
    assert picture.size == (sequence.width, sequence.height)
    assert 2_000 < len(message.data) < 1_000_000
    assert np.asarray(picture.convert("L")).std() > 10


def test_the_overlay_is_in_colour_on_the_frame(camera: Camera, robot: Robot, sequence: Sequence) -> None:
    received = robot.listen(CompressedImage, "/ringcal/debug_image/compressed")
    message = _shown(camera, sequence, received)
    drawn = np.asarray(Picture.open(io.BytesIO(bytes(message.data))).convert("RGB")).astype(int)
    coloured = np.ptp(drawn, axis=2) > 60
    assert 0.0005 < coloured.mean() < 0.3
    # beneath it is the frame, its contrast stretched
    frame = sequence.frames[0].pixels
    assert np.corrcoef(drawn.mean(axis=2).ravel(), frame.ravel())[0, 1] > 0.9


@pytest.mark.parametrize("topic", ["debug_image", "enhanced_image"])
def test_raw_pictures_come_scaled_to_those_who_subscribe(
    camera: Camera, robot: Robot, sequence: Sequence, topic: str
) -> None:
    received = robot.listen(Image, f"/ringcal/{topic}")
    message = _shown(camera, sequence, received)
    assert (message.width, message.height) == (sequence.width // 2, sequence.height // 2)
    channels = {"mono8": 1, "rgb8": 3, "bgr8": 3}[message.encoding]
    assert message.step == message.width * channels
    assert len(message.data) == message.step * message.height


def _shown(camera: Camera, sequence: Sequence, received: list) -> CompressedImage | Image:
    """Shows the first frame until its picture arrives: the node may learn of a subscription after the first one."""
    for _ in range(12):
        image = camera.image(sequence.frames[0].pixels)
        camera.show(image)
        try:
            return camera.robot.until(
                lambda: next((p for p in received if p.header == image.header), None), "the picture", 5
            )
        except AssertionError:
            continue
    raise AssertionError(f"no picture of any frame; {len(received)} others")
