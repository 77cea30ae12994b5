// Decodes its share of a frame's chunks for decode_worker.js, which says which, and sends memory back to be used again.

import {FrameDecoder, firstOf, readHeader} from './decoder.js';
import {Zstandard} from './zstandard.js';

let decoder;
const pool = [];

self.onmessage = ({data: {number, message, begin, end, buffers}}) => {
  pool.push(...buffers);
  try {
    const header = readHeader(message);
    const share = decoder.prepare(header, pool, begin, end);
    decoder.decodeChunks(message, header, begin, end, share, firstOf(header, begin));
    pool.length = 0;  // of frames of another size
    const {positions, colors, normals, masks} = share;
    self.postMessage({number, positions, colors, normals, masks}, [positions, colors, normals, masks].filter((array) => array).map((array) => array.buffer));
  } catch (error) {
    self.postMessage({number, error: error.message});
  }
};

try {
  decoder = new FrameDecoder(await Zstandard.load());
  self.postMessage({ready: true});
} catch {
  self.close();  // then decode_worker.js decodes alone
}
