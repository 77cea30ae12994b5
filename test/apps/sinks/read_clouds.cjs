// Reads an MCAP file of clouds with @mcap/core, by its index, and ROS 2's messages in CDR: node read_clouds.cjs FILE.
// Prints a line for each message, in the order of time: of a cloud also what its last point is. Packages are found through NODE_PATH.
"use strict";

const fs = require("fs");
const zstd = require("@foxglove/wasm-zstd");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");
const { McapIndexedReader } = require("@mcap/core");

function lastPoint(cloud) {
  if (cloud.width === 0) return "";
  const at = (cloud.width - 1) * cloud.point_step;
  const view = new DataView(cloud.data.buffer, cloud.data.byteOffset, cloud.data.byteLength);
  const offset = (name) => at + cloud.fields.find((field) => field.name === name).offset;
  const float = (name) => view.getFloat32(offset(name), true);
  const color = [2, 1, 0].map((k) => view.getUint8(offset("rgb") + k));
  const rest = [float("confidence").toFixed(2), view.getUint32(offset("view_count"), true)];
  return ` ${[float("x"), float("y"), float("z"), ...color, ...rest].join(",")}`;
}

function content(message) {
  if (message.transforms)
    return message.transforms
      .map((t) => `${t.header.frame_id}>${t.child_frame_id}:${t.transform.translation.x}`)
      .join(" ");
  if (message.data.length !== message.width * message.height * message.point_step || !message.is_dense)
    throw new Error("a cloud that contradicts itself");
  const names = message.fields.map((field) => field.name).join(",");
  return `${message.header.frame_id} ${message.width} ${names}${lastPoint(message)}`;
}

async function main(path) {
  await zstd.isLoaded;
  const file = fs.openSync(path, "r");
  const readable = {
    size: async () => BigInt(fs.fstatSync(file).size),
    read: async (offset, size) => {
      const bytes = new Uint8Array(Number(size));
      fs.readSync(file, bytes, 0, Number(size), Number(offset));
      return bytes;
    }
  };
  const decompressHandlers = { zstd: (bytes, size) => zstd.decompress(bytes, Number(size)) };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  for await (const { channelId, data } of reader.readMessages()) {
    const channel = reader.channelsById.get(channelId);
    const definition = new TextDecoder().decode(reader.schemasById.get(channel.schemaId).data);
    const message = new MessageReader(parse(definition, { ros2: true })).readMessage(data);
    const { sec, nanosec } = (message.transforms?.[0] ?? message).header.stamp;
    console.log(`${channel.topic} ${sec}.${String(nanosec).padStart(9, "0")} ${content(message)}`);
  }
}

main(process.argv[2]).catch((error) => {
  console.error(error);
  process.exit(1);
});
