"""What a binary finds in a folder of generate.py: python score.py FOLDER BINARY

Two kinds of figure. Boards: found, missed, wrong (an index or another board), false (a board where none is). Centres: the
error of rings that show whole, px, and its square over the covariance that is reported with it, which should be 2 on average.
"""

import argparse
import json
import subprocess
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Told = dict[str, object]

NEAR = 0.25
"""A point is its ring's if it is nearer than this fraction of the way to the next one."""
LEAST = 0.6


@dataclass
class Tally:
    """What came of one kind of frame."""

    found: int = 0
    missed: int = 0
    unasked: int = 0
    wrong: int = 0
    false: int = 0
    rejected: int = 0
    errors: list[Array] = field(default_factory=list)
    squares: list[Array] = field(default_factory=list)
    per_frame: list[float] = field(default_factory=list)
    milliseconds: list[float] = field(default_factory=list)


def detect(binary: str, folder: Path, name: str, more: list[str]) -> Told:
    command = [binary, "detect", str(folder / f"{name}.png"), "--board", str(folder / f"{name}.yaml"), "--format", "jsonl"]
    done = subprocess.run([*command, *more], check=False, capture_output=True, text=True)
    if not done.stdout:
        raise SystemExit(f"{name}: {done.stderr}")
    return json.loads(done.stdout.splitlines()[0])


def numberings(rows: int, columns: int, marks: bool) -> list[Array]:
    """For each way to number a board the true (row, column) of each number, rows x columns x 2."""
    rows_, columns_ = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    own = np.stack([rows_, columns_], axis=2)
    if marks:
        return [own]
    turns = (0, 1, 2, 3) if rows == columns else (0, 2)
    return [np.rot90(own, turn) for turn in turns]


def matched(told: Told, truth: Told) -> dict[tuple[int, int], dict[str, object]] | None:
    """The true ring of each point, by number; `None` where an index is wrong."""
    rows, columns = int(truth["rows"]), int(truth["columns"])
    at = np.zeros((rows, columns, 2))
    rings = {}
    for ring in truth["rings"]:
        at[ring["row"], ring["col"]] = ring["x"], ring["y"]
        rings[ring["row"], ring["col"]] = ring
    steps = np.minimum(
        np.linalg.norm(np.gradient(at, axis=0), axis=2), np.linalg.norm(np.gradient(at, axis=1), axis=2)
    )
    for own in numberings(rows, columns, bool(truth["marks"])):
        shifts = [(0, 0)]
        if told["indices"] == "relative":
            shifts = [(r, c) for r in range(rows) for c in range(columns)]
        for shift in shifts:
            found = {}
            for point in told["points"]:
                r, c = point["row"] + shift[0], point["col"] + shift[1]
                if r >= own.shape[0] or c >= own.shape[1]:
                    break
                true = tuple(int(v) for v in own[r, c])
                if np.hypot(*(at[true] - (point["x"], point["y"]))) > NEAR * steps[true]:
                    break
                found[point["row"], point["col"]] = rings[true]
            if len(found) == len(told["points"]):
                return found
    return None


def is_asked(truth: Told) -> bool:
    """Whether what shows whole is enough for the detector's own rule."""
    rings = [ring for ring in truth["rings"] if not ring["mark"]]
    whole = [ring for ring in rings if ring["whole"]]
    lines = all(
        any(ring[axis] == line for ring in whole)
        for axis, count in (("row", truth["rows"]), ("col", truth["columns"]))
        for line in range(count)
    )
    return lines and len(whole) >= LEAST * len(truth["rings"])


def centres(told: Told, rings: dict[tuple[int, int], dict[str, object]]) -> tuple[Array, Array]:
    """Errors, px, and their normalised squares, of rings that show whole."""
    errors, squares = [], []
    for point in told["points"]:
        ring = rings[point["row"], point["col"]]
        if not ring["whole"] or point["cov"] is None:
            continue
        error = np.array([point["x"] - ring["x"], point["y"] - ring["y"]])
        xx, xy, yy = point["cov"]
        errors.append(error)
        squares.append(float(error @ np.linalg.solve(np.array([[xx, xy], [xy, yy]]), error)))
    return np.array(errors).reshape(-1, 2), np.array(squares)


def judge(frame: Told, told: Told, tally: Tally) -> str:
    """Adds a frame to the tally and says what is to be said of it."""
    tally.milliseconds.append(float(told["elapsed_ms"]))
    if not frame["boards"]:
        if told["found"]:
            tally.false += 1
            return f"FALSE {len(told['points'])} rings"
        tally.rejected += 1
        return f"none: {told['reason']}"
    truth = frame["boards"][0]
    if not told["found"]:
        if is_asked(truth):
            tally.missed += 1
            return f"MISSED: {told['reason']}"
        tally.unasked += 1
        return f"not asked for: {told['reason']}"
    rings = matched(told, truth)
    if rings is None:
        tally.wrong += 1
        return "WRONG index or board"
    tally.found += 1
    errors, squares = centres(told, rings)
    if len(squares) == 0:
        return "found"
    tally.errors.append(errors)
    tally.squares.append(squares)
    tally.per_frame.append(float(squares.mean()))
    rms = float(np.sqrt((errors**2).sum(axis=1).mean()))
    worst = float(np.linalg.norm(errors, axis=1).max())
    return f"found {len(told['points'])}: rms {rms:.4f} px, worst {worst:.4f}, mean square {squares.mean():.2f}"


def table(tallies: dict[str, Tally]) -> None:
    print("\nkind            found missed wrong false  not   rms px   p95 px  square  median   ms")
    everything = Tally()
    for kind, tally in [*sorted(tallies.items()), ("all", everything)]:
        if kind != "all":
            for name in ("found", "missed", "unasked", "wrong", "false", "rejected"):
                setattr(everything, name, getattr(everything, name) + getattr(tally, name))
            for name in ("errors", "squares", "per_frame", "milliseconds"):
                getattr(everything, name).extend(getattr(tally, name))
        line = f"{kind:15s} {tally.found:5d} {tally.missed:6d} {tally.wrong:5d} {tally.false:5d} {tally.unasked + tally.rejected:4d}"
        if tally.errors:
            off = np.linalg.norm(np.concatenate(tally.errors), axis=1)
            squares = np.concatenate(tally.squares)
            line += f" {np.sqrt((off**2).mean()):8.4f} {np.percentile(off, 95):8.4f}"
            line += f" {squares.mean():7.2f} {np.median(tally.per_frame):7.2f}"
        else:
            line += " " * 34
        print(f"{line} {np.median(tally.milliseconds):6.1f} {np.max(tally.milliseconds):6.1f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("binary")
    parser.add_argument("--only", default="", help="frames whose name or kind has this in it")
    parser.add_argument("--quiet", action="store_true", help="the table alone")
    told, more = parser.parse_known_args()
    frames = [json.loads(path.read_text()) for path in sorted(told.folder.glob("*_*.json"))]
    tallies: dict[str, Tally] = defaultdict(Tally)
    for frame in frames:
        kind = str(frame["wish"]["kind"])
        if told.only not in kind and told.only not in frame["name"]:
            continue
        kind = kind if frame["boards"] else f"- {kind}"
        result = detect(told.binary, told.folder, frame["name"], more)
        said = judge(frame, result, tallies[kind])
        if not told.quiet:
            print(f"{frame['name']} {kind:14s} {result['elapsed_ms']:6.1f} ms  {said}", flush=True)
    table(tallies)


if __name__ == "__main__":
    main()
