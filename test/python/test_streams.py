"""A server and a client of its stream, in one program."""

import os
import subprocess
import sys
import textwrap
import time

import numpy
import pytest

import fuse_flow
from rigs import wall_frame

pytestmark = pytest.mark.skipif(not hasattr(fuse_flow, "StreamServer"), reason="the module was built without streams")


def receive(server, client, cloud, number=0):
    for _ in range(100):
        server.publish(cloud, number)
        received = client.pull(0.1)
        if received is not None:
            return received
    raise AssertionError(client.error)


def test_a_cloud_arrives_as_it_was_to_half_a_step():
    cloud = fuse_flow.FuseFlow(normals=True).fuse(wall_frame())
    with fuse_flow.StreamServer(0, step=0.002) as server, fuse_flow.StreamClient(server.link) as client:
        server.describe("a wall", wall_frame().cameras)
        received = receive(server, client, cloud, 7)
        assert len(received) == len(cloud) == received.points_of_frame and received.number == 7 and received.step == 0.002
        low, high = received.points.min(axis=0), received.points.max(axis=0)
        assert numpy.abs(low - cloud.points.min(axis=0)).max() < 0.0011 and numpy.abs(high - cloud.points.max(axis=0)).max() < 0.0011
        assert (received.colors == (200, 120, 40)).all()
        assert received.confidence.max() <= 1 and received.view_count.max() == 2 and received.normals.shape == received.points.shape
        assert client.connected and server.watched


def test_arrays_of_a_received_cloud_stay():
    cloud = fuse_flow.FuseFlow().fuse(wall_frame())
    with fuse_flow.StreamServer(0) as server:
        with fuse_flow.StreamClient(server.link) as client:
            points = receive(server, client, cloud).points
            receive(server, client, cloud)
    assert numpy.abs(points[:, 2] - 1).max() < 0.001


def test_a_pull_ends_with_its_time_and_a_closed_end_says_so():
    server = fuse_flow.StreamServer(0)
    client = fuse_flow.StreamClient(server.link)
    begin = time.monotonic()
    assert client.pull(0.2) is None and time.monotonic() - begin < 20
    client.close()
    server.close()
    with pytest.raises(RuntimeError, match="StreamClient is closed"):
        client.pull(0)
    with pytest.raises(RuntimeError, match="StreamServer is closed"):
        server.link


def test_wrong_options_are_refused():
    with pytest.raises(ValueError, match="token"):
        fuse_flow.StreamServer(0, address="0.0.0.0")
    with pytest.raises(ValueError):
        fuse_flow.StreamServer(0, step=-1)
    with pytest.raises(ValueError):
        fuse_flow.StreamClient("ftp://127.0.0.1/")


def test_the_interpreter_ends_cleanly_with_a_stream_open():
    program = textwrap.dedent("""
        import threading, time
        import fuse_flow
        from rigs import wall_frame
        cloud = fuse_flow.FuseFlow().fuse(wall_frame())
        server = fuse_flow.StreamServer(0)
        client = fuse_flow.StreamClient(server.link)
        def pull():
            while True:
                client.pull(10)
        threading.Thread(target=pull, daemon=True).start()
        for _ in range(5):
            server.publish(cloud)
            time.sleep(0.02)
    """)
    run = subprocess.run([sys.executable, "-c", program], cwd=os.path.dirname(__file__), capture_output=True, text=True, timeout=60)
    assert run.returncode == 0, run.stderr
    errors = [line for line in run.stderr.splitlines() if "Error" in line or "terminate" in line]
    assert all("the interpreter is ending" in line or "is closed" in line for line in errors), run.stderr
