"""calibration.json against its schema, and the other formats beside it."""

import copy
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
import yaml

from conftest import BOARD, ROOT, ringcal

SCHEMA = json.loads((ROOT / "docs" / "calibration.schema.json").read_text())


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Views of the board, and two files that cannot be used."""
    folder = tmp_path_factory.mktemp("frames")
    options = "--views 12 --width 320 --height 240 --focal-px 330 --distortion=-0.1,0.03,0,0,0 --blur-sigma 1 --noise 0.01"
    done = ringcal("simulate", "--board", BOARD, "--output", folder, *options.split())
    assert done.returncode == 0, done.stderr
    (folder / "view_003.png").write_bytes(b"no picture")
    (folder / "empty.pgm").write_bytes(b"P5 320 240 255\n" + bytes(320 * 240))
    return folder


def calibrate(frames: Path, folder: Path, *options: str) -> dict[str, Any]:
    done = ringcal("calibrate", frames, "--board", BOARD, "--output", folder, *options)
    assert done.returncode == 0, done.stderr
    return json.loads((folder / "calibration.json").read_text())


def closed(schema: dict[str, Any]) -> dict[str, Any]:
    """The schema with no room for keys that it does not describe."""
    schema = copy.deepcopy(schema)

    def objects(part: Any) -> Iterator[dict[str, Any]]:
        if isinstance(part, dict):
            yield part
        for inner in part.values() if isinstance(part, dict) else part if isinstance(part, list) else ():
            yield from objects(inner)

    for part in objects(schema):
        if part.get("type") == "object" and "properties" in part:
            part["additionalProperties"] = False
    return schema


def validate(file: dict[str, Any]) -> None:
    jsonschema.Draft202012Validator(closed(SCHEMA)).validate(file)


def test_the_schema_is_one() -> None:
    jsonschema.Draft202012Validator.check_schema(SCHEMA)


@pytest.mark.parametrize(
    "options",
    [
        "",
        "--model rational_polynomial --fix k4,k5,k6",
        "--model equidistant --estimator cross --fix k3,k4",
        "--bow --pitch-ratio --estimator big_ellipse",
    ],
)
def test_what_is_written_obeys_the_schema(frames: Path, tmp_path: Path, options: str) -> None:
    file = calibrate(frames, tmp_path, *options.split())
    validate(file)
    views = {Path(view["source"]).name: view for view in file["views"]}
    assert len(views) == 13
    assert not views["view_003.png"]["used"] and not views["empty.pgm"]["used"]
    assert np.shape(file["covariance"]) == (len(file["names"]), len(file["names"]))
    assert set(file["parameters"]) == set(file["std"]) == set(file["names"])


def test_the_schema_refuses_what_is_none(frames: Path, tmp_path: Path) -> None:
    file = calibrate(frames, tmp_path)
    used = next(at for at, view in enumerate(file["views"]) if view["used"])
    for spoil in (
        lambda f: f.pop("model"),
        lambda f: f.update(model="fisheye"),
        lambda f: f.update(surprise=1),
        lambda f: f["parameters"].pop("k3"),
        lambda f: f["parameters"].update(fx=None),
        lambda f: f["views"][used].update(rms_px=None),
        lambda f: f["views"][used]["rings"][0].update(row=-1),
    ):
        spoilt = copy.deepcopy(file)
        spoil(spoilt)
        with pytest.raises(jsonschema.ValidationError):
            validate(spoilt)


def test_a_refused_calibration_leaves_the_report_alone(frames: Path, tmp_path: Path) -> None:
    done = ringcal("calibrate", frames / "empty.pgm", "--board", BOARD, "--output", tmp_path)
    assert done.returncode == 1
    assert [path.name for path in tmp_path.iterdir()] == ["report.html"]


def test_other_formats_come_beside_it(frames: Path, tmp_path: Path) -> None:
    file = calibrate(frames, tmp_path, "--fix", "radial=2", "--also", "ost,opencv,kalibr,mrcal", "--camera-name", "front")
    written = {path.name for path in tmp_path.iterdir()}
    others = {"ost.txt", "opencv.yaml", "camchain.yaml", "camera.cameramodel"}
    assert written == others | {"camera_info.yaml", "calibration.json", "report.html"}
    for name in [*others, "calibration.json"]:
        done = ringcal("convert", tmp_path / name, "-", "--to", "camera_info", "--camera-name", "front")
        assert done.stdout == (tmp_path / "camera_info.yaml").read_text(), name
    assert yaml.safe_load(done.stdout)["camera_matrix"]["data"][0] == file["parameters"]["fx"]


def test_a_format_that_cannot_express_it_is_told_and_the_rest_is_there(frames: Path, tmp_path: Path) -> None:
    options = ["--model", "equidistant", "--also", "mrcal,kalibr"]
    done = ringcal("calibrate", frames, "--board", BOARD, "--output", tmp_path, *options)
    assert done.returncode == 1
    assert "camera.cameramodel is not written: mrcal has no equidistant lens" in done.stderr
    written = {path.name for path in tmp_path.iterdir()}
    assert written == {"camera_info.yaml", "calibration.json", "report.html", "camchain.yaml"}
