"""What the ROS graph shows of the node, under any name, and who it hears."""

import pytest
from rclpy.qos import QoSProfile

from conftest import Start
from ringcal_process import RingcalProcess
from robot import BEST_EFFORT, LATCHED, RELIABLE, Camera, Robot
from sequence import Sequence

from ringcal.msg import CalibrationStatus

TRIGGERS = ("calibrate", "reset", "save")
PARAMETER_SERVICES = (
    "describe_parameters",
    "get_parameter_types",
    "get_parameters",
    "list_parameters",
    "set_parameters",
    "set_parameters_atomically",
)
PUBLISHED = {
    "/ringcal/centres": "ringcal/msg/RingCentreArray",
    "/ringcal/status": "ringcal/msg/CalibrationStatus",
    "/ringcal/camera_info": "sensor_msgs/msg/CameraInfo",
    "/ringcal/debug_image": "sensor_msgs/msg/Image",
    "/ringcal/debug_image/compressed": "sensor_msgs/msg/CompressedImage",
    "/ringcal/enhanced_image": "sensor_msgs/msg/Image",
    "/ringcal/enhanced_image/compressed": "sensor_msgs/msg/CompressedImage",
    "/parameter_events": "rcl_interfaces/msg/ParameterEvent",
    "/rosout": "rcl_interfaces/msg/Log",
}


def test_the_node_is_in_the_graph_with_all_it_offers(ringcal: RingcalProcess, robot: Robot) -> None:
    robot.until(lambda: robot.knows("ringcal"), "the node in the graph")
    node = robot.node
    robot.until(
        lambda: PUBLISHED.keys() <= dict(node.get_publisher_names_and_types_by_node("ringcal", "/")).keys(),
        "the node's topics",
    )
    published = dict(node.get_publisher_names_and_types_by_node("ringcal", "/"))
    assert {name: published[name] for name in PUBLISHED} == {name: [kind] for name, kind in PUBLISHED.items()}
    robot.until(
        lambda: "/image" in dict(node.get_subscriber_names_and_types_by_node("ringcal", "/")),
        "the node's subscription",
    )
    subscribed = dict(node.get_subscriber_names_and_types_by_node("ringcal", "/"))
    assert subscribed["/image"] == ["sensor_msgs/msg/Image"]
    expected = {f"/ringcal/{name}" for name in TRIGGERS + PARAMETER_SERVICES}
    robot.until(
        lambda: expected <= dict(node.get_service_names_and_types_by_node("ringcal", "/")).keys(),
        "the node's services",
    )
    services = dict(node.get_service_names_and_types_by_node("ringcal", "/"))
    assert all(services[f"/ringcal/{name}"] == ["std_srvs/srv/Trigger"] for name in TRIGGERS)


@pytest.mark.parametrize("qos", [BEST_EFFORT, RELIABLE], ids=["best effort", "reliable"])
def test_every_publisher_is_heard(ringcal: RingcalProcess, robot: Robot, sequence: Sequence, qos: QoSProfile) -> None:
    assert len(Camera(robot, qos=qos).show(sequence.frames[0].pixels).centres) == 35


def test_two_nodes_under_their_own_names_hear_their_own_cameras(start: Start, robot: Robot, sequence: Sequence) -> None:
    start("-r", "__ns:=/left", "-r", "image:=camera/image_raw")
    start("-r", "__node:=eye", "-r", "__ns:=/right", "-r", "image:=/cameras/right", "-r", "~/centres:=/found")
    left = Camera(robot, "/left/ringcal", "/left/camera/image_raw")
    robot.until(lambda: robot.knows("ringcal", "/left") and robot.knows("eye", "/right"), "both nodes")
    assert len(left.show(sequence.frames[0].pixels).centres) == 35

    def topics() -> dict[str, list[str]]:
        return dict(robot.node.get_publisher_names_and_types_by_node("eye", "/right"))

    def heard() -> dict[str, list[str]]:
        return dict(robot.node.get_subscriber_names_and_types_by_node("eye", "/right"))

    robot.until(lambda: {"/right/eye/status", "/found"} <= topics().keys(), "the second node's topics")
    assert "/right/eye/centres" not in topics()
    robot.until(lambda: "/cameras/right" in heard(), "the second node's subscription")
    assert "/right/image" not in heard()
    assert robot.trigger("/right/eye/reset").success


def test_nodes_started_at_the_same_moment_are_all_heard(start: Start, robot: Robot) -> None:
    namespaces = [f"/crowd{i}" for i in range(3)]
    statuses = [robot.listen(CalibrationStatus, f"{namespace}/ringcal/status", LATCHED) for namespace in namespaces]
    for namespace in namespaces:
        start("-r", f"__ns:={namespace}")
    robot.until(lambda: all(statuses), "a status of every node")
    robot.until(lambda: all(robot.knows("ringcal", namespace) for namespace in namespaces), "every node in the graph")
