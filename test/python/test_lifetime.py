"""Memory, threads, exceptions, and an interpreter that ends while frames are in flight."""

import gc
import os
import subprocess
import sys
import textwrap
import threading
import time

import pytest

import fuse_flow
from endings import assert_ended_cleanly
from other_threads import most_counted_during
from rigs import rough_frame, wall_frame


def resident_kilobytes():
    with open("/proc/self/status", encoding="ascii") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))


def test_thousands_of_frames_leave_no_memory():
    fusion = fuse_flow.FuseFlow(threads=1, normals=True)
    frames = [rough_frame(seed) for seed in range(4)]

    def run(count):
        kept = None
        for i in range(count):
            frame = fuse_flow.RigFrame(frames[i % 4].cameras, frames[i % 4].views)
            cloud = fusion.fuse(frame)
            kept = (cloud.points, cloud.colors, cloud.array, fusion.statistics)
        return kept

    run(100)
    gc.collect()
    before = resident_kilobytes()
    run(2500)
    gc.collect()
    assert resident_kilobytes() - before < 4096


def test_frames_that_are_refused_leave_no_memory():
    fusion = fuse_flow.FuseFlow(threads=1)
    frame = wall_frame()
    frame.views.append(None)

    def run(count):
        for _ in range(count):
            with pytest.raises(ValueError):
                fusion.fuse(frame)

    run(100)
    before = resident_kilobytes()
    run(3000)
    assert resident_kilobytes() - before < 2048
    frame.views.pop()
    assert len(fusion.fuse(frame)) > 0


def test_each_thread_may_fuse_with_an_object_of_its_own():
    expected = fuse_flow.FuseFlow().fuse(rough_frame()).array.tobytes()
    wrong = []

    def work():
        fusion = fuse_flow.FuseFlow(threads=1)
        frame = rough_frame()
        for _ in range(20):
            if fusion.fuse(frame).array.tobytes() != expected:
                wrong.append(1)

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def test_other_threads_run_while_a_frame_is_fused():
    frame = rough_frame(cameras=8)
    fusion = fuse_flow.FuseFlow(threads=1)
    assert most_counted_during(lambda: fusion.fuse(frame), 20) > 10


def test_a_second_thread_in_one_object_gets_an_error_and_the_first_its_cloud():
    frame = rough_frame(cameras=8)
    expected = fuse_flow.FuseFlow().fuse(frame).array.tobytes()
    fusion = fuse_flow.FuseFlow(threads=1)
    errors, clouds = [], []

    def work():
        for _ in range(30):
            try:
                clouds.append(fusion.fuse(frame).array.tobytes())
            except RuntimeError as error:
                errors.append(str(error))

    threads = [threading.Thread(target=work) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert errors and set(errors) == {
        "fuse_flow.FuseFlow is in use by another thread: each thread needs an object of its own"}
    assert clouds and set(clouds) == {expected}


def test_a_point_too_far_out_is_a_runtime_error_and_the_next_frame_is_fused():
    fusion = fuse_flow.FuseFlow()
    frame = wall_frame()
    near = frame.cameras[0].T_world_camera
    far = near.copy()
    far[0, 3] = 1e7
    frame.cameras[0].T_world_camera = far
    with pytest.raises(RuntimeError):
        fusion.fuse(frame)
    frame.cameras[0].T_world_camera = near
    assert len(fusion.fuse(frame)) > 0


@pytest.mark.parametrize("end", ["pass", "raise SystemExit(0)", "raise KeyError", "import os, signal; os.kill(os.getpid(), signal.SIGINT)"])
def test_the_interpreter_ends_cleanly_with_frames_in_flight(end):
    program = textwrap.dedent("""
        import threading, time
        import fuse_flow
        from rigs import rough_frame
        frame = rough_frame(cameras=8)
        started = threading.Barrier(4)
        def work():
            fusion = fuse_flow.FuseFlow(threads=1)
            fusion.fuse(frame)
            started.wait()
            while True:
                fusion.fuse(frame)
        for _ in range(3):
            threading.Thread(target=work, daemon=True).start()
        started.wait()
        time.sleep(0.05)
        try:
            %s
        except (KeyError, KeyboardInterrupt):
            pass
    """) % end
    run = subprocess.run([sys.executable, "-c", program], cwd=os.path.dirname(__file__), capture_output=True, text=True, timeout=60)
    assert_ended_cleanly(run)
