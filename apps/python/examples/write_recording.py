"""write_recording.py FOLDER: depth images of your own, as numpy arrays, become a recording, which every tool reads."""

import sys

import numpy

import fuse_flow


def depth_of_a_wall(number):
    """In place of your camera: millimetres of a wall that comes nearer; (480, 640) uint16."""
    return numpy.full((480, 640), 2000 - 10 * number, numpy.uint16)


def at(x):
    """Where a camera stands: camera to world, metres; x right, y down, z forward."""
    pose = numpy.eye(4)
    pose[0, 3] = x
    return pose


intrinsics = fuse_flow.Intrinsics(640, 480, 525, 525, 319.5, 239.5)
cameras = [fuse_flow.Camera(intrinsics, at(x), name) for x, name in ((-0.1, "left"), (0.1, "right"))]
with fuse_flow.RigWriter(sys.argv[1], cameras, frames_per_second=30) as writer:
    for number in range(3):
        views = [fuse_flow.DepthView(depth_of_a_wall(number)) for camera in cameras]  # None: the camera lost this frame
        writer.write(fuse_flow.RigFrame(cameras, views))
for frame in fuse_flow.open(sys.argv[1]):
    print(f"{frame.stamp / 1e6:.2f} s: {fuse_flow.FuseFlow().fuse(frame)}")
