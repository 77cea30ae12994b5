#!/usr/bin/env python3
"""python_gpu.py [--cameras 8] [--frames 500] [--no-exchange]: from the depth of a PyTorch network to a fused cloud, on a GPU.

What a frame takes in Python, from tensors to a tensor of points, beside C++'s own time for it (FrameStatistics.total_ms); and frames a
second together with a small network, whose depth never leaves the GPU. --no-exchange asks each tensor by Python's methods, as for
versions of PyTorch without DLPack's functions for C.
"""

import argparse
import statistics
import time

import numpy
import torch

import fuse_flow


class Network(torch.nn.Module):
    """Any network from colour to metres; this one sees a wavy wall."""

    def __init__(self):
        super().__init__()
        self.layers = torch.nn.Sequential(torch.nn.Conv2d(3, 16, 3, padding=1), torch.nn.ReLU(), torch.nn.Conv2d(16, 1, 3, padding=1))

    def forward(self, colors):
        return 1.5 + 0.02 * torch.tanh(self.layers(colors.permute(0, 3, 1, 2).float() / 255)[:, 0])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cameras", type=int, default=8)
    parser.add_argument("--frames", type=int, default=500)
    parser.add_argument("--no-exchange", action="store_true")
    options = parser.parse_args()
    if options.no_exchange:
        torch.Tensor.__dlpack_c_exchange_api__ = None
    width, height = 640, 480
    intrinsics = fuse_flow.Intrinsics(width, height, 525, 525, 319.5, 239.5)
    cameras = []
    for i in range(options.cameras):
        pose = numpy.eye(4)
        pose[0, 3] = 0.1 * i
        cameras.append(fuse_flow.Camera(intrinsics, pose, name=f"camera {i}"))
    torch.manual_seed(1)
    colors = torch.randint(0, 256, (options.cameras, height, width, 3), dtype=torch.uint8, device="cuda")
    network = Network().cuda().eval()
    with torch.no_grad():
        depths = network(colors).contiguous()
    fusion = fuse_flow.FuseFlow(device="gpu")

    def fuse(depths):
        views = [fuse_flow.DepthView(depth, color) for depth, color in zip(depths, colors)]
        return torch.from_dlpack(fusion.fuse_on_device(fuse_flow.RigFrame(cameras, views)).points)

    torch.cuda.synchronize()
    whole, library, alone = [], [], []
    views = [fuse_flow.DepthView(depths[i], colors[i]) for i in range(options.cameras)]
    frame = fuse_flow.RigFrame(cameras, views)
    for _ in range(options.frames):
        begin = time.perf_counter()
        points = fuse(depths)
        whole.append(1e3 * (time.perf_counter() - begin))
        library.append(fusion.statistics.total_ms)
        begin = time.perf_counter()
        fusion.fuse_on_device(frame)
        alone.append(1e3 * (time.perf_counter() - begin) - fusion.statistics.total_ms)
    begin = time.perf_counter()
    with torch.no_grad():
        for _ in range(options.frames):
            points = fuse(network(colors).contiguous())
    rate = options.frames / (time.perf_counter() - begin)
    in_library, in_python = statistics.median(library), statistics.median(whole)
    print(f"{options.cameras} cameras of {width}x{height}, {len(points)} points: {in_library:.3f} ms in C++, {in_python:.3f} ms in Python "
          f"({100 * (in_python / in_library - 1):.1f} % more); of a frame that is there already {1e3 * statistics.median(alone):.0f} µs more (medians)")
    print(f"with the network {rate:.0f} frames a second")


if __name__ == "__main__":
    main()
