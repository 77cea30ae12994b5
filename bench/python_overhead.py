#!/usr/bin/env python3
"""python_overhead.py [--cameras 8] [--frames 500]: what a frame costs in Python beyond C++'s own time for it, and whether memory stays.

The overhead of fuse() is its time less FrameStatistics.total_ms; that of the frame includes RigFrame(), DepthView() for each camera, and
.points.
"""

import argparse
import statistics
import time

import numpy

import fuse_flow


def resident_megabytes():
    with open("/proc/self/status", encoding="ascii") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS")) / 1024


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cameras", type=int, default=8)
    parser.add_argument("--frames", type=int, default=500)
    parser.add_argument("--width", type=int, default=640)
    options = parser.parse_args()
    width, height = options.width, options.width * 3 // 4
    random = numpy.random.default_rng(1)
    intrinsics = fuse_flow.Intrinsics(width, height, 0.82 * width, 0.82 * width, (width - 1) / 2, (height - 1) / 2)
    cameras, depths, colors = [], [], []
    for i in range(options.cameras):
        pose = numpy.eye(4)
        pose[0, 3] = 0.1 * i
        cameras.append(fuse_flow.Camera(intrinsics, pose, name=f"camera {i}"))
        depths.append((1500 + random.integers(-3, 4, (height, width))).astype(numpy.uint16))
        colors.append(random.integers(0, 256, (height, width, 3)).astype(numpy.uint8))
    fusion = fuse_flow.FuseFlow()
    overheads, calls, frames = [], [], []
    for k in range(options.frames):
        begin = time.perf_counter()
        frame = fuse_flow.RigFrame(cameras, [fuse_flow.DepthView(d, c) for d, c in zip(depths, colors)], stamp=k)
        called = time.perf_counter()
        cloud = fusion.fuse(frame)
        call = 1e3 * (time.perf_counter() - called)
        points = cloud.points
        total = 1e3 * (time.perf_counter() - begin)
        frames.append(fusion.statistics.total_ms)
        overheads.append(1e3 * (total - frames[-1]))
        calls.append(1e3 * (call - frames[-1]))
        if k == options.frames // 10:
            before = resident_megabytes()
    print(f"{options.cameras} cameras of {width}x{height}, {len(points)} points: {statistics.median(frames):.2f} ms in C++, "
          f"overhead of fuse() {statistics.median(calls):.0f} µs, of the frame {statistics.median(overheads):.0f} µs (medians)")
    print(f"memory: {before:.1f} MiB after {options.frames // 10} frames, {resident_megabytes():.1f} MiB after {options.frames}")


if __name__ == "__main__":
    main()
