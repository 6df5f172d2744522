"""The ringcal node for one camera.

ros2 launch ringcal ringcal.launch.py image:=/camera/image_raw board_file:=/absolute/path/to/board.yaml
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    config = PathJoinSubstitution([FindPackageShare("ringcal"), "config"])
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "image", default_value="image", description="topic of the camera's images, sensor_msgs/msg/Image"
            ),
            DeclareLaunchArgument(
                "board_file",
                default_value=PathJoinSubstitution([config, "a4.yaml"]),
                description="the board, see share/ringcal/config",
            ),
            DeclareLaunchArgument(
                "params_file",
                default_value=PathJoinSubstitution([config, "ringcal.yaml"]),
                description="parameters of the node; the arguments given here win",
            ),
            DeclareLaunchArgument("namespace", default_value="", description="namespace of the node"),
            Node(
                package="ringcal",
                executable="ringcal_node",
                name="ringcal",
                namespace=LaunchConfiguration("namespace"),
                output="screen",
                parameters=[
                    LaunchConfiguration("params_file"),
                    # a string even where it looks like a number
                    {"board_file": ParameterValue(LaunchConfiguration("board_file"), value_type=str)},
                ],
                remappings=[("image", LaunchConfiguration("image"))],
            ),
        ]
    )
