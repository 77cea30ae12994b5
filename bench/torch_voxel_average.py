#!/usr/bin/env python3
"""The peer a GPU user would write: every view back-projected, all in one cloud, and the mean of each voxel, in PyTorch.

    fuse_flow_gpu_bench --torch "python3 bench/torch_voxel_average.py" [8x640x480 …]
        beside ours and the CPU's, in one run
    fuse_flow_gpu_bench --dump FOLDER 8x640x480; python3 bench/torch_voxel_average.py FOLDER [--leaf 0.008] [--repeats 60]
        alone

Reads the frames that the benchmark dumped: rig.txt, a line a camera (width height fx fy cx cy, then the 3×4 pose, camera to
world), and images0.bin, images1.bin, … (16-bit depth in millimetres of all cameras, then their 8-bit RGB), and takes them in
turn. Times are medians, from pinned host memory to a cloud in pinned host memory; points are those of the first frame. The
benchmark reads the line that it prints."""
import argparse
import glob
import statistics
import time

import numpy as np
import torch


def read_frames(folder):
    rig = np.loadtxt(folder + "/rig.txt", ndmin=2)
    sizes = [int(row[0] * row[1]) for row in rig]
    pixels = sum(sizes)
    frames = []
    for path in sorted(glob.glob(glob.escape(folder) + "/images*.bin")):
        data = np.fromfile(path, np.uint8)
        depth = torch.from_numpy(data[: 2 * pixels].view(np.int16).copy()).pin_memory()
        color = torch.from_numpy(data[2 * pixels : 5 * pixels].reshape(-1, 3).copy()).pin_memory()
        frames.append((depth, color))
    return rig, sizes, frames


class VoxelAverage:
    """What depends on the calibration alone is computed once."""

    def __init__(self, rig, sizes, leaf):
        self.leaf = leaf
        self.sizes = sizes
        self.rays = []
        for width, height, fx, fy, cx, cy, *pose in rig:
            u, v = torch.meshgrid(torch.arange(int(width)), torch.arange(int(height)), indexing="xy")
            ray = torch.stack([(u - cx) / fx, (v - cy) / fy, torch.ones_like(u)], -1).reshape(-1, 3).float()
            T = torch.tensor(pose, dtype=torch.float32).reshape(3, 4)
            self.rays.append(((ray @ T[:, :3].T).cuda(), T[:, 3].cuda()))

    def points(self, depth):
        z = depth.to(torch.int32).bitwise_and_(0xFFFF).float() * 0.001
        out, begin = [], 0
        for size, (ray, origin) in zip(self.sizes, self.rays):
            out.append(z[begin : begin + size, None] * ray + origin)
            begin += size
        return torch.cat(out), z

    def fuse(self, depth, color):
        points, z = self.points(depth)
        valid = (z >= 0.1) & (z <= 20)
        points, color = points[valid], color[valid].float()
        cell = torch.floor(points / self.leaf).to(torch.int64) + (1 << 20)
        key = cell[:, 0] | cell[:, 1] << 21 | cell[:, 2] << 42
        _, group, count = torch.unique(key, return_inverse=True, return_counts=True)
        sums = torch.zeros(len(count), 6, device=points.device)
        sums.index_add_(0, group, torch.cat([points, color], 1))
        return sums / count[:, None]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder")
    parser.add_argument("--leaf", type=float, default=0.008, help="side of a voxel, metres")
    parser.add_argument("--repeats", type=int, default=60)
    options = parser.parse_args()
    rig, sizes, frames = read_frames(options.folder)
    if not frames:
        parser.error(f"no images in {options.folder}")
    method = VoxelAverage(rig, sizes, options.leaf)
    on_device = [(depth.cuda(), color.cuda()) for depth, color in frames]
    host_cloud = torch.empty(0)
    warm = 2 * len(frames)
    device_ms, latency_ms = [], []
    points = 0
    for k in range(warm + options.repeats):
        depth, color = frames[k % len(frames)]
        torch.cuda.synchronize()
        start = time.perf_counter()
        cloud = method.fuse(*on_device[k % len(frames)])
        torch.cuda.synchronize()
        middle = time.perf_counter()
        cloud = method.fuse(depth.cuda(non_blocking=True), color.cuda(non_blocking=True))
        if host_cloud.shape[0] < cloud.shape[0]:
            host_cloud = torch.empty(cloud.shape[0] * 5 // 4, 6).pin_memory()
        host_cloud[: cloud.shape[0]].copy_(cloud, non_blocking=True)
        torch.cuda.synchronize()
        end = time.perf_counter()
        if k % len(frames) == 0:
            points = cloud.shape[0]
        if k >= warm:
            device_ms.append(1e3 * (middle - start))
            latency_ms.append(1e3 * (end - middle))
    print(f"PyTorch {torch.__version__}, {len(rig)} cameras, {sum(sizes) / 1e6:.2f} Mpixel: {points} points, "
          f"device {statistics.median(device_ms):.3f} ms, host to host {statistics.median(latency_ms):.3f} ms, "
          f"{1e3 / statistics.median(latency_ms):.1f} fps one after the other, "
          f"{torch.cuda.max_memory_allocated() / 1e6:.0f} MB")


if __name__ == "__main__":
    main()
