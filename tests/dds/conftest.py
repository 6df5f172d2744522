"""The stage of the DDS tests: a DDS domain of their own on this machine alone, and simulated frames."""

import os
import socket
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import rclpy

from ringcal_process import BINARY, BOARD, ROOT, RingcalProcess
from robot import Camera, Robot
from sequence import Sequence

Start = Callable[..., RingcalProcess]


def _free_domain() -> int:
    """A DDS domain in which nobody on this machine is the first participant, so that runs do not hear one another."""
    for domain in range(1 + os.getpid() % 100, 102):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("", 7400 + 250 * domain + 10))
                return domain
            except OSError:
                continue
    raise RuntimeError("no DDS domain is free")


@pytest.fixture(scope="session", autouse=True)
def domain(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Shuts rclpy and the nodes in: a private domain, loopback, logs in a temporary folder."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", os.environ.get("RINGCAL_TEST_DOMAIN_ID") or str(_free_domain()))
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        patch.setenv("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp")
        patch.setenv("FASTDDS_DEFAULT_PROFILES_FILE", str(ROOT / "config" / "fastdds_large_images.xml"))
        patch.setenv("ROS_HOME", str(tmp_path_factory.mktemp("ros_home")))
        patch.delenv("ROS_LOCALHOST_ONLY", raising=False)
        rclpy.init()
        # as long as there is a node, Fast DDS keeps its participant: the robot is there before the nodes under test
        keeper = rclpy.create_node("keeper")
        yield
        keeper.destroy_node()
        rclpy.shutdown()


@pytest.fixture(scope="session")
def sequence(tmp_path_factory: pytest.TempPathFactory) -> Sequence:
    """Sixteen defocused views, several frames each, and the truth about them."""
    return Sequence.simulate(BINARY, BOARD, tmp_path_factory.mktemp("frames"))


@pytest.fixture(scope="module")
def start(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Start]:
    """Starts nodes with the given ROS arguments, after those that name the board; ends them afterwards."""
    processes: list[RingcalProcess] = []

    def starter(*ros_arguments: str, board: Path | None = BOARD) -> RingcalProcess:
        given = () if board is None else ("-p", f"board_file:={board}")
        log = tmp_path_factory.mktemp("node") / "log"
        processes.append(RingcalProcess(log, *given, *ros_arguments))
        return processes[-1]

    yield starter
    for process in processes:
        process.stop()
        print(f"--- node {process.log_file}\n{process.log}")


@pytest.fixture(scope="module")
def robot() -> Iterator[Robot]:
    robot = Robot("robot")
    yield robot
    robot.close()


@pytest.fixture(scope="module")
def ringcal(start: Start) -> RingcalProcess:
    """A node under its default name, shared by the tests of a file."""
    return start()


@pytest.fixture(scope="module")
def camera(ringcal: RingcalProcess, robot: Robot) -> Camera:
    """A camera that the shared node looks through."""
    return Camera(robot)
