// Reads frames as doc/reference/stream_format.md describes them. Any bytes may come: what is no whole frame is refused by an Error of one
// line, before memory is taken for it, and nothing is read or written outside of arrays. No dependency: the Zstandard decoder is handed in.
//
// How it is fast. Nothing is allocated for a point. A Morton code has up to 63 bits: the lower 30 and the others are integers of their own, and
// what is between two neighbours is mostly below 2^28, so that 32 bits do. Chunks whose codes differ by 2^52 and more take the path of
// readCodesExactly(), with BigInt. Values that are predicted alike lie in the bytes of one integer.

export const FIELD = Object.freeze({color: 1, confidence: 2, viewCount: 4, normal: 8, cameras: 16});

const MAGIC = 0x31434646;  // "FFC1"
const FIXED_HEADER = 84;
const CHUNK_HEADER = 36;
const MOST_CHUNK_POINTS = 65536;
const GREATEST = 2 ** 21 - 1;  // of a coordinate, in steps
const MOST_BYTES_OF_A_POINT = 1 + 3 + 1 + 1 + 2 + 8 + 8;  // the last: raw bits, at most 61

// CRC-32 of zlib.
const crcTable = new Int32Array(256);
for (let i = 0; i < 256; ++i) {
  let c = i;
  for (let k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  crcTable[i] = c;
}
export function crc32(bytes) {
  let c = -1;
  for (let i = 0; i < bytes.length; ++i) c = crcTable[(c ^ bytes[i]) & 255] ^ (c >>> 8);
  return ~c >>> 0;
}

// 15 bits of a Morton code → 5 bits of x, of y, of z, from bits 0, 10 and 20 on.
const mortonTable = new Int32Array(32768);
for (let code = 0; code < 32768; ++code)
  for (let k = 0; k < 15; ++k) mortonTable[code] |= ((code >> k) & 1) << (10 * (k % 3) + Math.floor(k / 3));

// Bits 30 … 62 of the Morton code of a point, as a number: its coordinates without their lower 10 bits, interleaved.
function highCode(x, y, z) {
  let code = 0;
  for (let k = 10; k >= 0; --k) code = code * 8 + (((z >> (10 + k)) & 1) * 4 + ((y >> (10 + k)) & 1) * 2 + ((x >> (10 + k)) & 1));
  return code;
}
function lowCode(x, y, z) {
  let code = 0;
  for (let k = 9; k >= 0; --k) code = code * 8 + (((z >> k) & 1) * 4 + ((y >> k) & 1) * 2 + ((x >> k) & 1));
  return code;
}

const bitLength = (value) => (value >= 2 ** 32 ? 64 - Math.clz32(value / 2 ** 32) : 32 - Math.clz32(value));  // below 2^53

// The packet of a layer: exactly one Zstandard frame that has a checksum. A decoder may take several frames, or one without.
function checkZstandardFrame(bytes, begin, size) {
  const end = begin + size;
  const wrong = () => new Error('a layer is no Zstandard frame with a checksum');
  if (size < 9 || bytes[begin] !== 0x28 || bytes[begin + 1] !== 0xb5 || bytes[begin + 2] !== 0x2f || bytes[begin + 3] !== 0xfd) throw wrong();
  const descriptor = bytes[begin + 4];
  if ((descriptor & 0x0f) !== 4) throw wrong();  // checksum; neither the reserved bit nor a dictionary
  const single_segment = (descriptor >> 5) & 1;
  const size_flag = descriptor >> 6;
  let at = begin + 5 + (single_segment ? 0 : 1) + (size_flag === 0 ? single_segment : 1 << size_flag);
  for (;;) {  // each block is at least 3 bytes
    if (at + 3 > end) throw wrong();
    const block = bytes[at] | (bytes[at + 1] << 8) | (bytes[at + 2] << 16);
    const type = (block >> 1) & 3;
    at += 3 + (type === 1 ? 1 : block >> 3);
    if (type === 3) throw wrong();
    if (block & 1) break;
  }
  if (at + 4 !== end) throw wrong();
}

/**
 * What a message says before its points. Throws if the message is not as long as it says, and if anything in it contradicts the format.
 * `message`: Uint8Array. Times are in milliseconds since 1970; 0: not known.
 */
export function readHeader(message) {
  if (message.length < FIXED_HEADER + 4) throw new Error('the message is shorter than a header');
  const view = new DataView(message.buffer, message.byteOffset, message.byteLength);
  if (view.getUint32(0, true) !== MAGIC) throw new Error('the message does not begin with FFC1');
  const header_size = view.getUint32(4, true);
  if (header_size < FIXED_HEADER + 4 || header_size > message.length) throw new Error('the header is longer than the message');
  if (crc32(message.subarray(0, header_size - 4)) !== view.getUint32(header_size - 4, true))
    throw new Error('the header is damaged: its CRC-32 differs');
  const header = {
    number: Number(view.getBigUint64(8, true)),
    captured: Number(view.getBigInt64(16, true)) / 1e6,
    encoded: Number(view.getBigInt64(24, true)) / 1e6,
    origin: [view.getFloat64(32, true), view.getFloat64(40, true), view.getFloat64(48, true)],
    step: view.getFloat64(56, true),
    fields: view.getUint32(64, true),
    chromaStep: message[68],
    layers: message[69],
    maskBytes: message[70],
    pointsOfFrame: view.getUint32(72, true),
    points: view.getUint32(76, true),
    chunks: [],
    least: [0, 0, 0],     // of the boxes of all chunks, steps
    greatest: [0, 0, 0],
  };
  if (!header.origin.every(Number.isFinite)) throw new Error('the origin is not finite');
  if (!(header.step > 0 && header.step < Infinity)) throw new Error('the step is not above 0');
  if (header.fields > 31) throw new Error('the message has fields that are not known');
  if (header.chromaStep > 64) throw new Error('the chroma step is above 64');
  if (header.layers < 1 || header.layers > 8) throw new Error('the number of layers is not 1 to 8');
  if (header.fields & FIELD.cameras ? header.maskBytes < 1 || header.maskBytes > 8 : header.maskBytes !== 0)
    throw new Error('the size of the camera masks is wrong');
  if (message[71] !== 0) throw new Error('byte 71 is not 0');
  if (header.points > header.pointsOfFrame) throw new Error('the message has more points than its frame');
  const chunk_count = view.getUint32(80, true);
  const list_end = header_size - 4;
  if (chunk_count > (list_end - FIXED_HEADER) / CHUNK_HEADER) throw new Error('the list of chunks is longer than the header');
  let at = FIXED_HEADER;
  let last = -1;
  let points = 0;
  let points_of_chunks = 0;
  for (let c = 0; c < chunk_count; ++c) {
    if (at + CHUNK_HEADER > list_end) throw new Error('the list of chunks is longer than the header');
    const u32 = (k) => view.getUint32(at + 4 * k, true);
    const chunk = {
      layers: u32(2), least: [u32(3), u32(4), u32(5)], greatest: [u32(6), u32(7), u32(8)],
      points: 0,     // that are here
      first: points, // the place of its first point among those of the message
      begins: [], sizes: [],
    };
    const number = u32(0);
    const whole = u32(1);
    if (number <= last) throw new Error('the numbers of chunks do not increase');
    if (number >= header.pointsOfFrame) throw new Error('a chunk has a number that the frame has not');
    if (whole < 1 || whole > MOST_CHUNK_POINTS) throw new Error('a chunk has not 1 to 65536 points');
    if (chunk.layers < 1 || chunk.layers > header.layers) throw new Error('a chunk has more layers than the frame, or none');
    for (let k = 0; k < 3; ++k)
      if (chunk.least[k] > chunk.greatest[k] || chunk.greatest[k] > GREATEST) throw new Error('the box of a chunk is wrong');
    last = number;
    at += CHUNK_HEADER;
    if (at + 4 * chunk.layers > list_end) throw new Error('the list of chunks is longer than the header');
    for (let l = 0; l < chunk.layers; ++l) chunk.sizes.push(view.getUint32(at + 4 * l, true));
    at += 4 * chunk.layers;
    chunk.points = Math.ceil(whole / 2 ** (header.layers - chunk.layers));
    points += chunk.points;
    points_of_chunks += whole;
    for (let k = 0; k < 3; ++k) {
      header.least[k] = c === 0 ? chunk.least[k] : Math.min(header.least[k], chunk.least[k]);
      header.greatest[k] = c === 0 ? chunk.greatest[k] : Math.max(header.greatest[k], chunk.greatest[k]);
    }
    header.chunks.push(chunk);
  }
  if (at !== list_end) throw new Error('the header is longer than its list of chunks');
  if (points !== header.points) throw new Error('the chunks have another number of points than the message');
  if (points_of_chunks > header.pointsOfFrame) throw new Error('the chunks have more points than the frame');
  let begin = header_size;
  for (let l = 0; l < header.layers; ++l)
    for (const chunk of header.chunks)
      if (l < chunk.layers) {
        chunk.begins.push(begin);
        begin += chunk.sizes[l];
      }
  if (begin !== message.length) throw new Error(`the message has ${message.length} bytes, and should have ${begin}`);
  return header;
}

/** The place of the first point of a chunk among those of the message; of the chunk after the last, their number. */
export function firstOf(header, chunk) { return chunk < header.chunks.length ? header.chunks[chunk].first : header.points; }

/** Reads frames. It keeps memory from one frame to the next. */
export class FrameDecoder {
  /**
   * `zstandard.decompress(bytes, most)`: the Uint8Array that one Zstandard frame unpacks to, valid until the next call; it throws if that
   * has more than `most` bytes, and if its checksum is wrong. `mostPoints`: a frame with more is refused.
   */
  constructor(zstandard, {mostPoints = 2 ** 24} = {}) {
    this.zstandard = zstandard;
    this.mostPoints = mostPoints;
    this.capacity = 0;
    this.layer = new Uint8Array(0);      // what is unpacked; with 8 bytes more, which the reader of bits may touch
    this.layerView = new DataView(this.layer.buffer);
    this.low = new Int32Array(0);        // of the Morton code of each point of a chunk, see readCodes()
    this.high = new Int32Array(0);
    this.grid = new Int32Array(0);       // x, y, z of each, and nothing
    this.views = new Uint8Array(0);      // of each
    this.weights = new Uint8Array(0);    // of the left neighbour, of 16, of each point of a layer
  }

  /** Scratch for a chunk of so many points. */
  reserve(points) {
    if (points <= this.capacity) return;
    this.capacity = Math.min(MOST_CHUNK_POINTS, Math.max(16384, 2 * points));
    this.layer = new Uint8Array(this.capacity * MOST_BYTES_OF_A_POINT + 8);
    this.layerView = new DataView(this.layer.buffer);
    this.low = new Int32Array(this.capacity);
    this.high = new Int32Array(this.capacity);
    this.views = new Uint8Array(this.capacity);
    this.grid = new Int32Array(4 * this.capacity);
    this.weights = new Uint8Array(this.capacity);
  }

  /**
   * A frame. Point i is at origin + step · (x, y, z), with (x, y, z, views) = positions[4 i …], and colours r, g, b, confidence =
   * colors[4 i …]: so a graphics card reads them without their being converted. positions is a Uint16Array, or a Float32Array of whole
   * numbers if the points are too far apart; origin is that of the message moved to the least corner of the points. normals: p, q
   * of each; masks: maskBytes of each; both null if the frame has not got them.
   *
   * `message`: Uint8Array. `recycled`: an array of ArrayBuffers that may be taken instead of new ones; those taken are removed.
   */
  decode(message, recycled = []) {
    const header = readHeader(message);
    const frame = this.prepare(header, recycled);
    this.decodeChunks(message, header, 0, header.chunks.length, frame);
    return frame;
  }

  /** Memory for the chunks from `begin` to `end` − 1, all by default, without what is in it: see decode(). */
  prepare(header, recycled = [], begin = 0, end = header.chunks.length) {
    const {fields, maskBytes} = header;
    if (header.points > this.mostPoints) throw new Error(`the message has ${header.points} points: more than ${this.mostPoints}`);
    const points = firstOf(header, end) - firstOf(header, begin);
    const narrow = [0, 1, 2].every((k) => header.greatest[k] - header.least[k] < 65536);
    const take = (bytes) => {
      let best = -1;  // the smallest that is large enough, and not much too large
      for (let i = 0; i < recycled.length; ++i)
        if (recycled[i].byteLength >= bytes && recycled[i].byteLength <= 4 * bytes + 4096 &&
            (best < 0 || recycled[i].byteLength < recycled[best].byteLength)) best = i;
      if (best >= 0) return recycled.splice(best, 1)[0];
      return new ArrayBuffer(8 * Math.ceil(bytes * 1.1 / 8));  // the next frame has about as many points
    };
    const frame = {
      ...header,
      origin: header.origin.map((origin, k) => origin + header.step * header.least[k]),
      greatest: header.greatest.map((greatest, k) => greatest - header.least[k]),
      positions: narrow ? new Uint16Array(take(8 * points), 0, 4 * points) : new Float32Array(take(16 * points), 0, 4 * points),
      colors: new Uint8Array(take(4 * points), 0, 4 * points),
      normals: fields & FIELD.normal ? new Uint8Array(take(2 * points), 0, 2 * points) : null,
      masks: fields & FIELD.cameras ? new Uint8Array(take(maskBytes * points), 0, maskBytes * points) : null,
    };
    delete frame.chunks;
    delete frame.least;
    return frame;
  }

  /**
   * Decodes the chunks from `begin` to `end` − 1 of a message into what prepare() has made for them, or for all. Chunks do not depend on each
   * other, so several decoders can share a frame. `before`: the points before those of `frame`.
   */
  decodeChunks(message, header, begin, end, frame, before = 0) {
    const {fields, maskBytes} = header;
    const narrow = frame.positions instanceof Uint16Array;
    const packed = new Int32Array(frame.colors.buffer, 0, frame.colors.length / 4);
    const exact_colors = header.chromaStep === 0;
    for (const chunk of header.chunks.slice(begin, end)) {
      const first_point = chunk.first - before;
      this.reserve(chunk.points);
      const read_codes = this.codesFit(chunk) ? this.readCodes : this.readCodesExactly;
      for (let l = 0; l < chunk.layers; ++l) {
        // Without the layers that are not here, the ranks are every 2^(L − n)-th; they are counted from 0 again.
        const stride = 2 ** (chunk.layers - 1 - l);
        const first = l === 0 ? 0 : stride;
        const gap = l === 0 ? stride : 2 * stride;
        const count = first < chunk.points ? Math.ceil((chunk.points - first) / gap) : 0;
        if (count === 0) {
          if (chunk.sizes[l] !== 0) throw new Error('a layer without points has bytes');
          continue;
        }
        const unpacked = this.unpack(message, chunk.begins[l], chunk.sizes[l], count, fields, maskBytes);
        read_codes.call(this, chunk, l, count, stride, header.least, unpacked);
        if (fields === 0) continue;
        this.weigh(l, count, stride, chunk.points);
        let at = count;
        const color_at = fields & FIELD.color ? at : -1;
        if (fields & FIELD.color) at += 3 * count;
        const confidence_at = fields & FIELD.confidence ? at : -1;
        if (fields & FIELD.confidence) at += count;
        if (fields & (FIELD.color | FIELD.confidence))
          this.readColors(packed, first_point, l, count, stride, chunk.points, color_at, confidence_at, exact_colors);
        if (fields & FIELD.viewCount) {
          this.readViews(l, count, stride, chunk.points, at);
          at += count;
        }
        if (fields & FIELD.normal) {
          for (let k = 0; k < 2; ++k, at += count) this.readNearest(frame.normals, 2, first_point, k, l, count, stride, chunk.points, at, false);
        }
        if (fields & FIELD.cameras)
          for (let k = 0; k < maskBytes; ++k, at += count)
            this.readNearest(frame.masks, maskBytes, first_point, k, l, count, stride, chunk.points, at, true);
      }
      this.finish(frame, chunk, first_point, header.least, narrow);
    }
    const [from, to] = [firstOf(header, begin) - before, firstOf(header, end) - before];
    if (fields & FIELD.color && !exact_colors) toRgb(packed.subarray(from, to), header.chromaStep);
  }

  /** Unpacks a layer into this.layer. Returns where its raw bits begin and how many bytes it has. */
  unpack(message, begin, size, count, fields, maskBytes) {
    checkZstandardFrame(message, begin, size);
    const plain = count * (1 + (fields & FIELD.color ? 3 : 0) + (fields & FIELD.confidence ? 1 : 0) + (fields & FIELD.viewCount ? 1 : 0) +
                           (fields & FIELD.normal ? 2 : 0) + maskBytes);
    const bytes = this.zstandard.decompress(message.subarray(begin, begin + size), plain + 8 * count);
    if (bytes.length < plain) throw new Error('a layer is too short');
    if (bytes.length > plain + 8 * count) throw new Error('a layer is too long');
    this.layer.set(bytes);
    this.layer.fill(0, bytes.length, bytes.length + 8);
    return {bits: plain, end: bytes.length};
  }

  /** Whether the Morton codes of a chunk, less that of its least corner, have at most 52 bits, and so are exact as doubles. */
  codesFit(chunk) {
    return highCode(...chunk.greatest) - highCode(...chunk.least) < 2 ** 22 - 1;
  }

  /**
   * Positions of a layer's points into this.grid. A code is in two parts: bits 0 … 29 in this.low, and the bits above, less those of the
   * least corner, in this.high.
   */
  readCodes(chunk, l, count, stride, least, unpacked) {
    const {layer, layerView, low, high, grid} = this;
    const points = chunk.points;
    const base = highCode(...chunk.least);
    const most_high = highCode(...chunk.greatest) - base;
    const most_low = lowCode(...chunk.greatest);
    const end = 8 * unpacked.end;
    let at = 8 * unpacked.bits;  // in bits
    let high_of_corner = -1;
    let x_corner = 0, y_corner = 0, z_corner = 0;
    const first = l === 0 ? 0 : stride;
    const gap = l === 0 ? stride : 2 * stride;
    const last_between = l === 0 ? 0 : points - stride;  // before it, points have a right neighbour
    for (let k = 0, i = first; k < count; ++k, i += gap) {
      const token = layer[k];
      let code_low = 0, code_high = 0;
      if (i < last_between) {
        const left = i - stride | 0;
        const right = i + stride | 0;
        code_low = low[left];
        code_high = high[left];
        const range = low[right] - code_low | 0;
        if (token > 15) throw new Error('a point between two others has a token above 15');
        if (high[right] === code_high && range < 0x10000000) {
          const last = range >> 4;  // w − 1
          // At most 24 bits, and as many as 7 before them: of one word. Past the end of the bits are bytes, too; that is found later.
          const word = layerView.getUint32(at >> 3, true) >>> (at & 7);
          const bits = 31 - Math.clz32(last | 1);  // k − 1; and 0 if there are none, so that nothing here needs a branch
          const u = (2 << bits) - last - 1 | 0;
          const r = word & ((1 << bits) - 1);
          const more = ~(r - u) >>> 31;  // 1: one more bit
          const d = Math.imul(token, last + 1) + r + ((r - u + ((word >>> bits) & 1)) & -more) | 0;
          at = at + bits + more | 0;
          if (d > range) throw new Error('a point is not between its neighbours');
          code_low = code_low + d | 0;
        } else {
          const wide_range = (high[right] - code_high) * 2 ** 30 + range;
          const last = Math.floor(wide_range / 16);
          const w = last + 1;
          const bits = bitLength(last) - 1;
          const u = 2 ** (bits + 1) - w;
          if (at + bits > end) throw new Error('the raw bits end too early');
          let r = this.bits(at, bits);
          at += bits;
          if (r >= u) {
            r = 2 * r + this.bits(at, 1) - u;
            ++at;
          }
          const d = token * w + r;
          if (d > wide_range) throw new Error('a point is not between its neighbours');
          const sum = code_low + d;
          code_high += Math.floor(sum / 2 ** 30);
          code_low = sum % 2 ** 30;
        }
      } else {
        const n = (token - 16) >> 1;
        if (token < 16 || n > 63 || (n < 2 && (token & 1))) throw new Error('a point has a wrong token');
        let d_low = n, d_high = 0;  // 30 bits, 33 bits
        if (n >= 2) {
          const bits = n - 2;
          const top = 2 | (token & 1);
          if (at + bits > end) throw new Error('the raw bits end too early');
          if (bits < 24) {
            d_low = (top << bits) | ((layerView.getUint32(at >> 3, true) >>> (at & 7)) & ((1 << bits) - 1));
          } else if (bits < 30) {
            const d = top * 2 ** bits + this.bits(at, bits);
            d_low = d % 2 ** 30;
            d_high = Math.floor(d / 2 ** 30);
          } else {
            d_low = this.bits(at, 30);
            d_high = top * 2 ** (bits - 30) + this.bits(at + 30, bits - 30);
          }
          at += bits;
        }
        if (i < stride) {
          d_high -= base;
        } else {
          d_low += low[i - stride];
          d_high += high[i - stride];
          if (d_low >= 2 ** 30) {
            d_low -= 2 ** 30;
            ++d_high;
          }
        }
        if (d_high < 0 || d_high > most_high || (d_high === most_high && d_low > most_low))
          throw new Error('a point is outside of the box of its chunk');
        code_low = d_low | 0;
        code_high = d_high | 0;
      }
      low[i] = code_low;
      high[i] = code_high;
      if (code_high !== high_of_corner) {  // rare, as the codes increase
        high_of_corner = code_high;
        // Of 33 bits, 15, then 15, and the highest of each coordinate.
        const all = base + code_high;
        const middle = mortonTable[all % 32768];
        const top = Math.floor(all / 32768);
        const upper = mortonTable[top % 32768];
        const last = Math.floor(top / 32768);
        x_corner = (((middle & 1023) << 10) | ((upper & 1023) << 15) | ((last & 1) << 20)) - least[0];
        y_corner = ((((middle >> 10) & 1023) << 10) | (((upper >> 10) & 1023) << 15) | (((last >> 1) & 1) << 20)) - least[1];
        z_corner = (((middle >> 20) << 10) | ((upper >> 20) << 15) | ((last >> 2) << 20)) - least[2];
      }
      const xyz = mortonTable[code_low & 32767] | (mortonTable[code_low >> 15] << 5);
      const to = i << 2;
      grid[to] = x_corner + (xyz & 1023) | 0;
      grid[to + 1] = y_corner + ((xyz >> 10) & 1023) | 0;
      grid[to + 2] = z_corner + (xyz >> 20) | 0;
    }
    this.checkEnd(at, unpacked);
  }

  /** The same with BigInt, for chunks that lie on both sides of a far border of Morton codes. */
  readCodesExactly(chunk, l, count, stride, least, unpacked) {
    if (l === 0) this.bigCodes = new BigUint64Array(chunk.points);
    const {layer, bigCodes, grid} = this;
    const end = 8 * unpacked.end;
    let at = 8 * unpacked.bits;
    const read = (n) => {
      if (at + n > end) throw new Error('the raw bits end too early');
      let value = 0n;
      for (let done = 0; done < n; done += 24)
        value |= BigInt(this.bits(at + done, Math.min(24, n - done))) << BigInt(done);
      at += n;
      return value;
    };
    const first = l === 0 ? 0 : stride;
    const gap = l === 0 ? stride : 2 * stride;
    for (let k = 0, i = first; k < count; ++k, i += gap) {
      const token = layer[k];
      const left = i >= stride ? bigCodes[i - stride] : 0n;
      let d;
      if (l > 0 && i + stride < chunk.points) {
        const range = bigCodes[i + stride] - left;
        if (token > 15) throw new Error('a point between two others has a token above 15');
        const w = range / 16n + 1n;
        let r = 0n;
        if (w > 1n) {
          const bits = (w - 1n).toString(2).length;
          const u = (1n << BigInt(bits)) - w;
          r = read(bits - 1);
          if (r >= u) r = 2n * r + read(1) - u;
        }
        d = BigInt(token) * w + r;
        if (d > range) throw new Error('a point is not between its neighbours');
      } else {
        const n = (token - 16) >> 1;
        if (token < 16 || n > 63 || (n < 2 && (token & 1))) throw new Error('a point has a wrong token');
        d = n < 2 ? BigInt(n) : (BigInt(2 | (token & 1)) << BigInt(n - 2)) | read(n - 2);
      }
      const code = left + d;
      if (code >= 1n << 63n) throw new Error('a point is outside of the box of its chunk');
      bigCodes[i] = code;
      for (let part = 0; part < 3; ++part) grid[4 * i + part] = -least[part];
      for (let shift = 0, rest = code; rest > 0n; shift += 5, rest >>= 15n) {
        const xyz = mortonTable[Number(rest & 32767n)];
        grid[4 * i] += (xyz & 1023) << shift;
        grid[4 * i + 1] += ((xyz >> 10) & 1023) << shift;
        grid[4 * i + 2] += (xyz >> 20) << shift;
      }
    }
    this.checkEnd(at, unpacked);
  }

  /** A number of n < 53 bits that begins at this bit of this.layer. */
  bits(at, n) {
    let value = 0;
    for (let done = 0; done < n; done += 24) {
      const word = this.layerView.getUint32((at + done) >>> 3, true) >>> ((at + done) & 7);
      value += (word & (2 ** Math.min(24, n - done) - 1)) * 2 ** done;
    }
    return value;
  }

  checkEnd(at, unpacked) {
    if (Math.ceil(at / 8) > unpacked.end) throw new Error('the raw bits end too early');
    if (Math.ceil(at / 8) < unpacked.end) throw new Error('a layer is too long');
  }

  /** How much of the prediction is the left neighbour's, of 16. From 8 on, the left one is the nearer, or as near. */
  weigh(l, count, stride, points) {
    const {grid, weights} = this;
    if (l === 0) {
      weights.fill(16, 0, count);
      return;
    }
    const last_between = points - stride;
    for (let k = 0, i = stride; k < count; ++k, i += 2 * stride) {
      if (i >= last_between) {
        weights[k] = 16;
        break;  // it is the last one
      }
      const at = i << 2;
      const left = at - (stride << 2) | 0;
      const right = at + (stride << 2) | 0;
      const x = grid[at], y = grid[at + 1], z = grid[at + 2];
      const to_left = Math.abs(x - grid[left] | 0) + Math.abs(y - grid[left + 1] | 0) + Math.abs(z - grid[left + 2] | 0) | 0;
      const to_right = Math.abs(x - grid[right] | 0) + Math.abs(y - grid[right + 1] | 0) + Math.abs(z - grid[right + 2] | 0) | 0;
      const both = to_left + to_right | 0;
      weights[k] = both === 0 ? 8 : ((to_right << 4) / both) | 0;
    }
  }

  /**
   * Colours and confidence into the bytes of `out`: r, g, b (or u, y, v), confidence. Two values are in each 16 bits of an integer, so that
   * one multiplication predicts both.
   */
  readColors(out, begin, l, count, stride, points, color_at, confidence_at, exact) {
    const {layer, weights} = this;
    const first = l === 0 ? 0 : stride;
    const gap = l === 0 ? stride : 2 * stride;
    const mask = 0x00ff00ff;
    for (let k = 0, i = first; k < count; ++k, i += gap) {
      const a = weights[k];
      const left = i >= stride ? out[begin + i - stride] : 0;
      const right = l > 0 && i + stride < points ? out[begin + i + stride] : 0;  // a is 16 without
      const rb = ((Math.imul(left & mask, a) + Math.imul(right & mask, 16 - a) + 0x00080008) >>> 4) & mask;
      const ga = ((Math.imul((left >>> 8) & mask, a) + Math.imul((right >>> 8) & mask, 16 - a) + 0x00080008) >>> 4) & mask;
      let r = 0, g = 0, b = 0;
      if (color_at >= 0) {
        g = layer[color_at + k];
        const also = exact ? g : 0;
        r = layer[color_at + count + k] + also;
        b = layer[color_at + 2 * count + k] + also;
      }
      const confidence = confidence_at >= 0 ? layer[confidence_at + k] : 0;
      out[begin + i] = ((rb + ((r & 255) | ((b & 255) << 16))) & mask) | (((ga + (g | (confidence << 16))) & mask) << 8);
    }
  }

  readViews(l, count, stride, points, from) {
    const {layer, weights, views} = this;
    const first = l === 0 ? 0 : stride;
    const gap = l === 0 ? stride : 2 * stride;
    for (let k = 0, i = first; k < count; ++k, i += gap) {
      const a = weights[k];
      const left = i >= stride ? views[i - stride] : 0;
      const right = l > 0 && i + stride < points ? views[i + stride] : 0;
      views[i] = ((Math.imul(a, left) + Math.imul(16 - a, right) + 8) >> 4) + layer[from + k];
    }
  }

  /** Values that are as those of the nearer neighbour. */
  readNearest(out, size, begin, part, l, count, stride, points, from, exclusive_or) {
    const {layer, weights} = this;
    const first = l === 0 ? 0 : stride;
    const gap = l === 0 ? stride : 2 * stride;
    for (let k = 0, i = first; k < count; ++k, i += gap) {
      const neighbour = weights[k] >= 8 ? i - stride : i + stride;
      const predicted = neighbour >= 0 ? out[(begin + neighbour) * size + part] : 0;
      const value = layer[from + k];
      out[(begin + i) * size + part] = exclusive_or ? predicted ^ value : predicted + value;
    }
  }

  /** Checks that the points of a chunk are in its box, and puts their positions where they belong. */
  finish(frame, chunk, first, least, narrow) {
    const {grid, views} = this;
    const x_least = chunk.least[0] - least[0], x_greatest = chunk.greatest[0] - least[0];
    const y_least = chunk.least[1] - least[1], y_greatest = chunk.greatest[1] - least[1];
    const z_least = chunk.least[2] - least[2], z_greatest = chunk.greatest[2] - least[2];
    const with_views = frame.fields & FIELD.viewCount ? 255 : 0;
    const end = 4 * chunk.points;
    let outside = false;
    if (narrow) {
      const out = new Int32Array(frame.positions.buffer, 8 * first, 2 * chunk.points);
      for (let at = 0; at < end; at += 4) {
        const x = grid[at], y = grid[at + 1], z = grid[at + 2];
        if (x < x_least || x > x_greatest || y < y_least || y > y_greatest || z < z_least || z > z_greatest) outside = true;
        out[at >> 1] = x | (y << 16);
        out[(at >> 1) + 1] = z | ((views[at >> 2] & with_views) << 16);
      }
    } else {
      const out = frame.positions.subarray(4 * first);
      for (let at = 0; at < end; at += 4) {
        const x = grid[at], y = grid[at + 1], z = grid[at + 2];
        if (x < x_least || x > x_greatest || y < y_least || y > y_greatest || z < z_least || z > z_greatest) outside = true;
        out[at] = x;
        out[at + 1] = y;
        out[at + 2] = z;
        out[at + 3] = views[at >> 2] & with_views;
      }
    }
    if (outside) throw new Error('a point is outside of the box of its chunk');
  }
}

/** u, y, v in the lower three bytes become r, g, b. */
function toRgb(packed, step) {
  const limit = (value) => (value < 0 ? 0 : value > 255 ? 255 : value);
  for (let i = 0; i < packed.length; ++i) {
    const value = packed[i];
    const y = (value >> 8) & 255;
    const b = limit(y + step * ((value & 255) - 128));
    const r = limit(y + step * (((value >> 16) & 255) - 128));
    const g = limit((4 * y - r - b) >> 1);
    packed[i] = (value & 0xff000000) | (b << 16) | (g << 8) | r;
  }
}

/** The x, y, z of point i in metres. */
export function positionOf(frame, i) {
  return [0, 1, 2].map((k) => frame.origin[k] + frame.step * frame.positions[4 * i + k]);
}

/** The unit normal of point i, or null. */
export function normalOf(frame, i) {
  const p = frame.normals[2 * i];
  const q = frame.normals[2 * i + 1];
  if (p === 0 && q === 0) return null;
  let x = (p - 128) / 127;
  let y = (q - 128) / 127;
  const z = 1 - Math.abs(x) - Math.abs(y);
  if (z < 0) [x, y] = [(1 - Math.abs(y)) * (x < 0 ? -1 : 1), (1 - Math.abs(x)) * (y < 0 ? -1 : 1)];
  const length = Math.hypot(x, y, z);
  return [x / length, y / length, z / length];
}
