"""Calibration beside cv2.calibrateCamera on the same points: 20, 200 and 2000 views of 49 rings, in turn, in one run.

Needs numpy and opencv-python-headless, and the release build: cargo build --release --examples
ringcal is timed twice: with the centres as points, and as centres of small ellipses, whose displacement it predicts on every ring.
Each takes its turn several times; the middle one counts. A calibration of OpenCV's that takes longer than a limit is given up.
Prints seconds and the parameters' differences; there is nothing to pass or fail.
"""

import argparse
import json
import multiprocessing
import subprocess
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "target" / "release" / "examples" / "calibrate_time"
BOARD = ROOT / "config" / "paper_c4.yaml"
SIDE, PITCH_M = 7, 0.0269
SIZE = (1280, 960)
CAMERA = np.array([[1203.0, 0, 641], [0, 1201, 470], [0, 0, 1]])
LENS = np.array([-0.12, 0.05, 0.0004, -0.0003, 0.0])  # k1 k2 p1 p2 k3
NOISE_PX = 0.02
REPEATS = 5


def grid_m() -> np.ndarray:
    """The rings on the board, row by row."""
    rows, columns = np.mgrid[0:SIDE, 0:SIDE]
    return np.stack([columns.ravel() * PITCH_M, rows.ravel() * PITCH_M, np.zeros(SIDE * SIDE)], 1).astype(np.float32)


def views(count: int) -> list[np.ndarray]:
    """Boards tilted by up to 35 degrees, every ring in the frame, with noise."""
    random = np.random.default_rng(count)
    grid = grid_m()
    middle = grid.mean(0)
    found = []
    while len(found) < count:
        tilt, direction = random.uniform(0.1, 0.6), random.uniform(0, 2 * np.pi)
        turn = np.array([tilt * np.cos(direction), tilt * np.sin(direction), random.uniform(-0.2, 0.2)])
        depth = random.uniform(0.28, 0.45)
        pixel = random.uniform((0.2 * SIZE[0], 0.2 * SIZE[1]), (0.8 * SIZE[0], 0.8 * SIZE[1]))
        target = np.append((pixel - CAMERA[:2, 2]) / CAMERA[[0, 1], [0, 1]], 1) * depth
        shift = target - cv2.Rodrigues(turn)[0] @ middle
        points = cv2.projectPoints(grid, turn, shift, CAMERA, LENS)[0].reshape(-1, 2)
        if (points > 20).all() and (points < np.array(SIZE) - 20).all():
            found.append((points + random.normal(scale=NOISE_PX, size=points.shape)).astype(np.float32))
    return found


def opencv(points: list[np.ndarray], answer: multiprocessing.Queue) -> None:
    begin = time.perf_counter()
    rms, camera, lens, *_ = cv2.calibrateCamera([grid_m()] * len(points), points, SIZE, None, None)
    seconds = time.perf_counter() - begin
    parameters = [camera[0, 0], camera[1, 1], camera[0, 2], camera[1, 2], *lens.ravel()[:5]]
    answer.put({"seconds": seconds, "rms_px": rms, "parameters": parameters})


def opencv_within(points: list[np.ndarray], limit_s: float) -> dict | None:
    """None where it takes longer."""
    answer = multiprocessing.Queue()
    child = multiprocessing.Process(target=opencv, args=(points, answer))
    child.start()
    try:
        return answer.get(timeout=limit_s)
    except Exception:  # queue.Empty: out of time
        return None
    finally:
        child.kill()
        child.join()


def ringcal(points: list[np.ndarray], folder: Path, *estimator: str) -> dict:
    file = folder / "points.txt"
    with file.open("w") as out:
        for view, of_view in enumerate(points):
            for ring, (x, y) in enumerate(of_view):
                out.write(f"{view} {ring // SIDE} {ring % SIDE} {x:.9g} {y:.9g}\n")
    command = [str(PROGRAM), str(file), str(BOARD), *map(str, SIZE), *estimator]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def middle(results: list[dict | None]) -> dict | None:
    """The one with the middle time; None where one took too long."""
    if None in results:
        return None
    return sorted(results, key=lambda result: result["seconds"])[len(results) // 2]


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--limit", type=float, default=120, help="seconds OpenCV may take for one calibration")
    limit_s = arguments.parse_args().limit
    print(
        f"{'views':>6}{'ringcal, points s':>19}{'ringcal, rings s':>18}{'OpenCV s':>10}"
        f"{'OpenCV / points':>17}{'OpenCV / rings':>16}{'rms px, both':>18}{'fx differs px':>15}"
    )
    with tempfile.TemporaryDirectory() as folder:
        for count in (20, 200, 2000):
            points = views(count)
            turns = [
                (
                    ringcal(points, Path(folder)),
                    ringcal(points, Path(folder), "small_ellipse"),
                    opencv_within(points, limit_s),
                )
                for _ in range(REPEATS)
            ]
            ours, rings, theirs = (middle(list(results)) for results in zip(*turns))
            line = f"{count:>6}{ours['seconds']:>19.3f}{rings['seconds']:>18.3f}"
            if theirs is None:
                least, ratio = f"> {limit_s:.0f}", f"> {limit_s / ours['seconds']:.0f}"
                print(f"{line}{least:>10}{ratio:>17}{'':>16}{ours['rms_px']:>18.5f}")
                continue
            both = f"{ours['rms_px']:.5f} {theirs['rms_px']:.5f}"
            differs = abs(ours["parameters"][0] - theirs["parameters"][0])
            over_points = theirs["seconds"] / ours["seconds"]
            over_rings = theirs["seconds"] / rings["seconds"]
            print(f"{line}{theirs['seconds']:>10.3f}{over_points:>17.1f}{over_rings:>16.1f}{both:>18}{differs:>15.4f}")


if __name__ == "__main__":
    main()
