// A second encoder of doc/reference/stream_format.md, written from that page alone, slowly and plainly: what it writes is what decoder.js
// must read, and what it writes from the same points is what the library's encoder should write, but for Zstandard.

const MASK64 = (1n << 64n) - 1n;
const PRIMES = [11400714785074694791n, 14029467366897019727n, 1609587929392839161n, 9650029242287828579n, 2870177450012600261n];
const rotate = (x, r) => ((x << BigInt(r)) | (x >> BigInt(64 - r))) & MASK64;
const times = (a, b) => (a * b) & MASK64;

/** xxHash, 64 bits, seed 0: its lower 32 bits are the checksum of a Zstandard frame. */
export function xxh64(bytes) {
  const [p1, p2, p3, p4, p5] = PRIMES;
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const round = (acc, input) => times(rotate((acc + times(input, p2)) & MASK64, 31), p1);
  let at = 0;
  let hash;
  if (bytes.length >= 32) {
    const acc = [(p1 + p2) & MASK64, p2, 0n, (0n - p1) & MASK64];
    for (; at + 32 <= bytes.length; at += 32)
      for (let k = 0; k < 4; ++k) acc[k] = round(acc[k], view.getBigUint64(at + 8 * k, true));
    hash = (rotate(acc[0], 1) + rotate(acc[1], 7) + rotate(acc[2], 12) + rotate(acc[3], 18)) & MASK64;
    for (const value of acc) hash = (times(hash ^ round(0n, value), p1) + p4) & MASK64;
  } else {
    hash = p5;
  }
  hash = (hash + BigInt(bytes.length)) & MASK64;
  for (; at + 8 <= bytes.length; at += 8)
    hash = (times(rotate(hash ^ round(0n, view.getBigUint64(at, true)), 27), p1) + p4) & MASK64;
  if (at + 4 <= bytes.length) {
    hash = (times(rotate(hash ^ times(BigInt(view.getUint32(at, true)), p1), 23), p2) + p3) & MASK64;
    at += 4;
  }
  for (; at < bytes.length; ++at) hash = times(rotate(hash ^ times(BigInt(bytes[at]), p5), 11), p1);
  hash = times(hash ^ (hash >> 33n), p2);
  hash = times(hash ^ (hash >> 29n), p3);
  return hash ^ (hash >> 32n);
}

/** A Zstandard frame of blocks that are not compressed, with a checksum. */
export function zstandardStored(bytes) {
  const out = [0x28, 0xb5, 0x2f, 0xfd, 0b10100100];  // single segment, 4 bytes of size, checksum
  const u32 = (value) => out.push(value & 255, (value >> 8) & 255, (value >> 16) & 255, (value >>> 24) & 255);
  u32(bytes.length);
  for (let at = 0; ; ) {
    const size = Math.min(131072, bytes.length - at);
    const last = at + size === bytes.length ? 1 : 0;
    const block = last | (size << 3);
    out.push(block & 255, (block >> 8) & 255, (block >> 16) & 255);
    for (let k = 0; k < size; ++k) out.push(bytes[at + k]);
    at += size;
    if (last) break;
  }
  u32(Number(xxh64(bytes) & 0xffffffffn) | 0);
  return Uint8Array.from(out);
}

function crc32(bytes) {
  let c = 0xffffffff;
  for (const byte of bytes) {
    c ^= byte;
    for (let k = 0; k < 8; ++k) c = c & 1 ? (c >>> 1) ^ 0xedb88320 : c >>> 1;
  }
  return (c ^ 0xffffffff) >>> 0;
}

export function morton([x, y, z]) {
  let code = 0n;
  for (let k = 20n; k >= 0n; --k)
    code = (code << 3n) | (((BigInt(z) >> k) & 1n) << 2n) | (((BigInt(y) >> k) & 1n) << 1n) | ((BigInt(x) >> k) & 1n);
  return code;
}

class Bits {
  bytes = [];
  used = 0;  // bits of the last byte
  push(value, count) {
    for (let k = 0; k < count; ++k) {
      if (this.used % 8 === 0) this.bytes.push(0);
      this.bytes[this.bytes.length - 1] |= Number((value >> BigInt(k)) & 1n) << this.used % 8;
      ++this.used;
    }
  }
}

const bitLength = (value) => (value === 0n ? 0 : value.toString(2).length);
const floorDiv = (a, b) => Math.floor(a / b);

export function octahedral([x, y, z]) {
  const sum = Math.abs(x) + Math.abs(y) + Math.abs(z);
  if (sum === 0) return [0, 0];
  let p = x / sum, q = y / sum;
  if (z < 0) [p, q] = [(1 - Math.abs(q)) * (p < 0 ? -1 : 1), (1 - Math.abs(p)) * (q < 0 ? -1 : 1)];
  return [Math.round(127 * p) + 128, Math.round(127 * q) + 128];
}

/** y, u, v of a colour. */
export function toYuv([r, g, b], c) {
  const y = floorDiv(r + 2 * g + b + 2, 4);
  const part = (value) => {
    const units = Math.sign(value) * Math.floor(Math.abs(value) / c + 0.5);
    return Math.min(255, Math.max(0, units + 128));
  };
  return [y, part(b - y), part(r - y)];
}
export function fromYuv([y, u, v], c) {
  const limit = (value) => Math.min(255, Math.max(0, value));
  const b = limit(y + c * (u - 128)), r = limit(y + c * (v - 128));
  return [r, limit(floorDiv(4 * y - r - b, 2)), b];
}

/**
 * A frame as a message, and what a decoder should make of it. `points`: objects with xyz, in steps, and, as `fields` says, rgb,
 * confidence (0 … 255), views, normal (p, q), mask (BigInt). `layersOf(chunk)`: how many of its layers the message has, 0 for none.
 */
export function encode(points, options = {}) {
  const {number = 0n, captured = 0n, encoded = 0n, origin = [0, 0, 0], step = 0.001, fields = 0, chromaStep = 0, layers = 5,
         chunkPoints = 16384, maskBytes = fields & 16 ? 1 : 0, layersOf = () => layers, compress = zstandardStored} = options;
  const sorted = points.map((point) => ({...point, code: morton(point.xyz)})).sort((a, b) => (a.code < b.code ? -1 : a.code > b.code ? 1 : 0));
  const chunks = [];
  for (let begin = 0; begin < sorted.length; begin += chunkPoints)
    chunks.push({number: chunks.length, points: sorted.slice(begin, begin + chunkPoints)});

  const values = (point) => {
    const out = [];
    if (fields & 1) out.push(...(chromaStep ? toYuv(point.rgb, chromaStep) : [point.rgb[1], point.rgb[0], point.rgb[2]]));
    if (fields & 2) out.push(point.confidence);
    if (fields & 4) out.push(Math.min(255, point.views));
    return out;
  };
  const distance = (a, b) => Math.abs(a.xyz[0] - b.xyz[0]) + Math.abs(a.xyz[1] - b.xyz[1]) + Math.abs(a.xyz[2] - b.xyz[2]);

  function layerOf(chunk, l) {
    const stride = 2 ** (layers - 1 - l);
    const tokens = [];
    const arrays = [];  // of each point: its bytes, in the order of the arrays
    const bits = new Bits();
    for (let i = l === 0 ? 0 : stride; i < chunk.length; i += l === 0 ? stride : 2 * stride) {
      const point = chunk[i];
      const left = i >= stride ? chunk[i - stride] : null;
      const right = l > 0 && i + stride < chunk.length ? chunk[i + stride] : null;
      const d = point.code - (left ? left.code : 0n);
      if (right) {
        const w = (right.code - left.code) / 16n + 1n;
        tokens.push(Number(d / w));
        if (w > 1n) {
          const r = d % w;
          const k = bitLength(w - 1n);
          const u = (1n << BigInt(k)) - w;
          if (r < u) {
            bits.push(r, k - 1);
          } else {
            bits.push((r + u) / 2n, k - 1);
            bits.push((r + u) % 2n, 1);
          }
        }
      } else {
        const n = bitLength(d);
        const m = n < 2 ? 0 : Number((d >> BigInt(n - 2)) & 1n);
        tokens.push(16 + 2 * n + m);
        if (n > 2) bits.push(d & ((1n << BigInt(n - 2)) - 1n), n - 2);
      }
      const own = values(point);
      let a = 16;
      if (right) {
        const sum = distance(point, left) + distance(point, right);
        a = sum === 0 ? 8 : floorDiv(16 * distance(point, right), sum);
      }
      const lefts = left ? values(left) : own.map(() => 0);
      const rights = right ? values(right) : lefts;
      const residuals = own.map((value, k) => (value - floorDiv(a * lefts[k] + (16 - a) * rights[k] + 8, 16)) & 255);
      if (fields & 1 && !chromaStep) {
        residuals[1] = (residuals[1] - residuals[0]) & 255;
        residuals[2] = (residuals[2] - residuals[0]) & 255;
      }
      const near = right && distance(point, right) < distance(point, left) ? right : left;
      if (fields & 8)
        for (let k = 0; k < 2; ++k) residuals.push((point.normal[k] - (near ? near.normal[k] : 0)) & 255);
      if (fields & 16)
        for (let k = 0; k < maskBytes; ++k) residuals.push(Number(((point.mask ^ (near ? near.mask : 0n)) >> BigInt(8 * k)) & 255n));
      arrays.push(residuals);
    }
    if (tokens.length === 0) return new Uint8Array(0);
    const plain = [...tokens];
    for (let k = 0; k < arrays[0].length; ++k) for (const residuals of arrays) plain.push(residuals[k]);
    for (const byte of bits.bytes) plain.push(byte);
    return compress(Uint8Array.from(plain));
  }

  const expected = [];
  const list = [];
  for (const chunk of chunks) {
    const here = layersOf(chunk);
    if (here === 0) continue;
    const entry = {number: chunk.number, whole: chunk.points.length, layers: []};
    for (let l = 0; l < here; ++l) entry.layers.push(layerOf(chunk.points, l));
    entry.least = [0, 1, 2].map((k) => chunk.points.reduce((least, point) => Math.min(least, point.xyz[k]), Infinity));
    entry.greatest = [0, 1, 2].map((k) => chunk.points.reduce((greatest, point) => Math.max(greatest, point.xyz[k]), 0));
    for (let i = 0; i < chunk.points.length; i += 2 ** (layers - here)) expected.push(chunk.points[i]);
    list.push(entry);
  }
  const header_size = 84 + list.reduce((sum, entry) => sum + 36 + 4 * entry.layers.length, 0) + 4;
  const header = new Uint8Array(header_size);
  const view = new DataView(header.buffer);
  header.set([0x46, 0x46, 0x43, 0x31]);
  view.setUint32(4, header_size, true);
  view.setBigUint64(8, number, true);
  view.setBigInt64(16, captured, true);
  view.setBigInt64(24, encoded, true);
  origin.forEach((value, k) => view.setFloat64(32 + 8 * k, value, true));
  view.setFloat64(56, step, true);
  view.setUint32(64, fields, true);
  header[68] = chromaStep;
  header[69] = layers;
  header[70] = maskBytes;
  view.setUint32(72, points.length, true);
  view.setUint32(76, expected.length, true);
  view.setUint32(80, list.length, true);
  let at = 84;
  for (const entry of list)
    for (const value of [entry.number, entry.whole, entry.layers.length, ...entry.least, ...entry.greatest, ...entry.layers.map((l) => l.length)]) {
      view.setUint32(at, value, true);
      at += 4;
    }
  view.setUint32(at, crc32(header.subarray(0, at)), true);
  const pieces = [header];
  for (let l = 0; l < layers; ++l) for (const entry of list) if (l < entry.layers.length) pieces.push(entry.layers[l]);
  const message = new Uint8Array(pieces.reduce((sum, piece) => sum + piece.length, 0));
  let to = 0;
  for (const piece of pieces) {
    message.set(piece, to);
    to += piece.length;
  }
  return {message, expected};
}

/** Makes a header's CRC-32 right again, after it was changed. */
export function sealHeader(message) {
  const view = new DataView(message.buffer, message.byteOffset, message.byteLength);
  const size = view.getUint32(4, true);
  if (size >= 8 && size <= message.length) view.setUint32(size - 4, crc32(message.subarray(0, size - 4)), true);
  return message;
}

/** A stream file. `records`: messages, or descriptions as objects. */
export function streamFile(records) {
  const pieces = [Uint8Array.from([0x46, 0x46, 0x53, 0x31, 0, 0, 0, 0])];
  for (const record of records) {
    const bytes = record instanceof Uint8Array ? record : new TextEncoder().encode(JSON.stringify(record));
    const head = new Uint8Array(8);
    const view = new DataView(head.buffer);
    view.setUint32(0, bytes.length, true);
    view.setUint32(4, record instanceof Uint8Array ? 2 : 1, true);
    pieces.push(head, bytes);
  }
  const size = pieces.reduce((sum, piece) => sum + piece.length, 0);
  const out = new Uint8Array(size);
  let at = 0;
  for (const piece of pieces) {
    out.set(piece, at);
    at += piece.length;
  }
  return out;
}
