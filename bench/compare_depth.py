#!/usr/bin/env python3
"""How far estimated depth is from the true one, in the first instant of two recordings of the same cameras.

    PYTHONPATH=build/python python3 bench/compare_depth.py ESTIMATED TRUTH [VIEWS]

ESTIMATED as fuse_flow_depth writes it, with confidence; TRUTH with depth, as fuse_flow_simulate --sensor ideal has it. The first VIEWS cameras, all
by default. Printed: of all pixels with a true depth, the share within 10 mm, and the share that is confident (over a half); of the confident
ones median error, share within 10 mm, and over 50 mm."""
import sys

import numpy

import fuse_flow

ALIKE, FAR = 0.01, 0.05  # metres


def first_frame(path):
    return next(iter(fuse_flow.open(path)))


def metres(frame, k):
    depth = frame.views[k].depth
    return depth if depth.dtype == numpy.float32 else depth * numpy.float32(frame.cameras[k].depth_scale)


def main(estimated, truth, views=None):
    found, true = first_frame(estimated), first_frame(truth)
    if len(found.views) != len(true.views):
        sys.exit(f"{estimated} has {len(found.views)} cameras, {truth} {len(true.views)}; must be the same")
    errors, confident = [], []
    for k in range(min(int(views or len(true.views)), len(true.views))):
        there = metres(true, k) > 0
        z = metres(found, k)[there]
        errors.append(numpy.where(z > 0, numpy.abs(z - metres(true, k)[there]), numpy.inf))
        confident.append(found.views[k].confidence[there] > 0.5)
    error, sure = numpy.concatenate(errors), numpy.concatenate(confident)
    of_sure = error[sure]
    print(f"all pixels: within 10 mm {100 * numpy.mean(error < ALIKE):.1f} %, confident {100 * numpy.mean(sure):.1f} %")
    print(f"confident: median {1000 * numpy.median(of_sure):.2f} mm, within 10 mm {100 * numpy.mean(of_sure < ALIKE):.1f} %, "
          f"over 50 mm {100 * numpy.mean(of_sure > FAR):.2f} %")


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    main(*sys.argv[1:])
