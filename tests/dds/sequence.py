"""Frames that `ringcal simulate` rendered, and what is true of them."""

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image


FRAMES_PER_VIEW = 3


@dataclass(frozen=True)
class Frame:
    """One frame: its pixels, the number of its view, and where the rings' centres are, (row, column): (x, y) in px."""

    pixels: np.ndarray
    view: int
    centres: dict[tuple[int, int], tuple[float, float]]


@dataclass(frozen=True)
class Sequence:
    """What a camera sees while somebody moves the board from one place to the next and holds it still there."""

    width: int
    height: int
    camera: dict[str, float]  # fx, fy, cx, cy, k1, k2, p1, p2, k3
    frames: list[Frame]

    def view(self, number: int) -> list[Frame]:
        return [frame for frame in self.frames if frame.view == number]

    @classmethod
    def simulate(cls, binary: Path, board: Path, folder: Path) -> "Sequence":
        """Sixteen views of three frames each: blurred by 3 px, noisy, unevenly lit, seen through a lens that distorts."""
        options = (
            f"--views 16 --frames-per-view {FRAMES_PER_VIEW} --width 1280 --height 960 --fx 1210 --fy 1206 --cx 655 --cy 470 "
            "--distortion=-0.12,0.05,0.0004,-0.0006,0 --blur-sigma 3 --noise 0.01 --shading 0.2"
        )
        command = [binary, "simulate", "--board", board, "--output", folder, *options.split()]
        subprocess.run(command, check=True, capture_output=True)
        return cls.load(folder)

    @classmethod
    def load(cls, folder: Path) -> "Sequence":
        truth = json.loads((folder / "truth.json").read_text())
        camera = truth["camera"]
        frames = [
            Frame(
                pixels=np.asarray(Image.open(folder / frame["source"])),
                view=number // FRAMES_PER_VIEW,
                centres={(ring["row"], ring["col"]): (ring["x"], ring["y"]) for ring in frame["rings"]},
            )
            for number, frame in enumerate(truth["views"])
        ]
        return cls(camera["width"], camera["height"], camera["parameters"], frames)
