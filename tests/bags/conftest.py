"""The frames that all bags are made of."""

from pathlib import Path

import pytest

from recording import Frames


@pytest.fixture(scope="session")
def frames(tmp_path_factory: pytest.TempPathFactory) -> Frames:
    return Frames.simulate(tmp_path_factory.mktemp("frames"))
