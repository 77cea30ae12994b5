"""show_in_open3d.py RECORDING [CLOUD.ply]: fuses the first frame of a recording, and shows it in Open3D, or writes it."""

import sys

import open3d

import fuse_flow

frame = next(iter(fuse_flow.open(sys.argv[1])))
cloud = fuse_flow.FuseFlow(normals=True).fuse(frame)
shown = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(cloud.points))
shown.colors = open3d.utility.Vector3dVector(cloud.colors / 255)
shown.normals = open3d.utility.Vector3dVector(cloud.normals)
print(shown)
if len(sys.argv) > 2:
    open3d.io.write_point_cloud(sys.argv[2], shown)
else:
    open3d.visualization.draw_geometries([shown])
