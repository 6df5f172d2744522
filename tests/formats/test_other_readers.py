"""The camera files in the eyes of other programs. Every number must come back to the last bit."""

import ast
from configparser import ConfigParser

import cv2
import numpy as np
import pytest
import yaml

from conftest import FISHEYE, PLUMB_BOB, RADTAN, RATIONAL, Camera, Convert


def test_camera_info_by_pyyaml(convert: Convert, camera: Camera) -> None:
    file = yaml.safe_load(convert(camera, "front.yaml").read_text())
    assert file["camera_name"] == "front"
    assert (file["image_width"], file["image_height"]) == camera.size
    assert np.reshape(file["camera_matrix"]["data"], (3, 3)).tolist() == camera.matrix
    assert file["distortion_model"] == camera.model
    assert file["distortion_coefficients"] == {
        "rows": 1,
        "cols": len(camera.coefficients),
        "data": list(camera.coefficients),
    }
    assert file["rectification_matrix"]["data"] == np.eye(3).ravel().tolist()
    assert np.reshape(file["projection_matrix"]["data"], (3, 4))[:, :3].tolist() == camera.matrix


@pytest.mark.parametrize("camera", [PLUMB_BOB, RATIONAL], ids=lambda camera: camera.model)
def test_ost_by_configparser(convert: Convert, camera: Camera) -> None:
    # keys without values, and lines that occur twice
    ini = ConfigParser(allow_no_value=True, strict=False)
    text = convert(camera, "ost.txt").read_text()
    ini.read_string(text)
    assert ini.sections() == ["image", "front"]
    width, height = camera.size
    assert list(ini["image"]) == ["width", str(width), "height", str(height)]
    assert {"camera matrix", "distortion", "rectification", "projection"} <= set(ini["front"])

    lines = text.splitlines()

    def below(key: str, rows: int) -> list[list[float]]:
        at = lines.index(key) + 1
        return [[float(word) for word in line.split()] for line in lines[at : at + rows]]

    assert below("camera matrix", 3) == camera.matrix
    assert below("distortion", 1) == [list(camera.coefficients)]
    assert below("rectification", 3) == np.eye(3).tolist()
    assert [row[:3] for row in below("projection", 3)] == camera.matrix


def test_opencv_by_file_storage(convert: Convert, camera: Camera) -> None:
    storage = cv2.FileStorage(str(convert(camera, "opencv.yaml")), cv2.FILE_STORAGE_READ)
    assert storage.getNode("camera_name").string() == "front"
    assert (storage.getNode("image_width").real(), storage.getNode("image_height").real()) == camera.size
    assert storage.getNode("fisheye_model").real() == (camera.model == "equidistant")
    assert storage.getNode("camera_matrix").mat().tolist() == camera.matrix
    assert storage.getNode("distortion_coefficients").mat().ravel().tolist() == list(camera.coefficients)


@pytest.mark.parametrize("camera", [RADTAN, FISHEYE], ids=lambda camera: camera.model)
def test_kalibr_by_pyyaml(convert: Convert, camera: Camera) -> None:
    chain = yaml.safe_load(convert(camera, "camchain.yaml").read_text())
    assert chain == {
        "cam0": {
            "camera_model": "pinhole",
            "intrinsics": list(camera.pinhole),
            "distortion_model": {"plumb_bob": "radtan"}.get(camera.model, camera.model),
            "distortion_coeffs": list(camera.coefficients[:4]),
            "resolution": list(camera.size),
            "rostopic": "/front/image_raw",
        }
    }
    # Kalibr refuses integers here
    assert all(isinstance(number, float) for number in chain["cam0"]["intrinsics"])


@pytest.mark.parametrize("camera", [PLUMB_BOB, RATIONAL], ids=lambda camera: camera.model)
def test_mrcal_by_python(convert: Convert, camera: Camera) -> None:
    # mrcal itself reads its files so
    model = ast.literal_eval(convert(camera, "front.cameramodel").read_text())
    assert model == {
        "lensmodel": f"LENSMODEL_OPENCV{len(camera.coefficients)}",
        "intrinsics": [*camera.pinhole, *camera.coefficients],
        "extrinsics": [0] * 6,
        "imagersize": list(camera.size),
    }
