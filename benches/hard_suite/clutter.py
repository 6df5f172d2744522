"""What stands around a board or where none is: linear light 0..1, flat pictures."""

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Random = np.random.Generator


def noise(random: Random, height: int, width: int, finest: float = 2.0) -> Floats:
    """Texture of all sizes from `finest` px up."""
    total, step, strength = np.zeros((height, width), np.float32), finest, 1.0
    roughness = random.uniform(0.6, 1.0)
    while step < max(height, width) / 2:
        cells = random.random((int(height / step) + 2, int(width / step) + 2), np.float32) - 0.5
        total += strength * cv2.resize(cells, (width, height), interpolation=cv2.INTER_CUBIC)
        strength, step = strength / roughness, step * 2
    low, high = np.percentile(total, (2, 98))
    return np.clip((total - low) / (high - low), 0, 1) * random.uniform(0.3, 0.8) + 0.05


def leaves(random: Random, height: int, width: int, size: float) -> Floats:
    """Leaves over leaves, each with a light of its own."""
    picture = np.full((height, width), 0.05, np.float32)
    for _ in range(int(3 * height * width / size**2)):
        centre = (int(random.integers(0, width) * 16), int(random.integers(0, height) * 16))
        long = size * random.uniform(0.4, 1.0)
        axes = (int(16 * long), int(16 * long * random.uniform(0.25, 0.8)))
        grey = float(random.beta(1.5, 2.5))
        cv2.ellipse(picture, centre, axes, random.uniform(0, 360), 0, 360, grey, -1, cv2.LINE_AA, 4)
    return picture


def shapes(random: Random, height: int, width: int, size: float, rings: bool = True) -> Floats:
    """Things on a table: boxes, discs, rings, lines, letters."""
    picture = np.full((height, width), int(random.uniform(25, 200)), np.uint8)
    for _ in range(int(0.6 * height * width / size**2)):
        x, y = int(random.integers(0, width)), int(random.integers(0, height))
        r, grey = max(2, int(size * random.uniform(0.15, 0.7))), int(random.uniform(8, 240))
        kind = int(random.integers(0, 5))
        if kind == 0:
            corners = cv2.boxPoints(((x, y), (2.0 * r, r * 2.0 * random.uniform(0.3, 1)), random.uniform(0, 90)))
            cv2.fillPoly(picture, [np.int32(np.round(corners))], grey, cv2.LINE_AA)
        elif kind == 1 or (kind == 2 and not rings):
            cv2.circle(picture, (x, y), r, grey, -1, cv2.LINE_AA)
        elif kind == 2:
            cv2.circle(picture, (x, y), r, grey, -1, cv2.LINE_AA)
            cv2.circle(picture, (x, y), max(1, r // 2), int(random.uniform(8, 240)), -1, cv2.LINE_AA)
        elif kind == 3:
            cv2.line(picture, (x, y), (x + 3 * r, y + int(random.integers(-3 * r, 3 * r + 1))), grey, 1 + r // 6, cv2.LINE_AA)
        else:
            letters = "".join(random.choice(list("OQ0o8eadgB6%@"), 4))
            cv2.putText(picture, letters, (x, y), cv2.FONT_HERSHEY_SIMPLEX, r / 16, grey, 1 + r // 8, cv2.LINE_AA)
    return picture.astype(np.float32) / 255


def text(random: Random, height: int, width: int, size: float) -> Floats:
    """Lines of print."""
    picture = np.full((height, width), 216, np.uint8)
    signs = list("abcdefghijklmnopqrstuvwxyzOQ0o8eadgB69 .,:;%@&") if random.random() < 0.7 else list("oO0Q8 ")
    y = int(size)
    while y < height:
        line = "".join(random.choice(signs, int(width / size * 2)))
        cv2.putText(picture, line, (4, y), cv2.FONT_HERSHEY_SIMPLEX, size / 22, 15, max(1, int(size / 12)), cv2.LINE_AA)
        y += int(size * random.uniform(1.0, 1.6)) + 1
    return picture.astype(np.float32) / 255


def background(random: Random, height: int, width: int, size: float, busy: bool) -> Floats:
    """What is behind a sheet whose rings are `size` px large."""
    if not busy:
        return np.full((height, width), random.uniform(0.05, 0.6), np.float32)
    kind = int(random.integers(0, 5))
    if kind == 0:
        return noise(random, height, width)
    if kind == 1:
        return leaves(random, height, width, size * random.uniform(0.5, 1.5) + 4)
    if kind == 2:
        return text(random, height, width, max(8.0, size * random.uniform(0.4, 1.2)))
    return shapes(random, height, width, size * random.uniform(0.7, 1.6) + 3)


def hand(random: Random, outline: NDArray[np.float64]) -> list[NDArray[np.int32]]:
    """A fist with fingers that reaches in over the `outline` of a board (px) from outside: polygons, in 1/16 px."""
    middle = outline.mean(axis=0)
    reach = float(np.linalg.norm(outline - middle, axis=1).mean())
    side = outline[int(random.integers(0, len(outline)))]
    inwards = (middle - side) / np.linalg.norm(middle - side)
    across = np.array([-inwards[1], inwards[0]])
    palm = side - inwards * reach * random.uniform(0.1, 0.3) + across * reach * random.uniform(-0.3, 0.3)
    polygons = []
    angle = np.linspace(0, 2 * np.pi, 60)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    polygons.append(palm + ring * reach * 0.28)
    for finger in range(4):
        tilt = (finger - 1.5) * random.uniform(0.2, 0.35)
        way = inwards * np.cos(tilt) + across * np.sin(tilt)
        begin = palm + across * reach * 0.14 * (finger - 1.5)
        end = begin + way * reach * random.uniform(0.3, 0.65)
        for part in np.linspace(0, 1, 12):
            polygons.append(begin + (end - begin) * part + ring * reach * 0.07)
    return polygons
