"""Hours of video: what is passed over, what is told on the way, how it is broken off, and how much memory it takes."""

import os
import signal
import subprocess
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin

from recording import BINARY, BOARD, Frames, calibrate, of_raw, raw, write


def test_a_board_that_is_held_longer_changes_nothing(frames: Frames, tmp_path: Path) -> None:
    results = []
    for times in (1, 4):
        bag = write(tmp_path / str(times), {"/image": of_raw(frames.film(times))})
        result, said = calibrate(tmp_path, bag)
        assert "not looked at: as the frames before" in said
        results.append(result["parameters"])
    assert results[0] == results[1]


def test_quiet_tells_nothing_of_what_goes_well(frames: Frames, tmp_path: Path) -> None:
    bag = write(tmp_path / "bag", {"/image": of_raw(frames.pixels)})
    _, said = calibrate(tmp_path, bag, "--quiet")
    assert all(line.startswith("wrote ") for line in said.splitlines()), said


def test_the_same_whatever_the_number_of_threads(frames: Frames, tmp_path: Path, monkeypatch) -> None:
    bag = write(tmp_path / "bag", {"/image": of_raw(frames.pixels)})
    results = []
    for threads in ("1", "3"):
        monkeypatch.setenv("RAYON_NUM_THREADS", threads)
        results.append(calibrate(tmp_path, bag)[0])
    assert results[0] == results[1]


def test_ctrl_c_calibrates_with_what_there_is(frames: Frames, tmp_path: Path) -> None:
    # a damaged message says when the process is in the middle; far more than it can have done by then follow
    count, places = 1500, len(frames.pixels)
    messages = [raw(at, pixels) for at, pixels in enumerate(frames.pixels)]
    messages.append(messages[-1][:1000])
    messages += [raw(at, frames.pixels[at * 7 % places]) for at in range(len(messages), count)]
    bag = write(tmp_path / "bag", {"/image": ("sensor_msgs/msg/Image", messages)})
    command = [BINARY, "calibrate", bag, "--board", BOARD, "--output", tmp_path / "out"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
    said = []
    for line in process.stderr:
        said.append(line)
        if "frame 75: the message ends" in line:
            process.send_signal(signal.SIGINT)
    assert process.wait() == 0, said
    (stopped,) = [line for line in said if "stopped after" in line]
    assert places < int(stopped.split("stopped after ")[1].split()[0]) < count
    assert (tmp_path / "out" / "camera_info.yaml").exists()


def peak_kb(bag: Path, folder: Path) -> int:
    command = [BINARY, "calibrate", bag, "--board", BOARD, "--output", folder]
    with open(os.devnull, "w") as nowhere:
        process = subprocess.Popen(command, stderr=nowhere, stdout=nowhere)
        _, _, usage = os.wait4(process.pid, 0)
    return usage.ru_maxrss


def test_memory_does_not_grow_with_the_length(tmp_path: Path) -> None:
    random = np.random.default_rng(1)
    # noise: no frame repeats another, and none has a board
    noise = [random.integers(0, 255, (48, 64), dtype=np.uint8) for _ in range(50)]
    for storage in (StoragePlugin.MCAP, StoragePlugin.SQLITE3):
        peaks = []
        for count in (1000, 10000):
            film = (noise[at % len(noise)] for at in range(count))
            bag = write(tmp_path / f"{storage.name}{count}", {"/image": of_raw(film)}, storage)
            peaks.append(peak_kb(bag, tmp_path / "out"))
        # ten times as long; a tenth is what the allocator does as it likes
        assert peaks[1] < 1.1 * peaks[0] + 1000, peaks
