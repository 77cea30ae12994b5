"""Clouds as the tools write them."""

import numpy

TYPES = {"float": "<f4", "uchar": "u1", "uint": "<u4"}


def read_ply(path):
    """A binary PLY file as a structured array."""
    data = path.read_bytes()
    header, _, body = data.partition(b"end_header\n")
    lines = header.decode().splitlines()
    count = next(int(line.split()[2]) for line in lines if line.startswith("element vertex"))
    fields = [(line.split()[2], TYPES[line.split()[1]]) for line in lines if line.startswith("property")]
    return numpy.frombuffer(body, numpy.dtype(fields), count)
