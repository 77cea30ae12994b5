"""Frames of geometry that is known by hand."""

import numpy

import fuse_flow

WIDTH, HEIGHT, FOCAL = 160, 120, 131.25


def intrinsics():
    return fuse_flow.Intrinsics(WIDTH, HEIGHT, FOCAL, FOCAL, (WIDTH - 1) / 2, (HEIGHT - 1) / 2)


def at(x=0.0, y=0.0, z=0.0):
    """A pose without rotation."""
    pose = numpy.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def wall(depth=1000, dtype=numpy.uint16):
    """What a camera measures of a wall that it faces."""
    return numpy.full((HEIGHT, WIDTH), depth, dtype)


def paint(color=(200, 120, 40)):
    return numpy.full((HEIGHT, WIDTH, 3), color, numpy.uint8)


def wall_frame(cameras=2, dtype=numpy.uint16):
    """Cameras side by side, 5 cm apart, in front of a wall at z = 1 m."""
    depth = 1000 if dtype == numpy.uint16 else 1.0
    return fuse_flow.RigFrame(
        [fuse_flow.Camera(intrinsics(), at(x=0.05 * i), name=f"camera {i}") for i in range(cameras)],
        [fuse_flow.DepthView(wall(depth, dtype), paint()) for _ in range(cameras)])


def rough_frame(seed=1, cameras=2):
    """A wall with noise, so that each frame is another."""
    random = numpy.random.default_rng(seed)
    frame = wall_frame(cameras)
    frame.views = [fuse_flow.DepthView(wall() + random.integers(-2, 3, (HEIGHT, WIDTH)).astype(numpy.uint16), paint())
                   for _ in range(cameras)]
    return frame
