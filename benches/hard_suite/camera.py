"""A camera: pinhole, lens, and the pose of a plane before it. Pixels have the middle of the first one at (0, 0)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TABLE = 20000


@dataclass(frozen=True)
class Camera:
    """`model` is plumb_bob (coefficients k1 k2 p1 p2) or equidistant (k1 k2 0 0)."""

    width: int
    height: int
    focal_px: float
    cx: float
    cy: float
    model: str = "plumb_bob"
    coefficients: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    def bent(self, x: Array, y: Array) -> tuple[Array, Array]:
        """What the lens makes of the ray (x, y, 1), in focal lengths."""
        k1, k2, p1, p2 = self.coefficients
        r2 = x * x + y * y
        if self.model == "equidistant":
            r = np.sqrt(np.maximum(r2, 1e-24))
            theta = np.arctan(r)
            scale = theta * (1 + k1 * theta**2 + k2 * theta**4) / r
            return x * scale, y * scale
        radial = 1 + k1 * r2 + k2 * r2 * r2
        return (
            x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
        )

    def project(self, points: Array) -> Array:
        """Points (n x 3) in the camera's frame to px; not a number behind the camera, and beyond the fold, where nothing shows."""
        sx, sy = points[:, 0] / points[:, 2], points[:, 1] / points[:, 2]
        hidden = (points[:, 2] <= 0) | (np.hypot(sx, sy) > self.radius_table()[1][-1])
        x, y = self.bent(np.where(hidden, np.nan, sx), np.where(hidden, np.nan, sy))
        return np.stack([self.cx + self.focal_px * x, self.cy + self.focal_px * y], axis=1)

    def radius_table(self) -> tuple[Array, Array]:
        """Bent radii and those of the rays, as far as the one grows with the other: beyond, the lens folds."""
        if self.model == "equidistant":
            straight = np.tan(np.linspace(0.0, 1.45, TABLE))
        else:
            straight = np.linspace(0.0, 3.0, TABLE)
        k1, k2, _, _ = self.coefficients
        radial = Camera(0, 0, 1.0, 0.0, 0.0, self.model, (k1, k2, 0.0, 0.0))
        bent, _ = radial.bent(straight, np.zeros(TABLE))
        fold = int(np.argmax(np.diff(bent) <= 0)) or TABLE
        return bent[:fold], straight[:fold]

    def rays(self, u: Array, v: Array) -> tuple[Array, Array]:
        """The ray (x, y, 1) of each pixel; not a number beyond the fold."""
        xd, yd = (u - self.cx) / self.focal_px, (v - self.cy) / self.focal_px
        table = self.radius_table()
        x, y = straightened(table, xd, yd)
        _, _, p1, p2 = self.coefficients
        if p1 or p2:
            # what the tangential part adds hardly depends on where it is asked
            for _ in range(3):
                r2, xy = x * x + y * y, x * y
                x, y = straightened(table, xd - 2 * p1 * xy - p2 * (r2 + 2 * x * x), yd - p1 * (r2 + 2 * y * y) - 2 * p2 * xy)
        return x, y


def straightened(table: tuple[Array, Array], xd: Array, yd: Array) -> tuple[Array, Array]:
    """Undoes what a lens does along the radius."""
    bent, straight = table
    rd = np.hypot(xd, yd)
    scale = np.interp(rd, bent, straight, right=np.nan) / np.maximum(rd, 1e-12)
    scale[rd < 1e-9] = straight[1] / bent[1]
    return xd * scale, yd * scale


@dataclass(frozen=True)
class Pose:
    """A plane's frame in the camera's: x_camera = rotation x + translation."""

    rotation: Array
    translation: Array

    def points(self, xy: Array) -> Array:
        """Points of the plane (n x 2, m) in the camera's frame."""
        return xy @ self.rotation[:, :2].T + self.translation

    def on_plane(self, x: Array, y: Array) -> tuple[Array, Array, Array]:
        """Where rays (x, y, 1) meet the plane, m, and one over the depth there, 1/m."""
        normal = self.rotation[:, 2]
        away = float(normal @ self.translation)
        inverse_depth = (normal[0] * x + normal[1] * y + normal[2]) / away
        depth = 1.0 / inverse_depth
        d = [depth * x - self.translation[0], depth * y - self.translation[1], depth - self.translation[2]]
        a, b = self.rotation[:, 0], self.rotation[:, 1]
        return (
            a[0] * d[0] + a[1] * d[1] + a[2] * d[2],
            b[0] * d[0] + b[1] * d[1] + b[2] * d[2],
            inverse_depth,
        )


def turned(tilt: float, towards: float, roll: float) -> Array:
    """A rotation by `roll` in the plane, then by `tilt` about the axis at the angle `towards`; radians."""
    c, s = np.cos(roll), np.sin(roll)
    in_plane = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    k = np.array([np.cos(towards), np.sin(towards), 0.0])
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    return (np.eye(3) + np.sin(tilt) * cross + (1 - np.cos(tilt)) * cross @ cross) @ in_plane
