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
    image = LaunchConfiguration("image")
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "image", default_value="image", description="topic of the camera's images, without /compressed"
            ),
            DeclareLaunchArgument(
                "image_transport", default_value="raw", choices=["raw", "compressed"], description="form of the images"
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
            DeclareLaunchArgument(
                "set_camera_info",
                default_value="set_camera_info",
                description="the camera driver's service, which ~/commit calls",
            ),
            Node(
                package="ringcal",
                executable="ringcal_node",
                name="ringcal",
                namespace=LaunchConfiguration("namespace"),
                output="screen",
                parameters=[
                    LaunchConfiguration("params_file"),
                    {
                        # strings even where they look like numbers
                        "board_file": ParameterValue(LaunchConfiguration("board_file"), value_type=str),
                        "image_transport": ParameterValue(LaunchConfiguration("image_transport"), value_type=str),
                    },
                ],
                remappings=[
                    ("image", image),
                    ("image/compressed", [image, "/compressed"]),
                    ("set_camera_info", LaunchConfiguration("set_camera_info")),
                ],
            ),
        ]
    )
