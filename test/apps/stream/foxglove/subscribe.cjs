// A client of Foxglove's protocol that is not ours: node subscribe.cjs ws://HOST:PORT/. Subscribes with @foxglove/ws-protocol to all that the
// server has, reads each message by the schema that came with its channel, and again by Foxglove's own definition of the type; both must be
// the same. Prints a line for each topic, when it has of each a message, and of /points the second. Packages are found through NODE_PATH.
"use strict";

const assert = require("assert");
const path = require("path");
const { FoxgloveClient } = require("@foxglove/ws-protocol");
const protobuf = require("protobufjs");
const { FileDescriptorSet } = require("protobufjs/ext/descriptor");
const WebSocket = require("ws");

const url = process.argv[2];
const options = { longs: String, enums: String, arrays: true, defaults: true, objects: true };

function fromSchema(channel) {
  const set = FileDescriptorSet.decode(Buffer.from(channel.schema, "base64"));
  return protobuf.Root.fromDescriptor(set).lookupType(channel.schemaName);
}

/** Foxglove's own files: in the package up to version 0.7; a list of transforms came later. */
function official(name) {
  const folder = path.join(path.dirname(require.resolve("@foxglove/schemas/package.json")), "schemas", "proto");
  const root = new protobuf.Root();
  root.resolvePath = (_, target) => path.join(folder, target);
  if (name === "foxglove.FrameTransforms") {
    const list = `syntax = "proto3"; package foxglove; import "foxglove/FrameTransform.proto";
      message FrameTransforms { repeated foxglove.FrameTransform transforms = 1; }`;
    const parsed = protobuf.parse(list, root, { keepCase: true });
    for (const file of parsed.imports) root.loadSync(file, { keepCase: true });
  } else {
    root.loadSync(`${name.replace(".", "/")}.proto`, { keepCase: true });
  }
  root.resolveAll();
  return root.lookupType(name);
}

function points(cloud) {
  const field = (name) => cloud.fields.find((f) => f.name === name);
  const offsets = cloud.fields.map((f) => `${f.name}:${f.offset}:${f.type}`);
  const data = Buffer.from(cloud.data);
  const count = data.length / cloud.point_stride;
  const sum = { x: 0, y: 0, z: 0, red: 0, green: 0, blue: 0, alpha: 0, confidence: 0, view_count: 0 };
  for (let i = 0; i < count; ++i)
    for (const name of Object.keys(sum)) {
      const at = i * cloud.point_stride + field(name).offset;
      sum[name] += field(name).type === "FLOAT32" ? data.readFloatLE(at) : data.readUInt8(at);
    }
  const sums = Object.values(sum).map((value) => value.toFixed(2));
  return `${cloud.frame_id} ${count} ${offsets.join(",")} ${sums.join(",")}`;
}

function content(name, message) {
  if (name === "foxglove.PointCloud") return points(message);
  if (name === "foxglove.FrameTransforms")
    return message.transforms
      .map((t) => `${t.parent_frame_id}>${t.child_frame_id}:${t.translation.x}:${t.rotation.w.toFixed(3)}`)
      .join(",");
  if (name === "foxglove.CompressedImage") {
    const data = Buffer.from(message.data); // a JPEG begins with FF D8 and ends with FF D9
    const ends = `${data.subarray(0, 2).toString("hex")}..${data.subarray(-2).toString("hex")}`;
    return `${message.frame_id} ${message.format} ${ends}`;
  }
  return `${message.frame_id} ${message.width}x${message.height} ${message.K.join(",")}`;
}

const socket = new WebSocket(url, [FoxgloveClient.SUPPORTED_SUBPROTOCOL]);
const client = new FoxgloveClient({ ws: socket });
const channels = new Map(); // by subscription
const lines = new Map(); // by topic
let clouds = 0;
let done = false;

client.on("error", (error) => {
  throw error;
});
client.on("status", (status) => console.log(`status ${status.level} ${status.message}`));
client.on("serverInfo", (info) => console.log(`server ${info.name}, ${info.capabilities.length} capabilities`));
client.on("advertise", (added) => {
  for (const channel of added) {
    const types = [fromSchema(channel), official(channel.schemaName)];
    channels.set(client.subscribe(channel.id), { channel, types });
  }
});
client.on("message", ({ subscriptionId, timestamp, data }) => {
  const { channel, types } = channels.get(subscriptionId);
  const bytes = new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
  const [message, same] = types.map((type) => type.toObject(type.decode(bytes), options));
  assert.deepStrictEqual(message, same);
  if (channel.topic === "/points" && ++clouds < 2) return;
  const time = ["/points", "/cameras/left/image"].includes(channel.topic) ? ` ${timestamp}` : "";
  if (!lines.has(channel.topic))
    lines.set(channel.topic, `${channel.topic} ${channel.schemaName}${time} ${content(channel.schemaName, message)}`);
  if (done || lines.size < channels.size) return;
  done = true; // what is on its way still comes
  for (const topic of [...lines.keys()].sort()) console.log(lines.get(topic));
  client.close();
});
client.on("close", () => process.exit(done ? 0 : 1));
setTimeout(() => {
  console.error("nothing more has come");
  process.exit(1);
}, 60000);
