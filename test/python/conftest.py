import os
import pathlib
import subprocess
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parent))


def tool(name):
    """A program of the build, or None where it was not built."""
    path = pathlib.Path(os.environ.get("FUSE_FLOW_BIN", "build/bin")) / name
    return path if path.exists() else None


@pytest.fixture(scope="session")
def recording(tmp_path_factory):
    """The demo's recording, in small: a person, and four structured-light cameras that are a little off."""
    simulate = tool("fuse_flow_simulate")
    if simulate is None:
        pytest.skip("fuse_flow_simulate was not built")
    folder = tmp_path_factory.mktemp("recording") / "person"
    subprocess.run(
        [simulate, "--scene", "person", "--rig", "ring-4", "--sensor", "structured_light", "--frames", "3", "--fps", "5",
         "--position-error", "2", "--rotation-error", "0.1", "--scale", "0.25", "-o", folder],
        check=True, stdout=subprocess.DEVNULL)
    return folder
