"""A board of concentric circles: its file, where its rings are, and how much of it is ink."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Floats = NDArray[np.float32]


@dataclass(frozen=True)
class Board:
    rows: int
    columns: int
    pitch: float
    inner: float
    outer: float
    polarity: str = "dark_on_light"
    marks: tuple[tuple[int, int], ...] = ()
    margin: float = 1.0
    """From the outermost centres to the end of the sheet, in pitches."""
    extra: dict[str, object] = field(default_factory=dict)

    def write(self, path: Path, polarity: str | None = None) -> None:
        """The board file."""
        lines = [f"rows: {self.rows}", f"columns: {self.columns}", f"pitch: {self.pitch}"]
        lines += [f"inner_radius: {self.inner}", f"outer_radius: {self.outer}"]
        lines.append(f"polarity: {polarity or self.polarity}")
        if self.marks:
            lines.append("marks: [" + ", ".join(f"[{r}, {c}]" for r, c in self.marks) + "]")
        path.write_text("\n".join(lines) + "\n")

    def centres(self) -> Array:
        """Of all rings, by row, then column, m."""
        row, column = np.divmod(np.arange(self.rows * self.columns), self.columns)
        return np.stack([column, row], axis=1) * self.pitch

    def middle(self) -> Array:
        return np.array([self.columns - 1, self.rows - 1]) * self.pitch / 2

    def outline(self, row: int, column: int, count: int = 48) -> Array:
        """Points of the outer circle of a ring, m."""
        angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
        return np.array([column, row]) * self.pitch + self.outer * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def covered(distance: Array, slope_x: Array, slope_y: Array) -> Floats:
    """How much of each pixel lies where `distance` is negative; the slopes are its change over a pixel."""
    width = np.maximum(np.abs(slope_x) + np.abs(slope_y), 1e-12)
    return np.clip(0.5 - distance / width, 0.0, 1.0).astype(np.float32)


def slopes(of: Array) -> tuple[Array, Array]:
    """Change over a pixel in x and in y."""
    return np.gradient(of, axis=1), np.gradient(of, axis=0)


def ink(board: Board, x: Array, y: Array, slope: tuple[Array, Array, Array, Array]) -> Floats:
    """The fraction of each pixel that is printed; x, y on the board, m, and their changes over a pixel."""
    x_x, x_y, y_x, y_y = slope
    column = np.clip(np.rint(x / board.pitch), 0, board.columns - 1)
    row = np.clip(np.rint(y / board.pitch), 0, board.rows - 1)
    dx, dy = x - column * board.pitch, y - row * board.pitch
    r = np.maximum(np.hypot(dx, dy), 1e-9)
    r_x, r_y = (dx * x_x + dy * y_x) / r, (dx * x_y + dy * y_y) / r
    inner = covered(r - board.inner, r_x, r_y)
    for mark_row, mark_column in board.marks:
        inner[(row == mark_row) & (column == mark_column)] = 0.0
    return covered(r - board.outer, r_x, r_y) - inner


def sheet(board: Board, x: Array, y: Array, slope: tuple[Array, Array, Array, Array]) -> Floats:
    """The fraction of each pixel that the sheet covers."""
    x_x, x_y, y_x, y_y = slope
    (mx, my), margin = board.middle(), board.margin * board.pitch
    return covered(np.abs(x - mx) - (mx + margin), x_x, x_y) * covered(np.abs(y - my) - (my + margin), y_x, y_y)
