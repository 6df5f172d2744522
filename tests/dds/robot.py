"""What a user of the node does, with the real rclpy and nothing else."""

import time
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
import rclpy
from builtin_interfaces.msg import Time
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger

from ringcal.msg import CalibrationStatus, RingCentreArray

T = TypeVar("T")

# Long enough for a slow machine under load: no test waits this long unless it fails.
PATIENCE_S = 60.0
# How often a frame is sent before it counts as ignored.
ATTEMPTS = 12
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
RELIABLE = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)


class Robot:
    """A node of rclpy that listens, calls and waits; spun only while it waits."""

    def __init__(self, name: str) -> None:
        self.node = rclpy.create_node(name)

    def close(self) -> None:
        self.node.destroy_node()

    def until(self, condition: Callable[[], T], what: str, patience_s: float = PATIENCE_S) -> T:
        """Spins until `condition` is true and returns its value; fails with `what` was waited for."""
        deadline = time.monotonic() + patience_s
        while not (value := condition()):
            if time.monotonic() > deadline:
                raise AssertionError(f"waited {patience_s} s in vain for {what}")
            rclpy.spin_once(self.node, timeout_sec=0.05)
        return value

    def listen(self, message_type: type[T], topic: str, qos: QoSProfile = QoSProfile(depth=100)) -> list[T]:
        """Subscribes; the list grows as messages come."""
        received: list[T] = []
        self.node.create_subscription(message_type, topic, received.append, qos)
        return received

    def call(self, service_type: Any, service: str, request: Any = None) -> Any:
        client = self.node.create_client(service_type, service)
        self.until(client.service_is_ready, f"service {service}")
        future = client.call_async(request or service_type.Request())
        self.until(future.done, f"the answer of {service}")
        self.node.destroy_client(client)
        return future.result()

    def trigger(self, service: str) -> Trigger.Response:
        return self.call(Trigger, service)

    def knows(self, name: str, namespace: str = "/") -> bool:
        return (name, namespace) in self.node.get_node_names_and_namespaces()


class Camera:
    """Publishes frames to one ringcal node and hears what it says about them."""

    def __init__(self, robot: Robot, node: str = "/ringcal", topic: str = "/image", qos: QoSProfile = RELIABLE) -> None:
        self.robot = robot
        self.node = node
        self.centres = robot.listen(RingCentreArray, f"{node}/centres")
        self.statuses = robot.listen(CalibrationStatus, f"{node}/status", LATCHED)
        self._publisher = robot.node.create_publisher(Image, topic, qos)
        self._frames = 0
        robot.until(lambda: self._publisher.get_subscription_count() == 1, f"a subscriber of {topic}")
        robot.until(lambda: self.statuses, f"the first status of {node}")

    def image(self, pixels: np.ndarray, frame_id: str = "camera", encoding: str = "mono8") -> Image:
        """A message with a stamp of its own."""
        self._frames += 1
        stamp = Time(sec=1000 + self._frames // 30, nanosec=self._frames % 30 * 33_333_333)
        height, width = pixels.shape[:2]
        image = Image(height=height, width=width, encoding=encoding, step=pixels.strides[0])
        image.header.stamp = stamp
        image.header.frame_id = frame_id
        image.data = pixels.tobytes()
        return image

    def publish(self, image: Image) -> None:
        self._publisher.publish(image)

    def show(self, image: Image | np.ndarray) -> RingCentreArray:
        """Publishes a frame and waits for its centres. The node subscribes best effort, as it must to hear
        every camera, so a frame may be lost on the way and is sent again then."""
        message = image if isinstance(image, Image) else self.image(image)

        def answer() -> RingCentreArray | None:
            return next((c for c in reversed(self.centres) if c.header == message.header), None)

        for _ in range(ATTEMPTS):
            self.publish(message)
            try:
                return self.robot.until(answer, "the centres of a frame", PATIENCE_S / ATTEMPTS)
            except AssertionError:
                continue
        raise AssertionError(f"no centres for the frame; last status: {self.statuses[-1]}")

    def status(self, condition: Callable[[CalibrationStatus], bool], what: str) -> CalibrationStatus:
        """Waits until the latest status fulfils `condition`."""
        self.robot.until(lambda: condition(self.statuses[-1]), f"a status with {what}")
        return self.statuses[-1]

    def trigger(self, service: str) -> Trigger.Response:
        return self.robot.trigger(f"{self.node}/{service}")
