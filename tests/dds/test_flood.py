"""A camera faster than the detection: frames are dropped and counted, and the results stay recent."""

from itertools import cycle

from robot import Camera
from sequence import Sequence

FLOOD = 60


def test_frames_that_cannot_be_looked_at_are_dropped_not_queued(camera: Camera, sequence: Sequence) -> None:
    sent = []
    frames = cycle([camera.image(frame.pixels) for frame in sequence.frames[:6]])

    def flood() -> bool:
        for image in (next(frames) for _ in range(FLOOD)):
            image.header = camera.image(sequence.frames[0].pixels[:1]).header
            sent.append(image.header.stamp)
            camera.publish(image)
        return camera.statuses[-1].frames_dropped > 0

    camera.robot.until(flood, "a status that counts dropped frames")
    late = len(camera.centres)
    last = camera.show(sequence.frames[0].pixels)

    # what was still looked at after the flood is little: nothing is queued but the newest frame
    assert len(camera.centres) - late < FLOOD
    status = camera.status(lambda s: s.header == last.header, "the last frame")
    assert status.frames_received == status.frames_processed + status.frames_dropped
    assert status.frames_received <= len(sent) + 4
    stamps = [(c.header.stamp.sec, c.header.stamp.nanosec) for c in camera.centres]
    assert stamps == sorted(stamps)
