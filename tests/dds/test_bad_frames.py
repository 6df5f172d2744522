"""Frames that nothing can be found in: the node says why, and lives on."""

from collections.abc import Callable

import numpy as np
import pytest
from sensor_msgs.msg import Image

from ringcal_process import RingcalProcess
from robot import Camera
from sequence import Sequence

from ringcal.msg import CalibrationStatus


def _grey(height: int = 48, width: int = 64) -> np.ndarray:
    return np.full((height, width), 128, np.uint8)


def test_a_frame_without_a_board_has_no_centres_but_a_reason(camera: Camera) -> None:
    noise = np.random.default_rng(1).integers(0, 255, (480, 640)).astype(np.uint8)
    for pixels in (_grey(480, 640), noise):
        found = camera.show(pixels)
        assert len(found.centres) == 0 and not found.indices_absolute
        assert (found.width, found.height, found.rows, found.columns) == (640, 480, 5, 7)
        assert found.reason
    camera.status(lambda s: not s.board_found and s.frames_processed >= 2 and s.views == 0, "no board")


def _unknown_encoding(image: Image) -> None:
    image.encoding = "mono9"


def _too_little_data(image: Image) -> None:
    image.data = image.data[:-1]


def _size_that_lies(image: Image) -> None:
    image.width = image.height = 2**32 - 1


def _rows_that_overlap(image: Image) -> None:
    image.step = 1


def _empty(image: Image) -> None:
    image.width = image.height = image.step = 0
    image.data = []


@pytest.mark.parametrize("spoil", [_unknown_encoding, _too_little_data, _size_that_lies, _rows_that_overlap, _empty])
def test_a_broken_frame_is_counted_and_explained(camera: Camera, ringcal: RingcalProcess, spoil: Callable[[Image], None]) -> None:
    failed = camera.statuses[-1].frames_failed
    image = camera.image(_grey())
    spoil(image)
    found = camera.show(image)
    assert len(found.centres) == 0 and found.reason

    def counted(status: CalibrationStatus) -> bool:
        return status.frames_failed > failed and status.last_error == found.reason

    camera.status(counted, "the failed frame")
    assert ringcal.is_running()


def test_the_next_good_frame_is_read(camera: Camera, sequence: Sequence) -> None:
    assert len(camera.show(sequence.frames[0].pixels).centres) == 35


def test_colour_and_16_bit_frames_show_the_same_board(camera: Camera, sequence: Sequence) -> None:
    grey = sequence.frames[0].pixels
    expected = camera.show(grey)
    deep = camera.image(grey.astype(np.uint16) * 257, encoding="mono16")
    colour = camera.image(np.repeat(grey[:, :, None], 3, axis=2), encoding="bgr8")
    for image in (deep, colour):
        found = camera.show(image)
        assert [(c.row, c.column) for c in found.centres] == [(c.row, c.column) for c in expected.centres]
        for one, other in zip(found.centres, expected.centres, strict=True):
            assert one.x == pytest.approx(other.x, abs=0.02) and one.y == pytest.approx(other.y, abs=0.02)
