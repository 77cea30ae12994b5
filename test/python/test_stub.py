"""The stub, which type checkers and editors read."""

import ast
import importlib.util
import os
import pathlib
import subprocess
import sys

import pytest

import fuse_flow

PACKAGE = pathlib.Path(fuse_flow.__file__).parent


def test_the_stub_has_every_name_of_the_module():
    assert (PACKAGE / "py.typed").exists()
    tree = ast.parse((PACKAGE / "__init__.pyi").read_text())
    declared = {node.name: node for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    public = {name for name, value in vars(fuse_flow).items() if not name.startswith("_") and callable(value)}
    assert set(declared) == public
    for name in public:
        cls = getattr(fuse_flow, name)
        if not isinstance(cls, type) or hasattr(cls, "__members__"):
            continue
        members = {node.name for node in declared[name].body if isinstance(node, ast.FunctionDef)}
        assert {member for member in vars(cls) if not member.startswith("_")} <= members, name


WITH_STREAMS = """
server = fuse_flow.StreamServer(0, encoding=fuse_flow.StreamEncoding(chroma_step=4))
server.publish(cloud)
server.publish(numpy.zeros((7, 3)), colors=numpy.zeros((7, 3), numpy.uint8))
client = fuse_flow.StreamClient(server.link)
client.wish(region=((0, 0, 0), numpy.ones(3)), points=1000)
with fuse_flow.StreamWriter("stream.ffs", name="all") as stream:
    received = client.pull(1)
    if received is not None:
        stream.write(received, captured=5)
for streamed in fuse_flow.StreamReader("stream.ffs"):
    number: int = streamed.number
"""


def test_the_examples_pass_a_strict_type_check(tmp_path):
    if importlib.util.find_spec("mypy") is None:
        pytest.skip("no mypy")
    program = tmp_path / "program.py"
    program.write_text(
        "import numpy\n"
        "import fuse_flow\n"
        "camera = fuse_flow.Camera(fuse_flow.Intrinsics(640, 480, 525, 525, 319.5, 239.5), numpy.eye(4), depth_scale=0.001)\n"
        "camera.noise = fuse_flow.NoiseModel(floor=0.001)\n"
        "view = fuse_flow.DepthView(numpy.zeros((480, 640), numpy.uint16))\n"
        "fusion = fuse_flow.FuseFlow('cpu', normals=True, parameters=fuse_flow.FuseFlowParameters.published())\n"
        "fusion.parameters.confidence.form = fuse_flow.ConfidenceForm.GIVEN\n"
        "fusion.parameters.crop_box = ((0, 0, 0), (1, 1, 1))\n"
        "cloud: fuse_flow.Cloud = fusion.fuse(fuse_flow.RigFrame([camera], [view, None]))\n"
        "points: numpy.ndarray = cloud.points\n"
        "with fuse_flow.RigWriter('recording', [camera], 30) as writer:\n"
        "    writer.write(fuse_flow.RigFrame([camera], [view]))\n"
        "with fuse_flow.LiveRig(['openni2:#1'], stalls=[(0, 1, 2)]) as rig:\n"
        "    for live in rig:\n"
        "        fused: fuse_flow.Cloud = fusion.fuse(live)\n"
        "for frame in fuse_flow.open('recording', views='0,1'):\n"
        "    stamp: int = frame.stamp\n"
        + (WITH_STREAMS if hasattr(fuse_flow, "StreamServer") else ""))
    check = [sys.executable, "-m", "mypy", "--strict", "--allow-any-generics", "--cache-dir", str(tmp_path)]
    environment = {**os.environ, "MYPYPATH": str(PACKAGE.parent)}  # before 0.990 it does not look where Python does
    for file in (program, PACKAGE / "__init__.pyi"):
        run = subprocess.run([*check, str(file)], capture_output=True, text=True, env=environment)
        assert run.returncode == 0, run.stdout
    program.write_text("import fuse_flow\nfuse_flow.FuseFlow().parameters.confidence.treshold = 0.5\n")
    assert subprocess.run([*check, str(program)], capture_output=True, env=environment).returncode != 0
