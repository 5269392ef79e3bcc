// People and agents of Throng, drawn by three.js from records of 32 bytes that lie in the memory of the wasm module.
import {
  BoxGeometry, BufferAttribute, CapsuleGeometry, Color, DataTexture, DoubleSide, FloatType,
  GLSL3, GridHelper, InstancedBufferGeometry, InstancedInterleavedBuffer, InterleavedBufferAttribute, Matrix4, Mesh,
  MeshBasicMaterial, PerspectiveCamera, Plane, RawShaderMaterial, Raycaster, RGBAFormat, RingGeometry, Scene, Vector2,
  Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

const TEXELS = 4096; // texels in a line of the texture of poses
const STEP_S = 1 / 60;
const $ = (id) => document.getElementById(id);

let lib; // what the module exports
const at = (Kind, pointer) => new Kind(lib.memory.buffer, pointer, lib.throng_size());
const fault = (why) => { $('fault').textContent = why; };

/** Throws what the library says of a call that failed. */
function done(status) {
  if (status !== 0) throw new Error(new TextDecoder().decode(at(Uint8Array, lib.throng_text())));
}

// The stage.
const renderer = new WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
document.body.prepend(renderer.domElement);
const scene = new Scene();
scene.background = new Color(0xe9edf1);
const camera = new PerspectiveCamera(45, 1, 0.1, 2000);
const controls = new OrbitControls(camera, renderer.domElement);
controls.maxPolarAngle = 1.5;
scene.add(new GridHelper(400, 80, 0x9aa5b1, 0xc9d0d8));

/** Limbs as boxes and capsules, each rigid on one joint: positions relative to that joint at rest. */
function body() {
  const rest = at(Float32Array, lib.throng_rest()).slice();
  const parents = at(Int32Array, lib.throng_parents()).slice();
  const joint = (j) => new Vector3(rest[3 * j], rest[3 * j + 1], rest[3 * j + 2]);
  const [positions, normals, joints, indices] = [[], [], [], []];
  const add = (geometry, matrix, j) => {
    geometry.applyMatrix4(matrix);
    const first = positions.length / 3;
    positions.push(...geometry.attributes.position.array);
    normals.push(...geometry.attributes.normal.array);
    for (let k = 0; k < geometry.attributes.position.count; k++) joints.push(j);
    indices.push(...Array.from(geometry.index.array, (i) => first + i));
  };
  const limb = (j, to, radius) => {
    const length = to.length();
    if (length < 0.02) return;
    const y = to.clone().normalize();
    const x = (Math.abs(y.x) < 0.9 ? new Vector3(1, 0, 0) : new Vector3(0, 0, 1)).cross(y).normalize();
    const matrix = new Matrix4().makeBasis(x, y, x.clone().cross(y)).setPosition(to.clone().multiplyScalar(0.5));
    add(new CapsuleGeometry(radius, Math.max(length - radius, 0.02), 1, 6), matrix, j);
  };
  // Hips, spine to upper chest, neck, head, then arms and legs, left before right.
  const thick = (j) => (j < 4 ? 0.125 : j < 6 ? 0.06 : j < 14 ? 0.045 : [14, 18].includes(j) ? 0.075 : 0.055);
  parents.forEach((p, j) => { if (p >= 0 && ![6, 10, 14, 18].includes(j)) limb(p, joint(j).sub(joint(p)), thick(p)); });
  for (const j of [6, 10, 14, 18]) limb(parents[j], joint(j).sub(joint(parents[j])), 0.07);
  add(new CapsuleGeometry(0.095, 0.06, 2, 7), new Matrix4().makeTranslation(0, 0.09, 0.02), 5);
  for (const j of [9, 13]) add(new BoxGeometry(0.04, 0.05, 0.12), new Matrix4().makeTranslation(0, -0.02, 0), j);
  for (const j of [17, 21]) add(new BoxGeometry(0.085, 0.05, 0.1), new Matrix4().makeTranslation(0, 0.0, 0.03), j);
  return { positions, normals, joints, indices };
}

const VERTEX = `
precision highp float;
precision highp int;
uniform mat4 viewMatrix, projectionMatrix;
uniform sampler2D rows;
uniform int lastRow;
uniform bool posed;
in vec3 position, normal;
in float joint;
in uvec4 what; // row_a, row_b, frac and blend, variant
in uvec4 where; // x, y, z, heading
out vec3 vNormal, vColour;
mat4x3 rowOf(int row) {
  int texel = (min(row, lastRow) * 22 + int(joint)) * 3;
  vec4 m[3];
  for (int i = 0; i < 3; i++) m[i] = texelFetch(rows, ivec2((texel + i) % ${TEXELS}, (texel + i) / ${TEXELS}), 0);
  return mat4x3(m[0].x, m[1].x, m[2].x, m[0].y, m[1].y, m[2].y, m[0].z, m[1].z, m[2].z, m[0].w, m[1].w, m[2].w);
}
mat4x3 between(int row, float frac) {
  return rowOf(row) * (1.0 - frac) + rowOf(row + 1) * frac;
}
vec3 hue(uint k) {
  float h = fract(float(k) * 0.61803399);
  return mix(vec3(0.45), clamp(abs(fract(h + vec3(0.0, 0.667, 0.333)) * 6.0 - 3.0) - 1.0, 0.0, 1.0), 0.45);
}
void main() {
  vec3 p = position, n = normal;
  if (posed) {
    vec2 share = unpackUnorm2x16(what.z);
    mat4x3 m = between(int(what.x), share.x);
    if (share.y > 0.0) m = m * (1.0 - share.y) + between(int(what.y), share.x) * share.y;
    p = m * vec4(p, 1.0);
    n = mat3(m) * n;
  }
  vec4 place = uintBitsToFloat(where);
  float s = sin(place.w), c = cos(place.w);
  mat3 turn = mat3(c, 0.0, -s, 0.0, 1.0, 0.0, s, 0.0, c);
  vNormal = turn * n;
  vColour = joint == 5.0 || joint == 9.0 || joint == 13.0 ? vec3(0.85, 0.7, 0.58) : joint < 0.5 || joint > 13.5 ? vec3(0.24, 0.27, 0.33) : hue(what.w);
  gl_Position = projectionMatrix * viewMatrix * vec4(turn * p + place.xyz, 1.0);
}`;
const FRAGMENT = `
precision highp float;
in vec3 vNormal, vColour;
out vec4 colour;
void main() {
  vec3 n = normalize(vNormal);
  float light = 0.55 + 0.25 * n.y + 0.3 * max(dot(n, normalize(vec3(0.4, 0.8, 0.35))), 0.0);
  colour = vec4(pow(vColour * light, vec3(1.0 / 1.3)), 1.0);
}`;

let crowd; // the mesh of everybody
const targets = [];

/** The mesh for what is shown: bodies posed from rows, or upright capsules. */
function draw(posed) {
  if (crowd) {
    scene.remove(crowd);
    crowd.geometry.dispose();
    crowd.material.uniforms.rows.value?.dispose();
    crowd.material.dispose();
  }
  const geometry = new InstancedBufferGeometry();
  let rows = null;
  let parts;
  if (posed) {
    parts = body();
    const poses = at(Float32Array, lib.throng_rows());
    const lines = Math.ceil(poses.length / 4 / TEXELS);
    const texels = new Float32Array(4 * TEXELS * lines);
    texels.set(poses);
    rows = new DataTexture(texels, TEXELS, lines, RGBAFormat, FloatType);
    rows.needsUpdate = true;
    geometry.userData.numRows = poses.length / 264;
  } else {
    const capsule = new CapsuleGeometry(0.26, 1.2, 4, 10).translate(0, 0.86, 0);
    const nose = new BoxGeometry(0.1, 0.1, 0.2).translate(0, 1.45, 0.25);
    parts = { positions: [], normals: [], joints: [], indices: [] };
    for (const g of [capsule, nose]) {
      const first = parts.positions.length / 3;
      parts.positions.push(...g.attributes.position.array);
      parts.normals.push(...g.attributes.normal.array);
      for (let k = 0; k < g.attributes.position.count; k++) parts.joints.push(g === nose ? 0 : 1);
      parts.indices.push(...Array.from(g.index.array, (i) => first + i));
    }
  }
  geometry.setIndex(parts.indices);
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(parts.positions), 3));
  geometry.setAttribute('normal', new BufferAttribute(new Float32Array(parts.normals), 3));
  geometry.setAttribute('joint', new BufferAttribute(new Float32Array(parts.joints), 1));
  const records = new InstancedInterleavedBuffer(readRecords(), 8);
  geometry.setAttribute('what', new InterleavedBufferAttribute(records, 4, 0));
  geometry.setAttribute('where', new InterleavedBufferAttribute(records, 4, 4));
  geometry.instanceCount = records.count;
  const uniforms = { rows: { value: rows }, lastRow: { value: (geometry.userData.numRows ?? 1) - 1 }, posed: { value: posed } };
  const material = new RawShaderMaterial({ glslVersion: GLSL3, vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms, side: DoubleSide });
  crowd = new Mesh(geometry, material);
  crowd.frustumCulled = false;
  crowd.userData.records = records;
  scene.add(crowd);
}

/** All records, 8 words each, copied into an array that stays where it is. */
function readRecords() {
  const pointer = lib.throng_records();
  return new Uint32Array(lib.memory.buffer, pointer, 8 * lib.throng_size()).slice();
}

function show() {
  const [kind, count] = [$('scene').value, Math.min(Math.max(Math.round(+$('count').value) || 1, 1), 20000)];
  try {
    done(kind === 'people' ? lib.throng_people(count, 1) : lib.throng_agents(count, 1));
    fault('');
  } catch (why) {
    return fault(why.message);
  }
  draw(kind === 'people');
  targets.splice(0).forEach((ring) => { scene.remove(ring); ring.geometry.dispose(); ring.material.dispose(); });
  const places = at(Float32Array, lib.throng_targets());
  for (let k = 0; k < places.length; k += 2) {
    const ring = new Mesh(new RingGeometry(0.7, 1.1, 40).rotateX(-Math.PI / 2), new MeshBasicMaterial({ color: 0xd1305f }));
    ring.position.set(places[k], 0.02, places[k + 1]);
    targets.push(ring);
    scene.add(ring);
  }
  const side = 2.2 * Math.sqrt(count);
  camera.position.set(0, 4 + 0.42 * side, -(6 + 0.7 * side));
  controls.target.set(0, 0.8, 0);
}

// Targets are dragged over the ground.
let dragged = -1;
const ray = new Raycaster();
const ground = new Plane(new Vector3(0, 1, 0), 0);
function pointed(event) {
  const size = renderer.getSize(new Vector2());
  ray.setFromCamera(new Vector2((2 * event.clientX) / size.x - 1, 1 - (2 * event.clientY) / size.y), camera);
  return ray.ray.intersectPlane(ground, new Vector3());
}
renderer.domElement.addEventListener('pointerdown', (event) => {
  const place = pointed(event);
  dragged = place ? targets.findIndex((t) => Math.hypot(t.position.x - place.x, t.position.z - place.z) < 1.6) : -1;
  controls.enabled = dragged < 0;
}, true);
addEventListener('pointermove', (event) => {
  const place = dragged >= 0 && pointed(event);
  if (!place) return;
  targets[dragged].position.set(place.x, 0.02, place.z);
  try { done(lib.throng_target(dragged, place.x, place.z)); } catch (why) { fault(why.message); }
});
addEventListener('pointerup', () => { dragged = -1; controls.enabled = true; });

/** Opens a bundle; what was shown stays where it is none. */
function open(bytes) {
  const input = lib.throng_input(bytes.length);
  new Uint8Array(lib.memory.buffer, input, bytes.length).set(bytes);
  done(lib.throng_open());
  show();
}
addEventListener('dragover', (event) => event.preventDefault());
addEventListener('drop', async (event) => {
  event.preventDefault();
  const [file] = event.dataTransfer.files;
  if (!file) return;
  try { open(new Uint8Array(await file.arrayBuffer())); } catch (why) { fault(`${file.name}: ${why.message}`); }
});

const mean = { frame: 0, step: 0, draw: 0 };
const smooth = (key, ms) => { mean[key] += 0.05 * (ms - mean[key]); };
let [last, owed, shownAt] = [0, 0, 0];
function frame(now) {
  requestAnimationFrame(frame);
  const [width, height] = [innerWidth, innerHeight];
  const size = renderer.getSize(new Vector2());
  if (size.x !== width || size.y !== height) {
    renderer.setSize(width, height);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
  }
  if (!crowd) return;
  if (last > 0) smooth('frame', now - last);
  // Slow frames are not made up for: people move more slowly then.
  owed = Math.min(owed + (now - last) / 1000, 0.1);
  last = now;
  const begun = performance.now();
  try {
    for (; owed >= STEP_S; owed -= STEP_S) {
      const before = performance.now();
      done(lib.throng_step(STEP_S));
      smooth('step', performance.now() - before);
    }
  } catch (why) {
    fault(why.message);
  }
  crowd.userData.records.array.set(readRecords());
  crowd.userData.records.needsUpdate = true;
  controls.update();
  renderer.render(scene, camera);
  smooth('draw', performance.now() - begun);
  if (now - shownAt > 500) {
    shownAt = now;
    const kB = (n) => `${Math.round(n / 1000)} kB`;
    $('figures').textContent = `frame ${mean.frame.toFixed(1)} ms; a step ${mean.step.toFixed(2)} ms; steps and drawing ${mean.draw.toFixed(1)} ms\n`
      + `module ${kB(sizes.module)}, bundle ${kB(sizes.bundle)}, records ${kB(32 * crowd.userData.records.count)} a frame\ndrag a ring; drop a bundle`;
  }
}

const sizes = {};
async function bytesOf(name) {
  const answer = await fetch(name);
  if (!answer.ok) throw new Error(`${name}: ${answer.status} ${answer.statusText}`);
  return new Uint8Array(await answer.arrayBuffer());
}
try {
  const code = await bytesOf('throng_web.wasm');
  lib = (await WebAssembly.instantiate(code)).instance.exports;
  const name = new URLSearchParams(location.search).get('bundle') ?? 'demo.throng';
  const bundle = await bytesOf(name);
  Object.assign(sizes, { module: code.length, bundle: bundle.length });
  $('scene').addEventListener('change', show);
  $('count').addEventListener('change', show);
  try { open(bundle); } catch (why) { fault(`${name}: ${why.message}`); }
} catch (why) {
  fault(why.message);
}
requestAnimationFrame(frame);
window.throng = { camera, targets, mean, records: () => readRecords(), open, fault };
