"""Parameters: from the command line, from files and through the services that every ROS tool uses."""

from pathlib import Path
from typing import Any

import pytest
from rcl_interfaces.msg import ParameterDescriptor, ParameterType, SetParametersResult
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.task import Future

from conftest import Start
from ringcal_process import BOARD, ROOT, RingcalProcess
from robot import Camera, Robot


class Parameters:
    """The parameters of a node, waited for."""

    def __init__(self, robot: Robot, node: str) -> None:
        self._robot = robot
        self._client = AsyncParameterClient(robot.node, node)
        robot.until(self._client.services_are_ready, f"the parameter services of {node}")

    def _wait(self, future: Future) -> Any:
        self._robot.until(future.done, "a parameter service")
        return future.result()

    def names(self) -> list[str]:
        return list(self._wait(self._client.list_parameters()).result.names)

    def get(self, name: str) -> Any:
        (value,) = self._wait(self._client.get_parameters([name])).values
        return parameter_value_to_python(value)

    def set(self, **values: Any) -> list[SetParametersResult]:
        answer = self._wait(self._client.set_parameters([Parameter(n, value=v) for n, v in values.items()]))
        return answer.results

    def describe(self, name: str) -> ParameterDescriptor:
        return self._wait(self._client.describe_parameters([name])).descriptors[0]


@pytest.fixture(scope="module")
def parameters(ringcal: RingcalProcess, robot: Robot) -> Parameters:
    return Parameters(robot, "/ringcal")


def test_they_can_be_listed_and_read(parameters: Parameters) -> None:
    names = parameters.names()
    assert {"board_file", "estimator", "psf", "response_gamma", "min_views", "max_motion_px", "use_sim_time"} <= set(names)
    assert names == sorted(names)
    assert parameters.get("board_file") == str(BOARD)
    assert parameters.get("min_views") == 10
    assert parameters.get("fixed") == []
    assert parameters.get("no_such_parameter") is None


def test_a_change_takes_effect(parameters: Parameters, camera: Camera) -> None:
    (result,) = parameters.set(min_views=7)
    assert result.successful
    assert parameters.get("min_views") == 7
    camera.status(lambda s: s.min_views == 7, "the new minimum")


@pytest.mark.parametrize(
    "name, value",
    [
        ("estimator", "best"),
        ("psf", "pillbox"),
        ("response_gamma", "srgb"),
        ("response_gamma", 9.5),
        ("jpeg_quality", 0),
        ("min_views", "ten"),
        ("board_file", "/nowhere.yaml"),
    ],
)
def test_a_value_that_makes_no_sense_is_refused_with_the_reason(parameters: Parameters, name: str, value: Any) -> None:
    before = parameters.get(name)
    (result,) = parameters.set(**{name: value})
    assert not result.successful
    assert name in result.reason or str(value) in result.reason
    assert parameters.get(name) == before


def test_the_response_is_a_number_or_auto(parameters: Parameters) -> None:
    for value, taken in [(2.2, "2.2"), (2, "2.0"), ("auto", "auto"), ("1.0", "1.0")]:  # the default again at the end
        (result,) = parameters.set(response_gamma=value)
        assert result.successful, result.reason
        assert parameters.get("response_gamma") == taken


def test_each_is_described(parameters: Parameters) -> None:
    assert all(parameters.describe(name).description for name in parameters.names())
    quality = parameters.describe("jpeg_quality")
    assert quality.type == ParameterType.PARAMETER_INTEGER
    (bounds,) = quality.integer_range
    assert (bounds.from_value, bounds.to_value) == (1, 100)


def test_a_params_file_is_read_and_the_command_line_wins(start: Start, robot: Robot, tmp_path: Path) -> None:
    file = tmp_path / "params.yaml"
    file.write_text("/**:\n  ros__parameters: {min_views: 5, max_views: 33}\n/files/ringcal:\n  ros__parameters: {max_views: 44}\n")
    start("--params-file", str(file), "-p", "min_views:=6", "-r", "__ns:=/files")
    parameters = Parameters(robot, "/files/ringcal")
    assert (parameters.get("min_views"), parameters.get("max_views")) == (6, 44)


def test_the_params_file_that_ships_holds_the_defaults(parameters: Parameters, start: Start, robot: Robot) -> None:
    node = start("--params-file", str(ROOT / "config" / "ringcal.yaml"), "-r", "__ns:=/shipped")
    shipped = Parameters(robot, "/shipped/ringcal")
    for name in parameters.names():
        if name != "min_views":  # changed above
            assert shipped.get(name) == parameters.get(name), name
    assert shipped.get("min_views") == 10
    assert "WARN" not in node.log  # every name in it is a parameter of the node


@pytest.mark.parametrize(
    "arguments, says",
    [
        (("-p", "estimator:=best"), "estimator"),
        (("-p", "response_gamma:=0.1"), "response_gamma"),
        (("-p", "board_file:=/nowhere.yaml"), "/nowhere.yaml"),
        (("--no-such-flag",), "--no-such-flag"),
        (("-r", "no rule"), "no rule"),
        (("--params-file", "/nowhere.yaml"), "/nowhere.yaml"),
    ],
)
def test_a_wrong_start_ends_at_once_and_says_why(start: Start, arguments: tuple[str, ...], says: str) -> None:
    node = start(*arguments)
    assert node.wait() in (1, 2)
    assert says in node.log


def test_without_a_board_file_it_says_how_to_give_one(start: Start) -> None:
    node = start(board=None)
    assert node.wait() == 1
    assert "board_file:=" in node.log
