"""The kinds of hard frames and what is drawn at random for each."""

from dataclasses import dataclass, field

import numpy as np

Random = np.random.Generator


@dataclass
class Wish:
    """What a frame shall show; the scene makes it so."""

    kind: str
    width: int = 800
    height: int = 600
    rows: int = 6
    columns: int = 7
    radii: tuple[float, float] = (0.12, 0.24)
    """Inner and outer radius over the pitch."""
    extent: float = 0.8
    """Longer side of the grid over that of the frame, or 0 where `ring_px` says how large it is."""
    ring_px: float = 0.0
    tilt_deg: float = 20.0
    off: float = 0.05
    """How far the board's middle may be from the frame's, over the frame's size."""
    lens: str = "plumb_bob"
    bend: float = 0.1
    focal: float = 1.1
    """Over the width."""
    blur: str = "gaussian"
    blur_size: float = 0.15
    """Sigma or radius at the board's middle over the outer radius of a ring in the frame."""
    blur_change: float = 0.0
    """How fast it changes with depth: 0 not at all, 1 as where infinity is in focus, more towards the board's own depth."""
    light_ratio: float = 1.2
    vignette: float = 0.0
    exposure: float = 0.85
    """Grey of white paper; above 1 it is clipped."""
    depth16: float = 0.0
    """Range used of 16 bit, or 0 for 8 bit."""
    black: float = 0.0
    """Grey of no light: what a sensor adds to light, which a file that is not linear in light from 0 has."""
    noise: float = 0.005
    polarity: str = "dark_on_light"
    told_polarity: str = ""
    marks: bool = False
    hand: bool = False
    second: bool = False
    busy: bool = False
    margin: float = 0.9
    notes: dict[str, float] = field(default_factory=dict)


def blur(random: Random, wish: Wish, gaussian: float, disc: float) -> None:
    """Some blur up to these sizes."""
    wish.blur = "disc" if random.random() < 0.5 else "gaussian"
    most = disc if wish.blur == "disc" else gaussian
    wish.blur_size = float(random.uniform(0.0, most))


def common(random: Random, kind: str) -> Wish:
    wish = Wish(kind)
    wish.width, wish.height = [(640, 480), (800, 600), (1024, 768)][int(random.integers(0, 3))]
    wish.rows, wish.columns = int(random.integers(4, 9)), int(random.integers(4, 9))
    outer = float(random.uniform(0.2, 0.3))
    wish.radii = (outer * float(random.uniform(0.42, 0.6)), outer)
    wish.extent = float(random.uniform(0.5, 0.8))
    wish.tilt_deg = float(random.uniform(0, 35))
    wish.bend = float(random.uniform(-0.25, 0.1))
    wish.noise = float(random.uniform(0.0, 0.01))
    wish.margin = float(random.uniform(0.6, 1.2))
    wish.busy = random.random() < 0.3
    if random.random() < 0.35:
        wish.polarity = "light_on_dark"
    if random.random() < 0.25:
        wish.told_polarity = "auto"
    blur(random, wish, 0.2, 0.35)
    return wish


def of_kind(random: Random, kind: str) -> Wish:
    """A frame of one kind."""
    wish = common(random, kind)
    if kind == "gaussian":
        wish.blur, wish.blur_size = "gaussian", float(random.uniform(0.2, 0.42))
    elif kind == "disc":
        wish.blur, wish.blur_size = "disc", float(random.uniform(0.35, 0.95))
    elif kind in ("varies", "varies_exact"):
        wish.width, wish.height = (640, 480) if random.random() < 0.5 else (800, 600)
        blur(random, wish, 0.25, 0.45)
        wish.blur_size = max(wish.blur_size, 0.08)
        wish.tilt_deg = float(random.uniform(25, 55))
        wish.blur_change = float(random.uniform(1, 5))
    elif kind == "light":
        wish.light_ratio = float(random.uniform(2, 4))
    elif kind == "exposure":
        wish.vignette = float(random.uniform(0.2, 0.7))
        wish.exposure = float(random.choice([0.06, 0.12, 1.1, 1.4]))
        wish.noise = min(wish.noise, 0.05 * wish.exposure)
    elif kind == "deep":
        wish.depth16, wish.noise = float(random.choice([0.01, 0.03, 1.0])), 0.002
        if random.random() < 0.3:
            wish.kind, wish.black = "deep_black", float(random.uniform(0.1, 0.9))
    elif kind == "noise":
        wish.noise = float(random.uniform(0.02, 0.05))
    elif kind == "tilt":
        wish.tilt_deg, wish.extent = float(random.uniform(40, 60)), 0.85
    elif kind == "tiny":
        wish.extent, wish.ring_px = 0.0, float(random.uniform(8, 12))
        blur(random, wish, 0.12, 0.25)
        wish.tilt_deg = float(random.uniform(0, 15))
        wish.noise = min(wish.noise, 0.005)
        wish.width, wish.height = 640, 480
    elif kind == "huge":
        wish.width, wish.height = 1280, 960
        wish.rows, wish.columns = 3, int(random.integers(3, 5))
        wish.extent, wish.ring_px = 0.0, float(random.uniform(150, 200))
        wish.noise = float(random.uniform(0.002, 0.02))
    elif kind == "far":
        wish.width, wish.height, wish.extent = 1280, 960, float(random.uniform(0.22, 0.35))
        wish.off = 0.25
    elif kind == "overfilling":
        wish.rows, wish.columns = int(random.integers(5, 9)), int(random.integers(5, 9))
        wish.extent, wish.tilt_deg = float(random.uniform(1.0, 1.15)), float(random.uniform(0, 25))
        wish.busy = False
    elif kind == "hand":
        wish.hand = True
        wish.rows, wish.columns = int(random.integers(5, 9)), int(random.integers(6, 9))
    elif kind == "two":
        wish.second = True
        wish.extent, wish.off = 0.5, 0.0
    elif kind == "marks":
        wish.marks = True
    elif kind == "clutter":
        wish.busy = True
        wish.extent = float(random.uniform(0.35, 0.6))
    elif kind == "wide":
        wish.lens = "equidistant" if random.random() < 0.5 else "plumb_bob"
        wish.focal = float(random.uniform(0.42, 0.6))
        wish.bend = float(random.uniform(-0.03, 0.03)) if wish.lens == "equidistant" else float(random.uniform(-0.28, -0.15))
        wish.rows, wish.columns = int(random.integers(3, 7)), int(random.integers(3, 7))
        wish.extent, wish.tilt_deg = float(random.uniform(0.7, 0.95)), float(random.uniform(0, 30))
    elif kind == "mixed":
        wish.light_ratio = float(random.uniform(1.5, 3))
        wish.noise = float(random.uniform(0.005, 0.02))
        wish.tilt_deg = float(random.uniform(10, 45))
        wish.busy = random.random() < 0.6
        wish.hand = random.random() < 0.3
        wish.blur_change = float(random.uniform(0, 3)) if wish.width < 1000 else 0.0
        blur(random, wish, 0.3, 0.5)
    if kind == "varies_exact":
        wish.noise, wish.depth16, wish.busy = 0.0, 1.0, False
    if kind == "light" and random.random() < 0.3:
        wish.noise, wish.depth16 = 0.0, 1.0
    return wish


KINDS = (
    "plain gaussian disc varies light exposure deep noise tilt tiny huge far overfilling hand two marks clutter wide "
    "mixed varies_exact"
).split()
