"""live_loop.py RECORDING: cameras that run, each in a thread of its own, are put together by their stamps and fused as they come.

A recording stands in for the cameras here.
"""

import sys
import threading
import time

import fuse_flow

recording = fuse_flow.open(sys.argv[1])
cameras, frames = recording.cameras, list(recording)
parameters = fuse_flow.SynchronizerParameters(clocks=fuse_flow.ClockModel.SHARED)  # SEPARATE: each camera has its own clock
synchronizer = fuse_flow.ViewSynchronizer(len(cameras), parameters)


def grab(number):
    """What the callback of your camera does; a view may be any object."""
    for frame in frames:
        synchronizer.push(number, frame.stamp, frame.views[number])  # stamp: microseconds
        time.sleep(0.2)


for number in range(len(cameras)):
    threading.Thread(target=grab, args=(number,), daemon=True).start()
fusion = fuse_flow.FuseFlow()
while (instant := synchronizer.wait(1.0)) is not None:  # None: nothing came for a second
    cloud = fusion.fuse(fuse_flow.RigFrame(cameras, instant.views, instant.stamp))
    print(f"{instant.stamp / 1e6:.1f} s: {len(cloud)} points, {fusion.statistics.total_ms:.0f} ms")
