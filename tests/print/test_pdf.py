"""The PDF of `ringcal board` in the eyes of other programs: pdfminer reads its coordinates, PDFium draws it."""

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pdfplumber
import pytest
import yaml

ROOT = Path(__file__).parents[2]
BINARY = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "ringcal"
MOST_OFF_MM = 0.01
DPI = 150

MARKED = """
rows: 4
columns: 5
pitch: 0.035
inner_radius: 0.005
outer_radius: 0.011
polarity: light_on_dark
marks: [[0, 0], [0, 1], [1, 0]]
"""
BOARDS = {
    "a4": (ROOT / "config" / "a4.yaml").read_text(),
    "c4": (ROOT / "config" / "paper_c4.yaml").read_text(),
    "marked": MARKED,
}


@pytest.fixture(params=BOARDS)
def print_of(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[dict, Path]:
    """A board and the PDF of it; the board's file lies beside it."""
    file = tmp_path / "board.yaml"
    file.write_text(BOARDS[request.param])
    pdf = tmp_path / "board.pdf"
    subprocess.run([BINARY, "board", "--board", file, "--output", pdf], check=True, capture_output=True)
    return yaml.safe_load(file.read_text()), pdf


def rms_about_lattice_mm(board: dict, points_mm: dict[tuple[int, int], tuple[float, float]]) -> float:
    """RMS distance of the points from the board's lattice, moved and turned to fit but not scaled."""
    places = sorted(points_mm)
    lattice = np.array([[column, row] for row, column in places]) * board["pitch"] * 1e3
    points = np.array([points_mm[place] for place in places])
    lattice -= lattice.mean(axis=0)
    points -= points.mean(axis=0)
    left, _, right = np.linalg.svd(lattice.T @ points)
    residuals = points - lattice @ left @ right
    return float(np.sqrt((residuals**2).sum(axis=1).mean()))


def test_centres_by_coordinates(print_of: tuple[dict, Path]) -> None:
    board, file = print_of
    with pdfplumber.open(file) as pdf:
        (page,) = pdf.pages
        mm = 25.4 / 72
        circles = [c for c in page.curves if abs((c["x1"] - c["x0"]) / 2 * mm - board["outer_radius"] * 1e3) < 1e-3]
        centres = [((c["x0"] + c["x1"]) / 2 * mm, (c["top"] + c["bottom"]) / 2 * mm) for c in circles]
        assert all(abs(c["x1"] - c["x0"] - (c["bottom"] - c["top"])) < 1e-3 for c in circles)
        assert yaml.safe_load(pdf.metadata["Subject"]) == board
        assert "100 mm here must measure 100 mm" in page.extract_text()
    rows, columns = board["rows"], board["columns"]
    assert len(centres) == rows * columns
    points = {(k // columns, k % columns): centre for k, centre in enumerate(centres)}
    assert rms_about_lattice_mm(board, points) < MOST_OFF_MM / 10


def test_centres_by_detection_on_a_raster(print_of: tuple[dict, Path]) -> None:
    board, file = print_of
    raster = file.with_suffix(".png")
    with pdfplumber.open(file) as pdf:
        page = pdf.pages[0]
        picture = page.to_image(resolution=DPI, antialias=True).original
        picture.convert("L").save(raster)
        # PDFium stretches the page to whole pixels
        mm_x, mm_y = page.width * 25.4 / 72 / picture.width, page.height * 25.4 / 72 / picture.height
    detect = [BINARY, "detect", raster, "--board", file.with_suffix(".yaml"), "--format", "jsonl"]
    line = json.loads(subprocess.run(detect, check=True, capture_output=True).stdout)
    assert line["found"], line["reason"]
    assert len(line["points"]) == board["rows"] * board["columns"] - len(board.get("marks", []))
    points = {(p["row"], p["col"]): (p["x"] * mm_x, p["y"] * mm_y) for p in line["points"]}
    rms = rms_about_lattice_mm(board, points)
    print(f"{rms:.5f} mm rms")
    assert rms < MOST_OFF_MM
