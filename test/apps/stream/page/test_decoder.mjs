// node --test test_decoder.mjs, with FUSE_FLOW_PAGE = the folder of the page as browsers get it. FUSE_FLOW_STREAM_FILES:
// the folder that write_stream_files filled.

import assert from 'node:assert/strict';
import {readFileSync, readdirSync} from 'node:fs';
import {test} from 'node:test';
import {pathToFileURL} from 'node:url';
import {encode, fromYuv, octahedral, sealHeader, streamFile, toYuv, xxh64, zstandardStored} from './reference_encoder.mjs';

const page = pathToFileURL(`${process.env.FUSE_FLOW_PAGE}/`);
const {FIELD, FrameDecoder, crc32, firstOf, normalOf, positionOf, readHeader} = await import(new URL('decoder.js', page));
const {Zstandard} = await import(new URL('zstandard.js', page));
const {StreamFile, parseDescription} = await import(new URL('stream_file.js', page));
const zstandard = await Zstandard.load();
const decoder = new FrameDecoder(zstandard);

// Numbers that are the same in each run.
let state = 1;
function random(below) {
  state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
  return Math.floor((state / 2 ** 32) * below);
}

/** Points of a wavy surface, with all fields. */
function surface(count, extent = 3000) {
  return Array.from({length: count}, () => {
    const x = random(extent), y = random(extent);
    const z = Math.round(500 + 300 * Math.sin(x / 400) * Math.cos(y / 300)) + random(4);
    return {xyz: [x, y, z], rgb: [(x >> 3) & 255, (y >> 2) & 255, random(256)], confidence: random(256), views: random(300),
            normal: random(10) === 0 ? [0, 0] : octahedral([Math.sin(x), Math.cos(y), random(200) - 100]), mask: BigInt(random(2 ** 30))};
  });
}
/** Points anywhere, so that codes have all of their 63 bits. */
function anywhere(count) {
  const points = surface(count);
  for (const point of points) point.xyz = [random(2 ** 21), random(2 ** 21), random(2 ** 21)];
  return points;
}

function check(points, options) {
  const {message, expected} = encode(points, options);
  const frame = decoder.decode(message);
  compare(frame, expected, options);
  return {message, frame, expected};
}
function compare(frame, expected, {origin = [0, 0, 0], step = 0.001, fields = 0, chromaStep = 0, maskBytes = fields & 16 ? 1 : 0}) {
  assert.equal(frame.points, expected.length);
  const base = frame.origin.map((value, k) => Math.round((value - origin[k]) / step));
  expected.forEach((point, i) => {
    assert.deepEqual([0, 1, 2].map((k) => frame.positions[4 * i + k] + base[k]), point.xyz, `position of point ${i}`);
    if (fields & 1)
      assert.deepEqual([...frame.colors.subarray(4 * i, 4 * i + 3)], chromaStep ? fromYuv(toYuv(point.rgb, chromaStep), chromaStep) : point.rgb, `colour of point ${i}`);
    if (fields & 2) assert.equal(frame.colors[4 * i + 3], point.confidence, `confidence of point ${i}`);
    if (fields & 4) assert.equal(frame.positions[4 * i + 3], Math.min(255, point.views), `views of point ${i}`);
    if (fields & 8) assert.deepEqual([...frame.normals.subarray(2 * i, 2 * i + 2)], point.normal, `normal of point ${i}`);
    if (fields & 16)
      for (let k = 0; k < maskBytes; ++k)
        assert.equal(frame.masks[maskBytes * i + k], Number((point.mask >> BigInt(8 * k)) & 255n), `mask of point ${i}`);
  });
}

test('Checksums are those of their definitions', () => {
  assert.equal(crc32(new TextEncoder().encode('123456789')), 0xcbf43926);
  assert.equal(xxh64(new Uint8Array(0)), 0xef46db3751d8e999n);
  assert.equal(xxh64(new TextEncoder().encode('xxhash')), 0x32dd38952c4bc720n);
});

test('A frame that was put together by hand is read', () => {
  // Points (0,0,0), (1,1,1) and (3,0,0): the codes 0, 7 and 9. One chunk of two layers, so that the stride of layer 0 is 2: it has the
  // ranks 0 and 2, layer 1 the rank 1. Only positions.
  // Layer 0: d = 0 has no bits: 16. d = 9 = 0b1001 has 4 bits, the second highest 0: 16 + 8 = 24, and then its lower two bits, 01.
  // Layer 1: d = 7, R = 9, so that w = 1, the token is 7, and no bits follow.
  const layer0 = zstandardStored(Uint8Array.from([16, 24, 0b01]));
  const layer1 = zstandardStored(Uint8Array.from([7]));
  const size = 84 + 36 + 8 + 4;
  const bytes = new Uint8Array(size + layer0.length + layer1.length);
  const view = new DataView(bytes.buffer);
  bytes.set([0x46, 0x46, 0x43, 0x31]);
  view.setUint32(4, size, true);
  view.setBigUint64(8, 7n, true);
  view.setBigInt64(16, 1700000000123456789n, true);
  view.setBigInt64(24, 1700000000200000000n, true);
  [1.5, -2, 0.25].forEach((value, k) => view.setFloat64(32 + 8 * k, value, true));
  view.setFloat64(56, 0.5, true);
  bytes[69] = 2;
  view.setUint32(72, 3, true);
  view.setUint32(76, 3, true);
  view.setUint32(80, 1, true);
  [0, 3, 2, 0, 0, 0, 3, 1, 1, layer0.length, layer1.length].forEach((value, k) => view.setUint32(84 + 4 * k, value, true));
  view.setUint32(size - 4, crc32(bytes.subarray(0, size - 4)), true);
  bytes.set(layer0, size);
  bytes.set(layer1, size + layer0.length);
  const frame = decoder.decode(bytes);
  assert.equal(frame.number, 7);
  assert.ok(Math.abs(frame.captured - 1700000000123.4568) < 0.001);
  assert.deepEqual([0, 1, 2].map((i) => positionOf(frame, i)), [[1.5, -2, 0.25], [2, -1.5, 0.75], [3, -2, 0.25]]);
});

test('Frames are read with each sum of fields', () => {
  const points = surface(700);
  for (let fields = 0; fields < 32; ++fields) check(points, {fields, chunkPoints: 256, maskBytes: fields & 16 ? 4 : 0});
});

test('Frames are read with each number of layers, and with those of them that are here', () => {
  const points = surface(300);
  for (let layers = 1; layers <= 8; ++layers)
    for (let here = 1; here <= layers; ++here)
      check(points, {fields: 31, layers, chunkPoints: 100, layersOf: (chunk) => (chunk.number === 1 ? here : Math.max(1, here - 1))});
  check(points, {fields: 7, layers: 3, chunkPoints: 64, layersOf: (chunk) => (chunk.number % 2 ? 0 : 2)});
});

test('A frame is the same in shares', () => {
  for (const points of [surface(1500), anywhere(1500)])
    for (const options of [{fields: 31, maskBytes: 3}, {fields: 7, chromaStep: 4}, {fields: 0}]) {
      const {message} = encode(points, {...options, chunkPoints: 200});
      const whole = decoder.decode(message);
      const header = readHeader(message);
      for (const borders of [[0, 8], [0, 3, 8], [0, 0, 5, 6, 8, 8]]) {
        const joined = decoder.prepare(header);
        for (const [k, begin] of borders.slice(0, -1).entries()) {
          const end = borders[k + 1];
          const share = new FrameDecoder(zstandard).prepare(header, [], begin, end);
          decoder.decodeChunks(message, header, begin, end, share, firstOf(header, begin));
          for (const [name, items] of [['positions', 4], ['colors', 4], ['normals', 2], ['masks', header.maskBytes]])
            joined[name]?.set(share[name], items * firstOf(header, begin));
        }
        assert.deepEqual(joined, whole);
      }
    }
});

test('Chunks of few points have layers without any', () => {
  for (const count of [1, 2, 3, 5, 17]) check(surface(count), {fields: 31, layers: 8});
});

test('Points in one place are read', () => {
  const points = surface(500);
  for (const point of points) point.xyz = [5, 6, 7];
  check(points, {fields: 31});
  check([...points, ...surface(3)], {fields: 31});
});

test('Points anywhere are read: codes of 63 bits', () => {
  check(anywhere(2000), {fields: 31, chunkPoints: 500, maskBytes: 8});
  check(anywhere(2000), {fields: 31, chunkPoints: 65536});
  check([{...surface(1)[0], xyz: [0, 0, 0]}, {...surface(1)[0], xyz: [2 ** 21 - 1, 2 ** 21 - 1, 2 ** 21 - 1]}], {fields: 31});
  // On both sides of the farthest border, near one another.
  const border = surface(1000);
  for (const point of border) point.xyz = point.xyz.map(() => 2 ** 20 - 8 + random(16));
  check(border, {fields: 31});
});

test('Wide and narrow chunks take different paths to the same points', () => {
  for (const extent of [50, 3000, 60000, 2 ** 17, 2 ** 18, 2 ** 21 - 1]) {
    const points = surface(1500, extent);
    const {message, frame, expected} = check(points, {fields: 31, chunkPoints: 300});
    const exact = new FrameDecoder(zstandard);
    exact.codesFit = () => false;
    const same = exact.decode(message);
    assert.deepEqual(same.positions, frame.positions);
    assert.deepEqual(same.colors, frame.colors);
    assert.equal(frame.positions instanceof Uint16Array, frame.greatest.every((value) => value < 65536));
    assert.equal(expected.length, 1500);
  }
});

test('Coarser tints are read', () => {
  for (const chromaStep of [1, 2, 7, 64]) check(surface(500), {fields: 7, chromaStep});
});

test('The largest chunk is read', () => {
  check(surface(65536), {fields: 7, chunkPoints: 65536, layers: 5});
});

test('A frame without points is read', () => {
  const {frame} = check([], {fields: 7});
  assert.equal(frame.positions.length, 0);
});

test('Memory that is handed in is used again', () => {
  const {message} = encode(surface(1000), {fields: 31});
  const first = decoder.decode(message);
  const buffers = [first.positions, first.colors, first.normals, first.masks].map((array) => array.buffer);
  const pool = [...buffers];
  const second = decoder.decode(message, pool);
  assert.equal(pool.length, 0);
  for (const array of [second.positions, second.colors, second.normals, second.masks]) assert.ok(buffers.includes(array.buffer));
});

test('Normals are unit vectors near to what they were', () => {
  for (let i = 0; i < 500; ++i) {
    const n = [random(2001) - 1000, random(2001) - 1000, random(2001) - 1000];
    const length = Math.hypot(...n);
    if (length === 0) continue;
    const back = normalOf({normals: Uint8Array.from(octahedral(n))}, 0);
    assert.ok(back.reduce((sum, value, k) => sum + (value * n[k]) / length, 0) > 0.999);
  }
  assert.equal(normalOf({normals: Uint8Array.from([0, 0])}, 0), null);
});

/** Whatever comes: the same decoder refuses it by an Error of one line, or reads it, and then reads a good frame as before. */
function refuses(message, must = true) {
  try {
    decoder.decode(message);
  } catch (error) {
    assert.ok(error instanceof Error && !(error instanceof TypeError), `${error.stack}`);
    assert.ok(error.message.length > 0 && !error.message.includes('\n'));
    return true;
  }
  assert.ok(!must, 'a damaged message was read');
  return false;
}

test('A message that ends early, or has more, is refused', () => {
  const {message} = encode(surface(200), {fields: 31, chunkPoints: 100, layers: 3});
  for (let size = 0; size < message.length; ++size) refuses(message.slice(0, size));
  const longer = new Uint8Array(message.length + 1);
  longer.set(message);
  refuses(longer);
});

test('Each byte that differs is found', () => {
  const {message} = encode(surface(120), {fields: 31, chunkPoints: 64, layers: 3});
  for (let at = 0; at < message.length; ++at)
    for (const flip of [1, 0x80, 0xff]) {
      const damaged = message.slice();
      damaged[at] ^= flip;
      // Some bits of a Zstandard frame mean nothing: then the points are the same.
      if (!refuses(damaged, false)) assert.deepEqual(decoder.decode(damaged).positions, decoder.decode(message).positions);
    }
});

test('Headers whose checksum is right but that lie are refused, or read without harm', () => {
  const points = surface(300);
  const {message, expected} = encode(points, {fields: 31, chunkPoints: 100, layers: 3});
  const header = new DataView(message.buffer).getUint32(4, true);
  for (let at = 4; at < header - 4; ++at)
    for (const value of [0, 1, 0x7f, 0x80, 0xff, message[at] ^ 1, message[at] ^ 16]) {
      const damaged = message.slice();
      damaged[at] = value;
      refuses(sealHeader(damaged), false);
    }
  // Numbers that would take memory without end.
  for (const [at, value] of [[76, 0xffffffff], [80, 0xffffffff], [84 + 4, 0xffffffff], [84 + 8, 0xffffffff], [84 + 36, 0xffffffff], [4, 0xffffffff]]) {
    const damaged = message.slice();
    new DataView(damaged.buffer).setUint32(at, value, true);
    refuses(sealHeader(damaged));
  }
  compare(decoder.decode(message), expected, {fields: 31});
});

test('Layers whose checksum is right but that lie are refused, or read without harm', () => {
  const points = surface(150);
  let reached = 0;
  for (let round = 0; round < 3000; ++round) {
    const layer = random(4);
    let number = 0;
    const {message} = encode(points, {fields: 31, chunkPoints: 150, layers: 4, compress: (bytes) => {
      if (number++ === layer) {
        const how = random(4);
        if (how === 0) for (let k = 0; k < 1 + random(4); ++k) bytes[random(bytes.length)] = random(256);
        if (how === 1) bytes = bytes.slice(0, random(bytes.length));
        if (how === 2) bytes = Uint8Array.from([...bytes, random(256)]);
        if (how === 3) bytes = bytes.map(() => random(256));
      }
      return zstandardStored(bytes);
    }});
    if (refuses(message, false)) ++reached;
  }
  assert.ok(reached > 1500, `${reached}`);
});

test('Bytes at random are refused', () => {
  for (let round = 0; round < 2000; ++round) {
    const message = Uint8Array.from({length: random(400)}, () => random(256));
    message.set([0x46, 0x46, 0x43, 0x31].slice(0, message.length));
    refuses(message);
  }
});

test('Layers that are no single Zstandard frame with a checksum are refused', () => {
  const points = surface(100);
  const make = (change) => encode(points, {layers: 1, compress: (bytes) => change(zstandardStored(bytes), bytes)}).message;
  decoder.decode(make((frame) => frame));
  refuses(make((frame) => { frame[4] &= ~4; return frame.slice(0, -4); }));                          // no checksum
  refuses(make((frame) => { frame[frame.length - 1] ^= 1; return frame; }));                         // another checksum
  refuses(make((frame) => Uint8Array.from([...frame, ...zstandardStored(new Uint8Array(0))])));      // two frames
  refuses(make((frame) => Uint8Array.from([0x50, 0x2a, 0x4d, 0x18, 0, 0, 0, 0, ...frame])));         // a frame to be skipped before it
  refuses(make((frame, bytes) => bytes));                                                            // nothing of Zstandard's
  // A few bytes that unpack to gigabytes: 1000 blocks of one byte repeated.
  refuses(make(() => {
    const bomb = [0x28, 0xb5, 0x2f, 0xfd, 0b00000100, 0x58];
    for (let k = 0; k < 1000; ++k) bomb.push((k === 999 ? 1 : 0) | 2 | ((131072 << 3) & 0xff), ((131072 << 3) >> 8) & 0xff, (131072 << 3) >> 16, 0);
    return Uint8Array.from([...bomb, 0, 0, 0, 0]);
  }));
});

test('A frame with too many points is refused before memory is taken', () => {
  const {message} = encode(surface(300), {});
  assert.throws(() => new FrameDecoder(zstandard, {mostPoints: 299}).decode(message), /300 points/);
});

const DESCRIPTION = {type: 'stream', version: 1, name: 'demo', frame: 'world', step: 0.001,
                     cameras: [{name: 'left', width: 640, height: 480, fx: 525, fy: 525, cx: 319.5, cy: 239.5, T_world_camera: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}]};

test('Descriptions are read, and what is none is refused', () => {
  assert.equal(parseDescription(JSON.stringify(DESCRIPTION)).cameras[0].name, 'left');
  for (const text of ['', '{', 'null', '[]', '{"type": "other"}', '{"type": "stream", "version": 2}',
                      JSON.stringify({...DESCRIPTION, cameras: [{name: 'x'}]}), JSON.stringify({...DESCRIPTION, cameras: [null]})])
    assert.throws(() => parseDescription(text), Error);
});

test('Stream files are read, also those that were cut off', async () => {
  const messages = [0n, 1n, 2n].map((number) => encode(surface(50), {number, fields: 7, captured: 10n ** 18n + number * 10n ** 8n}).message);
  const bytes = streamFile([DESCRIPTION, messages[0], messages[1], {...DESCRIPTION, name: 'other'}, messages[2]]);
  const file = await StreamFile.open(new Blob([bytes]));
  assert.equal(file.frames.length, 3);
  assert.equal(file.cutOff, false);
  assert.equal(file.frames[1].time - file.frames[0].time, 100);
  assert.equal(file.descriptions[file.frames[2].description].name, 'other');
  for (let k = 0; k < 3; ++k) assert.deepEqual(await file.read(k), messages[k]);
  const cut = await StreamFile.open(new Blob([bytes.slice(0, -1)]));
  assert.equal(cut.frames.length, 2);
  assert.equal(cut.cutOff, true);
  for (let size = 0; size < bytes.length; size += 7) await StreamFile.open(new Blob([bytes.slice(0, size)])).catch((error) => assert.ok(error.message));
  await assert.rejects(StreamFile.open(new Blob([messages[0]])), /no stream file/);
  await assert.rejects(StreamFile.open(new Blob([streamFile([messages[0]])])), /begin with a description/);
});

// Files of the library, and what its own decoder makes of them: see write_stream_files.cpp.
const folder = process.env.FUSE_FLOW_STREAM_FILES;
for (const path of folder ? readdirSync(folder).filter((name) => name.endsWith('.ffs')) : [])
  test(`What the library wrote to ${path} is read as the library reads it`, async () => {
    const file = await StreamFile.open(new Blob([readFileSync(`${folder}/${path}`)]));
    const expected = readFileSync(`${folder}/${path.replace(/ffs$/, 'points')}`);
    let at = 0;
    const take = (size) => expected.subarray(at, (at += size));
    for (let k = 0; k < file.frames.length; ++k) {
      const frame = decoder.decode(await file.read(k));
      const count = take(4).readUInt32LE(0);
      assert.equal(frame.points, count);
      const has = (field) => (frame.fields & field ? count : 0);
      const positions = take(12 * count);
      const colors = take(3 * has(FIELD.color));
      const confidence = take(has(FIELD.confidence));
      const views = take(has(FIELD.viewCount));
      const normals = take(12 * has(FIELD.normal));
      const masks = take(8 * has(FIELD.cameras));
      for (let i = 0; i < count; ++i) {
        positionOf(frame, i).forEach((value, axis) => {
          const there = positions.readFloatLE(12 * i + 4 * axis);
          assert.ok(Math.abs(value - there) <= 1e-6 * (1 + Math.abs(there)), `point ${i}: ${value}, ${there}`);
        });
        if (colors.length) assert.deepEqual([...frame.colors.subarray(4 * i, 4 * i + 3)], [...colors.subarray(3 * i, 3 * i + 3)], `colour of point ${i}`);
        if (confidence.length) assert.equal(frame.colors[4 * i + 3], confidence[i]);
        if (views.length) assert.equal(frame.positions[4 * i + 3], views[i]);
        if (normals.length)
          (normalOf(frame, i) ?? [0, 0, 0]).forEach((value, axis) => assert.ok(Math.abs(value - normals.readFloatLE(12 * i + 4 * axis)) < 1e-5));
        if (masks.length)
          for (let byte = 0; byte < frame.maskBytes; ++byte) assert.equal(frame.masks[frame.maskBytes * i + byte], masks[8 * i + byte]);
      }
    }
    assert.equal(at, expected.length);
  });
