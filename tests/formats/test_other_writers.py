"""ringcal reads what other programs write, and says what it cannot read or write."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from conftest import BOARD, CAMERAS, FISHEYE, PLUMB_BOB, RADTAN, RATIONAL, Camera, Convert, ringcal

COLUMNS, ROWS = 7, 5


def read_back(path: Path) -> dict:
    """What ringcal understood, as camera_info YAML."""
    done = ringcal("convert", path, "-", "--to", "camera_info")
    assert done.returncode == 0, done.stderr
    return yaml.safe_load(done.stdout)


def same(read: dict, camera: Camera) -> bool:
    return (
        (read["image_width"], read["image_height"]) == camera.size
        and np.reshape(read["camera_matrix"]["data"], (3, 3)).tolist() == camera.matrix
        and read["distortion_model"] == camera.model
        and read["distortion_coefficients"]["data"] == list(camera.coefficients)
    )


@pytest.mark.parametrize("ending", ["yaml", "json"])
def test_file_storage_of_opencv(camera: Camera, tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"out_camera_data.{ending}"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("calibration_time", "Wed Nov 25 22:41:35 2026")
    storage.write("image_width", camera.size[0])
    storage.write("image_height", camera.size[1])
    storage.write("fisheye_model", int(camera.model == "equidistant"))
    storage.write("camera_matrix", np.array(camera.matrix))
    storage.write("distortion_coefficients", np.array(camera.coefficients))
    storage.write("avg_reprojection_error", 0.25)
    storage.release()
    assert same(read_back(path), camera)


def test_camera_info_of_pyyaml(convert: Convert, camera: Camera) -> None:
    path = convert(camera, "front.yaml")
    path.write_text(yaml.safe_dump(yaml.safe_load(path.read_text())))
    assert same(read_back(path), camera)


def test_a_chain_of_kalibr_one_camera_at_a_time(tmp_path: Path) -> None:
    def entry(camera: Camera, model: str) -> dict:
        return {
            "cam_overlaps": [1],
            "camera_model": "pinhole",
            "distortion_coeffs": list(camera.coefficients[:4]),
            "distortion_model": model,
            "intrinsics": list(camera.pinhole),
            "resolution": list(camera.size),
            "rostopic": "/eye/image_raw",
            "T_cn_cnm1": np.eye(4).tolist(),
        }

    path = tmp_path / "camchain-drive.yaml"
    path.write_text(yaml.dump({"cam0": entry(RADTAN, "radtan"), "cam1": entry(FISHEYE, "equidistant")}))
    for name, camera in [("cam0", RADTAN), ("cam1", FISHEYE)]:
        out = tmp_path / f"{name}.yaml"
        done = ringcal("convert", path, out, "--camera", name)
        assert done.returncode == 0, done.stderr
        assert same(yaml.safe_load(out.read_text()), camera)
    done = ringcal("convert", path, tmp_path / "both.yaml")
    assert done.returncode == 1 and "several cameras: cam0, cam1" in done.stderr
    assert not (tmp_path / "both.yaml").exists()


@pytest.mark.parametrize(
    ("camera", "name", "lacks"),
    [
        ("fisheye", "ost.txt", "ost.txt has no equidistant lens"),
        ("fisheye", "front.cameramodel", "mrcal has no equidistant lens"),
        ("plumb_bob", "camchain.yaml", "k3 = -0.3333333333333333"),
        ("rational", "camchain.yaml", "rational_polynomial lens has k3 = 0.3333333333333333, k4 = 0.5"),
    ],
)
def test_what_a_format_cannot_express_it_says(tmp_path: Path, camera: str, name: str, lacks: str) -> None:
    CAMERAS[camera].write(tmp_path / "in.json")
    done = ringcal("convert", tmp_path / "in.json", tmp_path / name)
    assert done.returncode == 1 and lacks in done.stderr, done.stderr
    assert not (tmp_path / name).exists()


def test_a_name_that_tells_no_format_is_wrong_usage(tmp_path: Path) -> None:
    PLUMB_BOB.write(tmp_path / "in.json")
    done = ringcal("convert", tmp_path / "in.json", tmp_path / "front.xml")
    assert done.returncode == 2 and "--to" in done.stderr


@pytest.mark.parametrize("camera", [PLUMB_BOB, RATIONAL, FISHEYE], ids=lambda camera: camera.model)
def test_opencv_projects_as_ringcal_does(convert: Convert, tmp_path: Path, camera: Camera) -> None:
    """Model, order of the coefficients and where a pixel begins are the same."""
    mild = Camera(camera.model, (640.5, 639.25, 320.25, 238.5), tuple(0.1 * k for k in camera.coefficients), (640, 480))
    path = convert(mild, "opencv.yaml")
    done = ringcal("simulate", "--board", BOARD, "--output", tmp_path / "frames", "--views", "3", "--camera-info", path)
    assert done.returncode == 0, done.stderr
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    matrix = storage.getNode("camera_matrix").mat()
    coefficients = storage.getNode("distortion_coefficients").mat()
    pitch = yaml.safe_load(BOARD.read_text())["pitch"]
    project = cv2.fisheye.projectPoints if storage.getNode("fisheye_model").real() else cv2.projectPoints
    for view in json.loads((tmp_path / "frames" / "truth.json").read_text())["views"]:
        board = np.array([[[ring["col"] * pitch, ring["row"] * pitch, 0.0] for ring in view["rings"]]])
        pose = [np.array(view[key]) for key in ("rotation_vector", "translation_m")]
        pixels = project(board, *pose, matrix, coefficients)[0].reshape(-1, 2)
        assert len(pixels) == ROWS * COLUMNS
        truth = [[ring["x"], ring["y"]] for ring in view["rings"]]
        assert np.abs(pixels - truth).max() < 1e-9
