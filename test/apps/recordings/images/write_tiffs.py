#!/usr/bin/python3
"""Writes TIFFs of 21 x 18 pixels for the tests, with Pillow and tifffile: write_tiffs.py FOLDER.

At (u, v) whole.tif and others of its kind have 300 + 5 u + 70 v, and 0 at u = v; float.tif and others of its kind have a thousandth of that.
"""
import struct
import sys

import numpy
import tifffile
from PIL import Image

WIDTH, HEIGHT = 21, 18
v, u = numpy.mgrid[0:HEIGHT, 0:WIDTH]
whole = numpy.where(u == v, 0, 300 + 5 * u + 70 * v).astype(numpy.uint16)
floats = whole.astype(numpy.float32) / numpy.float32(1000)


def path(name):
    return sys.argv[1] + "/" + name


Image.fromarray(whole).save(path("whole.tif"))
Image.fromarray(floats).save(path("float.tiff"))
for compression in "tiff_lzw", "tiff_adobe_deflate", "packbits":
    Image.fromarray(whole).save(path("whole_" + compression + ".tif"), compression=compression)
    Image.fromarray(floats).save(path("float_" + compression + ".tif"), compression=compression)
tifffile.imwrite(path("float_big_endian.tif"), floats, byteorder=">")
tifffile.imwrite(path("whole_big_endian.TIF"), whole, byteorder=">")
tifffile.imwrite(path("float_tiles.tif"), floats, tile=(16, 16))
tifffile.imwrite(path("whole_tiles.tif"), whole, tile=(16, 16))
tifffile.imwrite(path("float_double.tif"), floats.astype(numpy.float64))
tifffile.imwrite(path("float_bigtiff.tif"), floats, bigtiff=True)
tifffile.imwrite(path("float_bottom_first.tif"), floats[::-1], extratags=[(274, "H", 1, 4, True)])

tifffile.imwrite(path("wrong_pages.tif"), numpy.stack([floats] * 2), photometric="minisblack")
tifffile.imwrite(path("wrong_channels.tif"), numpy.stack([floats] * 3, axis=2), photometric="rgb")
tifffile.imwrite(path("wrong_bits.tif"), whole.astype(numpy.uint8))
tifffile.imwrite(path("wrong_sign.tif"), whole.astype(numpy.int16))
tifffile.imwrite(path("wrong_white.tif"), whole, photometric="miniswhite")
tifffile.imwrite(path("wrong_turned.tif"), whole, extratags=[(274, "H", 1, 6, True)])
with open(path("wrong_text.tif"), "w") as file:
    file.write("depth\n")
with open(path("float.tiff"), "rb") as file:
    image = file.read()
with open(path("wrong_short.tif"), "wb") as file:
    file.write(image[: len(image) // 2])
# A header that claims more than there is: little endian, one directory, and no pixels.
entries = [(256, 4, 1, 70000), (257, 4, 1, 70000), (258, 3, 1, 32), (273, 4, 1, 8), (278, 4, 1, 70000), (279, 4, 1, 8),
           (339, 3, 1, 3)]
with open(path("wrong_large.tif"), "wb") as file:
    file.write(struct.pack("<2sHIH", b"II", 42, 8, len(entries)))
    for entry in entries:
        file.write(struct.pack("<HHII", *entry))
    file.write(struct.pack("<I", 0))
