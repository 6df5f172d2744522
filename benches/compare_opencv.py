"""The photometric fit of 7 x 7 rings, and the whole detection, beside OpenCV on the same 8-bit frames, in turn, in one run.

Needs numpy and opencv-python-headless, and the release build: cargo build --release --examples --bins
Prints medians in ms and their ratio; there is nothing to pass or fail.
"""

import json
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "target" / "release"
ROUNDS = 3
BLURS = [("gaussian", s) for s in (0, 1, 2, 3, 4, 6, 8, 10)] + [("disc", r) for r in (2, 4, 8, 12)]


def blur_ms(frame: Path) -> float:
    picture = cv2.imread(str(frame), cv2.IMREAD_GRAYSCALE)
    times = []
    for _ in range(100):
        begin = time.perf_counter()
        cv2.GaussianBlur(picture, (0, 0), 2)
        times.append(1e3 * (time.perf_counter() - begin))
    return statistics.median(times)


def simulate(board: Path, folder: Path, psf: str, size: float) -> Path:
    kind = ["--blur-sigma", str(size)] if psf == "gaussian" else ["--disc-radius", str(size)]
    command = [str(BUILD / "ringcal"), "simulate", "--board", str(board), "--output", str(folder)]
    subprocess.run([*command, "--views", "3", "--noise", "0.01", *kind], check=True, capture_output=True)
    return folder / "view_001.png"


def tuned_grid_ms(frame: Path) -> tuple[float, bool]:
    """findCirclesGrid as good as hand-tuning makes it for these frames."""
    picture = cv2.imread(str(frame), cv2.IMREAD_GRAYSCALE)
    tuning = cv2.SimpleBlobDetector_Params()
    tuning.minArea, tuning.maxArea = 30, 1e5 * picture.size / 1.2e6
    tuning.minThreshold, tuning.maxThreshold, tuning.thresholdStep = 20, 220, 10
    tuning.filterByConvexity = tuning.filterByInertia = False
    tuning.minDistBetweenBlobs = 10
    tuning.blobColor = 255  # the inner discs
    flags = cv2.CALIB_CB_SYMMETRIC_GRID | cv2.CALIB_CB_CLUSTERING
    begin = time.perf_counter()
    found, _ = cv2.findCirclesGrid(picture, (7, 7), flags=flags, blobDetector=cv2.SimpleBlobDetector_create(tuning))
    return 1e3 * (time.perf_counter() - begin), bool(found)


def detected(frame: Path, board: Path) -> tuple[float, int]:
    """Median time of five detections in one process, and the rings found."""
    command = [str(BUILD / "ringcal"), "detect", *[str(frame)] * 5, "--board", str(board), "--format", "jsonl"]
    told = subprocess.run(command, check=True, capture_output=True, text=True)
    lines = [json.loads(line) for line in told.stdout.splitlines()]
    return statistics.median(line["elapsed_ms"] for line in lines), len(lines[0]["points"])


def texture(folder: Path, width: int, height: int, grain: float) -> Path:
    """A frame without a board: noise, smoothed."""
    noise = np.random.default_rng(1).normal(size=(height, width)).astype(np.float32)
    smooth = cv2.GaussianBlur(noise, (0, 0), grain)
    path = folder / f"texture_{width}_{grain}.png"
    cv2.imwrite(str(path), np.clip(128 + 50 * smooth / smooth.std(), 0, 255).astype(np.uint8))
    return path


def whole_detection(board: Path, folder: Path) -> None:
    print(f"\n{'frame':>28}{'rings':>7}{'detect ms':>11}{'GaussianBlur ms':>17}{'detect / blur':>15}{'findCirclesGrid ms':>20}")
    frames = []
    for width, height in [(1280, 960), (5496, 3672)]:
        for size in (1, 3, 6):
            shape = ["--width", str(width), "--height", str(height)]
            blur = str(size * width / 1280)
            out = folder / f"whole_{width}_{size}"
            command = [str(BUILD / "ringcal"), "simulate", "--board", str(board), "--output", str(out), "--views", "3"]
            command += [*shape, "--noise", "0.01", "--blur-sigma", blur]
            subprocess.run(command, check=True, capture_output=True)
            frames.append((f"{width} x {height}, blur {blur[:5]}", out / "view_001.png"))
        frames.append((f"{width} x {height}, texture", texture(folder, width, height, 3.0)))
    for name, frame in frames:
        ms, rings = detected(frame, board)
        blur = blur_ms(frame)
        said = "-"  # on texture it takes minutes
        if rings:
            grid, found = tuned_grid_ms(frame)
            said = f"{grid:.0f}{'' if found else ' (none)'}"
        print(f"{name:>28}{rings:>7}{ms:>11.1f}{blur:>17.3f}{ms / blur:>15.1f}{said:>20}")


def main() -> None:
    cv2.setNumThreads(2)
    board = ROOT / "config" / "paper_c4.yaml"
    print(f"{'blur':>14}{'rings':>7}{'detect ms':>11}{'fit ms':>9}{'GaussianBlur ms':>17}{'fit / blur':>12}")
    with tempfile.TemporaryDirectory() as folder:
        for psf, size in BLURS:
            frame = simulate(board, Path(folder) / f"{psf}{size}", psf, size)
            pairs = []
            for _ in range(ROUNDS):
                command = [str(BUILD / "examples" / "refine_time"), str(frame), str(board)]
                told = subprocess.run(command, check=False, capture_output=True, text=True)
                if told.returncode == 0:
                    pairs.append((json.loads(told.stdout), blur_ms(frame)))
            if not pairs:
                print(f"{psf:>10}{size:>4}  not found")
                continue
            fit = statistics.median(p["refine_ms"] for p, _ in pairs)
            detect = statistics.median(p["detect_ms"] for p, _ in pairs)
            blur = statistics.median(b for _, b in pairs)
            rings = pairs[0][0]["rings"]
            print(f"{psf:>10}{size:>4}{rings:>7}{detect:>11.2f}{fit:>9.2f}{blur:>17.3f}{fit / blur:>12.1f}")
        whole_detection(board, Path(folder))


if __name__ == "__main__":
    main()
