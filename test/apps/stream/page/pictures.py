"""Pictures as files, and how alike two of them are. Without a library: the test of the page needs enough of them."""

import math
import struct
import zlib


class Picture:
    """8-bit RGB, the top row first."""

    def __init__(self, width, height, rgb):
        self.width, self.height, self.rgb = width, height, bytes(rgb)
        assert len(self.rgb) == 3 * width * height

    def pixel(self, u, v):
        at = 3 * (v * self.width + u)
        return self.rgb[at:at + 3]

    def mapped(self, place, outside=b"\0\0\0"):
        """The picture whose pixel (u, v) is that at place(u, v) of this one."""
        out = bytearray()
        for v in range(self.height):
            for u in range(self.width):
                x, y = place(u, v)
                out += self.pixel(x, y) if 0 <= x < self.width and 0 <= y < self.height else outside
        return Picture(self.width, self.height, out)

    def mirrored(self):
        return self.mapped(lambda u, v: (self.width - 1 - u, v))

    def upside_down(self):
        return self.mapped(lambda u, v: (u, self.height - 1 - v))

    def turned(self, degrees, outside):
        cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        x, y = (self.width - 1) / 2, (self.height - 1) / 2
        return self.mapped(lambda u, v: (round(x + cosine * (u - x) - sine * (v - y)), round(y + sine * (u - x) + cosine * (v - y))), outside)

    def moved(self, right, down, outside):
        return self.mapped(lambda u, v: (u - right, v - down), outside)

    def red_and_blue_swapped(self):
        out = bytearray(self.rgb)
        out[0::3], out[2::3] = self.rgb[2::3], self.rgb[0::3]
        return Picture(self.width, self.height, out)


def read_png(data):
    """Of 8 bits a channel, RGB or RGBA, not interlaced: what browsers and VTK write."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n", "no PNG"
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, depth, color, _, _, interlaced = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            packed += body
        at += 12 + size
    assert depth == 8 and color in (2, 6) and interlaced == 0, "another kind of PNG"
    channels = 3 if color == 2 else 4
    raw, row_bytes = zlib.decompress(packed), channels * width
    before, out = bytearray(row_bytes), bytearray()
    for v in range(height):
        begin = v * (row_bytes + 1)
        kind, row = raw[begin], bytearray(raw[begin + 1:begin + 1 + row_bytes])
        if kind == 1:
            for k in range(channels, row_bytes):
                row[k] = (row[k] + row[k - channels]) & 255
        elif kind == 2:
            row = bytearray((a + b) & 255 for a, b in zip(row, before))
        elif kind == 3:
            for k in range(row_bytes):
                row[k] = (row[k] + ((row[k - channels] if k >= channels else 0) + before[k]) // 2) & 255
        elif kind == 4:
            for k in range(row_bytes):
                a, b, c = (row[k - channels] if k >= channels else 0), before[k], (before[k - channels] if k >= channels else 0)
                p = a + b - c
                pa, pb, pc = abs(p - a), abs(p - b), abs(p - c)
                row[k] = (row[k] + (a if pa <= pb and pa <= pc else b if pb <= pc else c)) & 255
        before = row
        for channel in range(0, row_bytes, channels):
            out += row[channel:channel + 3]
    return Picture(width, height, out)


def silhouette(picture, background):
    """Of each pixel, whether something is drawn there."""
    r, g, b = background
    rgb = picture.rgb
    return [abs(rgb[at] - r) + abs(rgb[at + 1] - g) + abs(rgb[at + 2] - b) > 24 for at in range(0, len(rgb), 3)]


def intersection_over_union(a, b):
    both = sum(1 for x, y in zip(a, b) if x and y)
    either = sum(1 for x, y in zip(a, b) if x or y)
    return both / either if either else 1.0


def color_difference(a, b, background, cells=24):
    """Mean difference of the channels of the cells of a coarse grid, 0 to 255; cells that are empty in both do not count. A cell is the mean of
    its pixels: neither noise nor the shape of a point matters."""
    columns, rows = cells, max(1, round(cells * a.height / a.width))

    def means(picture):
        sums, counts = [[0, 0, 0] for _ in range(columns * rows)], [0] * (columns * rows)
        for v in range(picture.height):
            row = rows * v // picture.height * columns
            for u in range(picture.width):
                cell = row + columns * u // picture.width
                r, g, b_ = picture.pixel(u, v)
                total = sums[cell]
                total[0] += r
                total[1] += g
                total[2] += b_
                counts[cell] += 1
        return [[value / count for value in total] for total, count in zip(sums, counts)]

    difference, counted = 0.0, 0
    for one, other in zip(means(a), means(b)):
        if max(sum(abs(value - of) for value, of in zip(cell, background)) for cell in (one, other)) < 6:
            continue
        difference += sum(abs(x - y) for x, y in zip(one, other)) / 3
        counted += 1
    return difference / max(1, counted)
