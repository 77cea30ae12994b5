#!/usr/bin/python3
"""Writes bags of small images for the tests, with the rosbag of ROS: write_bags.py FOLDER.

A camera c's depth image k has at (u, v) 500 + 100 c + 11 k + 3 u + 7 v units, and 0 at u = v; its colour image (4 u, 5 v, 40 + 20 k + c).
"""
import io
import struct
import sys
import zlib

import genpy
import geometry_msgs.msg
import rosbag
import sensor_msgs.msg
import std_msgs.msg
import tf2_msgs.msg

DEPTH = (64, 48)
COLOR = (80, 60)
START = 1700000000
PERIOD_NS = 33333333


def stamp(k, offset_ns=0):
    return genpy.Time.from_sec(START) + genpy.Duration(0, k * PERIOD_NS + offset_ns)


def depth_values(c, k):
    return [0 if u == v else 500 + 100 * c + 11 * k + 3 * u + 7 * v for v in range(DEPTH[1]) for u in range(DEPTH[0])]


def color_values(c, k):
    return [(4 * u % 256, 5 * v % 256, (40 + 20 * k + c) % 256) for v in range(COLOR[1]) for u in range(COLOR[0])]


def png16(values, size):
    """A 16-bit grey PNG."""
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    width, height = size
    rows = b"".join(b"\0" + struct.pack(">%dH" % width, *values[v * width:(v + 1) * width]) for v in range(height))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def rvl(values):
    """Wilson's depth compression, as image_transport has it."""
    nibbles = []

    def put(value):
        while True:
            rest = value >> 3
            nibbles.append((value & 7) | (8 if rest else 0))
            value = rest
            if not value:
                return

    at, last = 0, 0
    while at < len(values):
        start = at
        while at < len(values) and values[at] == 0:
            at += 1
        put(at - start)
        end = at
        while end < len(values) and values[end] != 0:
            end += 1
        put(end - at)
        for value in values[at:end]:
            delta = value - last
            put(((delta << 1) ^ (delta >> 31)) & 0xffffffff)
            last = value
        at = end
    while len(nibbles) % 8:
        nibbles.append(0)
    words = [0] * (len(nibbles) // 8)
    for n, nibble in enumerate(nibbles):
        words[n // 8] |= nibble << (28 - 4 * (n % 8))
    return struct.pack("<%dI" % len(words), *words)


def header(message, frame, time):
    message.header.frame_id = frame
    message.header.stamp = time
    return message


def image(frame, time, size, encoding, data, step):
    message = header(sensor_msgs.msg.Image(), frame, time)
    message.width, message.height = size
    message.encoding, message.data, message.step = encoding, data, step
    return message


def depth16(frame, c, k, time, encoding="16UC1"):
    values = depth_values(c, k)
    return image(frame, time, DEPTH, encoding, struct.pack("<%dH" % len(values), *values), 2 * DEPTH[0])


def depth16_big_endian_padded(frame, c, k, time):
    values, width = depth_values(c, k), DEPTH[0]
    rows = b"".join(struct.pack(">%dH" % width, *values[v * width:(v + 1) * width]) + b"????" for v in range(DEPTH[1]))
    message = image(frame, time, DEPTH, "16UC1", rows, 2 * width + 4)
    message.is_bigendian = 1
    return message


def depth32(frame, c, k, time):
    values = [float("nan") if d == 0 else d / 1000 for d in depth_values(c, k)]
    return image(frame, time, DEPTH, "32FC1", struct.pack("<%df" % len(values), *values), 4 * DEPTH[0])


def compressed(frame, time, format, data):
    message = header(sensor_msgs.msg.CompressedImage(), frame, time)
    message.format, message.data = format, data
    return message


def compressed_depth(frame, c, k, time):
    return compressed(frame, time, "16UC1; compressedDepth", struct.pack("<iff", 0, 0, 0) + png16(depth_values(c, k), DEPTH))


def compressed_depth_rvl(frame, c, k, time):
    data = struct.pack("<iff", 0, 0, 0) + struct.pack("<ii", *DEPTH) + rvl(depth_values(c, k))
    return compressed(frame, time, "16UC1; compressedDepth rvl", data)


def compressed_inverse_depth(frame, c, k, time):
    """Float depth, quantised so that its inverse has equal steps."""
    a, b = 100 * (100 + 1), 1 - 100 * (100 + 1) / 10.0
    raw = [0 if d == 0 else round(a / (d / 1000) + b) for d in depth_values(c, k)]
    return compressed(frame, time, "32FC1; compressedDepth png", struct.pack("<iff", 0, a, b) + png16(raw, DEPTH))


def color(frame, c, k, time, encoding="rgb8"):
    order = {"rgb8": lambda p: p, "bgr8": lambda p: p[::-1], "bgra8": lambda p: p[::-1] + (255,)}[encoding]
    pixels = b"".join(bytes(order(p)) for p in color_values(c, k))
    return image(frame, time, COLOR, encoding, pixels, len(pixels) // COLOR[1])


def info(frame, size, model="plumb_bob", D=(0.1, -0.05, 0.001, -0.002, 0.01), f=60):
    message = header(sensor_msgs.msg.CameraInfo(), frame, genpy.Time.from_sec(START))
    message.width, message.height = size
    cx, cy = size[0] / 2 - 0.5, size[1] / 2 - 0.5
    message.distortion_model, message.D = model, list(D)
    message.K = [f, 0, cx, 0, f + 1, cy, 0, 0, 1]
    message.R = [1, 0, 0, 0, 1, 0, 0, 0, 1]
    message.P = [f - 2, 0, cx + 1, 0, 0, f - 1, cy + 1, 0, 0, 0, 1, 0]
    return message


def transform(parent, child, t, q=(0, 0, 0, 1)):
    message = header(geometry_msgs.msg.TransformStamped(), parent, genpy.Time.from_sec(START))
    message.child_frame_id = child
    message.transform = plain_transform(t, q)
    return message


def plain_transform(t, q=(0, 0, 0, 1)):
    message = geometry_msgs.msg.Transform()
    message.translation.x, message.translation.y, message.translation.z = t
    message.rotation.x, message.rotation.y, message.rotation.z, message.rotation.w = q
    return message


HALF = 0.5 ** 0.5
TREE = [
    transform("world", "left_link", (1, 0, 0)),
    transform("left_link", "left_depth", (0, 0.5, 0), (0, HALF, 0, HALF)),  # a quarter turn about y
    transform("left_link", "left_color", (0, 0.5, 0.03), (0, HALF, 0, HALF)),
    transform("world", "right_depth", (0, 0, 2)),
]


def write_rig(path, compression="none", frames=3):
    """Two cameras, one raw with its colour beside it, one compressed, whose colour is in the pixels of depth; the right one is 5 ms late."""
    with rosbag.Bag(path, "w", compression=compression) as bag:
        start = stamp(0)
        bag.write("/tf_static", tf2_msgs.msg.TFMessage(TREE), start)
        bag.write("/left/depth/camera_info", info("left_depth", DEPTH), start)
        bag.write("/left/color/camera_info", info("left_color", COLOR, f=70), start)
        bag.write("/right/depth_registered/camera_info", info("right_depth", DEPTH, D=()), start)
        for k in range(frames):
            left, right = stamp(k), stamp(k, 5000000)
            written = stamp(k, 20000000)
            bag.write("/left/depth/image_raw", depth16("left_depth", 0, k, left), written)
            bag.write("/left/color/image_raw", color("left_color", 0, k, left), written)
            bag.write("/left/infra1/image_raw", image("left_depth", left, (2, 1), "mono8", b"ab", 2), written)
            bag.write("/right/depth_registered/image_raw/compressedDepth", compressed_depth("right_depth", 1, k, right), written)


def write_encodings(path):
    """A camera for each encoding of depth, and of colour."""
    depths = {"plain": depth16, "padded": depth16_big_endian_padded, "float": depth32, "png": compressed_depth,
              "rvl": compressed_depth_rvl, "inverse": compressed_inverse_depth}
    with rosbag.Bag(path, "w") as bag:
        start = stamp(0)
        for n, (name, make) in enumerate(depths.items()):
            frame = name + "_depth"
            bag.write("/tf_static", tf2_msgs.msg.TFMessage([transform("world", frame, (n, 0, 0))]), start)
            bag.write("/%s/depth/camera_info" % name, info(frame, DEPTH, D=()), start)
            message = make(frame, 0, 0, stamp(0))
            suffix = "/compressedDepth" if name in ("png", "rvl", "inverse") else ""
            bag.write("/%s/depth/image_raw%s" % (name, suffix), message, start)
            if name in ("plain", "padded"):
                bag.write("/%s/color/camera_info" % name, info(frame, COLOR, D=()), start)
                encoding = {"plain": "bgr8", "padded": "bgra8"}[name]
                bag.write("/%s/color/image_raw" % name, color(frame, 0, 0, stamp(0), encoding), start)


def write_realsense(path, units=0.0005):
    """As the SDK of RealSense records: topics of its own, extrinsics from depth to each stream, a unit of depth."""
    depth_stream, color_stream = "/device_0/sensor_0/Depth_0", "/device_0/sensor_1/Color_0"
    none = genpy.Time(0, 1)
    with rosbag.Bag(path, "w", compression="lz4") as bag:
        bag.write("/file_version", std_msgs.msg.UInt32(4), none)
        bag.write("/device_0/sensor_0/option/Depth_Units/value", std_msgs.msg.Float32(units), none)
        bag.write(depth_stream + "/info/camera_info", info("", DEPTH, "Brown Conrady", (0, 0, 0, 0, 0)), none)
        bag.write(color_stream + "/info/camera_info",
                  info("", COLOR, "Inverse Brown Conrady", (-0.05, 0.06, 0.001, -0.0004, -0.02), 70), none)
        bag.write(depth_stream + "/tf/0", plain_transform((0, 0, 0)), none)
        bag.write(color_stream + "/tf/0", plain_transform((0.015, 0, 0)), none)
        for k in range(2):
            bag.write(depth_stream + "/image/data", depth16("1", 2, k, stamp(k), "mono16"), genpy.Time(0, 1000 + k * PERIOD_NS))
            bag.write(color_stream + "/image/data", color("1", 2, k, stamp(k, 2000000)), genpy.Time(0, 2000 + k * PERIOD_NS))


def write_text(path):
    with rosbag.Bag(path, "w") as bag:
        bag.write("/chatter", std_msgs.msg.String("hello"), stamp(0))


def main(folder):
    write_rig(folder + "/rig.bag")
    write_rig(folder + "/rig_lz4.bag", "lz4")
    write_rig(folder + "/rig_bz2.bag", "bz2")
    write_encodings(folder + "/encodings.bag")
    write_realsense(folder + "/realsense.bag")
    write_text(folder + "/text.bag")
    # A recorder that is killed has not written the index, nor where it is.
    whole = open(folder + "/rig.bag", "rb").read()
    position = whole.find(b"index_pos=")
    killed = bytearray(whole[:len(whole) // 2])
    killed[position + 10:position + 18] = bytes(8)
    open(folder + "/killed.bag", "wb").write(killed)


main(sys.argv[1])
