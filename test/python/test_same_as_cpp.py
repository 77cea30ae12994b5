"""Python's clouds are C++'s, bit by bit: of the tool, on the demo's recording in small."""

import subprocess

import numpy
import pytest

import fuse_flow
from conftest import tool
from ply import read_ply


def written_by_the_tool(recording, out, *options):
    fuse = tool("fuse_flow_fuse")
    if fuse is None:
        pytest.skip("fuse_flow_fuse was not built")
    subprocess.run([fuse, recording, "-o", out, "--device", "cpu", "--no-quality", *options], check=True, stdout=subprocess.DEVNULL)
    return [read_ply(path) for path in sorted(out.glob("*.ply"))]


def assert_same(cloud, written):
    assert len(cloud) == len(written) > 1000
    names = {"x": "x", "y": "y", "z": "z", "confidence": "confidence", "view_count": "view_count",
             "nx": "normal_x", "ny": "normal_y", "nz": "normal_z"}
    for name in written.dtype.names:
        if name in names:
            assert written[name].tobytes() == cloud.array[names[name]].tobytes(), name
    colors = numpy.stack([written["red"], written["green"], written["blue"]], axis=1)
    assert numpy.array_equal(colors, cloud.colors)


@pytest.mark.parametrize("options, settings", [
    ((), {}),
    (("--published",), {"parameters": fuse_flow.FuseFlowParameters.published()}),
    (("--normals",), {"normals": True}),
    (("--depth-source", "network"), {"parameters": fuse_flow.FuseFlowParameters.estimated_depth()}),
], ids=["defaults", "published", "normals", "estimated depth"])
def test_clouds_are_those_of_fuse_flow_fuse_bit_by_bit(recording, tmp_path, options, settings):
    written = written_by_the_tool(recording, tmp_path / "clouds", *options)
    fusion = fuse_flow.FuseFlow(**settings)
    frames = list(fuse_flow.open(recording))
    assert len(written) == len(frames)
    for frame, cloud in zip(frames, written):
        assert_same(fusion.fuse(frame), cloud)
