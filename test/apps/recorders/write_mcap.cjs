// Writes MCAP files of small images for the tests, with @mcap/core and ROS 2's messages in CDR: node write_mcap.cjs FOLDER.
// The images are those of write_bags.py. The packages are found through NODE_PATH.
"use strict";

const fs = require("fs");
const zstd = require("@foxglove/wasm-zstd");
const { MessageWriter } = require("@foxglove/rosmsg2-serialization");
const { ros2humble } = require("@foxglove/rosmsg-msgs-common");
const { McapWriter } = require("@mcap/core");

const DEPTH = [64, 48], COLOR = [80, 60], START = 1700000000, PERIOD_NS = 33333333;

function depthData(c, k) {
  const [width, height] = DEPTH;
  const data = Buffer.alloc(2 * width * height);
  for (let v = 0; v < height; ++v)
    for (let u = 0; u < width; ++u)
      data.writeUInt16LE(u === v ? 0 : 500 + 100 * c + 11 * k + 3 * u + 7 * v, 2 * (v * width + u));
  return data;
}

function colorData(c, k) {
  const [width, height] = COLOR;
  const data = Buffer.alloc(3 * width * height);
  for (let v = 0; v < height; ++v)
    for (let u = 0; u < width; ++u)
      data.set([(4 * u) % 256, (5 * v) % 256, 40 + 20 * k + c], 3 * (v * width + u));
  return data;
}

function stamp(k) {
  return { sec: START, nanosec: k * PERIOD_NS };
}

function header(frame_id, k) {
  return { stamp: stamp(k), frame_id };
}

function image(frame, k, [width, height], encoding, data) {
  return { header: header(frame, k), width, height, encoding, is_bigendian: 0, step: data.length / height, data };
}

function info(frame, [width, height], f) {
  const cx = width / 2 - 0.5, cy = height / 2 - 0.5;
  return {
    header: header(frame, 0), width, height, distortion_model: "rational_polynomial",
    d: [0.1, -0.05, 0.001, -0.002, 0.01, 0.2, 0.03, 0.004],
    k: [f, 0, cx, 0, f + 1, cy, 0, 0, 1], r: [1, 0, 0, 0, 1, 0, 0, 0, 1], p: [f, 0, cx, 0, 0, f + 1, cy, 0, 0, 0, 1, 0],
    binning_x: 0, binning_y: 0, roi: { x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: false }
  };
}

function transform(parent, child, x) {
  return {
    header: header(parent, 0), child_frame_id: child,
    transform: { translation: { x, y: 0, z: 0 }, rotation: { x: 0, y: 0, z: 0, w: 1 } }
  };
}

class Out {
  constructor(path) {
    this.file = fs.openSync(path, "w");
    this.at = 0n;
  }
  position() {
    return this.at;
  }
  async write(bytes) {
    fs.writeSync(this.file, bytes);
    this.at += BigInt(bytes.length);
  }
}

async function writeRig(path, options) {
  const writer = new McapWriter({ writable: new Out(path), ...options });
  await writer.start({ profile: "ros2", library: "test" });
  const schemas = new Map(), channels = new Map(), serializers = new Map();
  const definitions = Object.entries(ros2humble).map(([, definition]) => definition);
  const publish = async (topic, type, message, k) => {
    if (!serializers.has(type)) {
      const own = ros2humble[type];
      serializers.set(type, new MessageWriter([own, ...definitions.filter((d) => d !== own)]));
      const name = type.replace("/", "/msg/");
      schemas.set(type, await writer.registerSchema({ name, encoding: "ros2msg", data: Buffer.from("") }));
    }
    if (!channels.has(topic))
      channels.set(topic, await writer.registerChannel({
        topic, schemaId: schemas.get(type), messageEncoding: "cdr", metadata: new Map()
      }));
    const time = BigInt(START) * 1000000000n + BigInt(k * PERIOD_NS + 20000000);
    await writer.addMessage({
      channelId: channels.get(topic), sequence: k, logTime: time, publishTime: time,
      data: serializers.get(type).writeMessage(message)
    });
  };
  await publish("/tf_static", "tf2_msgs/TFMessage", {
    transforms: [transform("world", "left_depth", 1), transform("left_depth", "left_color", 0.03), transform("world", "right_depth", 2)]
  }, 0);
  for (const [c, name] of [[0, "left"], [1, "right"]])
    await publish(`/${name}/depth/camera_info`, "sensor_msgs/CameraInfo", info(`${name}_depth`, DEPTH, 60), 0);
  await publish("/left/color/camera_info", "sensor_msgs/CameraInfo", info("left_color", COLOR, 70), 0);
  for (let k = 0; k < 5; ++k) {
    await publish("/left/depth/image_raw", "sensor_msgs/Image", image("left_depth", k, DEPTH, "16UC1", depthData(0, k)), k);
    await publish("/left/color/image_raw", "sensor_msgs/Image", image("left_color", k, COLOR, "rgb8", colorData(0, k)), k);
    await publish("/right/depth/image_raw", "sensor_msgs/Image", image("right_depth", k, DEPTH, "16UC1", depthData(1, k)), k);
  }
  await writer.end();
}

async function main(folder) {
  await zstd.isLoaded;
  await writeRig(`${folder}/unchunked.mcap`, { useChunks: false });
  await writeRig(`${folder}/plain.mcap`, { chunkSize: 20000 });
  await writeRig(`${folder}/zstd.mcap`, {
    chunkSize: 20000, compressChunk: (chunk) => ({ compression: "zstd", compressedData: zstd.compress(chunk, 3) })
  });
  await writeRig(`${folder}/unindexed.mcap`, {
    chunkSize: 20000, useMessageIndex: false, useChunkIndex: false, repeatChannels: false, repeatSchemas: false, useSummaryOffsets: false
  });
}

main(process.argv[2]).catch((error) => {
  console.error(error);
  process.exit(1);
});
