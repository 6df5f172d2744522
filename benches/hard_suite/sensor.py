"""Light on the sensor to grey values of a file."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Random = np.random.Generator


def lit(random: Random, light: Floats, ratio: float, span_px: float, vignette: float) -> Floats:
    """Light that falls off by `ratio` over `span_px` in some direction, and towards the corners by the fraction `vignette`."""
    height, width = light.shape
    x, y = np.meshgrid(np.arange(width) - width / 2, np.arange(height) - height / 2)
    angle = random.uniform(0, 2 * np.pi)
    along = (x * np.cos(angle) + y * np.sin(angle)) / span_px
    field = np.exp(np.clip(along, -0.75, 0.75) * np.log(ratio)) / np.sqrt(ratio)
    corner = (x * x + y * y) / (width * width + height * height) * 4
    return (light * field * (1 - vignette * corner)).astype(np.float32)


def exposed(
    random: Random, light: Floats, exposure: float, noise: float, depth16: float, black: float = 0.0
) -> NDArray[np.uint8 | np.uint16]:
    """`exposure` is the grey of the lightest light, 1 full scale; `noise` its standard deviation in that scale.

    `black` is the grey of no light, of the part of 16 bit that `depth16` leaves free.
    """
    grey = light * (exposure / max(float(np.percentile(light, 99.5)), 1e-6))
    grey = grey + noise * random.standard_normal(light.shape, np.float32)
    grey = np.clip(grey, 0, 1)
    if depth16:
        return np.rint(65535 * (black * (1 - depth16) + depth16 * grey)).astype(np.uint16)
    return np.rint(255 * grey).astype(np.uint8)
