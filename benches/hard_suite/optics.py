"""Defocus. A pixel gathers light through every point of the aperture.

A point of the scene that a pinhole would show at p shows, through the point u of the aperture (a disc of radius 1, or a
Gaussian of standard deviation 1), at x = p + c(p) u. c is the radius of the disc of blur, or sigma, in px, and proportional
to the difference of one over the depth and one over the depth in focus: over a plane it changes linearly. So what a pixel x
sees through u is at p = x - u c(x) / (1 + u . grad c), and the grey value is the mean of the light there over the aperture.
This is exact for a plane, where layers of constant blur are not.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]

SUB = 3
"""Samples of the sharp picture across a pixel: an odd number, so that one is in its middle."""
CELL_PX = 0.75
GAUSS_CELL_PX = 0.9
GAUSS_REACH = 3.7
STRIP = 24


def sub_grid(width: int, height: int, margin: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Coordinates of the samples of a frame with a margin, px."""
    x = (np.arange((width + 2 * margin) * SUB) - (SUB - 1) / 2) / SUB - margin
    y = (np.arange((height + 2 * margin) * SUB) - (SUB - 1) / 2) / SUB - margin
    return tuple(np.meshgrid(x, y))  # type: ignore[return-value]


def disc_weights(cells: int) -> tuple[Floats, Floats, Floats]:
    """A grid over the unit disc: places and the share of each cell that lies on the disc."""
    fine = 8
    edge = (np.arange(cells * fine) + 0.5) / (cells * fine) * 2 - 1
    inside = (edge[None, :] ** 2 + edge[:, None] ** 2 < 1).astype(np.float64)
    weight = inside.reshape(cells, fine, cells, fine).mean(axis=(1, 3))
    place = (np.arange(cells) + 0.5) / cells * 2 - 1
    x, y = np.meshgrid(place, place)
    # a cell stands for its area, which adds to the spread: the whole has that of the disc
    spread = (weight * x * x).sum() / weight.sum()
    scale = np.sqrt(0.25 / spread)
    keep = weight > 0
    return x[keep] * scale, y[keep] * scale, weight[keep] / weight.sum()


def gauss_weights(step: float) -> tuple[Floats, Floats, Floats]:
    """A grid over a Gaussian of standard deviation 1, in steps of it."""
    count = int(np.ceil(GAUSS_REACH / step))
    place = np.arange(-count, count + 1) * step
    x, y = np.meshgrid(place, place)
    weight = np.exp(-0.5 * (x * x + y * y))
    keep = x * x + y * y <= GAUSS_REACH**2
    x, y, weight = x[keep], y[keep], weight[keep] / weight[keep].sum()
    scale = 1 / np.sqrt((weight * x * x).sum())
    return x * scale, y * scale, weight


def aperture(kind: str, most_px: float) -> tuple[Floats, Floats, Floats]:
    """Points of the aperture, close enough together for blur of this size."""
    if kind == "disc":
        return disc_weights(max(10, int(np.ceil(2 * most_px / CELL_PX))))
    return gauss_weights(min(0.5, GAUSS_CELL_PX / max(most_px, 1e-3)))


def pixels(sharp: Floats) -> Floats:
    """The mean over the square of a pixel around each sample."""
    return cv2.blur(sharp, (SUB, SUB), borderType=cv2.BORDER_REPLICATE)


def at_pixels(fine: Floats, margin: int) -> Floats:
    """The samples in the middles of the frame's pixels."""
    begin = margin * SUB + SUB // 2
    end = -margin * SUB or None
    return np.ascontiguousarray(fine[begin:end:SUB, begin:end:SUB])


def uniform(sharp: Floats, margin: int, kind: str, size_px: float) -> Floats:
    """The same blur everywhere."""
    fine = pixels(sharp)
    if size_px > 0 and kind == "gaussian":
        reach = 2 * int(np.ceil(5 * size_px * SUB)) + 1
        fine = cv2.GaussianBlur(fine, (reach, reach), size_px * SUB, borderType=cv2.BORDER_REPLICATE)
    elif size_px > 0:
        fine = cv2.filter2D(fine, -1, disc_kernel(size_px * SUB), borderType=cv2.BORDER_REPLICATE)
    return at_pixels(fine, margin)


def disc_kernel(radius: float) -> Floats:
    """A disc in cells of 1, each with the share of it that lies on the disc."""
    reach, fine = int(np.ceil(radius + 0.5)), 16
    edge = (np.arange((2 * reach + 1) * fine) + 0.5) / fine - reach - 0.5
    inside = (edge[None, :] ** 2 + edge[:, None] ** 2 < radius**2).astype(np.float64)
    weight = inside.reshape(2 * reach + 1, fine, 2 * reach + 1, fine).mean(axis=(1, 3))
    return (weight / weight.sum()).astype(np.float32)


def gathered(sharp: Floats, margin: int, kind: str, size_px: Floats) -> Floats:
    """Blur of another size at every pixel (`size_px`, height x width; negative before the focus)."""
    fine = pixels(sharp)
    slopes = np.gradient(size_px.astype(np.float64))
    strips = range(0, size_px.shape[0], STRIP)
    return np.concatenate([strip(fine, margin, kind, size_px, slopes, slice(at, at + STRIP)) for at in strips])


def strip(fine: Floats, margin: int, kind: str, size_px: Floats, slopes: list[Floats], rows: slice) -> Floats:
    """Some rows of it: with as many points of the aperture as these need."""
    size = size_px[rows]
    slope_y, slope_x = (slope[rows].astype(np.float32) for slope in slopes)
    x, y = np.meshgrid(np.arange(size.shape[1]), np.arange(size.shape[0]) + rows.start)
    x, y = ((v + margin) * SUB + SUB // 2 for v in (x, y))
    x, y, c = x.astype(np.float32), y.astype(np.float32), (size * SUB).astype(np.float32)
    total = np.zeros(size.shape, np.float32)
    for u, v, weight in zip(*aperture(kind, float(np.abs(size).max()))):
        u, v = np.float32(u), np.float32(v)
        step = c / (1 + u * slope_x + v * slope_y)
        seen = cv2.remap(fine, x - u * step, y - v * step, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        total += np.float32(weight) * seen
    return total
