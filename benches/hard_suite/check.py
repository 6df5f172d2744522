"""Whether the renderer is right, before anything is said of a detector: python check.py

What a symmetric blur cannot move is the centroid of a figure seen from straight ahead; where blur varies, the gathered light
is set beside rays traced through the aperture one by one, drawn at random.
"""

import cv2
import numpy as np

import optics
from board import Board, ink, slopes
from camera import Camera, Pose, turned
from kinds import Wish
from scene import Shown, blur_sizes

RAYS = 1_000_000


def frontal() -> None:
    """Centroids of rings seen from straight ahead, sharp and blurred."""
    camera = Camera(400, 300, 420.0, 197.3, 151.6)
    board = Board(3, 4, 0.03, 0.003, 0.007)
    pose = Pose(turned(0.0, 0.0, 0.3), np.array([-0.031, -0.041, 0.16]))
    shown = Shown(board, camera, pose)
    for kind, size in (("gaussian", 0.0), ("gaussian", 3.3), ("disc", 5.2), ("disc gathered", 5.2), ("gaussian gathered", 3.3)):
        margin = 20
        x, y = camera.rays(*optics.sub_grid(camera.width, camera.height, margin))
        px, py, _ = pose.on_plane(x, y)
        sharp = ink(board, px, py, (*slopes(px), *slopes(py)))
        name, how = kind.split()[0], optics.gathered if "gathered" in kind else optics.uniform
        light = how(sharp, margin, name, np.full((300, 400), size, np.float32) if "gathered" in kind else size)
        worst = 0.0
        for centre in shown.centres():
            u, v = np.meshgrid(np.arange(400) - centre[0], np.arange(300) - centre[1])
            # half-way to the neighbours there is no ink
            weight = light * (np.hypot(u, v) < 39)
            worst = max(worst, float(np.hypot((weight * u).sum(), (weight * v).sum()) / weight.sum()))
        print(f"{kind:18s} {size:4.1f} px: centroids within {worst:.5f} px")


def traced() -> None:
    """Pixels of a tilted board beside rays through random points of the pixel and of the aperture."""
    random = np.random.default_rng(1)
    camera = Camera(160, 120, 170.0, 80.0, 60.0)
    board = Board(3, 4, 0.03, 0.003, 0.007)
    rotation = turned(0.8, 0.5, 0.2)
    pose = Pose(rotation, np.array([0, 0, 0.14]) - rotation[:, :2] @ board.middle())
    wish = Wish("check", blur_change=3.0)
    shown = Shown(board, camera, pose)
    for kind in ("disc", "gaussian"):
        sizes = blur_sizes(wish, shown, 3.0)
        x, y = camera.rays(*optics.sub_grid(160, 120, 40))
        px, py, _ = pose.on_plane(x, y)
        light = optics.gathered(ink(board, px, py, (*slopes(px), *slopes(py))), 40, kind, sizes)
        near = pose.points(board.middle()[None])[0, 2]
        worst = []
        for u, v in random.integers((30, 25), (130, 95), (40, 2)):
            if not 0.05 < light[v, u] < 0.95:
                continue
            a = random.standard_normal((RAYS // 10, 2))
            if kind == "disc":
                radius, angle = np.sqrt(random.random(RAYS // 10)), random.uniform(0, 2 * np.pi, RAYS // 10)
                a = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
            at = np.array([u, v]) + random.uniform(-0.5, 0.5, a.shape)
            # the lens in units in which the depth in focus and the aperture give this blur
            focus_inverse = (1 - 1 / wish.blur_change) / near
            aperture = 3.0 * wish.blur_change * near / 170.0
            end = np.c_[(at - [80.0, 60.0]) / 170.0, np.ones(len(at))] / focus_inverse
            begin = np.c_[a * aperture, np.zeros(len(a))]
            # the picture is upright here, so a point of the aperture shows nearer things moved against it
            away = end - begin
            normal = rotation[:, 2]
            t = (normal @ pose.translation - begin @ normal) / (away @ normal)
            hit = begin + t[:, None] * away - pose.translation
            flat = hit @ rotation[:, :2]
            column = np.clip(np.rint(flat[:, 0] / board.pitch), 0, 3)
            row = np.clip(np.rint(flat[:, 1] / board.pitch), 0, 2)
            r = np.hypot(flat[:, 0] - column * board.pitch, flat[:, 1] - row * board.pitch)
            printed = (r < board.outer) & (r > board.inner)
            worst.append(float(light[v, u] - printed.mean()))
        noise = 0.5 / np.sqrt(RAYS // 10)
        print(f"{kind:10s} traced at {len(worst)} pixels: rms difference {np.std(worst):.5f} (of which the rays' own noise {noise:.5f})")


def sub_pixel() -> None:
    """The picture of a pattern whose value at each sample is known."""
    _, y = optics.sub_grid(4, 3, 2)
    assert cv2.__version__ and np.allclose(optics.at_pixels(y.astype(np.float32), 2)[:, 0], [0, 1, 2])


if __name__ == "__main__":
    sub_pixel()
    frontal()
    traced()
