#!/usr/bin/env python3
"""How two fused clouds differ, whatever the order of their points.

    python3 bench/compare_clouds.py A.ply B.ply

Both as fuse_flow_fuse writes them. Points with the same bytes are put aside; the others are paired with the nearest one of the
other cloud within 0.1 mm. Exit status 1 if a point has no counterpart."""
import collections
import math
import struct
import sys

CELL = 1e-4  # metres; farther is another point
CODES = {"float": "f", "uchar": "B", "uint": "I", "int": "i", "double": "d"}


def read_points(path):
    with open(path, "rb") as file:
        data = file.read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    count, layout, names = 0, "<", []
    for line in data[:end].decode("ascii").splitlines():
        words = line.split()
        if words[:2] == ["element", "vertex"]:
            count = int(words[2])
        elif words[0] == "property":
            layout += CODES[words[1]]
            names.append(words[2])
    if b"binary_little_endian" not in data[:end]:
        sys.exit(f"{path}: is not a binary PLY of this machine")
    size = struct.calcsize(layout)
    return [data[end + k * size : end + (k + 1) * size] for k in range(count)], layout, names


def cell_of(point):
    return tuple(math.floor(x / CELL) for x in point[:3])


def around(cell):
    return [(cell[0] + i, cell[1] + j, cell[2] + k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)]


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    (first, layout, names), (second, other_layout, other_names) = map(read_points, sys.argv[1:])
    if (layout, names) != (other_layout, other_names):
        sys.exit("the clouds have different fields")
    of_first, of_second = collections.Counter(first), collections.Counter(second)
    rest = [struct.unpack(layout, p) for p in (of_first - of_second).elements()]
    cells = collections.defaultdict(list)
    for p in (of_second - of_first).elements():
        point = struct.unpack(layout, p)
        cells[cell_of(point)].append(point)
    colors = [names.index(c) for c in ("red", "green", "blue") if c in names]
    alone, moved, farthest, recolored, most = 0, 0, 0.0, 0, 0
    for point in rest:
        near = [(math.dist(point[:3], q[:3]), q) for cell in around(cell_of(point)) for q in cells.get(cell, [])]
        if not near or min(near)[0] > CELL:
            alone += 1
            continue
        distance, counterpart = min(near)
        cells[cell_of(counterpart)].remove(counterpart)
        moved += distance > 0
        farthest = max(farthest, distance)
        step = max((abs(point[c] - counterpart[c]) for c in colors), default=0)
        recolored += step > 0
        most = max(most, step)
    left = sum(map(len, cells.values()))
    print(f"{len(first)} and {len(second)} points: {len(rest)} of the first differ in a bit, {moved} in position by at most "
          f"{1e6 * farthest:.2f} µm, {recolored} in colour by at most {most} of 255; {alone} and {left} have no counterpart")
    return 1 if alone + left else 0


if __name__ == "__main__":
    sys.exit(main())
