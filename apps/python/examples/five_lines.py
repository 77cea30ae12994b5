import fuse_flow, numpy
camera = fuse_flow.Camera(fuse_flow.Intrinsics(640, 480, 525, 525, 319.5, 239.5))
depth = numpy.full((480, 640), 1000, numpy.uint16)  # millimetres: what your camera gives
frame = fuse_flow.RigFrame([camera], [fuse_flow.DepthView(depth)])
print(fuse_flow.FuseFlow().fuse(frame).points)  # (N, 3) float32, metres
