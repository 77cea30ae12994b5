// Several workers that decode one frame together: its chunks do not depend on each other.

import {FrameDecoder, firstOf, readHeader} from './decoder.js';
import {Zstandard} from './zstandard.js';

const FEW_POINTS = 50000;  // of a frame: to share them takes longer
const PATIENCE = 5000;     // milliseconds for a share: it takes a hundredth of that

/** One more worker. Until it is ready, and once it has failed, or does not answer, it takes no share. */
class Helper {
  constructor() {
    this.ready = false;
    this.number = 0;
    this.buffers = [];  // its memory, to be sent back
    this.worker = new Worker(new URL('./chunk_worker.js', import.meta.url), {type: 'module'});
    this.worker.onmessage = ({data}) => {
      if (data.ready) this.ready = true;
      else if (data.number === this.number) this.answer?.(data);
    };
    this.worker.onmessageerror = () => this.lose();
    this.worker.onerror = (event) => {
      event.preventDefault();
      this.lose();
    };
  }

  lose() {
    this.ready = false;
    this.buffers = [];
    this.worker.terminate();
    this.answer?.({lost: true});
  }

  /** Its share: positions, colors, normals, masks; or an error; or lost, if this worker is. */
  async decode(message, begin, end, patience) {
    let timer = 0;
    const share = await new Promise((answer) => {
      this.answer = answer;
      timer = setTimeout(() => this.lose(), patience);  // browsers end workers without a word where memory is short
      try {
        this.worker.postMessage({number: ++this.number, message, begin, end, buffers: this.buffers}, this.buffers);
      } catch {
        this.lose();
      }
      this.buffers = [];
    });
    clearTimeout(timer);
    return share;
  }
}

/** As FrameDecoder, but that decode() returns a promise. One frame at a time. */
export class DecodeTeam {
  /** `size`: how many workers may decode, this one included. A frame of fewer points than `fewPoints` is decoded by this one alone. */
  static async make(size, options) { return new DecodeTeam(await Zstandard.load(), size, options); }

  constructor(zstandard, size, {fewPoints = FEW_POINTS, patience = PATIENCE} = {}) {
    this.fewPoints = fewPoints;
    this.patience = patience;
    this.decoder = new FrameDecoder(zstandard);
    this.helpers = [];
    // Workers of workers: some older browsers do not have them.
    try {
      while (this.helpers.length + 1 < size) this.helpers.push(new Helper());
    } catch {
      this.helpers = [];
    }
  }

  /** How many workers decode now. */
  get size() { return 1 + this.helpers.filter((helper) => helper.ready).length; }

  async decode(message, recycled) {
    const header = readHeader(message);
    const helpers = header.points < this.fewPoints ? [] : this.helpers.filter((helper) => helper.ready).slice(0, header.chunks.length - 1);
    const frame = this.decoder.prepare(header, recycled);
    const borders = shares(header, helpers.length + 1);
    const answers = helpers.map((helper, k) => helper.decode(message, borders[k + 1], borders[k + 2], this.patience));
    let failed = null;
    try {
      this.decoder.decodeChunks(message, header, borders[0], borders[1], frame);
    } catch (error) {
      failed = error;
    }
    for (const [k, share] of (await Promise.all(answers)).entries()) {
      if (share.error) failed ??= new Error(share.error);
      if (share.lost && !failed) this.decoder.decodeChunks(message, header, borders[k + 1], borders[k + 2], frame);
      if (share.error || share.lost) continue;
      const first = firstOf(header, borders[k + 1]);
      for (const [name, items] of [['positions', 4], ['colors', 4], ['normals', 2], ['masks', header.maskBytes]])
        if (share[name]) {
          frame[name].set(share[name], items * first);
          helpers[k].buffers.push(share[name].buffer);
        }
    }
    if (failed) throw failed;
    return frame;
  }
}

/** Where the chunks of each of `count` workers begin, and where those of the last end: nearly as many points for each. */
function shares(header, count) {
  const borders = [0];
  for (let k = 1; k <= count; ++k) {
    let chunk = borders[k - 1];
    const points = k / count * header.points;
    while (chunk < header.chunks.length && firstOf(header, chunk) + header.chunks[chunk].points / 2 < points) ++chunk;
    borders.push(k < count ? chunk : header.chunks.length);
  }
  return borders;
}
