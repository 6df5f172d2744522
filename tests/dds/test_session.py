"""What the services answer before there is a calibration, and what starts the collection anew."""

from robot import Camera
from sequence import Sequence


def test_calibrate_without_views_says_how_many_are_missing(camera: Camera) -> None:
    answer = camera.trigger("calibrate")
    assert not answer.success
    assert "0 of the 10 views" in answer.message
    camera.status(lambda s: s.last_result == answer.message, "the answer")


def test_save_without_a_calibration_says_so(camera: Camera) -> None:
    answer = camera.trigger("save")
    assert not answer.success
    assert "calibrat" in answer.message


def test_reset_forgets_the_views(camera: Camera, sequence: Sequence) -> None:
    for frame in sequence.view(0):
        camera.show(frame.pixels)
    camera.status(lambda s: s.views == 1 and s.state == "collecting", "one view")
    assert camera.trigger("reset").success
    status = camera.status(lambda s: s.views == 0, "no view")
    assert status.coverage == 0


def test_another_frame_size_starts_anew(camera: Camera, sequence: Sequence) -> None:
    frames = sequence.view(0)
    for frame in frames:
        camera.show(frame.pixels)
    camera.status(lambda s: s.views == 1, "one view")
    smaller = frames[0].pixels[:-2].copy()
    camera.show(smaller)
    camera.status(lambda s: s.views == 0 and " px" in s.guidance, "no view and the reason")
