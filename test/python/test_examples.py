"""The examples run, and are as short as the guide says."""

import importlib.util
import json
import os
import pathlib
import signal
import subprocess
import sys
import urllib.request

import pytest

EXAMPLES = pathlib.Path(os.environ["FUSE_FLOW_SOURCE"]) / "apps/python/examples"


def run(example, *arguments):
    done = subprocess.run([sys.executable, EXAMPLES / example, *map(str, arguments)], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout


def need(package):
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"no {package}")


@pytest.mark.parametrize("example", sorted(path.name for path in EXAMPLES.glob("*.py")))
def test_an_example_has_fewer_than_forty_lines(example):
    assert len((EXAMPLES / example).read_text().splitlines()) < 40


def test_the_cells_of_the_notebook_run_one_after_the_other(tmp_path):
    need("matplotlib")
    cells = json.loads((EXAMPLES / "first_steps.ipynb").read_text())["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    assert sum(len(cell.splitlines()) for cell in code) < 40 and all(not cell["outputs"] for cell in cells if "outputs" in cell)
    (tmp_path / "cells.py").write_text("\n".join(code))
    first, second = run(tmp_path / "cells.py").splitlines()
    assert first.startswith("Cloud of ") and int(first.split()[2]) > 2 * int(second.split()[2])


def test_the_readmes_five_lines_give_points():
    assert run("five_lines.py").startswith("[[")


def test_arrays_of_ones_own_become_a_picture(tmp_path):
    need("matplotlib")
    said = run("own_arrays.py", tmp_path / "picture.png")
    poses, points = said.splitlines()
    assert poses == "nothing is wrong with the poses" and int(points.split()[0]) > 20000
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")


def test_a_recording_is_shown_in_matplotlib(recording, tmp_path):
    need("matplotlib")
    assert run("show_in_matplotlib.py", recording, tmp_path / "picture.png").startswith("4 cameras, ")
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")


def test_a_recording_is_shown_in_open3d(recording, tmp_path):
    need("open3d")
    assert "points" in run("show_in_open3d.py", recording, tmp_path / "cloud.ply")
    assert (tmp_path / "cloud.ply").stat().st_size > 10000


def test_the_depth_of_a_network_is_fused(recording):
    need("torch")
    lines = run("network_in_pytorch.py", recording).splitlines()
    assert len(lines) == 3 and all(int(line.split()[0]) > 100 and "on cpu" in line for line in lines)


def test_a_rig_is_calibrated(recording, tmp_path):
    import fuse_flow

    said = run("calibrate.py", recording, tmp_path / "rig.json")
    before, after = (float(part.split()[-2]) for part in said.splitlines()[0].replace(" before", "").replace(" after", "").split(","))
    assert after < before
    cameras = fuse_flow.read_rig(tmp_path / "rig.json")
    assert [camera.name for camera in cameras] == [camera.name for camera in fuse_flow.open(recording).cameras]
    assert len(next(iter(fuse_flow.open(recording, poses=str(tmp_path / "rig.json")))).cameras) == 4


def test_cameras_that_run_are_fused_as_they_come(recording):
    lines = run("live_loop.py", recording).splitlines()
    assert 1 <= len(lines) <= 3 and all("points" in line for line in lines)


def test_arrays_become_a_recording(tmp_path):
    lines = run("write_recording.py", tmp_path / "recording").splitlines()
    assert [line.split()[0] for line in lines] == ["0.00", "0.03", "0.07"] and all("Cloud of " in line for line in lines)


def test_fused_clouds_are_streamed_to_browsers(recording):
    import fuse_flow

    if not hasattr(fuse_flow, "StreamServer"):
        pytest.skip("the module was built without streams")
    command = [sys.executable, EXAMPLES / "stream_to_browsers.py", recording]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:
        try:
            link = server.stdout.readline().strip()
            with fuse_flow.StreamClient(link) as client:
                clouds = [client.pull(60) for _ in range(4)]
                assert client.description.name == "fused in Python" and len(client.description.cameras) == 4
            assert all(len(cloud) == cloud.points_of_frame > 100 for cloud in clouds)
            for times in ([cloud.number for cloud in clouds], [cloud.captured for cloud in clouds]):
                assert times == sorted(set(times))
            with fuse_flow.StreamServer(0) as probe:
                if probe.has_page:
                    with urllib.request.urlopen(link) as page:
                        assert b"<html" in page.read()
        finally:
            server.send_signal(signal.SIGINT)
            said = server.communicate(timeout=60)[1]
        assert "KeyboardInterrupt" in said and "terminate" not in said and server.returncode in (1, -signal.SIGINT)
