// Zstandard by the WebAssembly of zstddec. Not by its class: that fetches a data: address, which the page's
// Content-Security-Policy forbids, copies what it unpacks, and takes an error for a size.
import {wasm} from './zstddec.mjs';  // the export is added where the page is put together, see CMakeLists.txt

export class Zstandard {
  static async load() {
    const binary = atob(wasm);
    const bytes = Uint8Array.from(binary, (character) => character.charCodeAt(0));
    const {instance} = await WebAssembly.instantiate(bytes, {env: {emscripten_notify_memory_growth() {}}});
    return new Zstandard(instance.exports);
  }

  constructor(exports) {
    this.exports = exports;
    this.input = {at: 0, size: 0};
    this.output = {at: 0, size: 0};
  }

  /** What one frame unpacks to; valid until the next call. Throws if that is more than `most` bytes, or if anything is wrong with it. */
  decompress(bytes, most) {
    this.reserve(this.input, bytes.length);
    this.reserve(this.output, most);
    const memory = new Uint8Array(this.exports.memory.buffer);  // another one after it has grown
    memory.set(bytes, this.input.at);
    const size = this.exports.ZSTD_decompress(this.output.at, most, this.input.at, bytes.length);
    if (this.exports.ZSTD_isError(size) || size < 0 || size > most) throw new Error('a layer is damaged, or too long');
    // Unpacking may have taken memory as well, and so replaced it.
    return new Uint8Array(this.exports.memory.buffer, this.output.at, size);
  }

  reserve(space, size) {
    if (size <= space.size && space.at !== 0) return;
    if (space.at !== 0) this.exports.free(space.at);
    space.size = Math.ceil(1.25 * size) + 64;
    space.at = this.exports.malloc(space.size);
    if (space.at === 0) {
      space.size = 0;
      throw new Error('out of memory');
    }
  }
}
