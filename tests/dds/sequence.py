"""Frames that `ringcal simulate` rendered, and what is true of them."""

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image


@dataclass(frozen=True)
class TrueCamera:
    """Pinhole parameters, px."""

    fx: float
    fy: float
    cx: float
    cy: float


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
    camera: TrueCamera
    frames: list[Frame]

    def view(self, number: int) -> list[Frame]:
        return [frame for frame in self.frames if frame.view == number]

    @classmethod
    def simulate(cls, binary: Path, board: Path, folder: Path) -> "Sequence":
        command = [binary, "simulate", "--board", board, "--output", folder, "--views", "16", "--frames-per-view", "3"]
        subprocess.run(command, check=True)
        return cls.load(folder)

    @classmethod
    def load(cls, folder: Path) -> "Sequence":
        truth = json.loads((folder / "truth.json").read_text())
        camera = truth["camera"]
        frames = [
            Frame(
                pixels=np.asarray(Image.open(folder / frame["image"]).convert("L")),
                view=frame["view"],
                centres={(ring["row"], ring["col"]): (ring["x"], ring["y"]) for ring in frame["rings"]},
            )
            for frame in truth["frames"]
        ]
        return cls(
            width=camera["width"],
            height=camera["height"],
            camera=TrueCamera(camera["fx"], camera["fy"], camera["cx"], camera["cy"]),
            frames=frames,
        )
