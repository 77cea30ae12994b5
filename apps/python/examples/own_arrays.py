"""own_arrays.py [PICTURE.png]: depth images of your own, as numpy arrays, become one cloud, and a picture of it."""

import sys

import matplotlib.pyplot as plt
import numpy

import fuse_flow


def depth_of_a_ball(x):
    """In place of your camera: millimetres of a ball of 0.5 m before a wall, from a camera at x metres; (480, 640) uint16."""
    v, u = numpy.mgrid[:480, :640]
    rays = numpy.stack([(u - 319.5) / 525, (v - 239.5) / 525, numpy.ones((480, 640))], axis=-1)
    to_ball = numpy.array([-x, 0, 2.0])  # from the camera
    a, b, c = (rays**2).sum(axis=-1), rays @ to_ball, to_ball @ to_ball - 0.5**2
    with numpy.errstate(invalid="ignore"):
        nearest = (b - numpy.sqrt(b**2 - a * c)) / a
    return (1000 * numpy.where(numpy.isnan(nearest), 3.0, nearest)).astype(numpy.uint16)


def at(x):
    """Where a camera stands: camera to world, metres; x right, y down, z forward."""
    pose = numpy.eye(4)
    pose[0, 3] = x
    return pose


intrinsics = fuse_flow.Intrinsics(640, 480, 525, 525, 319.5, 239.5)  # width, height, fx, fy, cx, cy; pixels
cameras = [fuse_flow.Camera(intrinsics, at(x), depth_scale=0.001) for x in (-0.4, 0.4)]
views = [fuse_flow.DepthView(depth_of_a_ball(x)) for x in (-0.4, 0.4)]  # color=: (480, 640, 3) uint8
frame = fuse_flow.RigFrame(cameras, views)
print(*fuse_flow.check_poses(frame) or ["nothing is wrong with the poses"], sep="\n")  # inverted, of OpenGL's axes, in mm ...
cloud = fuse_flow.FuseFlow().fuse(frame)
print(f"{len(cloud)} points, {(cloud.view_count > 1).mean():.0%} of them seen by both cameras")
x, y, z = cloud.points[::10].T
axes = plt.figure().add_subplot(projection="3d", box_aspect=(numpy.ptp(x), numpy.ptp(z), numpy.ptp(y)))
axes.scatter(x, z, -y, c=z, s=1)
plt.savefig(sys.argv[1]) if len(sys.argv) > 1 else plt.show()
