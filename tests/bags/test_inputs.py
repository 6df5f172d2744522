"""Which topic, which frames, and what the other commands do with a bag."""

import json
import re
from pathlib import Path

import pytest
from PIL import Image
from rosbags.rosbag2 import StoragePlugin

from recording import BOARD, COMPRESSED, FRAMES_PER_VIEW, Frames, calibrate, encoded, of_raw, ringcal, write


@pytest.fixture(scope="session")
def stereo(frames: Frames, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bag with two topics with images: the frames as they are, and dark ones."""
    path = tmp_path_factory.mktemp("stereo") / "bag"
    topics = {"/left/image_raw": of_raw(frames.pixels), "/right/image_raw": of_raw(p // 50 for p in frames.pixels[:5])}
    return write(path, topics, StoragePlugin.SQLITE3)


def test_of_several_topics_one_is_asked_for(stereo: Path, tmp_path: Path) -> None:
    for command in (["detect"], ["calibrate", "--output", tmp_path]):
        done = ringcal(*command, stereo, "--board", BOARD)
        assert done.returncode == 1
        assert "/left/image_raw  sensor_msgs/msg/Image  75 messages" in done.stderr
        assert "/right/image_raw  sensor_msgs/msg/Image  5 messages" in done.stderr
        assert "--topic" in done.stderr
    result, said = calibrate(tmp_path, stereo, "--topic", "/left/image_raw")
    assert "75 frames" in said and len(result["views"]) > 10


def test_the_report_of_a_bag_shows_its_views_and_counts_the_other_frames(
    stereo: Path, frames: Frames, tmp_path: Path
) -> None:
    result, _ = calibrate(tmp_path, stereo, "--topic", "/left/image_raw")
    page = (tmp_path / "out" / "report.html").read_text()
    assert page.count("<image ") == min(12, len(result["views"]))
    counts = re.findall(r"<td class=\"source\">(\d+) frames of bags</td>", page)
    assert sum(map(int, counts)) + len(result["views"]) == 75
    # of a bag that gives no calibration it says what became of the frames
    bag = write(tmp_path / "grey", {"/image": of_raw(p // 250 for p in frames.pixels[:5])})
    done = ringcal("calibrate", bag, "--board", BOARD, "--output", tmp_path / "none")
    assert done.returncode == 1 and "0 views" in done.stderr
    page = (tmp_path / "none" / "report.html").read_text()
    assert "found in none of the 5 inputs" in page and "without the board; the first of them: too dark" in page


def test_a_topic_that_is_not_there_is_named(stereo: Path) -> None:
    done = ringcal("detect", stereo, "--board", BOARD, "--topic", "/middle")
    assert done.returncode == 1 and "/middle" in done.stderr and "/left/image_raw" in done.stderr


def test_detect_gives_a_line_for_every_frame_in_order(frames: Frames, tmp_path: Path) -> None:
    bag = write(tmp_path / "bag", {"/image": of_raw(frames.pixels[:9])})
    done = ringcal("detect", bag, "--board", BOARD, "--format", "jsonl")
    assert done.returncode == 0, done.stderr
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert [line["frame"] for line in lines] == list(range(9))
    assert all(line["image"] == str(bag) and line["found"] for line in lines)
    assert lines[3]["stamp"] == {"sec": 1_700_000_000, "nanosec": 99_999_999}


def test_compressed_images_give_the_numbers_of_raw_ones(frames: Frames, tmp_path: Path) -> None:
    def picture(pixels) -> bytes:
        path = tmp_path / "picture.png"
        Image.fromarray(pixels).save(path)
        return path.read_bytes()

    messages = (encoded(at, picture(pixels)) for at, pixels in enumerate(frames.pixels))
    compressed = write(tmp_path / "compressed", {"/image/compressed": (COMPRESSED, messages)})
    plain = write(tmp_path / "raw", {"/image": of_raw(frames.pixels)})
    results = [calibrate(tmp_path, bag)[0]["parameters"] for bag in (compressed, plain)]
    assert results[0] == results[1]


def test_check_holds_a_bag_against_a_calibration(frames: Frames, tmp_path: Path) -> None:
    bag = write(tmp_path / "bag", {"/image": of_raw(frames.pixels)})
    calibrate(tmp_path, bag)
    info = tmp_path / "out" / "camera_info.yaml"
    done = ringcal("check", bag, "--board", BOARD, "--camera-info", info, "--format", "json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["rms_px"] < 0.2


def test_messages_that_are_damaged_are_passed_over(frames: Frames, tmp_path: Path) -> None:
    kind, messages = of_raw(frames.pixels)
    damaged = [m[: len(m) // 2] if at % (2 * FRAMES_PER_VIEW) == 0 else m for at, m in enumerate(messages)]
    bag = write(tmp_path / "bag", {"/image": (kind, damaged)}, StoragePlugin.SQLITE3)
    result, said = calibrate(tmp_path, bag)
    assert len(result["views"]) > 10
    assert "frame 0: the message ends in the middle of its data" in said and "13 without a picture" in said
