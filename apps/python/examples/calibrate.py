"""calibrate.py RECORDING RIG.json: finds how far the cameras of a recording are from where its calibration says, and writes a better one."""

import sys

import fuse_flow

recording = fuse_flow.open(sys.argv[1])
estimation = fuse_flow.ExtrinsicEstimation()
for frame in recording:
    estimation.add_frame(frame)
result = estimation.estimate()
print(f"distance of the views: {1000 * result.residual_before:.1f} mm before, {1000 * result.residual:.1f} mm after")
cameras = recording.cameras
for camera, pose, correction in zip(cameras, result.T_world_camera, result.corrections):
    camera.T_world_camera = pose
    print(f"{camera.name}: moved {1000 * correction.translation:.1f} mm" + ("" if correction.constrained else ", not all directions are known"))
fuse_flow.write_rig(sys.argv[2], cameras)
