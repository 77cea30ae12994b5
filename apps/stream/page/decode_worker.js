// Receives, keeps and decodes frames, so that none of it holds up drawing. The page sends wishes, and gets arrays that it can draw; it sends
// their memory back when it has drawn them. At most one frame is on its way to the page, and one more is decoded meanwhile: what comes then
// is replaced by what is newer.

import {DecodeTeam} from './decode_team.js';
import {readHeader} from './decoder.js';
import {StreamFile, parseDescription} from './stream_file.js';

const PROTOCOL = 'fuse_flow.v1';
const FIRST_WAIT = 500;      // milliseconds before connecting again
const LONGEST_WAIT = 8000;
const REST_AFTER = 3000;     // of nobody looking; servers let clients go that do not answer for ten seconds
const MOST_POOLED = 12;      // pieces of memory that wait to be used again
const memory_at_hand = navigator.deviceMemory ?? 4;  // GiB; browsers say 8 at most, and not all say
const RING_BYTES = (memory_at_hand >= 4 ? 256 : 64) * 2 ** 20;
// That decode: two cores are the page's and the browser's own. ?decoders=… of the page's address chooses another number.
const asked = Math.trunc(Number(new URL(self.location.href).searchParams.get('decoders')));
const DECODERS = asked >= 1 ? Math.min(16, asked) : Math.min(4, Math.max(1, (navigator.hardwareConcurrency ?? 2) - 2));

const now = () => performance.timeOrigin + performance.now();  // milliseconds since 1970, finer than Date's

let decoder;
const pool = [];
let source = null;
let waiting = false;     // a frame is with the page, and not drawn yet
let pending = null;      // what is to be decoded next: {message, received, index, source}
let decoding = false;
let decoded = null;      // what the page gets next, once it has drawn: {message, transfer}
let scheduled = false;
const counts = {bytes: 0, frames: 0, dropped: 0, damaged: 0};

function post(message, transfer = []) { self.postMessage(message, transfer); }

function damaged(reason) {
  ++counts.damaged;
  post({type: 'damaged', count: counts.damaged, reason});
}

// Decoding waits for a turn of its own: messages that have come already are then looked at before, and only the newest is decoded.
const turn = new MessageChannel();
turn.port1.onmessage = () => {
  scheduled = false;
  decodePending();
};
function show(entry) {
  if (pending) ++counts.dropped;
  pending = {...entry, source};
  schedule();
}
function schedule() {
  if (scheduled || decoding || decoded || !pending || !decoder) return;
  scheduled = true;
  turn.port2.postMessage(0);
}
/** Whether nothing waits, but for the page. */
function caughtUp() { return !pending && !decoding && !decoded; }

/** What was decoded is not what is asked for now. */
function giveUpDecoded() {
  if (!decoded) return;
  pool.push(...decoded.transfer);
  decoded = null;
  ++counts.dropped;
}

async function decodePending() {
  if (!pending || decoding || decoded) return;
  const entry = pending;
  pending = null;
  decoding = true;
  const begin = performance.now();
  try {
    const frame = await decoder.decode(entry.message, pool);
    // Nothing of a source that was left meanwhile, for a file.
    if (entry.source === source) {
      const arrays = [frame.positions, frame.colors, frame.normals, frame.masks].filter((array) => array);
      decoded = {entry, message: {type: 'frame', frame, bytes: entry.message.length, received: entry.received, decoding: performance.now() - begin},
                 transfer: arrays.map((array) => array.buffer)};
    }
  } catch (error) {
    damaged(error.message);
  }
  decoding = false;
  deliver();
}
function deliver() {
  if (decoded && !waiting) {
    const {entry, message, transfer} = decoded;
    decoded = null;
    if (entry.source === source) {
      waiting = true;
      post({...message, place: source.place(entry)}, transfer);
    } else {
      pool.push(...transfer);
    }
  }
  source?.afterShown();
  schedule();
}

/** Frames as they come. The last ones are kept as they came, for stepping back. */
class Live {
  constructor(url) {
    this.url = url;
    this.socket = null;
    this.wait = FIRST_WAIT;
    this.timer = 0;
    this.ring = [];        // {message, received, index}
    this.ringBytes = 0;
    this.next = 0;         // index of the next frame
    this.shown = -1;
    this.playing = true;
    this.hidden = false;
    this.stepping = false; // the next frame is to be shown though it does not play
    this.unanswered = [];
    this.restTimer = 0;
    this.connect();
  }

  /** Whether nobody looks for more. */
  get idle() { return (!this.playing || this.hidden) && !this.stepping; }

  connect() {
    post({type: 'state', state: 'connecting'});
    let socket;
    try {
      socket = new WebSocket(this.url, PROTOCOL);
    } catch (error) {
      post({type: 'state', state: 'failed', detail: error.message});
      return;
    }
    this.socket = socket;
    this.unanswered = [];
    socket.binaryType = 'arraybuffer';
    let opened = false;
    socket.onopen = () => {
      opened = true;
      post({type: 'state', state: 'connected'});
      this.sendWant();
    };
    socket.onmessage = (event) => {
      if (this.socket !== socket) return;
      this.wait = FIRST_WAIT;  // it serves: not just a port that is open
      if (typeof event.data === 'string') this.describe(event.data);
      else this.receive(new Uint8Array(event.data));
    };
    socket.onclose = (event) => {
      if (this.socket !== socket) return;
      this.socket = null;
      if (this.idle) {
        post({type: 'state', state: 'resting'});
        return;
      }
      // Not all at once, when a server that many look at comes back.
      const wait = this.wait * (0.8 + 0.4 * Math.random());
      this.wait = Math.min(LONGEST_WAIT, 2 * this.wait);
      post({type: 'state', state: 'disconnected', opened, code: event.code, detail: event.reason, again: wait});
      this.timer = setTimeout(() => {
        this.timer = 0;
        this.connect();
      }, wait);
    };
  }

  /** After what changes whether anybody looks: frames are answered, or not, and after a while the connection ends. */
  settle() {
    clearTimeout(this.restTimer);
    if (this.idle) {
      this.restTimer = setTimeout(() => {
        const socket = this.socket;
        clearTimeout(this.timer);
        this.timer = 0;
        this.socket = null;
        socket?.close();
        post({type: 'state', state: 'resting'});
      }, REST_AFTER);
      return;
    }
    if (!this.socket && !this.timer) this.connect();
    this.answer();
  }

  close() {
    clearTimeout(this.timer);
    clearTimeout(this.restTimer);
    const socket = this.socket;
    this.socket = null;
    socket?.close();
  }

  describe(text) {
    try {
      post({type: 'description', description: parseDescription(text)});
    } catch (error) {
      damaged(error.message);
    }
  }

  receive(message) {
    counts.bytes += message.length;
    ++counts.frames;
    let header;
    try {
      header = readHeader(message);
    } catch (error) {
      damaged(error.message);  // its number is not known: it is answered with the next one
      return;
    }
    this.unanswered.push(header.number);
    const entry = {message, received: now(), index: this.next++};
    this.ring.push(entry);
    this.ringBytes += message.length;
    while (this.ring.length > 1 && this.ringBytes > RING_BYTES && (this.playing || this.ring[0].index < this.shown))
      this.ringBytes -= this.ring.shift().message.length;
    if (this.playing || this.stepping) {
      this.shown = entry.index;
      show(entry);
      if (this.stepping) {
        this.stepping = false;
        this.settle();
      }
    } else {
      post({type: 'place', place: this.place(this.at(this.shown) ?? entry)});
    }
    this.answer();
  }

  /** A frame is answered at once, except while nobody looks: then nothing more is to come. */
  answer() {
    if (this.idle) return;
    for (const frame of this.unanswered.splice(0))
      if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify({type: 'got', frame}));
  }

  want(want) {
    this.wanted = want;
    this.sendWant();
  }
  sendWant() {
    if (this.wanted && this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify({type: 'want', ...this.wanted}));
  }

  at(index) { return this.ring[index - this.ring[0]?.index]; }
  place(entry) {
    const first = this.ring[0];
    const newest = this.ring[this.ring.length - 1];
    const index = Math.max(0, entry.index - first.index);  // it may not be kept any more
    return {live: true, index, count: this.ring.length, playing: this.playing,
            seconds: (newest.received - entry.received) / 1000, kept: (newest.received - first.received) / 1000};
  }

  play(playing) {
    this.playing = playing;
    this.stepping = false;
    if (playing) {
      const newest = this.ring[this.ring.length - 1];
      if (newest && newest.index !== this.shown) this.showEntry(newest);
    }
    this.settle();
    this.tellPlace();
  }
  step(by) {
    if (this.playing) this.play(false);
    if (this.ring.length === 0) return;
    const last = this.ring[this.ring.length - 1].index;
    if (by > 0 && this.shown >= last) {  // one more from the server
      this.stepping = true;
      this.settle();
      return;
    }
    this.seek(this.shown + by - this.ring[0].index);
  }
  seek(place) {
    if (this.playing) this.play(false);
    if (this.ring.length === 0) return;
    this.showEntry(this.ring[Math.max(0, Math.min(this.ring.length - 1, Math.round(place)))]);
  }
  showEntry(entry) {
    this.shown = entry.index;
    giveUpDecoded();
    show(entry);
  }
  tellPlace() {
    const entry = this.at(this.shown);
    if (entry) post({type: 'place', place: this.place(entry)});
  }
  hide(hidden) {
    this.hidden = hidden;
    this.settle();
  }
  speed() {}
  afterShown() {}
}

/** Frames of a file, at the pace at which they were taken. */
class Playing {
  constructor(file, name) {
    this.file = file;
    this.name = name;
    this.shown = -1;
    this.asked = 0;   // the one that is to be shown next, or is shown
    this.playing = true;
    this.hidden = false;
    this.factor = 1;
    this.timer = 0;
    this.closed = false;
    this.description = -1;
    this.request = 0;
    post({type: 'state', state: 'file', detail: name, cutOff: file.cutOff});
    this.load(0);
  }

  async load(index) {
    clearTimeout(this.timer);
    const request = ++this.request;
    this.asked = index;
    let message;
    try {
      message = await this.file.read(index);
    } catch (error) {
      if (!this.closed) post({type: 'state', state: 'failed', detail: `${this.name}: ${error.message}`});
      return;
    }
    if (this.closed || request !== this.request) return;
    const {description} = this.file.frames[index];
    if (description !== this.description) {
      this.description = description;
      post({type: 'description', description: this.file.descriptions[description]});
    }
    this.shown = index;
    this.due = performance.now();
    counts.bytes += message.length;
    ++counts.frames;
    show({message, received: now(), index});
    this.plan();
  }

  /** The next frame, as long after this one as it was taken after it. */
  plan() {
    clearTimeout(this.timer);
    if (!this.playing || this.hidden || this.file.frames.length < 2) return;
    const next = (this.shown + 1) % this.file.frames.length;
    let pause = this.file.frames[next].time - this.file.frames[this.shown].time;
    if (!(pause > 0)) pause = 100;  // from the last to the first; and where times are not known
    pause = Math.min(2000, Math.max(1, pause)) / this.factor;
    this.timer = setTimeout(() => {
      if (caughtUp()) this.load(next);
      else this.late = true;  // the page is behind: when it has caught up
    }, Math.max(0, this.due + pause - performance.now()));
  }
  afterShown() {
    if (!this.late || !caughtUp()) return;
    this.late = false;
    if (this.playing) this.load((this.shown + 1) % this.file.frames.length);
  }

  place(entry) {
    const frames = this.file.frames;
    return {live: false, index: entry.index, count: frames.length, playing: this.playing, speed: this.factor,
            seconds: (frames[entry.index].time - frames[0].time) / 1000, kept: (frames[frames.length - 1].time - frames[0].time) / 1000};
  }
  play(playing) {
    this.playing = playing;
    this.late = false;
    this.plan();
    if (this.shown >= 0) post({type: 'place', place: this.place({index: this.shown})});
  }
  step(by) {
    this.play(false);
    const count = this.file.frames.length;
    giveUpDecoded();
    this.load((((this.asked + by) % count) + count) % count);
  }
  seek(index) {
    this.play(false);
    giveUpDecoded();
    this.load(Math.max(0, Math.min(this.file.frames.length - 1, Math.round(index))));
  }
  speed(factor) {
    this.factor = factor;
    this.play(this.playing);
  }
  hide(hidden) {
    this.hidden = hidden;
    this.plan();
  }
  want() {}
  close() {
    this.closed = true;
    clearTimeout(this.timer);
  }
}

function use(next) {
  source?.close();
  source = next;
}

async function open(get, name) {
  post({type: 'state', state: 'opening', detail: name});
  try {
    const file = await StreamFile.open(await get());
    pending = null;
    use(null);
    use(new Playing(file, name));
  } catch (error) {
    post({type: 'state', state: 'failed', detail: `${name}: ${error.message}`, source: source !== null});
  }
}

const handlers = {
  connect: ({url}) => use(new Live(url)),
  open: ({file, name}) => open(async () => file, name),
  fetch: ({url, name}) =>
    open(async () => {
      const response = await fetch(url);
      if (!response.ok) throw new Error(`the server answers ${response.status}`);
      return response.blob();
    }, name),
  want: ({want}) => source?.want(want),
  play: ({playing}) => source?.play(playing),
  step: ({by}) => source?.step(by),
  seek: ({to}) => source?.seek(to),
  speed: ({factor}) => source?.speed(factor),
  hide: ({hidden}) => source?.hide(hidden),
  drawn: ({buffers}) => {
    for (const buffer of buffers) if (buffer.byteLength > 0) pool.push(buffer);
    while (pool.length > MOST_POOLED) pool.shift();
    waiting = false;
    deliver();
  },
};
const early = [];  // what the page asks before the decoder is there
self.onmessage = (event) => (decoder ? handlers[event.data.type]?.(event.data) : early.push(event.data));

setInterval(() => post({type: 'counts', ...counts, decoders: decoder?.size ?? 0}), 500);

try {
  decoder = await DecodeTeam.make(DECODERS);
  for (const message of early) handlers[message.type]?.(message);
} catch (error) {
  post({type: 'state', state: 'failed', detail: `This browser cannot decode: ${error.message}`});
}
