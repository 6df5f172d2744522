"""The end of a node: at once, with exit code 0, and out of the graph."""

import signal

import pytest

from conftest import Start
from robot import Camera, Robot
from sequence import Sequence

# A node that dies without a word stays in the graph until its lease runs out: 50 s for RustDDS.
SOONER_THAN_A_LEASE_S = 10.0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_a_signal_ends_it_and_it_leaves_the_graph(
    start: Start, robot: Robot, sequence: Sequence, number: signal.Signals
) -> None:
    name = f"leaving_{number.name.lower()}"
    node = start("-r", f"__node:={name}")
    camera = Camera(robot, f"/{name}")
    camera.show(sequence.frames[0].pixels)
    robot.until(lambda: robot.knows(name), "the node in the graph")
    assert node.stop(number) == 0
    robot.until(lambda: not robot.knows(name), "the node to leave the graph", SOONER_THAN_A_LEASE_S)
