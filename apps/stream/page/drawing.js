// What three.js draws: the cloud, the cameras, a grid, axes, the crop box, marks. World coordinates are doubles until they are relative to
// the eye, so that clouds far from the world's origin do not tremble.

import * as THREE from 'three';
import {OrbitControls} from './OrbitControls.js';
import {FIELD} from './decoder.js';

export const COLOR_BY = Object.freeze({rgb: 0, confidence: 1, views: 2, height: 3, normal: 4});
const NIGHT = 0x14171c;  // that of fuse_flow_viewer
const DAY = 0xededed;
const FRUSTUM_DEPTH = 0.25;  // metres

// PCL's Glasbey colours, as fuse_flow_viewer has them, and Viridis.
const CAMERA_COLORS = ('377eb8 984ea3 ff7f00 ffff33 a65628 f781bf 999999 0000ff ff00ff 00fff8 00ff00 0065ff ffffb4 344401 000044 600029 ' +
  '9e9300 7400b9 ff0072 00957d d1baff ffb79c f000ae d0fff5').split(' ');
const VIRIDIS = ('440154 48186a 472c7b 424086 3a528b 33638d 2c728e 26828e 20918c 1e9f88 27ae81 3dbc74 5cc963 81d44c abdc32 d5e21a fee724')
  .split(' ').map((hex) => [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16)));
export const cameraColor = (number) => `#${CAMERA_COLORS[number % CAMERA_COLORS.length]}`;
export function viridis(share) {
  const at = Math.min(1, Math.max(0, share)) * (VIRIDIS.length - 1);
  const low = Math.min(VIRIDIS.length - 2, Math.floor(at));
  return VIRIDIS[low].map((value, k) => Math.round(value + (at - low) * (VIRIDIS[low + 1][k] - value)));
}
// One camera red, two yellow, three green, more blue: what only one camera saw should strike the eye.
export const VIEWS_COLORS = [[128, 128, 128], [214, 69, 65], [235, 190, 60], [64, 170, 105], [60, 120, 216]];

// x, y, z in steps, number of views; r, g, b, confidence; p, q of the normal. All from the graphics card's memory as they were decoded.
const VERTEX = `
precision highp float;
uniform mat4 modelViewMatrix, projectionMatrix;
uniform float pixels;       // size of a point: pixels, or ...
uniform float metres;       // ... metres, if above 0; ...
uniform float most;         // ... then at most so many pixels
uniform float focal;        // pixels of a metre at a distance of one metre
uniform int colorBy;
uniform sampler2D scale;
uniform vec3 up;            // height = dot(up, position), 0 to 1 after heightScale
uniform vec2 heightScale;
uniform bool clip;
uniform vec3 clipLeast, clipGreatest;
in vec4 position;
in vec4 color;
in vec2 normal;
out vec3 rgb;
flat out float size;

vec3 octahedral(vec2 pq) {
  vec2 n = (pq - 128.0) / 127.0;
  float z = 1.0 - abs(n.x) - abs(n.y);
  if (z < 0.0) n = (1.0 - abs(n.yx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
  return normalize(vec3(n, z));
}

void main() {
  vec4 eye = modelViewMatrix * vec4(position.xyz, 1.0);
  gl_Position = projectionMatrix * eye;
  if (clip && (any(lessThan(position.xyz, clipLeast)) || any(greaterThan(position.xyz, clipGreatest)))) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  size = metres > 0.0 ? max(pixels, metres * focal / max(-eye.z, 0.001)) : pixels;
  size = clamp(size, 1.0, max(pixels, most));
  gl_PointSize = size;
  if (colorBy == 0) rgb = color.rgb;
  else if (colorBy == 1) rgb = texture(scale, vec2(0.5 / 256.0 + color.a * 255.0 / 256.0, 0.5)).rgb;
  else if (colorBy == 2) {
    int views = int(position.w + 0.5);
    rgb = views == 1 ? vec3(214, 69, 65) : views == 2 ? vec3(235, 190, 60) : views == 3 ? vec3(64, 170, 105) :
          views > 3 ? vec3(60, 120, 216) : vec3(128);
    rgb /= 255.0;
  } else if (colorBy == 3) {
    float height = clamp(dot(up, position.xyz) * heightScale.x + heightScale.y, 0.0, 1.0);
    rgb = texture(scale, vec2(0.5 / 256.0 + height * 255.0 / 256.0, 0.5)).rgb;
  } else {
    rgb = normal == vec2(0.0) ? vec3(0.5) : 0.5 + 0.5 * octahedral(normal);
  }
}`;
const FRAGMENT = `
precision mediump float;
in vec3 rgb;
flat in highp float size;
out vec4 color;
void main() {
  if (size > 2.5) {  // round
    vec2 from_middle = gl_PointCoord - 0.5;
    if (dot(from_middle, from_middle) > 0.25) discard;
  }
  color = vec4(rgb, 1.0);
}`;

function scaleTexture() {
  const data = new Uint8Array(1024);
  for (let i = 0; i < 256; ++i) data.set([...viridis(i / 255), 255], 4 * i);
  const texture = new THREE.DataTexture(data, 256, 1);
  texture.magFilter = THREE.LinearFilter;
  texture.minFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

/** Points in buffers that are filled without a copy. */
class CloudObject {
  constructor(renderer, scale) {
    this.renderer = renderer;
    this.frame = null;
    this.material = new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3, vertexShader: VERTEX, fragmentShader: FRAGMENT,
      uniforms: {
        pixels: {value: 2}, metres: {value: 0}, most: {value: 64}, focal: {value: 1}, colorBy: {value: 0}, scale: {value: scale},
        up: {value: new THREE.Vector3(0, 0, 1)}, heightScale: {value: new THREE.Vector2(1, 0)},
        clip: {value: 0}, clipLeast: {value: new THREE.Vector3()}, clipGreatest: {value: new THREE.Vector3()},
      },
    });
    this.uniforms = this.material.uniforms;
    this.geometry = new THREE.BufferGeometry();
    this.geometry.boundingSphere = new THREE.Sphere(new THREE.Vector3(), Infinity);  // three.js cannot read the buffers
    this.object = new THREE.Points(this.geometry, this.material);
    this.object.frustumCulled = false;
    this.object.matrixAutoUpdate = false;
    this.object.visible = false;
    this.makeBuffers();
  }

  makeBuffers() {
    const gl = this.renderer.getContext();
    this.attributes = {};
    for (const [name, type, items, bytes, normalized] of [['position', gl.UNSIGNED_SHORT, 4, 2, false], ['color', gl.UNSIGNED_BYTE, 4, 1, true],
                                                          ['normal', gl.UNSIGNED_BYTE, 2, 1, false]]) {
      const attribute = new THREE.GLBufferAttribute(gl.createBuffer(), type, items, bytes, 0, normalized);
      this.attributes[name] = attribute;
      this.geometry.setAttribute(name, attribute);
    }
  }

  set(frame) {
    const gl = this.renderer.getContext();
    this.frame = frame;
    const {position, color, normal} = this.attributes;
    const fill = (attribute, array) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, attribute.buffer);
      gl.bufferData(gl.ARRAY_BUFFER, array, gl.STREAM_DRAW);  // new memory: what is being drawn keeps the old
      attribute.count = frame.points;
      attribute.needsUpdate = true;
    };
    const wide = frame.positions instanceof Float32Array;
    const type = wide ? gl.FLOAT : gl.UNSIGNED_SHORT;
    if (position.type !== type) {  // another one, as three.js looks at the type of an attribute only once
      const other = new THREE.GLBufferAttribute(gl.createBuffer(), type, 4, wide ? 4 : 2, 0, false);
      gl.deleteBuffer(position.buffer);
      this.attributes.position = other;
      this.geometry.setAttribute('position', other);
    }
    fill(this.attributes.position, frame.positions);
    fill(color, frame.colors);
    if (frame.normals) {
      fill(normal, frame.normals);
      this.geometry.setAttribute('normal', normal);
    } else {
      this.geometry.deleteAttribute('normal');
    }
    this.object.matrix.makeScale(frame.step, frame.step, frame.step).setPosition(...frame.origin);
    this.object.matrixWorldNeedsUpdate = true;
    this.object.visible = frame.points > 0;
  }
}

export class Drawing {
  /** `labels`: the element that names are put into. `webgpu`: draw by WebGPU where it is there. Throws where there is no WebGL 2 either. */
  static async make(canvas, labels, webgpu) {
    if (webgpu) {
      const {makeRenderer, WebGpuCloudObject} = await import('./drawing_webgpu.js');
      const renderer = await makeRenderer(canvas).catch(() => null);
      if (renderer) return new Drawing('WebGPU', canvas, labels, renderer, new WebGpuCloudObject(renderer, scaleTexture()));
    }
    // Without antialiasing: it takes a third of the time again, and points gain nothing by it.
    const renderer = new THREE.WebGLRenderer({canvas, antialias: false, powerPreference: 'high-performance'});
    return new Drawing('WebGL 2', canvas, labels, renderer, new CloudObject(renderer, scaleTexture()));
  }

  /** For make(). `api`: what draws. */
  constructor(api, canvas, labels, renderer, cloud) {
    this.api = api;
    this.canvas = canvas;
    this.labels = labels;
    this.renderer = renderer;
    this.scene = new THREE.Scene();
    this.world = new THREE.Group();  // turned in XR, where y is up
    this.scene.add(this.world);
    this.camera = new THREE.PerspectiveCamera(45, 1, 0.01, 1000);
    this.camera.coordinateSystem = renderer.coordinateSystem;  // which depths are in view
    this.cloud = cloud;
    this.world.add(this.cloud.object);
    this.cameras = new THREE.Group();
    this.world.add(this.cameras);
    this.marks = new THREE.Group();
    this.world.add(this.marks);
    this.names = [];      // {element, position}
    this.changed = true;  // something is to be drawn anew
    this.drawn = 0;       // pictures
    this.look = {size: 2, byDistance: true, colorBy: 'rgb', cameras: true, grid: false, axes: false, day: false};
    this.box = null;      // {least, greatest}: of the crop box, metres
    this.radius = 1;      // of the cloud, as far as it is known
    this.setUp([0, 0, 1]);
    this.setDay(false);
    canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
    canvas.addEventListener('webglcontextrestored', () => {
      this.cloud.makeBuffers();
      if (this.cloud.frame) this.cloud.set(this.cloud.frame);
      this.changed = true;
    });
    // A lost device of WebGPU does not come back, as a context of WebGL does, and its canvas takes no other.
    renderer.onDeviceLost = () => this.onLost?.();
  }

  /** Which way is up. The viewpoint is to be set after that. */
  setUp(up) {
    this.up = new THREE.Vector3(...up).normalize();
    this.camera.up.copy(this.up);
    this.controls?.dispose();
    this.controls = new OrbitControls(this.camera, this.canvas);  // which looks at up only when it is made
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.15;
    this.controls.zoomToCursor = true;
    this.controls.addEventListener('change', () => {
      this.changed = true;
      this.onViewChanged?.();
    });
    this.cloud.uniforms.up.value.copy(this.up);
    for (const object of [this.grid, this.axes]) if (object) this.world.remove(object);
    this.grid = new THREE.GridHelper(20, 20, 0x5a6472, 0x333a44);
    this.grid.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), this.up);
    this.axes = new THREE.AxesHelper(1);
    this.world.add(this.grid, this.axes);
    this.grid.visible = this.look.grid;
    this.axes.visible = this.look.axes;
  }

  setDay(day) {
    this.look.day = day;
    this.renderer.setClearColor(day ? DAY : NIGHT);
    this.changed = true;
  }

  setLook(change) {
    Object.assign(this.look, change);
    this.grid.visible = this.look.grid;
    this.axes.visible = this.look.axes;
    this.cameras.visible = this.look.cameras;
    if ('day' in change) this.setDay(change.day);
    this.changed = true;
  }

  resize(width, height, ratio) {
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(1, height);
    this.camera.updateProjectionMatrix();
    this.changed = true;
  }

  /** Returns the frame that was there before, whose memory is free now. */
  setFrame(frame) {
    const before = this.cloud.frame;
    this.cloud.set(frame);
    this.setHeights(frame);
    this.changed = true;
    return before;
  }

  /** Colours by height: from the lowest to the highest corner of all frames so far, so that they stay from frame to frame. */
  setHeights(frame) {
    let low = Infinity, high = -Infinity;
    for (let corner = 0; corner < 8; ++corner) {
      let height = 0;
      ['x', 'y', 'z'].forEach((axis, k) => {
        height += this.up[axis] * (frame.origin[k] + frame.step * ((corner >> k) & 1 ? frame.greatest[k] : 0));
      });
      low = Math.min(low, height);
      high = Math.max(high, height);
    }
    if (!this.heights) this.heights = this.robustHeights(frame) ?? {low, high};
    const {uniforms} = this.cloud;
    const span = Math.max(1e-6, this.heights.high - this.heights.low);
    const of_origin = this.up.x * frame.origin[0] + this.up.y * frame.origin[1] + this.up.z * frame.origin[2];
    uniforms.heightScale.value.set(frame.step / span, (of_origin - this.heights.low) / span);
  }
  robustHeights(frame) {
    const points = this.sample(frame, 4000).map((p) => p.dot(this.up)).sort((a, b) => a - b);
    if (points.length < 10) return null;
    return {low: points[Math.floor(0.01 * points.length)], high: points[Math.floor(0.99 * (points.length - 1))]};
  }

  /** Positions of some of the points that are shown, metres. */
  sample(frame, count) {
    const out = [];
    const stride = Math.max(1, Math.floor(frame.points / count));
    for (let i = 0; i < frame.points; i += stride) {
      const point = this.pointOf(frame, i);
      if (!this.box || this.inBox(point)) out.push(point);
    }
    return out;
  }
  /** Whether a place in the world is within this share of the picture. */
  inView(position, share) {
    const at = position.clone().project(this.camera);
    return Math.abs(at.x) < share && Math.abs(at.y) < share && at.z > -1 && at.z < 1;
  }
  pointOf({origin, step, positions}, i) {
    return new THREE.Vector3(origin[0] + step * positions[4 * i], origin[1] + step * positions[4 * i + 1], origin[2] + step * positions[4 * i + 2]);
  }
  inBox(point) {
    return ['x', 'y', 'z'].every((axis, k) => point[axis] >= this.box.least[k] && point[axis] <= this.box.greatest[k]);
  }

  setCameras(cameras) {
    for (const child of [...this.cameras.children]) {
      this.cameras.remove(child);
      child.geometry.dispose();
      child.material.dispose();
    }
    for (const name of this.names) name.element.remove();
    this.names = [];
    this.cameraPoses = cameras.map((camera) => new THREE.Matrix4().set(...camera.T_world_camera));
    cameras.forEach((camera, number) => {
      const corner = (u, v) => [((u - camera.cx) / camera.fx) * FRUSTUM_DEPTH, ((v - camera.cy) / camera.fy) * FRUSTUM_DEPTH, FRUSTUM_DEPTH];
      const right = camera.width - 1, bottom = camera.height - 1;
      const corners = [corner(0, 0), corner(right, 0), corner(right, bottom), corner(0, bottom)];
      const lines = [];
      corners.forEach((from, k) => lines.push(0, 0, 0, ...from, ...from, ...corners[(k + 1) % 4]));
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.Float32BufferAttribute(lines, 3));
      const object = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({color: cameraColor(number)}));
      object.matrixAutoUpdate = false;
      object.matrix.copy(this.cameraPoses[number]);
      object.frustumCulled = false;
      this.cameras.add(object);
      const element = document.createElement('div');
      element.className = 'name';
      element.textContent = camera.name;  // a stranger's text: never as HTML
      element.style.color = cameraColor(number);
      this.labels.append(element);
      this.names.push({element, position: new THREE.Vector3().setFromMatrixPosition(object.matrix), camera: true});
    });
    this.changed = true;
  }

  /** Beside the first camera and no farther away, or obliquely from above; as fuse_flow_viewer does it. */
  startView(frame) {
    const points = this.sample(frame, 20000);
    if (points.length === 0) return false;
    const middle = (axis) => points.map((p) => p[axis]).sort((a, b) => a - b)[points.length >> 1];
    const at = new THREE.Vector3(middle('x'), middle('y'), middle('z'));
    const distances = points.map((p) => p.distanceTo(at)).sort((a, b) => a - b);
    const radius = Math.max(1e-3, distances[Math.floor(distances.length * 0.9)]);
    this.radius = Math.max(radius, distances[distances.length - 1]);
    const first = this.cameraPoses?.[0];
    const towards = first ? new THREE.Vector3().setFromMatrixPosition(first).sub(at) : new THREE.Vector3(1, -1.4, 0);
    let level = towards.clone().addScaledVector(this.up, -towards.dot(this.up));
    if (level.length() < 1e-6) level = new THREE.Vector3(1, 0, 0).cross(this.up).length() > 0.1 ? new THREE.Vector3(1, 0, 0).cross(this.up) : new THREE.Vector3(0, 0, 1);
    level.normalize().applyAxisAngle(this.up, first ? 0.45 : 0);
    const above = first ? 0.25 : 0.45;
    const direction = level.multiplyScalar(Math.cos(above)).addScaledVector(this.up, Math.sin(above));
    let distance = 2.2 * radius;
    if (first && towards.length() > 0.5 * radius) distance = Math.min(distance, towards.length());
    // In a narrow window the width decides.
    const shown = (2 * Math.atan((0.6 * radius) / distance) * 180) / Math.PI;
    const narrow = Math.min(1, this.camera.aspect);
    this.camera.fov = Math.min(75, Math.max(45, Math.min(65, shown)) / (narrow < 1 ? Math.sqrt(narrow) : 1));
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(at);
    this.camera.position.copy(at).addScaledVector(direction, distance);
    this.controls.update();
    this.changed = true;
    return true;
  }

  /** {from, at, fov}: metres, and degrees from the lower to the upper side. After startView(), which knows how large the cloud is. */
  setView({from, at, fov}) {
    this.camera.fov = fov;
    this.camera.updateProjectionMatrix();
    this.camera.position.set(...from);
    this.controls.target.set(...at);
    this.controls.update();
    this.changed = true;
  }

  lookAtBox() {
    const least = new THREE.Vector3(...this.box.least), greatest = new THREE.Vector3(...this.box.greatest);
    const at = least.clone().add(greatest).multiplyScalar(0.5);
    const direction = this.camera.position.clone().sub(this.controls.target).normalize();
    const half = (this.camera.fov / 2) * (Math.PI / 180) * Math.min(1, this.camera.aspect);
    this.controls.target.copy(at);
    this.camera.position.copy(at).addScaledVector(direction, (least.distanceTo(greatest) / 2 / Math.sin(half)) * 1.05);
    this.controls.update();
    this.changed = true;
  }

  /** Turns by angles, or moves by shares of the view, or comes nearer by a factor. */
  turn(right, upwards) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    offset.applyAxisAngle(this.up, -right);
    const side = offset.clone().cross(this.up).normalize();
    if (side.length() > 0.5) {
      const turned = offset.clone().applyAxisAngle(side, upwards);
      if (Math.abs(turned.clone().normalize().dot(this.up)) < 0.999) offset.copy(turned);
    }
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.changed = true;
  }
  move(right, upwards) {
    const distance = this.camera.position.distanceTo(this.controls.target);
    const by = new THREE.Vector3(right, upwards, 0).multiplyScalar(distance).applyQuaternion(this.camera.quaternion);
    this.camera.position.add(by);
    this.controls.target.add(by);
    this.controls.update();
    this.changed = true;
  }
  nearer(factor) {
    this.camera.position.sub(this.controls.target).divideScalar(factor).add(this.controls.target);
    this.controls.update();
    this.changed = true;
  }
  flyTo(point) {
    this.camera.position.add(point).sub(this.controls.target);
    this.controls.target.copy(point);
    this.nearer(1.4);
  }

  /** The point that is shown under a place of the canvas, the nearest to the eye of those near the cursor. null: none is. */
  pick(x, y, reach = 8) {
    const frame = this.cloud.frame;
    if (!frame) return null;
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    this.camera.updateMatrixWorld();
    const matrix = new THREE.Matrix4().multiplyMatrices(this.camera.projectionMatrix, this.camera.matrixWorldInverse)
      .multiply(this.cloud.object.matrix);
    const e = matrix.elements;
    const {clip, clipLeast, clipGreatest} = this.cloud.uniforms;
    const [least, greatest] = [clipLeast.value, clipGreatest.value];
    const {positions, points} = frame;
    let best = -1, best_depth = Infinity;
    const hits = [];
    for (let i = 0; i < points; ++i) {
      const px = positions[4 * i], py = positions[4 * i + 1], pz = positions[4 * i + 2];
      const w = e[3] * px + e[7] * py + e[11] * pz + e[15];
      if (w <= 0.001) continue;
      const sx = ((e[0] * px + e[4] * py + e[8] * pz + e[12]) / w * 0.5 + 0.5) * width - x;
      if (sx > reach || sx < -reach) continue;
      const sy = (0.5 - (e[1] * px + e[5] * py + e[9] * pz + e[13]) / w * 0.5) * height - y;
      const off = sx * sx + sy * sy;
      if (off > reach * reach) continue;
      if (clip.value && (px < least.x || py < least.y || pz < least.z || px > greatest.x || py > greatest.y || pz > greatest.z)) continue;
      hits.push([i, w, off]);
      if (w < best_depth) best_depth = w;
    }
    // Of those of the nearest surface, the one nearest to the cursor.
    let best_off = Infinity;
    for (const [i, w, off] of hits)
      if (w < best_depth * 1.02 + 0.01 && off < best_off) {
        best = i;
        best_off = off;
      }
    if (best < 0) return null;
    const {colors} = frame;
    return {position: this.pointOf(frame, best), confidence: frame.fields & FIELD.confidence ? colors[4 * best + 3] / 255 : null,
            views: frame.fields & FIELD.viewCount ? positions[4 * best + 3] : null};
  }

  /** Marks, over everything: points in metres; two are joined. `text`: what stands at their middle. */
  setMarks(points, text) {
    for (const child of [...this.marks.children]) {
      this.marks.remove(child);
      child.geometry.dispose();
      child.material.dispose();
    }
    this.names = this.names.filter((name) => {
      if (name.mark) name.element.remove();
      return !name.mark;
    });
    this.changed = true;
    if (points.length === 0) return;
    if (points.length > 1) {
      const geometry = new THREE.BufferGeometry();
      // Relative to the first one, see above.
      geometry.setAttribute('position', new THREE.Float32BufferAttribute(points.flatMap((p) => p.clone().sub(points[0]).toArray()), 3));
      const line = new THREE.Line(geometry, new THREE.LineBasicMaterial({color: 0xffd24a, depthTest: false}));
      line.position.copy(points[0]);
      line.renderOrder = 2;
      line.frustumCulled = false;
      this.marks.add(line);
    }
    for (const point of points) {
      const dot = this.ball(0xffd24a, 4.5);
      dot.position.copy(point);
      dot.renderOrder = 2;
      this.marks.add(dot);
    }
    if (text) {
      const element = document.createElement('div');
      element.className = 'name mark';
      element.textContent = text;
      this.labels.append(element);
      const middle = points.reduce((sum, p) => sum.add(p), new THREE.Vector3()).divideScalar(points.length);
      this.names.push({element, position: middle, mark: true});
    }
  }

  /** Over everything, so many pixels large wherever it is. */
  ball(color, radius) {
    const ball = new THREE.Mesh(new THREE.SphereGeometry(1, 16, 12), new THREE.MeshBasicMaterial({color, depthTest: false}));
    ball.userData.radius = radius;
    ball.frustumCulled = false;
    return ball;
  }

  /** null: none. Everything outside of it is not drawn. */
  setBox(box) {
    if (this.boxObject) {
      this.world.remove(this.boxObject);
      this.boxObject.traverse((object) => {
        object.geometry?.dispose();
        object.material?.dispose();
      });
      this.boxObject = null;
    }
    this.box = box;
    this.changed = true;
    if (!box) return;
    const group = new THREE.Group();
    const size = box.greatest.map((greatest, k) => greatest - box.least[k]);
    const middle = box.least.map((least, k) => least + size[k] / 2);
    const cube = new THREE.BoxGeometry(...size);
    const lines = new THREE.LineSegments(new THREE.EdgesGeometry(cube), new THREE.LineBasicMaterial({color: 0x6cb6ff}));
    cube.dispose();
    group.add(lines);
    this.handles = [];
    for (let axis = 0; axis < 3; ++axis)
      for (const side of [-1, 1]) {
        const handle = this.ball([0xff6b6b, 0x69db7c, 0x6ca8ff][axis], 7);
        handle.position.setComponent(axis, (side * size[axis]) / 2);
        handle.renderOrder = 1;
        Object.assign(handle.userData, {axis, side});
        group.add(handle);
        this.handles.push(handle);
      }
    group.position.set(...middle);
    this.boxObject = group;
    this.world.add(group);
  }

  /** The handle of the crop box under a place of the canvas. */
  handleAt(x, y) {
    if (!this.boxObject) return null;
    let best = null, nearest = 14;  // pixels
    for (const handle of this.handles) {
      const at = this.onScreen(handle.getWorldPosition(new THREE.Vector3()));
      if (!at) continue;
      const off = Math.hypot(at.x - x, at.y - y);
      if (off < nearest) [best, nearest] = [handle, off];
    }
    return best;
  }
  /** Moves the side of a handle to where its axis passes nearest to a place of the canvas. */
  dragHandle({userData: {axis, side}}, x, y) {
    const ray = this.ray(x, y);
    const along = new THREE.Vector3().setComponent(axis, 1);
    const from = new THREE.Vector3(...this.box.least).add(new THREE.Vector3(...this.box.greatest)).multiplyScalar(0.5);
    const b = along.dot(ray.direction);
    const between = from.clone().sub(ray.origin);
    if (1 - b * b < 1e-4) return;  // seen along the axis
    const at = from.getComponent(axis) + (b * ray.direction.dot(between) - along.dot(between)) / (1 - b * b);
    const box = {least: [...this.box.least], greatest: [...this.box.greatest]};
    if (side < 0) box.least[axis] = Math.min(at, box.greatest[axis] - 0.01);
    else box.greatest[axis] = Math.max(at, box.least[axis] + 0.01);
    this.setBox(box);
  }
  ray(x, y) {
    const caster = new THREE.Raycaster();
    caster.setFromCamera(new THREE.Vector2((x / this.canvas.clientWidth) * 2 - 1, 1 - (y / this.canvas.clientHeight) * 2), this.camera);
    return caster.ray;
  }
  onScreen(position) {
    const at = position.clone().project(this.camera);
    if (at.z < -1 || at.z > 1) return null;
    return {x: (at.x * 0.5 + 0.5) * this.canvas.clientWidth, y: (0.5 - at.y * 0.5) * this.canvas.clientHeight};
  }

  /** To be called for each picture of the screen. Returns whether it drew. */
  draw() {
    const xr = this.renderer.xr.isPresenting;
    if (!xr) this.controls.update();
    if (!this.changed && !xr) return false;
    this.changed = false;
    const {uniforms} = this.cloud;
    const frame = this.cloud.frame;
    const ratio = this.renderer.getPixelRatio();
    uniforms.pixels.value = (this.look.byDistance ? 1 : this.look.size) * ratio;
    // 4 mm for a pixel: about what a pixel is at the distance at which one looks at a room.
    uniforms.metres.value = this.look.byDistance ? this.look.size * 0.004 : 0;
    uniforms.most.value = 4 * this.look.size * ratio;  // what is right before the eye is not to hide the rest
    uniforms.focal.value = (this.canvas.height / 2) / Math.tan((this.camera.fov * Math.PI) / 360);
    if (frame) {
      const has = {rgb: FIELD.color, confidence: FIELD.confidence, views: FIELD.viewCount, normal: FIELD.normal, height: 0}[this.look.colorBy];
      uniforms.colorBy.value = COLOR_BY[(frame.fields & has) === has ? this.look.colorBy : 'height'];
      uniforms.clip.value = this.box ? 1 : 0;
      if (this.box)
        ['x', 'y', 'z'].forEach((axis, k) => {
          uniforms.clipLeast.value[axis] = (this.box.least[k] - frame.origin[k]) / frame.step;
          uniforms.clipGreatest.value[axis] = (this.box.greatest[k] - frame.origin[k]) / frame.step;
        });
    }
    if (!xr) {
      const distance = this.camera.position.distanceTo(this.controls.target);
      this.camera.near = Math.max(0.002, distance / 200);
      this.camera.far = Math.max(100, 20 * this.radius + 4 * distance);
      this.camera.updateProjectionMatrix();
    }
    for (const ball of [...(this.boxObject ? this.handles : []), ...this.marks.children]) {
      if (!ball.userData.radius) continue;  // the line
      const distance = ball.getWorldPosition(new THREE.Vector3()).distanceTo(this.camera.position);
      ball.scale.setScalar((ball.userData.radius * distance * ratio) / uniforms.focal.value);
    }
    this.renderer.render(this.scene, this.camera);
    ++this.drawn;
    for (const {element, position, camera} of this.names) {
      const at = (camera && !this.look.cameras) || xr ? null : this.onScreen(position);
      element.hidden = !at;
      if (at) element.style.transform = `translate(${at.x.toFixed(1)}px, ${at.y.toFixed(1)}px)`;
    }
    return true;
  }

  /** For a session of XR, where y is up and the floor is at 0: the world stands on it, its middle two metres ahead. */
  async present(session) {
    this.renderer.xr.enabled = true;
    await this.renderer.xr.setSession(session);
    const turned = new THREE.Quaternion().setFromUnitVectors(this.up, new THREE.Vector3(0, 1, 0));
    const target = this.controls.target.clone().applyQuaternion(turned);
    const low = this.heights ? this.heights.low : 0;
    this.world.quaternion.copy(turned);
    this.world.position.set(-target.x, -low, -target.z - 2);
    session.addEventListener('end', () => {
      this.renderer.xr.enabled = false;
      this.world.quaternion.identity();
      this.world.position.set(0, 0, 0);
      this.changed = true;
    });
  }
}
