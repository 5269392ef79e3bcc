// What does Khronos' validator say of glTF files? `node scripts/validate-gltf.mjs FILE.glb ...`, where the package
// `gltf-validator` is beside the current folder (`npm install gltf-validator`). Fails where there is an error or a warning.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

const validator = createRequire(join(process.cwd(), "index.js"))("gltf-validator");
let bad = 0;
for (const file of process.argv.slice(2)) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(file)), { maxIssues: 100 });
  const { numErrors, numWarnings, numInfos, messages } = report.issues;
  bad += numErrors + numWarnings;
  console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} infos`);
  for (const m of messages.filter((m) => m.severity < 2).slice(0, 10)) console.log(`  ${m.code} ${m.pointer}: ${m.message}`);
  const infos = new Set(messages.filter((m) => m.severity >= 2).map((m) => m.code));
  if (infos.size) console.log(`  infos: ${[...infos].join(", ")}`);
}
process.exit(bad > 0 ? 1 : 0);
