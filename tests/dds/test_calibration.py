"""The main job: defocused views go in over DDS, the camera comes out."""

from dataclasses import dataclass

import numpy as np
import pytest
import yaml
from sensor_msgs.msg import CameraInfo
from std_srvs.srv import Trigger

from conftest import Start
from robot import LATCHED, Camera, Robot
from sequence import Sequence

from ringcal.msg import RingCentreArray


@dataclass
class Calibrated:
    """A node that has been shown the whole sequence and then asked to calibrate."""

    camera: Camera
    centres: list[RingCentreArray]  # of each frame of the sequence
    infos: list[CameraInfo]  # from a subscription older than the calibration
    answer: Trigger.Response


@pytest.fixture(scope="module")
def calibrated(start: Start, robot: Robot, sequence: Sequence, tmp_path_factory: pytest.TempPathFactory) -> Calibrated:
    folder = tmp_path_factory.mktemp("saved")
    start("-p", f"save_dir:={folder}", "-p", "camera_name:=bench_camera")
    camera = Camera(robot)
    infos = robot.listen(CameraInfo, "/ringcal/camera_info")
    centres = [camera.show(frame.pixels) for frame in sequence.frames]
    return Calibrated(camera, centres, infos, camera.trigger("calibrate"))


def test_every_frame_s_centres_are_where_they_were_rendered(calibrated: Calibrated, sequence: Sequence) -> None:
    errors = []
    for frame, found in zip(sequence.frames, calibrated.centres, strict=True):
        assert (found.rows, found.columns) == (5, 7)
        assert (found.width, found.height) == (sequence.width, sequence.height)
        assert found.indices_absolute and found.reason == ""
        assert [(c.row, c.column) for c in found.centres] == sorted(frame.centres)
        errors += [np.hypot(*np.subtract((c.x, c.y), frame.centres[c.row, c.column])) for c in found.centres]
    assert np.median(errors) < 0.05
    assert np.max(errors) < 0.3


def test_each_still_view_is_kept_once(calibrated: Calibrated, sequence: Sequence) -> None:
    views = len({frame.view for frame in sequence.frames})
    status = calibrated.camera.status(lambda s: s.state == "calibrated", "the state calibrated")
    assert status.views == views
    assert status.frames_failed == 0
    assert 0.3 < status.coverage <= 1
    assert 0 < status.rms < 0.5
    assert status.blur_sigma > 1


def test_the_calibration_finds_the_camera(calibrated: Calibrated, sequence: Sequence) -> None:
    assert calibrated.answer.success, calibrated.answer.message
    calibrated.camera.robot.until(lambda: calibrated.infos, "the camera_info of the calibration")
    info = calibrated.infos[-1]
    truth = sequence.camera
    assert (info.width, info.height) == (sequence.width, sequence.height)
    assert info.header.frame_id == "camera"
    assert info.distortion_model == "plumb_bob" and len(info.d) == 5
    fx, _, cx, _, fy, cy = info.k[:6]
    assert fx == pytest.approx(truth["fx"], rel=0.003) and fy == pytest.approx(truth["fy"], rel=0.003)
    assert cx == pytest.approx(truth["cx"], abs=3) and cy == pytest.approx(truth["cy"], abs=3)
    assert list(info.p) == [fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0]
    assert list(info.r) == [1, 0, 0, 0, 1, 0, 0, 0, 1]


def test_a_late_subscriber_gets_the_camera_info(calibrated: Calibrated, robot: Robot) -> None:
    late = robot.listen(CameraInfo, "/ringcal/camera_info", LATCHED)
    robot.until(lambda: late, "the latched camera_info")
    assert list(late[-1].k) == list(calibrated.infos[-1].k)


def test_a_frame_after_the_calibration_has_its_own_camera_info(calibrated: Calibrated, sequence: Sequence) -> None:
    image = calibrated.camera.image(sequence.frames[0].pixels)
    calibrated.camera.show(image)
    calibrated.camera.robot.until(
        lambda: any(info.header == image.header for info in calibrated.infos), "a camera_info with the frame's header"
    )


def test_save_writes_what_camera_drivers_read(calibrated: Calibrated) -> None:
    saved = calibrated.camera.trigger("save")
    assert saved.success, saved.message
    path = next(word.rstrip(".,;:") for word in saved.message.split() if word.endswith(".yaml"))
    with open(path) as file:
        content = yaml.safe_load(file)
    assert list(content)[:8] == [
        "image_width",
        "image_height",
        "camera_name",
        "camera_matrix",
        "distortion_model",
        "distortion_coefficients",
        "rectification_matrix",
        "projection_matrix",
    ]
    info = calibrated.infos[-1]
    assert content["camera_name"] == "bench_camera"
    assert (content["image_width"], content["image_height"]) == (info.width, info.height)
    assert content["distortion_model"] == info.distortion_model
    for key, shape, values in (
        ("camera_matrix", (3, 3), info.k),
        ("distortion_coefficients", (1, 5), info.d),
        ("rectification_matrix", (3, 3), info.r),
        ("projection_matrix", (3, 4), info.p),
    ):
        assert (content[key]["rows"], content[key]["cols"]) == shape
        assert content[key]["data"] == list(values)
