"""show_in_matplotlib.py RECORDING [PICTURE.png]: fuses the first frame of a recording, and shows it."""

import sys

import matplotlib.pyplot as plt

import fuse_flow

frame = next(iter(fuse_flow.open(sys.argv[1])))
cloud = fuse_flow.FuseFlow().fuse(frame)
print(f"{len(frame.cameras)} cameras, {len(cloud)} points")
axes = plt.figure(figsize=(8, 8)).add_subplot(projection="3d")
x, y, z = cloud.points.T
axes.scatter(x, y, z, c=cloud.colors / 255, s=1)
axes.set_box_aspect((x.max() - x.min(), y.max() - y.min(), z.max() - z.min()))
plt.savefig(sys.argv[2]) if len(sys.argv) > 2 else plt.show()
