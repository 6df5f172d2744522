"""A camera faster than the detection: frames are dropped and counted, and the results stay recent."""

from itertools import cycle, islice

import numpy as np

from robot import ATTEMPTS, Camera
from sequence import Sequence

FLOOD = 60


def test_frames_that_cannot_be_looked_at_are_dropped_not_queued(camera: Camera, sequence: Sequence) -> None:
    # small frames: they are sent a hundred times faster than they can be looked at
    small = [np.ascontiguousarray(frame.pixels[::2, ::2]) for frame in sequence.frames[:6]]
    sent = 0

    def flood() -> bool:
        nonlocal sent
        for pixels in islice(cycle(small), FLOOD):
            camera.publish(camera.image(pixels))
            sent += 1
        return camera.statuses[-1].frames_dropped > 0

    camera.robot.until(flood, "a status that counts dropped frames")
    before = len(camera.centres)
    last = camera.show(small[0])

    # nothing is queued but the newest frame, so little is still looked at after the flood
    assert len(camera.centres) - before < FLOOD / 2
    status = camera.status(lambda s: s.header == last.header, "the last frame")
    assert status.frames_received == status.frames_processed + status.frames_dropped
    assert status.frames_received <= sent + ATTEMPTS
    stamps = [(c.header.stamp.sec, c.header.stamp.nanosec) for c in camera.centres]
    assert stamps == sorted(stamps)
