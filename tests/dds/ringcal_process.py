"""The `ringcal node` process under test."""

import os
import signal
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[2]
BINARY = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "ringcal"
BOARD = ROOT / "config" / "a4.yaml"

# Set for the ROS wheels of this Python; the node needs no ROS and must not get it by accident.
_OF_THE_WHEELS = ("LD_LIBRARY_PATH", "_ROS_WHEELS_BOOTSTRAP_COMPLETE")


class RingcalProcess:
    """One node, started with ROS arguments; its log is a file."""

    def __init__(self, log: Path, *ros_arguments: str) -> None:
        self.log_file = log
        environment = {name: value for name, value in os.environ.items() if name not in _OF_THE_WHEELS}
        with log.open("w") as output:
            self._process = subprocess.Popen(
                [BINARY, "node", "--ros-args", *ros_arguments],
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
            )

    @property
    def log(self) -> str:
        return self.log_file.read_text()

    def is_running(self) -> bool:
        return self._process.poll() is None

    def wait(self, timeout: float = 30) -> int:
        """Its exit code, once it has ended by itself."""
        return self._process.wait(timeout)

    def stop(self, number: signal.Signals = signal.SIGTERM) -> int:
        """Ends it with a signal; the exit code."""
        if self.is_running():
            self._process.send_signal(number)
        try:
            return self._process.wait(30)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
            raise
