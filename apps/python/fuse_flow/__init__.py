"""Fuses the images of several calibrated depth cameras into one point cloud, frame by frame.

    import fuse_flow, numpy
    camera = fuse_flow.Camera(fuse_flow.Intrinsics(640, 480, 525, 525, 319.5, 239.5))
    depth = numpy.full((480, 640), 1000, numpy.uint16)
    cloud = fuse_flow.FuseFlow().fuse(fuse_flow.RigFrame([camera], [fuse_flow.DepthView(depth)]))
    cloud.points  # (N, 3) float32, metres

Metres, seconds, pixels. Cameras look along z, with x to the right and y down; T_world_camera is camera to world.
"""

from ._fuse_flow import *  # noqa: F401,F403
from ._fuse_flow import __doc__ as _sentence  # noqa: F401

if "StreamServer" not in globals():

    def __getattr__(name):
        why = ": it was built without streams, which need Boost, OpenSSL, nlohmann_json and Zstandard"
        raise AttributeError(f"module 'fuse_flow' has no attribute '{name}'{why if name.startswith('Stream') else ''}")
