"""Views of several cameras, put together by their stamps, and a stereo frame."""

import datetime
import gc
import sys
import threading
import time
import weakref

import numpy
import pytest

import fuse_flow
from scenes import corner_frame


def shared(**values):
    return fuse_flow.SynchronizerParameters(clocks=fuse_flow.ClockModel.SHARED, **values)


def test_views_of_one_instant_come_as_a_set():
    synchronizer = fuse_flow.ViewSynchronizer(2, shared())
    synchronizer.push(0, 1000, "left")
    assert synchronizer.take() is None
    synchronizer.push(1, 3000, "right")
    together = synchronizer.take()
    assert together.views == ["left", "right"] and together.stamps == [1000, 3000] and together.stamp == 2000
    assert together.spread == datetime.timedelta(microseconds=2000)
    assert synchronizer.statistics.complete_sets == 1 and synchronizer.statistics.cameras[1].used == 1


def test_a_wait_ends_with_a_set_or_with_its_time():
    synchronizer = fuse_flow.ViewSynchronizer(1, shared())
    assert synchronizer.wait(0.01) is None
    threading.Timer(0.1, synchronizer.push, (0, 5, "late")).start()
    assert synchronizer.wait(20).views == ["late"]


def test_views_are_let_go_in_any_thread():
    class View:
        pass

    synchronizer = fuse_flow.ViewSynchronizer(1, shared(capacity=2))
    views = [View() for _ in range(10)]
    gone = [weakref.ref(view) for view in views]

    def push():
        for stamp, view in enumerate(views):
            synchronizer.push(0, 33000 * stamp, view)

    thread = threading.Thread(target=push)
    thread.start()
    thread.join()
    last = synchronizer.wait(5).views[0]
    assert last is views[-1]
    del views, push, thread
    gc.collect()
    assert [reference() is not None for reference in gone] == [False] * 9 + [True]
    count = sys.getrefcount(last)
    del synchronizer
    assert sys.getrefcount(last) == count


def test_durations_and_numbers_of_cameras_are_checked():
    with pytest.raises(ValueError):
        fuse_flow.ViewSynchronizer(0)
    with pytest.raises(ValueError, match="tolerance"):
        fuse_flow.ViewSynchronizer(1, shared(tolerance=0.0))
    with pytest.raises(ValueError):
        fuse_flow.ViewSynchronizer(1).push(1, 0, None)
    with pytest.raises(ValueError, match="timeout is -1"):
        fuse_flow.ViewSynchronizer(1).wait(-1)
    assert shared(tolerance=0.004).tolerance == datetime.timedelta(milliseconds=4)


def test_cameras_that_run_are_fused():
    frame = corner_frame()
    synchronizer = fuse_flow.ViewSynchronizer(4, shared())
    stop = threading.Event()

    def grab(i):
        k = 0
        while not stop.is_set():
            synchronizer.push(i, 33333 * k, frame.views[i])
            k += 1
            time.sleep(0.01)

    threads = [threading.Thread(target=grab, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    fusion = fuse_flow.FuseFlow()
    try:
        for _ in range(5):
            together = synchronizer.wait(10)
            cloud = fusion.fuse(fuse_flow.RigFrame(frame.cameras, together.views, together.stamp))
            assert len(cloud) > 100 and cloud.stamp == together.stamp
    finally:
        stop.set()
        for thread in threads:
            thread.join()


def test_stereo_finds_the_depth_of_what_cameras_see():
    frame = corner_frame(eyes=((2.2, 1.6, 1.3), (2.05, 1.8, 1.3), (1.9, 2.0, 1.3)), color=True)
    truth = [view.depth for view in frame.views]
    for view in frame.views:
        view.depth = None
    errors = fuse_flow.epipolar_errors(frame)
    assert errors and all(error.view != error.source for error in errors)
    stereo = fuse_flow.MultiViewStereo()
    found = stereo.estimate(frame)
    depth, confidence = found.views[1].depth, found.views[1].confidence
    assert depth.shape == truth[1].shape and found.views[1].normals.shape == truth[1].shape + (3,)
    sure = confidence > 0.8
    assert sure.mean() > 0.3
    assert numpy.median(numpy.abs(depth[sure] - truth[1][sure]) / truth[1][sure]) < 0.02
    assert found.views[1].geometry.sources
    cloud = fuse_flow.FuseFlow(parameters=fuse_flow.FuseFlowParameters.estimated_depth()).fuse(found.rig)
    assert len(cloud) > 100
    del found
    gc.collect()
    assert numpy.isfinite(depth).all()
