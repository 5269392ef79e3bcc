// Lets people and agents walk in the page's module and compares their records with those of a native run, byte by byte.
// `node scripts/compare-web.mjs MODULE BUNDLE COUNT STEPS RECORDS`, where RECORDS is what web/examples/records.rs wrote.
import { readFileSync } from 'node:fs';

const [module, bundle, count, steps, records] = process.argv.slice(2);
const lib = (await WebAssembly.instantiate(readFileSync(module), {})).instance.exports;
const done = (status) => {
  if (status === 0) return;
  const at = lib.throng_text();
  throw new Error(new TextDecoder().decode(new Uint8Array(lib.memory.buffer, at, lib.throng_size())));
};
const bytes = readFileSync(bundle);
const input = lib.throng_input(bytes.length);
new Uint8Array(lib.memory.buffer).set(bytes, input);
done(lib.throng_open());
const native = readFileSync(records);
const size = 32 * Number(count);
if (native.length !== 2 * size) throw new Error(`${records} has ${native.length} bytes, expected ${2 * size}`);
['people', 'agents'].forEach((who, k) => {
  done(lib[`throng_${who}`](Number(count), 1));
  const floats = () => new Float32Array(lib.memory.buffer.slice(lib.throng_records(), lib.throng_records() + size));
  const start = floats();
  for (let step = 0; step < Number(steps); step++) done(lib.throng_step(1 / 60));
  const ours = floats();
  const theirs = new Float32Array(native.buffer.slice(native.byteOffset + k * size, native.byteOffset + (k + 1) * size));
  const bits = (all) => new Uint32Array(all.buffer);
  const [a, b] = [bits(ours), bits(theirs)];
  const different = Array.from({ length: Number(count) }, (_, i) => i)
    .filter((i) => a.slice(8 * i, 8 * i + 8).some((word, w) => word !== b[8 * i + w]));
  const metres = (all, other) => Array.from({ length: Number(count) }, (_, i) =>
    Math.hypot(all[8 * i + 4] - other[8 * i + 4], all[8 * i + 6] - other[8 * i + 6]));
  const walked = metres(ours, start).filter((m) => m > 0.5).length;
  const farthest = Math.max(...metres(ours, theirs));
  console.log(`${count} ${who} after ${steps} steps: ${walked} walked, ${different.length} records differ from native, ` +
    `places by ${farthest} m at most`);
  if (different.length > 0 || walked < Number(count) / 4) process.exitCode = 1;
});
