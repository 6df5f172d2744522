"""Frames for the hard suite: python generate.py SEED BOARDS NEGATIVES FOLDER"""

import argparse
import json
from dataclasses import asdict
from pathlib import Path

import cv2
import numpy as np

import kinds
import negatives
import scene

AUTO_NEGATIVES = 0.5


def board_frame(seed: int, at: int, folder: Path) -> dict[str, object]:
    """One frame with a board, and what is known of it. Each frame has random numbers of its own."""
    random = np.random.default_rng([seed, 1, at])
    wish = kinds.of_kind(random, kinds.KINDS[at % len(kinds.KINDS)])
    grey, boards, prints = scene.frame_of(random, wish)
    name = f"board_{at:04d}"
    prints[0].write(folder / f"{name}.yaml", wish.told_polarity or None)
    cv2.imwrite(str(folder / f"{name}.png"), grey)
    return {"name": name, "wish": asdict(wish), "boards": boards}


def negative_frame(seed: int, at: int, folder: Path) -> dict[str, object]:
    """One frame without the board that is looked for."""
    random = np.random.default_rng([seed, 2, at])
    kind = negatives.KINDS[at % len(negatives.KINDS)]
    grey, board = negatives.negative(random, kind)
    name = f"negative_{at:04d}"
    board.write(folder / f"{name}.yaml", "auto" if random.random() < AUTO_NEGATIVES else None)
    cv2.imwrite(str(folder / f"{name}.png"), grey)
    return {"name": name, "wish": {"kind": kind}, "boards": []}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("seed", type=int)
    parser.add_argument("boards", type=int)
    parser.add_argument("negatives", type=int)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--kind", help="boards of this kind alone")
    told = parser.parse_args()
    told.folder.mkdir(parents=True, exist_ok=True)
    cv2.setNumThreads(1)
    wanted = [at for at in range(told.boards) if told.kind in (None, kinds.KINDS[at % len(kinds.KINDS)])]
    for at in wanted:
        known = board_frame(told.seed, at, told.folder)
        (told.folder / f"{known['name']}.json").write_text(json.dumps(known))
    for at in range(told.negatives):
        known = negative_frame(told.seed, at, told.folder)
        (told.folder / f"{known['name']}.json").write_text(json.dumps(known))


if __name__ == "__main__":
    main()
