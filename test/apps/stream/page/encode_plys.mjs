// node encode_plys.mjs OUT.ffs CLOUD.ply…: a stream file of fused clouds, as fuse_flow_fuse writes them, by the reference encoder and the
// program zstd. Takes seconds for each cloud. For trying the page and for measuring the decoder without a server.

import {readFileSync, writeFileSync} from 'node:fs';
import {encode, streamFile, zstandardByProgram} from './reference_encoder.mjs';

const [out, ...clouds] = process.argv.slice(2);
const step = Number(process.env.STEP ?? 0.001);
const chromaStep = Number(process.env.CHROMA_STEP ?? 0);
// Cameras on a ring, as the demo's: x right, y down, z forward.
const cameras = [0, 1, 2, 3].map((k) => {
  const angle = (k * Math.PI) / 2 + Math.PI / 4;
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return {name: `camera_0${k}`, width: 640, height: 480, fx: 525, fy: 525, cx: 319.5, cy: 239.5,
          T_world_camera: [-s, 0, -c, 2.4 * c, c, 0, -s, 2.4 * s, 0, -1, 0, 1.2, 0, 0, 0, 1]};
});
const records = [{type: 'stream', version: 1, name: 'demo', frame: 'world', step, cameras}];
clouds.forEach((path, number) => {
  const file = readFileSync(path);
  const end = file.indexOf('end_header\n') + 11;
  const count = Number(/element vertex (\d+)/.exec(file.toString('latin1', 0, end))[1]);
  const size = 23;
  const raw = [];
  let origin = [Infinity, Infinity, Infinity];
  for (let i = 0, at = end; i < count; ++i, at += size) {
    const xyz = [0, 4, 8].map((o) => file.readFloatLE(at + o));
    origin = origin.map((value, k) => Math.min(value, xyz[k]));
    raw.push({xyz, rgb: [file[at + 12], file[at + 13], file[at + 14]], confidence: Math.round(255 * file.readFloatLE(at + 15)),
              views: file.readUInt32LE(at + 19)});
  }
  for (const point of raw) point.xyz = point.xyz.map((value, k) => Math.round((value - origin[k]) / step));
  const time = 1700000000000000000n + BigInt(number) * 200000000n;
  const {message} = encode(raw, {number: BigInt(number), captured: time, encoded: time + 30000000n, origin, step, fields: 7, chromaStep,
                                 compress: (bytes) => zstandardByProgram(bytes, 3)});
  console.log(`${path}: ${count} points, ${message.length} bytes, ${((8 * message.length) / count).toFixed(1)} bits a point`);
  records.push(message);
});
writeFileSync(out, streamFile(records));
