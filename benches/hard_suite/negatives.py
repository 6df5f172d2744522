"""Frames that show no board, or another one than the file says."""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

import clutter
import optics
import sensor
from board import Board
from camera import turned
from kinds import Wish, common
from scene import frame_of

Floats = NDArray[np.float32]
Random = np.random.Generator

KINDS = "chessboard dots text leaves scattered hexagonal texture wrong_size shapes squares".split()
SIZE = 1600


def pattern(random: Random, kind: str, step: float) -> Floats:
    """A large flat picture, SIZE x SIZE, of things `step` px apart."""
    paper, print_ = (0.85, 0.07) if random.random() < 0.6 else (0.08, 0.8)
    picture = np.full((SIZE, SIZE), paper, np.float32)
    count = int(SIZE / step)
    if kind == "chessboard":
        for row in range(count + 1):
            for column in range(row % 2, count + 1, 2):
                corner = (int(column * step), int(row * step))
                cv2.rectangle(picture, corner, (int(corner[0] + step) - 1, int(corner[1] + step) - 1), print_, -1)
        return picture
    outer = step * random.uniform(0.2, 0.32)
    inner = outer * random.uniform(0.4, 0.6)
    for row in range(-1, count + 2):
        for column in range(-1, count + 2):
            x, y = column * step, row * step
            if kind == "hexagonal":
                x, y = x + step / 2 * (row % 2), y * np.sqrt(0.75)
            if kind == "scattered":
                x, y = x + random.uniform(-0.45, 0.45) * step, y + random.uniform(-0.45, 0.45) * step
            at = (int(16 * x), int(16 * y))
            if kind == "squares":
                for r, grey in ((outer, print_), (inner, paper)):
                    corners = np.int32([[at[0] + 16 * i * r, at[1] + 16 * j * r] for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
                    cv2.fillPoly(picture, [corners], grey, cv2.LINE_AA, 4)
                continue
            cv2.circle(picture, at, int(16 * outer), print_, -1, cv2.LINE_AA, 4)
            if kind != "dots":
                cv2.circle(picture, at, int(16 * inner), paper, -1, cv2.LINE_AA, 4)
    return picture


def flat(random: Random, kind: str, wish: Wish, step: float) -> Floats:
    """What the frame shows, on its fine grid."""
    margin = 0
    height, width = (wish.height + 2 * margin) * optics.SUB, (wish.width + 2 * margin) * optics.SUB
    size = step * optics.SUB
    if kind == "text":
        return clutter.text(random, height, width, size * 0.5)
    if kind == "leaves":
        return clutter.leaves(random, height, width, size * 0.7)
    if kind == "texture":
        return clutter.noise(random, height, width, random.uniform(1, 6) * optics.SUB)
    if kind == "shapes":
        return clutter.shapes(random, height, width, size)
    picture = pattern(random, kind, 64.0)
    rotation = turned(np.deg2rad(random.uniform(0, 40)), random.uniform(0, 6.3), random.uniform(0, 6.3))
    scale, depth = size / 64.0, 2.0 * width
    corners = np.float32([[0, 0], [SIZE, 0], [SIZE, SIZE], [0, SIZE]])
    space = np.c_[corners - SIZE / 2, np.zeros(4)] * scale @ rotation.T + [0, 0, depth]
    seen = space[:, :2] / space[:, 2:] * depth + [width / 2, height / 2]
    warp = cv2.getPerspectiveTransform(corners, np.float32(seen))
    behind = clutter.background(random, height, width, size, random.random() < 0.3)
    cover = cv2.warpPerspective(np.ones_like(picture), warp, (width, height))
    return behind * (1 - cover) + cover * cv2.warpPerspective(picture, warp, (width, height), flags=cv2.INTER_AREA)


def wrong_size(random: Random, wish: Wish) -> tuple[NDArray[np.uint8 | np.uint16], Board]:
    """A board of which the file says another number of rows or columns."""
    wish = replace(wish, extent=0.75, kind="wrong_size")
    grey, _, boards = frame_of(random, wish)
    change = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1)][int(random.integers(0, 5))]
    board = boards[0]
    return grey, replace(board, rows=max(3, board.rows + change[0]), columns=max(3, board.columns + change[1]))


def negative(random: Random, kind: str) -> tuple[NDArray[np.uint8 | np.uint16], Board]:
    """A frame, and the board that is looked for in it."""
    wish = common(random, kind)
    wish.blur_size = float(random.choice([0.0, 0.15, 0.3, 0.5])) * random.uniform(0.5, 1.0)
    if kind == "wrong_size":
        wish.blur_size = min(wish.blur_size, 0.3)
        return wrong_size(random, wish)
    pitch = 0.03
    board = Board(wish.rows, wish.columns, pitch, wish.radii[0] * pitch, wish.radii[1] * pitch, wish.polarity)
    step = float(random.uniform(0.05, 0.12)) * wish.width
    sharp = flat(random, kind, wish, step)
    light = optics.uniform(sharp, 0, wish.blur, wish.blur_size * step * 0.25)
    light = sensor.lit(random, light, wish.light_ratio, wish.width, wish.vignette)
    return sensor.exposed(random, light, wish.exposure, wish.noise, 0.0), board
