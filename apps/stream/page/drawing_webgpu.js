// What drawing.js does by WebGPU instead of WebGL 2: a renderer of three.js, and the cloud. Loaded only where it is used, as three.js for
// WebGPU is as large as the rest of the page. WebGPU has points of one pixel only, so a point is a triangle here, of which a square is drawn.
// Not an instance of one: drawn by software, each instance takes as long as an object of its own. Nor two triangles: twice the vertices.

import * as THREE from 'three/webgpu';

const {cameraProjectionMatrix, highpModelViewMatrix, screenSize, storage, texture, uniform, varying, vec4, vertexIndex, wgslFn} = THREE.TSL;

// As in drawing.js, where each step stands in GLSL.
const unpack = wgslFn(`
fn unpack(at: vec2u) -> vec4f {
  return vec4f(f32(at.x & 0xffffu), f32(at.x >> 16u), f32(at.y & 0xffffu), f32(at.y >> 16u));
}`);
const cornerOf = wgslFn(`
fn cornerOf(vertex: u32) -> vec2f {
  return vec2f(select(-0.5, 1.5, vertex % 3u == 1u), select(-0.5, 1.5, vertex % 3u == 2u));
}`);
const sizeOf = wgslFn(`
fn sizeOf(eye: vec4f, pixels: f32, metres: f32, most: f32, focal: f32) -> f32 {
  let size = select(pixels, max(pixels, metres * focal / max(-eye.z, 0.001)), metres > 0.0);
  return clamp(size, 1.0, max(pixels, most));
}`);
const place = wgslFn(`
fn place(onScreen: vec4f, corner: vec2f, size: f32, screen: vec2f, position: vec3f, clip: u32, least: vec3f, greatest: vec3f) -> vec4f {
  if (clip != 0u && (any(position < least) || any(position > greatest))) { return vec4f(2.0, 2.0, 2.0, 1.0); }
  return vec4f(onScreen.xy + 2.0 * size / screen * corner * onScreen.w, onScreen.zw);
}`);
const colorOf = wgslFn(`
fn colorOf(colorBy: i32, color: u32, views: f32, height: f32, normals: u32, point: u32, scale: texture_2d<f32>) -> vec3f {
  let rgba = unpack4x8unorm(color);
  if (colorBy == 0) { return rgba.rgb; }
  if (colorBy == 1) { return textureLoad(scale, vec2i(i32(rgba.a * 255.0 + 0.5), 0), 0).rgb; }
  if (colorBy == 2) {
    if (views < 0.5) { return vec3f(128.0) / 255.0; }
    if (views < 1.5) { return vec3f(214.0, 69.0, 65.0) / 255.0; }
    if (views < 2.5) { return vec3f(235.0, 190.0, 60.0) / 255.0; }
    if (views < 3.5) { return vec3f(64.0, 170.0, 105.0) / 255.0; }
    return vec3f(60.0, 120.0, 216.0) / 255.0;
  }
  if (colorBy == 3) { return textureLoad(scale, vec2i(i32(clamp(height, 0.0, 1.0) * 255.0 + 0.5), 0), 0).rgb; }
  let pq = (normals >> (16u * (point & 1u))) & 0xffffu;  // of two points
  if (pq == 0u) { return vec3f(0.5); }
  var n = (vec2f(f32(pq & 0xffu), f32(pq >> 8u)) - 128.0) / 127.0;
  let z = 1.0 - abs(n.x) - abs(n.y);
  if (z < 0.0) { n = (1.0 - abs(n.yx)) * vec2f(select(1.0, -1.0, n.x < 0.0), select(1.0, -1.0, n.y < 0.0)); }
  return 0.5 + 0.5 * normalize(vec3f(n, z));
}`);
const shade = wgslFn(`
fn shade(rgb: vec3f, corner: vec2f, size: f32) -> vec4f {
  // A square of the triangle; a larger one is round.
  if (corner.x > 0.5 || corner.y > 0.5 || (size > 2.5 && dot(corner, corner) > 0.25)) { discard; }
  return vec4f(rgb, 1.0);
}`);

/** null: this browser has no WebGPU, or not here: it is only on pages by https, or of this computer. */
export async function makeRenderer(canvas) {
  const adapter = await navigator.gpu?.requestAdapter({powerPreference: 'high-performance'});
  if (!adapter) return null;
  const {maxBufferSize, maxStorageBufferBindingSize} = adapter.limits;
  const device = await adapter.requestDevice({requiredLimits: {maxBufferSize, maxStorageBufferBindingSize}});
  // Colours are written as they are: no picture in between, which three.js would draw into and convert.
  THREE.ColorManagement.enabled = false;
  const renderer = new THREE.WebGPURenderer({canvas, device, antialias: false, alpha: false});
  renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
  renderer.highPrecision = true;  // of what is relative to the eye
  await renderer.init();
  return renderer;
}

/** As CloudObject of drawing.js. */
export class WebGpuCloudObject {
  constructor(renderer, scale) {
    this.renderer = renderer;
    this.scale = scale;
    this.frame = null;
    this.uniforms = {
      pixels: uniform(2), metres: uniform(0), most: uniform(64), focal: uniform(1), colorBy: uniform(0, 'int'), up: uniform(new THREE.Vector3(0, 0, 1)),
      heightScale: uniform(new THREE.Vector2(1, 0)), clip: uniform(0, 'uint'), clipLeast: uniform(new THREE.Vector3()), clipGreatest: uniform(new THREE.Vector3()),
    };
    this.object = new THREE.Mesh(new THREE.BufferGeometry(), new THREE.NodeMaterial());
    this.object.frustumCulled = false;
    this.object.matrixAutoUpdate = false;
    this.object.visible = false;
    this.capacity = 0;  // points; buffers are made for the first frame
    this.attributes = {};
  }

  /** For so many points, and some more. */
  enlarge(points, wide) {
    const {backend} = this.renderer;
    for (const attribute of Object.values(this.attributes)) backend.destroyAttribute(attribute);
    this.capacity = 2 * Math.ceil(0.6 * points);
    this.wide = wide;
    const make = (count, items, type = Uint32Array) => new THREE.StorageBufferAttribute(count, items, type);
    this.attributes = {positions: wide ? make(this.capacity, 4, Float32Array) : make(this.capacity, 2), colors: make(this.capacity, 1),
                       normals: make(this.capacity / 2, 1)};
    for (const attribute of Object.values(this.attributes)) backend.createStorageAttribute(attribute);
    this.object.material.dispose();
    this.object.material = this.makeMaterial();
  }

  makeMaterial() {
    const {pixels, metres, most, focal, colorBy, up, heightScale, clip, clipLeast, clipGreatest} = this.uniforms;
    const read = (name, type, index) => storage(this.attributes[name], type, this.attributes[name].count).toReadOnly().element(index);
    const index = vertexIndex.div(3).toVar();
    const packed = read('positions', this.wide ? 'vec4' : 'uvec2', index);
    const point = (this.wide ? packed : unpack({at: packed})).toVar();  // x, y, z in steps, number of views
    const position = point.xyz;
    const corner = cornerOf({vertex: vertexIndex}).toVar();
    const eye = highpModelViewMatrix.mul(vec4(position, 1)).toVar();
    const size = sizeOf({eye, pixels, metres, most, focal}).toVar();
    const rgb = colorOf({colorBy, color: read('colors', 'uint', index), views: point.w, height: up.dot(position).mul(heightScale.x).add(heightScale.y),
                         normals: read('normals', 'uint', index.shiftRight(1)), point: index, scale: texture(this.scale)});
    const material = new THREE.NodeMaterial();
    material.vertexNode = place({onScreen: cameraProjectionMatrix.mul(eye), corner, size, screen: screenSize, position, clip, least: clipLeast, greatest: clipGreatest});
    material.fragmentNode = shade({rgb: varying(rgb), corner: varying(corner), size: varying(size)});
    return material;
  }

  set(frame) {
    this.frame = frame;
    this.object.visible = frame.points > 0;
    if (frame.points === 0) return;
    const wide = frame.positions instanceof Float32Array;
    if (frame.points > this.capacity || wide !== this.wide) this.enlarge(frame.points, wide);
    const {backend} = this.renderer;
    const fill = (name, array) => {
      // Of whole words: an array's buffer has them.
      if (array) backend.device.queue.writeBuffer(backend.get(this.attributes[name]).buffer, 0, array.buffer, 0, 4 * Math.ceil(array.byteLength / 4));
    };
    fill('positions', frame.positions);
    fill('colors', frame.colors);
    fill('normals', frame.normals);
    this.object.geometry.setDrawRange(0, 3 * frame.points);
    this.object.matrix.makeScale(frame.step, frame.step, frame.step).setPosition(...frame.origin);
    this.object.matrixWorldNeedsUpdate = true;
  }
}
