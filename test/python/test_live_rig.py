"""Cameras that run: recordings that are played as if they did, and devices that are not there."""

import gc
import os
import subprocess
import sys
import textwrap
import time

import numpy
import pytest

import fuse_flow
from endings import assert_ended_cleanly
from other_threads import most_counted_during


def depths(frame):
    return [None if view is None else view.depth for view in frame.views]


def test_a_recording_is_played_to_its_end(recording):
    written = [[view.depth.tobytes() for view in frame.views] for frame in fuse_flow.open(recording)]
    begin = time.monotonic()
    patient = fuse_flow.SynchronizerParameters(max_wait=2.0)  # so that frames are whole, however busy the machine is
    with fuse_flow.LiveRig(recording, speed=0.5, parameters=patient) as rig:
        assert [camera.name for camera in rig.cameras] == [camera.name for camera in fuse_flow.open(recording).cameras]
        assert rig.running
        frames = list(rig)
        took = time.monotonic() - begin
        assert not rig.running and rig.next(0) is None
        assert all(status.received == 3 and status.lost == 0 for status in rig.status)
    assert 0.8 <= took < 60  # 0.4 s from the first to the last frame, at half the speed
    assert 1 <= len(frames) <= 3 and [frame.stamp for frame in frames] == sorted({frame.stamp for frame in frames})
    for frame in frames:
        seen = [depth.tobytes() if depth is not None else None for depth in depths(frame)]
        assert any(all(a in (None, b) for a, b in zip(seen, whole)) for whole in written)
    assert all(depth is not None for depth in depths(frames[-1]))


def test_arrays_of_a_frame_stay_and_cannot_be_written_to(recording):
    rig = fuse_flow.LiveRig(str(recording), loop=True, preload=True)
    frame = rig.next(60)
    depth = next(depth for depth in depths(frame) if depth is not None)
    before = depth.copy()
    with pytest.raises(ValueError, match="read-only"):
        depth[0, 0] = 1
    for _ in range(4):
        rig.next(60)
    rig.close()
    del rig, frame
    gc.collect()
    assert numpy.array_equal(depth, before)


def test_what_runs_is_fused_without_the_camera_that_stalls(recording):
    fusion = fuse_flow.FuseFlow()
    with fuse_flow.LiveRig(recording, loop=True, speed=4, stalls=[(1, 0, 86400)]) as rig:
        for count, frame in enumerate(rig):
            assert frame.views[1] is None
            assert len(fusion.fuse(frame)) > 100 and 1 in fusion.statistics.missing_cameras
            if count == 4:
                break
        end = time.monotonic() + 60
        while rig.status[1].silent is None and time.monotonic() < end:
            rig.next(0.1)
        assert rig.status[1].silent > 0.9
        assert rig.status[1].received == 0 < rig.status[0].used
        assert rig.status[0].clock_offset.total_seconds() == 0
        assert any(rig.cameras[1].name in line for line in rig.take_notices()) and rig.take_notices() == []


def test_a_closed_rig_says_so(recording):
    rig = fuse_flow.LiveRig(recording, loop=True)
    rig.close()
    with pytest.raises(RuntimeError, match="LiveRig is closed"):
        rig.next(0)


def test_other_threads_run_while_images_are_waited_for(recording):
    with fuse_flow.LiveRig(recording, stalls=[(k, 0, 86400) for k in range(4)]) as rig:

        def wait():
            assert rig.next(0.3) is None

        assert most_counted_during(wait, 1) > 3


def test_what_cannot_run_is_said(recording, tmp_path):
    for values, right in [({"speed": 0}, "speed is 0.0.*, must be 0.001 to 1000"),
                          ({"jitter": -1}, "jitter"),
                          ({"drop": 2}, "drop"),
                          ({"stalls": [(9, 0, 1)]}, "stalls has the number 9"),
                          ({"stalls": [(0, 0, 0)]}, "a stall's duration"),
                          ({"parameters": fuse_flow.SynchronizerParameters(tolerance=0.0)}, "tolerance")]:
        with pytest.raises(ValueError, match=right):
            fuse_flow.LiveRig(recording, **values)
    with pytest.raises(ValueError, match="nowhere"):
        fuse_flow.LiveRig(tmp_path / "nowhere")
    with pytest.raises(ValueError, match="source is empty"):
        fuse_flow.LiveRig([])
    with pytest.raises(ValueError, match="is no device, as the others are"):
        fuse_flow.LiveRig(["openni2:#1", recording])
    for name in ("openni2:#9", "realsense:0123", "k4a:7", "orbbec:#7"):
        with pytest.raises(ValueError, match=name.split(":")[0]):
            fuse_flow.LiveRig(name)
    assert any("realsense" in line for line in fuse_flow.list_devices())


def test_the_interpreter_ends_cleanly_with_cameras_that_run(recording):
    program = textwrap.dedent("""
        import sys, threading, time
        import fuse_flow
        rig = fuse_flow.LiveRig(sys.argv[1], loop=True, speed=20)
        def fuse():
            fusion = fuse_flow.FuseFlow(threads=1)
            for frame in rig:
                fusion.fuse(frame)
        threading.Thread(target=fuse, daemon=True).start()
        other = fuse_flow.LiveRig(sys.argv[1], loop=True)
        time.sleep(0.5)
    """)
    run = subprocess.run([sys.executable, "-c", program, recording], cwd=os.path.dirname(__file__), capture_output=True, text=True, timeout=60)
    assert_ended_cleanly(run)
