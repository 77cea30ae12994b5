// The page: what is pressed and dragged, and what is said. Drawing is drawing.js's, receiving and decoding decode_worker.js's.
//
// Of the address: ?token=… goes with the request for the stream; ?file=demo.ffs plays a file of the same server; ?up=-y says which way is up;
// ?view=2,-3,1.5,0,0,0.5,40 says where the viewer stands and what the viewer looks at, metres, and how many degrees the picture is high;
// ?renderer=webgpu draws by WebGPU where it is there; ?decoders=1 says how many workers decode.

import {FIELD} from './decoder.js';
import {Drawing, VIEWS_COLORS, viridis} from './drawing.js';

const $ = (id) => document.getElementById(id);
const parameters = new URLSearchParams(location.search);
const now = () => performance.timeOrigin + performance.now();  // milliseconds since 1970
const number = new Intl.NumberFormat('en');
// Then the clocks of the server and of the browser are one.
const same_host = ['localhost', '127.0.0.1', '[::1]'].includes(location.hostname);

let note_timer = 0;
function say(text, seconds = 3) {
  $('note').textContent = text;
  $('note').hidden = false;
  clearTimeout(note_timer);
  note_timer = setTimeout(() => ($('note').hidden = true), 1000 * seconds);
}
function setState(kind, text) {
  $('dot').className = `dot ${kind}`;
  $('state').textContent = text;
}

let drawing;
try {
  drawing = await Drawing.make($('canvas'), $('names'), parameters.get('renderer') === 'webgpu');
} catch (error) {
  setState('bad', 'This browser has no WebGL 2, which drawing needs.');
  throw error;
}
$('drawn-by').textContent = drawing.api;
if (parameters.get('renderer') === 'webgpu' && drawing.api !== 'WebGPU') say('This browser has no WebGPU here: WebGL 2 draws.', 6);

const canvas = $('canvas');
let worker;
let next = null;          // a frame that came and is not drawn yet
let frames = 0;           // drawn
let shown = null;         // {number, points, captured, …}: what is known of the one that is drawn
let description = null;
let fitted = false;       // the viewpoint has been set for a cloud
let place = null;         // of the frame that is shown, among those kept
let speed = 1;
let marks = [];
let marking = false;
let up_given = false;

// Which way is up.
{
  const match = /^([+-]?)([xyz])$/.exec(parameters.get('up') ?? '');
  if (match) {
    up_given = true;
    drawing.setUp(['x', 'y', 'z'].map((axis) => (axis === match[2] ? (match[1] === '-' ? -1 : 1) : 0)));
  } else if (parameters.has('up')) {
    say('up is one of x, y, z, -x, -y, -z');
  }
}

// Where the first picture is seen from. null: from where everything can be seen.
let view = null;
if (parameters.has('view')) {
  const texts = parameters.get('view').split(',');
  const numbers = texts.map((text) => (text.trim() === '' ? NaN : Number(text)));
  const [from, at, fov = 45] = [numbers.slice(0, 3), numbers.slice(3, 6), numbers[6]];
  if ((numbers.length === 6 || numbers.length === 7) && numbers.every(Number.isFinite) && fov >= 1 && fov <= 150 && from.some((value, k) => value !== at[k]))
    view = {from, at, fov};
  else
    say('view is six numbers: where you stand and what you look at, metres; and, as a seventh, the angle, 1 to 150 degrees', 8);
}
function linkToView() {
  const {position, fov} = drawing.camera;
  const place = [...position.toArray(), ...drawing.controls.target.toArray()].map((value) => Number(value.toFixed(4)));
  const address = new URL(location.href);
  address.searchParams.set('view', [...place, Number(fov.toFixed(2))].join());
  const up = drawing.up.toArray();
  const axis = up.findIndex((value) => value !== 0);  // it is one of the world's, see above and guessUp()
  address.searchParams.set('up', (up[axis] < 0 ? '-' : '') + 'xyz'[axis]);
  address.search = address.search.replaceAll('%2C', ',');
  history.replaceState(null, '', address);
  say('The address is a link to this view now.');
}
drawing.onLost = () => {  // the same view by WebGL 2, which is more often there
  if (fitted) linkToView();
  const address = new URL(location.href);
  address.searchParams.set('renderer', 'webgl');
  location.replace(address);
};

// ---- the stream

function startWorker() {
  const address = new URL('./decode_worker.js', import.meta.url);
  if (parameters.has('decoders')) address.searchParams.set('decoders', parameters.get('decoders'));
  worker = new Worker(address, {type: 'module'});
  worker.onmessage = ({data}) => from_worker[data.type](data);
  worker.onerror = (event) => setState('bad', `The decoder does not start: ${event.message ?? 'this browser has no module workers'}`);
  worker.postMessage({type: 'hide', hidden: document.hidden});
}

let connected = false;
function showLive() { setState(place?.playing === false ? '' : 'good', place?.playing === false ? 'Paused' : 'Live'); }

const from_worker = {
  state({state, detail, opened, code, again, cutOff, source}) {
    connected = state === 'connected';
    if (state === 'connecting') setState('wait', 'Connecting …');
    else if (state === 'connected') showLive();
    else if (state === 'resting') setState('', 'Paused. Nothing is received meanwhile.');
    else if (state === 'opening') setState('wait', `Opening ${detail} …`);
    else if (state === 'file') {
      setState('good', `File ${detail}.${cutOff ? ' It was cut off at its end.' : ''}${wanted_file ? '' : ' Load the page again to see the stream.'}`);
      startAnew();
    } else if (state === 'failed') {
      if (source) say(detail, 6);  // what played goes on
      setState('bad', detail);
    } else if (state === 'disconnected') {
      const reason = detail ? `The server says: ${detail}.` : code === 1008 ? 'The server refuses.' : opened ? 'The connection ended.' :
        parameters.has('token') ? 'No connection: the server does not run, or the token is wrong.' :
                                  'No connection: the server does not run, or it asks for a token.';
      setState('bad', `${reason} Next try in ${Math.max(1, Math.round(again / 1000))} s.`);
    }
  },
  description({description: given}) {
    const cameras_differ = JSON.stringify(given.cameras) !== JSON.stringify(description?.cameras);
    description = given;
    $('title').textContent = given.name || 'FUSE-Flow';
    document.title = given.name ? `${given.name} – FUSE-Flow` : 'FUSE-Flow';
    if (!cameras_differ) return;
    if (!up_given && !fitted) guessUp(given.cameras);
    drawing.setCameras(given.cameras);
  },
  frame(message) {
    if (next) free(next.frame);  // cannot be, as the worker waits; but memory must not get lost
    next = message;
    place = message.place;  // not when it is drawn: what the worker says of it meanwhile is newer
    showPlace();
  },
  place({place: given}) {
    const changed = given.live && given.playing !== place?.playing;
    place = given;
    showPlace();
    if (changed && connected) showLive();
  },
  damaged({count, reason}) {
    $('t-lost').hidden = $('n-lost').hidden = false;
    $('n-lost').textContent = `${number.format(count)} frame${count === 1 ? '' : 's'}`;
    say(`A frame was damaged: ${reason}`);
    if (next === null && shown === null) setState('bad', `A frame was damaged: ${reason}`);
  },
  counts(counts) {
    const time = performance.now();
    network.push({time, bytes: counts.bytes, frames: counts.frames});
    while (network.length > 2 && time - network[0].time > 2500) network.shift();
    dropped = counts.dropped;
    decoders = counts.decoders;
  },
};
const network = [];
let dropped = 0;
let decoders = 0;  // workers that decode

/** Where cameras agree that another axis than z is up, that one. Images have their y downwards. */
function guessUp(cameras) {
  if (cameras.length === 0) return;
  const up = [1, 5, 9].map((k) => cameras.reduce((sum, camera) => sum - camera.T_world_camera[k], 0) / cameras.length);
  const axis = up.findIndex((value) => Math.abs(value) > 0.8);
  if (axis >= 0) drawing.setUp(up.map((value, k) => (k === axis ? Math.sign(value) : 0)));
}

function startAnew() {
  fitted = false;
  drawing.heights = null;
  marks = [];
  drawing.setMarks([]);
}

function free(frame) {
  const buffers = [frame.positions, frame.colors, frame.normals, frame.masks].filter((array) => array).map((array) => array.buffer);
  worker.postMessage({type: 'drawn', buffers}, buffers);
}

function sendWant() {
  const want = {};
  if ($('most-points').value) {
    want.points = Number($('most-points').value);
    want.viewpoint = drawing.camera.position.toArray();
  }
  if ($('most-bytes').value) want.bytes_per_second = Number($('most-bytes').value);
  if (drawing.box) want.region = {min: drawing.box.least, max: drawing.box.greatest};
  const text = JSON.stringify(want);
  if (text === last_want) return;
  last_want = text;
  worker.postMessage({type: 'want', want});
}
let last_want = '{}';
let want_timer = 0;
/** Not for each step of a drag. */
function sendWantSoon() {
  if (want_timer) return;
  want_timer = setTimeout(() => {
    want_timer = 0;
    sendWant();
  }, 300);
}
drawing.onViewChanged = () => { if ($('most-points').value) sendWantSoon(); };

// ---- drawing

const pictures = [];
function loop() {
  if (next) {
    const message = next;
    next = null;
    const before = drawing.setFrame(message.frame);
    shown = message;
    ++frames;
    if (before) free(before);
    else worker.postMessage({type: 'drawn', buffers: []});
    if (!fitted) {
      fitted = drawing.startView(message.frame);
      if (fitted && view) drawing.setView(view);
      if (fitted) view = null;  // a file that is dropped later shows something else
    }
    showFields(message.frame.fields);
    const drawn = drawing.draw();
    message.drawn = now();
    delays.push({captured: message.frame.captured ? message.drawn - message.frame.captured : NaN,
                 encoded: message.frame.encoded ? message.drawn - message.frame.encoded : NaN,
                 received: message.drawn - message.received, decoding: message.decoding, time: performance.now()});
    while (delays.length > 30) delays.shift();
    if (drawn) pictures.push(performance.now());
  } else if (drawing.draw()) {
    pictures.push(performance.now());
  }
}
const delays = [];

function median(values) {
  const sorted = values.filter(Number.isFinite).sort((a, b) => a - b);
  return sorted.length ? sorted[sorted.length >> 1] : NaN;
}

function showNumbers() {
  const time = performance.now();
  while (pictures.length && time - pictures[0] > 2000) pictures.shift();
  $('numbers').hidden = !shown;
  if (!shown) return;
  const {points, pointsOfFrame} = shown.frame;
  $('n-points').textContent = points === pointsOfFrame ? number.format(points) : `${number.format(points)} of ${number.format(pointsOfFrame)}`;
  const first = network[0], last = network[network.length - 1];
  const seconds = first && last.time > first.time ? (last.time - first.time) / 1000 : NaN;
  const arriving = seconds ? (last.frames - first.frames) / seconds : 0;
  $('n-frames').textContent = `${arriving.toFixed(1)} /s, drawn ${(pictures.length / 2).toFixed(0)} /s`;
  $('n-network').textContent = place?.live === false ? `${(shown.bytes / 1e6).toFixed(2)} MB a frame` :
    `${seconds ? ((8 * (last.bytes - first.bytes)) / 1e6 / seconds).toFixed(1) : '–'} Mbit/s`;
  $('n-decoding').textContent = `${median(delays.map((delay) => delay.decoding)).toFixed(0)} ms`;
  const recent = delays.filter((delay) => time - delay.time < 3000);
  const captured = median(recent.map((delay) => delay.captured)), encoded = median(recent.map((delay) => delay.encoded));
  const text = (value) => `${Math.round(value)} ms`;
  // With clocks of two computers, what makes no sense is not shown, and what may be wrong by their difference is marked.
  const plausible = (value) => value > 0 && value < 60000;
  const about = same_host ? '' : '≈ ';
  if (place?.live === false || !place?.playing) $('n-delay').textContent = '–';
  else if (plausible(captured)) $('n-delay').textContent = `${about}${text(captured)} (${text(encoded)} after encoding)`;
  else if (plausible(encoded)) $('n-delay').textContent = `${about}${text(encoded)} after encoding`;
  else $('n-delay').textContent = recent.length ? `${text(median(recent.map((delay) => delay.received)))} after arrival` : '–';
}
setInterval(showNumbers, 500);

function showPlace() {
  if (!place) return;
  const timeline = $('timeline');
  timeline.disabled = place.count < 2;
  timeline.max = Math.max(0, place.count - 1);
  timeline.value = place.index;
  $('play').querySelector('use').setAttribute('href', place.playing ? '#i-pause' : '#i-play');
  $('play').title = place.playing ? 'Pause (space)' : 'Play (space)';
  const seconds = place.seconds.toFixed(1);
  if (place.live) $('time').textContent = place.playing ? 'live' : `−${seconds} s`;
  else $('time').textContent = `${place.index + 1} of ${place.count}${place.speed === 1 ? '' : `, ${place.speed} ×`}`;
}

/** Colours that the frames have no field for cannot be chosen. */
function showFields(fields) {
  if (fields === showFields.last) return;
  showFields.last = fields;
  const needs = {rgb: FIELD.color, confidence: FIELD.confidence, views: FIELD.viewCount, normal: FIELD.normal, height: 0};
  for (const input of document.querySelectorAll('[name=color]')) {
    const missing = (fields & needs[input.value]) !== needs[input.value];
    input.disabled = missing;
    input.parentElement.classList.toggle('missing', missing);
    if (missing && input.checked) colorBy('height');
  }
}

// ---- what can be set

function colorBy(what) {
  const input = document.querySelector(`[name=color][value=${what}]`);
  if (input.disabled) {
    say(`These frames have no ${{rgb: 'colours', confidence: 'confidence', views: 'number of views', normal: 'normals'}[what]}.`);
    return;
  }
  input.checked = true;
  drawing.setLook({colorBy: what});
  showLegend();
}
let legend = true;
function showLegend() {
  const what = drawing.look.colorBy;
  const box = $('legend');
  box.replaceChildren();
  box.hidden = !legend || what === 'rgb';
  if (box.hidden) return;
  const title = document.createElement('h2');
  title.textContent = {confidence: 'Confidence', views: 'Cameras that saw the point', height: 'Height', normal: 'Normal: x red, y green, z blue'}[what];
  box.append(title);
  const color = ([r, g, b]) => `rgb(${r} ${g} ${b})`;
  if (what === 'views') {
    const list = document.createElement('ul');
    for (let views = 1; views < VIEWS_COLORS.length; ++views) {
      const item = document.createElement('li');
      const mark = document.createElement('i');
      mark.style.background = color(VIEWS_COLORS[views]);
      item.append(mark, views < 4 ? String(views) : '4 or more');
      list.append(item);
    }
    box.append(list);
  } else if (what !== 'normal') {
    const scale = document.createElement('canvas');
    scale.width = 180;
    scale.height = 1;
    const context = scale.getContext('2d');
    for (let x = 0; x < 180; ++x) {
      context.fillStyle = color(viridis(x / 179));
      context.fillRect(x, 0, 1, 1);
    }
    const ends = document.createElement('div');
    ends.className = 'ends';
    const {low = 0, high = 1} = drawing.heights ?? {};
    for (const text of what === 'height' ? [`${low.toFixed(2)} m`, `${high.toFixed(2)} m`] : ['0', '1']) {
      const end = document.createElement('span');
      end.textContent = text;
      ends.append(end);
    }
    box.append(scale, ends);
  }
}

function setSize(size) {
  size = Math.min(12, Math.max(1, size));
  $('size').value = size;
  $('size-text').textContent = size;
  drawing.setLook({size});
}
function toggle(id, key) {
  const input = $(id);
  input.checked = !input.checked;
  drawing.setLook({[key]: input.checked});
}
function toggleSettings() {
  $('settings').hidden = !$('settings').hidden;
  $('open-settings').setAttribute('aria-pressed', String(!$('settings').hidden));
}
function toggleHelp() {
  if ($('help').open) $('help').close();
  else $('help').showModal();
}
function setMarking(on) {
  marking = on;
  canvas.classList.toggle('marking', on);
  $('measure').setAttribute('aria-pressed', String(on));
  if (on) say('Click on two points to measure their distance. Esc ends it.', 5);
}
function mark(x, y) {
  const hit = drawing.pick(x, y);
  if (!hit) {
    say('There is no point here.');
    return;
  }
  if (marks.length >= 2) marks = [];
  marks.push(hit.position);
  const coordinates = ['x', 'y', 'z'].map((axis) => `${axis} ${hit.position[axis].toFixed(3)}`).join(', ');
  const more = [hit.confidence === null ? '' : `confidence ${hit.confidence.toFixed(2)}`,
                hit.views === null ? '' : `${hit.views} camera${hit.views === 1 ? '' : 's'}`].filter((text) => text).join(', ');
  if (marks.length === 2) {
    const text = `${(1000 * marks[0].distanceTo(marks[1])).toFixed(1)} mm`;
    drawing.setMarks(marks, text);
    say(`Distance ${text}`, 6);
  } else {
    drawing.setMarks(marks, '');
    say(`${coordinates} m${more ? `; ${more}` : ''}`, 6);
  }
}
function forgetMarks() {
  marks = [];
  drawing.setMarks([]);
  setMarking(false);
}
function home() {
  if (drawing.box) drawing.lookAtBox();
  else if (shown) drawing.startView(shown.frame);
}
function toggleCrop() {
  if (drawing.box) {
    drawing.setBox(null);
  } else if (shown) {
    // At first around what is in the middle of the view, so that its handles can be seen; without the farthest points.
    const all = drawing.sample(shown.frame, 20000);
    const seen = all.filter((point) => drawing.inView(point, 0.7));
    const points = seen.length > 100 ? seen : all;
    if (points.length === 0) return;
    const ends = ['x', 'y', 'z'].map((axis) => {
      const sorted = points.map((point) => point[axis]).sort((a, b) => a - b);
      const at = (share) => sorted[Math.round(share * (sorted.length - 1))];
      const pad = 0.02 * (at(0.95) - at(0.05)) + 0.01;
      return [at(0.05) - pad, at(0.95) + pad];
    });
    drawing.setBox({least: ends.map((end) => end[0]), greatest: ends.map((end) => end[1])});
    say('Drag the balls on the sides of the box. Points outside are hidden.', 5);
  }
  $('crop').setAttribute('aria-pressed', String(drawing.box !== null));
  sendWantSoon();
}
function play(playing) { worker.postMessage({type: 'play', playing}); }
function togglePlay() { play(!(place?.playing ?? true)); }
function step(by) { worker.postMessage({type: 'step', by}); }
function seek(to) { worker.postMessage({type: 'seek', to}); }
function changeSpeed(factor) {
  if (place?.live !== false) {
    say('The speed can be changed only for files.');
    return;
  }
  speed = Math.min(16, Math.max(1 / 16, speed * factor));
  worker.postMessage({type: 'speed', factor: speed});
}
async function fullScreen() {
  try {
    if (document.fullscreenElement) await document.exitFullscreen();
    else await document.documentElement.requestFullscreen();
  } catch {
    say('This browser does not allow full screen here.');
  }
}

// ---- keys: those of fuse_flow_viewer, as far as both do the same

const KEYS = [
  ['Play', 'Space', 'play, pause', [' '], togglePlay],
  ['Play', '→  ←', 'one frame on, back', ['ArrowRight'], () => step(1)],
  ['Play', '', '', ['ArrowLeft'], () => step(-1)],
  ['Play', 'PgDn  PgUp', 'ten frames on, back', ['PageDown'], () => step(10)],
  ['Play', '', '', ['PageUp'], () => step(-10)],
  ['Play', 'Home  End', 'first, last frame', ['Home'], () => seek(0)],
  ['Play', '', '', ['End'], () => seek(Infinity)],
  ['Play', ']  [', 'twice, half as fast (files)', [']'], () => changeSpeed(2)],
  ['Play', '', '', ['['], () => changeSpeed(0.5)],
  ['Colour by', '4', 'rgb: what the cameras saw', ['4'], () => colorBy('rgb')],
  ['Colour by', '5', 'confidence', ['5'], () => colorBy('confidence')],
  ['Colour by', '6', 'number of views', ['6'], () => colorBy('views')],
  ['Colour by', '7', 'height', ['7'], () => colorBy('height')],
  ['Colour by', '9', 'normal', ['9'], () => colorBy('normal')],
  ['Colour by', 'u', 'legend', ['u'], () => { legend = !legend; showLegend(); }],
  ['View', 'r', 'show everything', ['r'], home],
  ['View', 'f', 'fly to the point under the cursor', ['f'], () => {
    const hit = drawing.pick(cursor.x, cursor.y);
    if (hit) drawing.flyTo(hit.position);
    else say('There is no point here.');
  }],
  ['View', 'v', 'put this view into the address: a link to it', ['v'], linkToView],
  ['View', '+  −', 'larger, smaller points', ['+', '='], () => setSize(drawing.look.size + 0.5)],
  ['View', '', '', ['-'], () => setSize(drawing.look.size - 0.5)],
  ['View', 'd', 'nearer points larger', ['d'], () => toggle('by-distance', 'byDistance')],
  ['View', 'Shift and arrows', 'turn', ['Shift ArrowRight'], () => drawing.turn(0.1, 0)],
  ['View', '', '', ['Shift ArrowLeft'], () => drawing.turn(-0.1, 0)],
  ['View', '', '', ['Shift ArrowUp'], () => drawing.turn(0, 0.1)],
  ['View', '', '', ['Shift ArrowDown'], () => drawing.turn(0, -0.1)],
  ['View', 'Ctrl and arrows', 'move', ['Ctrl ArrowRight'], () => drawing.move(0.05, 0)],
  ['View', '', '', ['Ctrl ArrowLeft'], () => drawing.move(-0.05, 0)],
  ['View', '', '', ['Ctrl ArrowUp'], () => drawing.move(0, 0.05)],
  ['View', '', '', ['Ctrl ArrowDown'], () => drawing.move(0, -0.05)],
  ['View', '↑  ↓', 'zoom in, out', ['ArrowUp', 'Alt +', 'Alt ='], () => drawing.nearer(1.1)],
  ['View', '', '', ['ArrowDown', 'Alt -'], () => drawing.nearer(1 / 1.1)],
  ['View', 'Alt f', 'full screen, and back', ['Alt f'], fullScreen],
  ['View', 'y', 'cameras and their names', ['y'], () => toggle('cameras', 'cameras')],
  ['View', 'g', 'grid of metres', ['g'], () => toggle('grid', 'grid')],
  ['View', 'a', 'axes of the world', ['a'], () => toggle('axes', 'axes')],
  ['View', 'n', 'background: night, day', ['n'], () => toggle('day', 'day')],
  ['View', 't', 'text', ['t'], () => ($('text').hidden = !$('text').hidden)],
  ['View', 'k', 'settings', ['k'], toggleSettings],
  ['Measure', 'm', 'mark the point under the cursor; two: their distance', ['m'], () => mark(cursor.x, cursor.y)],
  ['Measure', 'b', 'crop box with handles', ['b'], toggleCrop],
  ['Measure', 'Esc', 'forget the marks', ['Escape'], forgetMarks],
  ['Program', 'h', 'this help', ['h', '?'], toggleHelp],
  ['Mouse', 'left', 'turn; on a handle of the box: drag'],
  ['Mouse', 'right, or Ctrl left', 'move'],
  ['Mouse', 'wheel', 'zoom'],
  ['Mouse', 'Shift left', 'mark a point'],
  ['Touch', 'one finger', 'turn'],
  ['Touch', 'two fingers', 'move, zoom'],
];
const actions = new Map();
{
  const sections = new Map();
  for (const [group, label, text, keys, action] of KEYS) {
    for (const key of keys ?? []) actions.set(key, action);
    if (!label) continue;
    if (!sections.has(group)) {
      const section = document.createElement('section');
      const title = document.createElement('h3');
      title.textContent = group;
      section.append(title);
      sections.set(group, section);
    }
    const row = document.createElement('div');
    const what = document.createElement('span');
    what.textContent = text;
    const key = document.createElement('kbd');
    key.textContent = label;
    row.append(what, key);
    sections.get(group).append(row);
  }
  $('keys').append(...sections.values());
}

const cursor = {x: innerWidth / 2, y: innerHeight / 2};
addEventListener('keydown', (event) => {
  if (event.metaKey) return;
  const target = event.target;
  // A slider or a list has keys of its own.
  if (target instanceof HTMLSelectElement || (target instanceof HTMLInputElement && /^(Arrow|Page|Home|End)/.test(event.key))) return;
  if ((target instanceof HTMLButtonElement || target instanceof HTMLInputElement) && (event.key === ' ' || event.key === 'Enter')) return;
  if ($('help').open && event.key !== 'h' && event.key !== '?') return;  // Esc closes it by itself
  // With Alt, some keyboards type another character.
  const plain = event.altKey && {KeyF: 'f', Equal: '=', Minus: '-', NumpadAdd: '+', NumpadSubtract: '-'}[event.code];
  let key = plain || event.key;
  if (event.altKey) key = `Alt ${key}`;
  else if (event.ctrlKey) key = `Ctrl ${key}`;
  else if (event.shiftKey && event.key.startsWith('Arrow')) key = `Shift ${key}`;
  const action = actions.get(key) ?? (event.ctrlKey || event.altKey ? undefined : actions.get(key.toLowerCase()));
  if (!action) return;
  event.preventDefault();
  action();
});

// ---- mouse and touch

let dragged = null;
let pressed = null;
const local = (event) => {
  const box = canvas.getBoundingClientRect();
  return {x: event.clientX - box.left, y: event.clientY - box.top};
};
// Before the controls see it: a handle of the box is not the view.
canvas.addEventListener('pointerdown', (event) => {
  const at = local(event);
  pressed = event.isPrimary && event.button === 0 ? {...at, shift: event.shiftKey} : null;
  dragged = event.button === 0 ? drawing.handleAt(at.x, at.y) : null;
  if (dragged) dragged = dragged.userData;
  if (dragged || (event.shiftKey && event.button === 0)) {
    event.stopImmediatePropagation();
    if (dragged) canvas.setPointerCapture(event.pointerId);
  }
}, {capture: true});
addEventListener('pointermove', (event) => Object.assign(cursor, local(event)));
canvas.addEventListener('pointermove', (event) => {
  const at = local(event);
  if (dragged) {
    event.stopImmediatePropagation();
    drawing.dragHandle({userData: dragged}, at.x, at.y);
    sendWantSoon();
  } else {
    canvas.classList.toggle('handle', event.buttons === 0 && drawing.handleAt(at.x, at.y) !== null);
  }
}, {capture: true});
canvas.addEventListener('pointerup', (event) => {
  const at = local(event);
  const click = pressed && Math.hypot(at.x - pressed.x, at.y - pressed.y) < 4;
  if (dragged) event.stopImmediatePropagation();
  else if (click && (marking || pressed.shift)) mark(at.x, at.y);
  dragged = pressed = null;
}, {capture: true});
canvas.addEventListener('pointercancel', () => (dragged = pressed = null), {capture: true});

// What was clicked on does not keep the keys: after a click on a button, space is to play, not to press it again.
addEventListener('click', (event) => { if (event.detail > 0) document.activeElement?.blur(); });
addEventListener('change', (event) => { if (!(event.target.type === 'radio')) event.target.blur(); });
$('back').onclick = () => step(-1);
$('on').onclick = () => step(1);
$('play').onclick = togglePlay;
$('timeline').oninput = (event) => seek(Number(event.target.value));
$('home').onclick = home;
$('measure').onclick = () => (marking ? forgetMarks() : setMarking(true));
$('crop').onclick = toggleCrop;
$('full').onclick = fullScreen;
$('open-settings').onclick = toggleSettings;
$('open-help').onclick = $('close-help').onclick = toggleHelp;
$('settings').onsubmit = (event) => event.preventDefault();
$('colors').onchange = (event) => colorBy(event.target.value);
$('size').oninput = (event) => setSize(Number(event.target.value));
$('by-distance').onchange = (event) => drawing.setLook({byDistance: event.target.checked});
for (const key of ['cameras', 'grid', 'axes', 'day']) $(key).onchange = (event) => drawing.setLook({[key]: event.target.checked});
$('most-points').onchange = $('most-bytes').onchange = sendWant;
$('full').hidden = !document.fullscreenEnabled;

// ---- files

function openFile(file) { worker.postMessage({type: 'open', file, name: file.name}); }
addEventListener('dragover', (event) => {
  event.preventDefault();
  $('drop').hidden = false;
});
addEventListener('dragleave', (event) => { if (event.relatedTarget === null) $('drop').hidden = true; });
addEventListener('drop', (event) => {
  event.preventDefault();
  $('drop').hidden = true;
  const file = event.dataTransfer.files[0];
  if (file) openFile(file);
});

// ---- virtual reality, where the browser has it

if (drawing.api === 'WebGL 2') navigator.xr?.isSessionSupported('immersive-vr').then((supported) => {
  $('vr').hidden = !supported;
  $('vr').onclick = async () => {
    try {
      await drawing.present(await navigator.xr.requestSession('immersive-vr', {optionalFeatures: ['local-floor']}));
    } catch (error) {
      say(`Virtual reality does not start: ${error.message}`);
    }
  };
}).catch(() => {});

// ---- begin

function resize() { drawing.resize(canvas.clientWidth, canvas.clientHeight, Math.min(2, devicePixelRatio)); }
new ResizeObserver(resize).observe(canvas);
resize();
startWorker();
document.addEventListener('visibilitychange', () => worker.postMessage({type: 'hide', hidden: document.hidden}));

const wanted_file = parameters.get('file');
if (wanted_file) {
  const url = new URL(wanted_file, location.href);
  if (url.origin === location.origin) worker.postMessage({type: 'fetch', url: url.href, name: wanted_file});
  else setState('bad', 'A file can be opened only from the server of this page.');
} else {
  const url = new URL('stream', location.href);
  url.protocol = location.protocol === 'https:' ? 'wss:' : 'ws:';
  if (parameters.has('token')) url.searchParams.set('token', parameters.get('token'));
  worker.postMessage({type: 'connect', url: url.href});
}
drawing.renderer.setAnimationLoop(loop);

// For tests, and for people at the console.
globalThis.fuse_flow = {
  drawing,
  openFile,
  get shown() { return shown; },
  get place() { return place; },
  get frames() { return frames; },
  get decoders() { return decoders; },
  get idle() { return next === null; },
};
