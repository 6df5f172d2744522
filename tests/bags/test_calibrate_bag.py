"""Bags of 300 frames that another program wrote, calibrated in one command; whole and cut off."""

from pathlib import Path

import pytest
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from recording import VIEWS, Frames, calibrate, data_file, of_raw, write

KINDS = [
    (StoragePlugin.MCAP, CompressionMode.NONE),
    (StoragePlugin.MCAP, CompressionMode.STORAGE),
    (StoragePlugin.MCAP, CompressionMode.FILE),
    (StoragePlugin.SQLITE3, CompressionMode.NONE),
    (StoragePlugin.SQLITE3, CompressionMode.MESSAGE),
    (StoragePlugin.SQLITE3, CompressionMode.FILE),
]
kinds = pytest.mark.parametrize(("storage", "compression"), KINDS, ids=lambda value: value.name.lower())


@pytest.fixture(scope="session")
def bags(frames: Frames, tmp_path_factory: pytest.TempPathFactory) -> dict:
    """A bag of each kind, every pose held for twelve frames."""
    folder = tmp_path_factory.mktemp("bags")
    film = frames.film(4)
    assert len(film) == 300
    return {
        kind: write(folder / f"{kind[0].name}_{kind[1].name}".lower(), {"/camera/image_raw": of_raw(film)}, *kind)
        for kind in KINDS
    }


def is_the_camera(result: dict, frames: Frames, relative: float) -> None:
    for name in ("fx", "fy"):
        assert result["parameters"][name] == pytest.approx(frames.camera[name], rel=relative)
    for name in ("cx", "cy"):
        assert result["parameters"][name] == pytest.approx(frames.camera[name], abs=330 * relative)


@kinds
def test_a_bag_calibrates(bags, frames: Frames, tmp_path: Path, storage, compression) -> None:
    result, said = calibrate(tmp_path, bags[storage, compression])
    is_the_camera(result, frames, 0.01)
    used = [view for view in result["views"] if view["used"]]
    assert len(used) > VIEWS // 2
    assert used[0]["source"].startswith("camera at 17000000")
    assert "300 frames" in said and "warning" not in said


@kinds
def test_a_bag_cut_off_at_60_percent_calibrates_and_says_where_it_ends(
    bags, frames: Frames, tmp_path: Path, storage, compression
) -> None:
    file = data_file(bags[storage, compression])
    whole = file.read_bytes()
    cut = tmp_path / file.name
    cut.write_bytes(whole[: len(whole) * 6 // 10])
    result, said = calibrate(tmp_path, cut)
    is_the_camera(result, frames, 0.03)
    (warning,) = [line for line in said.splitlines() if line.startswith("warning: ")]
    assert "ends after" in warning and "cut off" in warning


def test_all_kinds_give_the_same_numbers(bags, tmp_path: Path) -> None:
    results = [calibrate(tmp_path, bag)[0]["parameters"] for bag in bags.values()]
    assert all(result == results[0] for result in results)


def test_a_bare_file_and_a_folder_without_metadata_are_bags_too(bags, tmp_path: Path) -> None:
    file = data_file(bags[KINDS[0]])
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / file.name).write_bytes(file.read_bytes())
    results = [calibrate(tmp_path, bag)[0]["parameters"] for bag in (file, folder)]
    assert results[0] == results[1]
