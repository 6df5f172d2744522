"""The photometric fit of 7 x 7 rings beside cv2.GaussianBlur of the same 8-bit frame, in turn, in one run.

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


if __name__ == "__main__":
    main()
