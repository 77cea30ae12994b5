// Stream files, .ffs, and the description of a stream: doc/reference/stream_format.md.

const MAGIC = 0x31534646;  // "FFS1"
const MOST_CAMERAS = 256;
const MOST_RECORD = 2 ** 30;
const FIRST_BYTES = 84;    // of a frame: as far as its times are

/** The description, with what the page needs of it checked. Throws an Error of one line. */
export function parseDescription(text) {
  let json;
  try {
    json = JSON.parse(text);
  } catch {
    throw new Error('the description is no JSON');
  }
  if (json === null || typeof json !== 'object' || json.type !== 'stream') throw new Error('a text message is no description');
  if (json.version !== 1) throw new Error('the stream has a version that this page does not know');
  const text_of = (value, otherwise) => (typeof value === 'string' ? value.slice(0, 200) : otherwise);
  const cameras = [];
  for (const camera of Array.isArray(json.cameras) ? json.cameras.slice(0, MOST_CAMERAS) : []) {
    const {width, height, fx, fy, cx, cy, T_world_camera} = camera ?? {};
    const numbers = [width, height, fx, fy, cx, cy, ...(Array.isArray(T_world_camera) ? T_world_camera : [])];
    if (numbers.length !== 22 || !numbers.every(Number.isFinite) || !(fx > 0 && fy > 0)) throw new Error('a camera of the description is wrong');
    cameras.push({name: text_of(camera.name, ''), width, height, fx, fy, cx, cy, T_world_camera});
  }
  return {name: text_of(json.name, ''), frame: text_of(json.frame, 'world'), step: Number.isFinite(json.step) ? json.step : 0, cameras};
}

/** A stream file. Only where its frames are is kept in memory. */
export class StreamFile {
  /** `blob`: a File or Blob. Throws if it is no stream file, or has no frame. */
  static async open(blob) {
    const file = new StreamFile();
    file.blob = blob;
    file.frames = [];        // {offset, size, time in milliseconds, description: an index}
    file.descriptions = [];
    file.cutOff = false;
    const bytes = async (from, to) => new DataView(await blob.slice(from, to).arrayBuffer());
    const begin = await bytes(0, 8);
    if (begin.byteLength < 8 || begin.getUint32(0, true) !== MAGIC || begin.getUint32(4, true) !== 0) throw new Error('it is no stream file');
    for (let at = 8; at < blob.size; ) {
      const head = await bytes(at, at + 8 + FIRST_BYTES);
      const size = head.byteLength >= 8 ? head.getUint32(0, true) : 0;
      if (head.byteLength < 8 || at + 8 + size > blob.size) {
        file.cutOff = true;
        break;
      }
      if (size > MOST_RECORD) throw new Error('a record is too long');
      const kind = head.getUint32(4, true);
      if (kind === 1) {
        file.descriptions.push(parseDescription(await blob.slice(at + 8, at + 8 + size).text()));
      } else if (kind === 2) {
        if (file.descriptions.length === 0) throw new Error('it does not begin with a description');
        const time = (offset) => (size >= FIRST_BYTES ? Number(head.getBigInt64(8 + offset, true)) / 1e6 : 0);
        file.frames.push({offset: at + 8, size, time: time(16) || time(24), description: file.descriptions.length - 1});
      } else {
        throw new Error('it has a record of a kind that is not known');
      }
      at += 8 + size;
    }
    if (file.frames.length === 0) throw new Error('it has no frame');
    return file;
  }

  async read(index) {
    const {offset, size} = this.frames[index];
    return new Uint8Array(await this.blob.slice(offset, offset + size).arrayBuffer());
  }
}
