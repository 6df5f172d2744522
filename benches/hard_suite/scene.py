"""A wish made a frame with its truth."""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

import clutter
import optics
import sensor
from board import Board, ink, sheet, slopes
from camera import Camera, Pose, turned
from kinds import Wish

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Random = np.random.Generator

FREE_OF_HAND = 0.002


@dataclass
class Shown:
    """One board in a frame."""

    board: Board
    camera: Camera
    pose: Pose

    def centres(self) -> Array:
        return self.camera.project(self.pose.points(self.board.centres()))

    def outlines(self) -> Array:
        """The outer circle of every ring, rings x points x 2, px."""
        rows, columns = self.board.rows, self.board.columns
        rings = [self.board.outline(row, column) for row in range(rows) for column in range(columns)]
        return np.stack([self.camera.project(self.pose.points(ring)) for ring in rings])


def camera_of(random: Random, wish: Wish) -> Camera:
    p = random.uniform(-0.001, 0.001, 2) if wish.lens == "plumb_bob" else (0.0, 0.0)
    lens = (wish.bend, float(random.uniform(-0.02, 0.02)) * (wish.lens == "plumb_bob"), float(p[0]), float(p[1]))
    centre = (wish.width / 2 + random.uniform(-8, 8), wish.height / 2 + random.uniform(-8, 8))
    return Camera(wish.width, wish.height, wish.focal * wish.width, *centre, wish.lens, lens)


def board_of(random: Random, wish: Wish) -> Board:
    rows, columns = wish.rows, wish.columns
    marks: tuple[tuple[int, int], ...] = ((0, 0), (0, 1), (1, 0)) if wish.marks else ()
    pitch = 0.03
    return Board(rows, columns, pitch, wish.radii[0] * pitch, wish.radii[1] * pitch, wish.polarity, marks, wish.margin)


def pose_of(random: Random, wish: Wish, camera: Camera, board: Board, towards: tuple[float, float]) -> Pose:
    """A pose at which the board is as large as wished, its middle seen at the pixel `towards`."""
    roll = random.uniform(-np.pi, np.pi)
    rotation = turned(np.deg2rad(wish.tilt_deg), random.uniform(0, 2 * np.pi), roll)
    x, y = camera.rays(np.array([towards[0]]), np.array([towards[1]]))
    ray = np.array([float(x[0]), float(y[0]), 1.0])

    def at(depth: float) -> Pose:
        return Pose(rotation, ray * depth - rotation[:, :2] @ board.middle())

    def size(depth: float) -> float:
        shown = Shown(board, camera, at(depth))
        if np.any(at(depth).points(board.centres())[:, 2] < 0.1 * depth) or not np.all(np.isfinite(shown.outlines())):
            return 1e9
        if wish.ring_px:
            outlines = shown.outlines()
            spans = np.linalg.norm(outlines - np.roll(outlines, 24, axis=1), axis=2).max(axis=1)
            return float(np.median(spans)) / wish.ring_px
        spread = np.ptp(shown.outlines().reshape(-1, 2), axis=0)
        return float(max(spread[0] / wish.width, spread[1] / wish.height)) / wish.extent

    near, far = 0.01, 20.0
    for _ in range(60):
        middle = np.sqrt(near * far)
        near, far = (middle, far) if size(middle) > 1 else (near, middle)
    return at(far)


def printed(random: Random, wish: Wish, shown: list[Shown], margin: int, ring_px: float) -> tuple[Floats, Floats]:
    """The sharp picture on the fine grid, linear light, and how much of it is hand."""
    camera = shown[0].camera
    u, v = optics.sub_grid(camera.width, camera.height, margin)
    x, y = camera.rays(u, v)
    beyond = ~np.isfinite(x)
    x, y = np.where(beyond, 0, x), np.where(beyond, 0, y)
    picture = clutter.background(random, *u.shape, ring_px * optics.SUB, wish.busy)
    light, dark = random.uniform(0.75, 0.9), random.uniform(0.04, 0.15)
    for one in reversed(shown):
        px, py, inverse_depth = one.pose.on_plane(x, y)
        behind = (inverse_depth <= 0) | beyond
        slope = (*slopes(px), *slopes(py))
        paper, print_ = (light, dark) if one.board.polarity == "dark_on_light" else (dark, light)
        covers = np.where(behind, 0, sheet(one.board, px, py, slope))
        printed_ = np.where(behind, 0, ink(one.board, px, py, slope))
        picture = (picture * (1 - covers) + covers * (paper + (print_ - paper) * printed_)).astype(np.float32)
    over = np.zeros_like(picture)
    if wish.hand:
        outline = shown[0].outlines().reshape(-1, 2)
        hull = cv2.convexHull(outline.astype(np.float32))[:, 0].astype(np.float64)
        for polygon in clutter.hand(random, hull):
            fine = (polygon + margin) * optics.SUB + (optics.SUB - 1) / 2
            cv2.fillPoly(over, [np.int32(np.round(fine * 16))], 1.0, cv2.LINE_AA, 4)
        picture = picture * (1 - over) + over * random.uniform(0.25, 0.6)
    return picture, over


def blur_sizes(wish: Wish, one: Shown, size_px: float) -> Floats:
    """Size of the blur at each pixel, px."""
    camera = one.camera
    u, v = np.meshgrid(np.arange(camera.width, dtype=float), np.arange(camera.height, dtype=float))
    x, y = camera.rays(u, v)
    near = one.pose.points(one.board.middle()[None])[0, 2]
    # a plane behind the camera, or beyond the lens's fold, shows nothing: any size will do
    inverse = np.nan_to_num(one.pose.on_plane(x, y)[2] * near, nan=1.0)
    return (size_px * (1 + wish.blur_change * (np.clip(inverse, 0.2, 3.0) - 1))).astype(np.float32)


def frame_of(random: Random, wish: Wish) -> tuple[NDArray[np.uint8 | np.uint16], list[dict[str, object]], list[Board]]:
    """The frame, the truth of each ring of each board (that of the first board first), and the boards."""
    camera, board = camera_of(random, wish), board_of(random, wish)
    shift = random.uniform(-wish.off, wish.off, 2) if wish.off else np.zeros(2)
    middle = ((0.5 + shift[0]) * wish.width, (0.5 + shift[1]) * wish.height)
    shown = [Shown(board, camera, pose_of(random, wish, camera, board, middle))]
    if wish.second:
        shown = both(random, wish, camera, board)
    spans = shown[0].outlines()
    ring_px = float(np.median(np.linalg.norm(spans - np.roll(spans, 24, axis=1), axis=2)))
    size_px = wish.blur_size * ring_px / 2
    sizes = blur_sizes(wish, shown[0], size_px) if wish.blur_change else np.full((1, 1), size_px, np.float32)
    reach = 1.1 if wish.blur == "disc" else 4.2
    margin = int(np.ceil(float(np.abs(sizes).max()) * reach)) + 3
    sharp, over = printed(random, wish, shown, margin, ring_px)
    if wish.blur_change:
        light, hidden = (optics.gathered(p, margin, wish.blur, sizes) for p in (sharp, over)) if wish.hand else (
            optics.gathered(sharp, margin, wish.blur, sizes), None)
    else:
        light = optics.uniform(sharp, margin, wish.blur, size_px)
        hidden = optics.uniform(over, margin, wish.blur, size_px) if wish.hand else None
    grid = np.ptp(spans.reshape(-1, 2), axis=0)
    light = sensor.lit(random, light, wish.light_ratio, float(min(grid.max(), wish.width)), wish.vignette)
    grey = sensor.exposed(random, light, wish.exposure, wish.noise, wish.depth16, wish.black)
    wish.notes = {"ring_px": ring_px, "blur_px": size_px, "rows": board.rows, "columns": board.columns}
    return grey, [truth(one, hidden, sizes) for one in shown], [one.board for one in shown]


def both(random: Random, wish: Wish, camera: Camera, board: Board) -> list[Shown]:
    """Two equal boards side by side, the first one larger."""
    wish = replace(wish, extent=0.45, tilt_deg=min(wish.tilt_deg, 15))
    left = random.random() < 0.5
    places = [(0.27, 0.5), (0.77, 0.5)] if left else [(0.73, 0.5), (0.23, 0.5)]
    at = [(x * wish.width, y * wish.height) for x, y in places]
    large = Shown(board, camera, pose_of(random, wish, camera, board, at[0]))
    small = Shown(board, camera, pose_of(random, replace(wish, extent=0.3), camera, board, at[1]))
    return [large, small]


def truth(one: Shown, hidden: Floats | None, sizes: Floats) -> dict[str, object]:
    """Where each ring is and whether all of it shows."""
    camera, rings = one.camera, []
    centres, outlines = one.centres(), one.outlines()
    for at, (centre, outline) in enumerate(zip(centres, outlines)):
        low, high = outline.min(axis=0), outline.max(axis=0)
        within = bool(low.min() >= 0 and high[0] <= camera.width - 1 and high[1] <= camera.height - 1)
        x0, y0 = np.clip(np.floor(low).astype(int), 0, None)
        x1, y1 = np.ceil(high).astype(int) + 1
        if hidden is not None and within:
            within = float(hidden[y0:y1, x0:x1].max()) < FREE_OF_HAND
        row, column = divmod(at, one.board.columns)
        mark = (row, column) in one.board.marks
        rings.append({"row": row, "col": column, "x": float(centre[0]), "y": float(centre[1]), "whole": within, "mark": mark})
    return {"rows": one.board.rows, "columns": one.board.columns, "marks": bool(one.board.marks), "rings": rings}
