// The npm package in headless Chromium: the same bits, a worker, broken archives, three.js and its GPU's way, under a
// strict Content-Security-Policy. Environment as for test_same_bits.ts and test_refused_archives.ts.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { basename } from "node:path";
import { checkDocsPage } from "./docs_page.js";
import type { GpuDifference } from "./gpu_page.js";
import { addressOf, openChromium, web, webGpuFlags } from "./open_chromium.js";

const pairs = (process.env["FB_ARCHIVES"] ?? "").split(" ").filter(Boolean).map((pair) => pair.split("=")) as [string, string][];
const refused = readFileSync(process.env["FB_REFUSED"]!, "utf8").trimEnd().split("\n").map((line) => line.split("\t"));
const broken = refused.find(([, status, message]) => status === "5" && /byte/.test(message!)) as [string, string, string];

const files: Record<string, string> = { [addressOf("refused", broken[0])]: broken[0] };
const faces = pairs.map(([archive, dump], index) => {
  const face = { archive: addressOf(`archive${index}`, archive), dump: addressOf("expected", dump),
                 name: basename(archive, ".fbk"), file: archive };
  files[face.archive] = archive;
  files[face.dump] = dump;
  return face;
});
const { page, call, errors, close } = await openChromium(files, undefined, webGpuFlags);
try {
  for (const { name, archive, dump } of faces)
    console.log(`${name}: ${await call("sameBits", archive, dump)}: the same bits`);
  const character = faces.find(({ name }) => name === "character")!;
  console.log(`worker: ${await call("inWorker", character.archive)}`);
  assert.equal(await call("refuses", addressOf("refused", broken[0])), `FB_ERROR_CORRUPT: ${broken[2]}`);
  assert.match(await call("refuses", "/nothing.fbk"), /FB_ERROR_IO: .*404/);
  console.log("broken and missing archives are refused");
  const body = faces.find(({ name }) => name === "body")!; // with a skin
  const driven = faces.find(({ name }) => name === "driven")!; // with driven joints
  for (const { name, archive, dump } of new Set([character, body, driven, faces.at(-1)!]))
    for (const kind of ["webgl", "webgpu", "webgpu-webgl2"]) {
      const gpu = await call<GpuDifference>("drawOnGpu", archive, dump, kind, kind === "webgl" ? 64 : 8);
      console.log(`${name} on the GPU: ${JSON.stringify(gpu)}`);
      await page.screenshot({ path: `${web}gpu-${name}-${kind}.png`, timeout: 120_000 });
      assert.equal(gpu.backend, kind);
      assert.deepEqual(gpu.supported, { webgl: kind === "webgl", webgpu: kind !== "webgl" });
      assert(gpu.position < (gpu.joints > 0 ? 1e-5 : 5e-5), `positions differ by ${gpu.position} of the diagonal`);
      assert(gpu.normal < 0.5, `normals differ by ${gpu.normal} degrees`);
      assert(gpu.covered > 1000 && gpu.brightness > 20 && gpu.differing < 0.002, "the pictures differ");
      assert(name !== "body" || gpu.bones > 0, "no bones are turned");
      assert(name !== "driven" || gpu.moved > 0.05, `joints move vertices by ${gpu.moved} of the diagonal`);
    }
  const exact = faces.find(({ name }) => name === "exact-poses")!;
  for (const { name, archive, dump } of new Set([character, driven, exact, faces.at(-1)!])) {
    const { said, skinned } = await call<{ said: string; skinned: number }>("evaluateOnGpu", archive, dump, 20);
    console.log(`${name} by WebGPU: ${said}: the same bits; skinned within ${skinned} of the diagonal`);
    assert(skinned < 1e-5);
  }
  assert.deepEqual(errors.filter((text) => !text.includes("404")), []);
} finally {
  await close();
}
const withItsControl = faces.find(({ name }) => name === "character")!;
await checkDocsPage(process.env["FB_DOCS_PAGE"]!, withItsControl.file);
console.log("the page of docs/browser.md shows a face that moves");
