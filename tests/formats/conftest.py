"""Camera files as ringcal writes them, for the tests that read them with other programs."""

import json
import os
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
BINARY = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "ringcal"
BOARD = ROOT / "config" / "a4.yaml"


def ringcal(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([BINARY, *arguments], capture_output=True, text=True)


@dataclass(frozen=True)
class Camera:
    """A camera with numbers that need every digit."""

    model: str
    pinhole: tuple[float, float, float, float] = (1110.123456789012, 1108.0000000000002, 651.1, 472.3)
    coefficients: tuple[float, ...] = ()
    size: tuple[int, int] = (1280, 960)

    @property
    def matrix(self) -> list[list[float]]:
        fx, fy, cx, cy = self.pinhole
        return [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]

    def write(self, path: Path) -> None:
        """As truth.json, which needs no format of another program."""
        names = {
            "plumb_bob": "k1 k2 p1 p2 k3",
            "rational_polynomial": "k1 k2 p1 p2 k3 k4 k5 k6",
            "equidistant": "k1 k2 k3 k4",
        }[self.model]
        values = zip(["fx", "fy", "cx", "cy", *names.split()], [*self.pinhole, *self.coefficients], strict=True)
        width, height = self.size
        camera = {"model": self.model, "width": width, "height": height, "parameters": dict(values)}
        path.write_text(json.dumps({"camera": camera}))


PLUMB_BOB = Camera("plumb_bob", coefficients=(-0.21000000000000002, 0.07, 8e-4, -5.1e-7, -1 / 3))
RADTAN = Camera("plumb_bob", coefficients=(-0.21000000000000002, 0.07, 8e-4, -5.1e-7, 0.0))
RATIONAL = Camera("rational_polynomial", coefficients=(0.3, 0.1, 8e-4, -5.1e-7, 1 / 3, 0.5, 0.2, 1e-22))
FISHEYE = Camera("equidistant", coefficients=(-0.02, 1 / 3, -3e-3, 4.5e-5))
CAMERAS = {"plumb_bob": PLUMB_BOB, "radtan": RADTAN, "rational": RATIONAL, "fisheye": FISHEYE}

Convert = Callable[[Camera, str], Path]


@pytest.fixture
def convert(tmp_path: Path) -> Convert:
    """Writes a camera to a file of this name, in the format that the name asks for."""

    def write(camera: Camera, name: str) -> Path:
        camera.write(tmp_path / "in.json")
        done = ringcal("convert", tmp_path / "in.json", tmp_path / name, "--camera-name", "front")
        assert done.returncode == 0, done.stderr
        return tmp_path / name

    return write


@pytest.fixture(params=CAMERAS)
def camera(request: pytest.FixtureRequest) -> Camera:
    return CAMERAS[request.param]
