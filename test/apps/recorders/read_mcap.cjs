// Reads an MCAP file with @mcap/core, by its index, and ROS 2's messages in CDR: node read_mcap.cjs FILE.
// Prints a line for each topic: name, type, number of messages, and what is in the last one. Packages are found through NODE_PATH.
"use strict";

const fs = require("fs");
const zstd = require("@foxglove/wasm-zstd");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");
const { McapIndexedReader } = require("@mcap/core");

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
  const topics = new Map();
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    const topic = topics.get(channel.topic) ?? { type: schema.name, count: 0, schema };
    topic.count += 1;
    topic.data = message.data;
    topic.time = message.logTime;
    topics.set(channel.topic, topic);
  }
  for (const name of [...topics.keys()].sort()) {
    const { type, count, schema, data, time } = topics.get(name);
    const decoder = new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true }));
    const message = decoder.readMessage(data);
    let content = "";
    if (message.transforms)
      content = message.transforms.map((t) => `${t.header.frame_id}>${t.child_frame_id}:${t.transform.translation.x}`).join(",");
    else if (message.k) content = `${message.width}x${message.height} ${message.distortion_model} ${message.k[0]}`;
    else content = `${message.header.frame_id} ${message.format ?? message.encoding} ${message.data.length > 0}`;
    console.log(`${name} ${type} ${count} ${time} ${content}`);
  }
}

main(process.argv[2]).catch((error) => {
  console.error(error);
  process.exit(1);
});
