// The npm package in headless Chromium: the same bits, a worker, broken archives, three.js and its GPU's way, under a
// strict Content-Security-Policy. Environment as for test_same_bits.ts and test_refused_archives.ts.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { basename, dirname } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";
import type { GpuDifference } from "./gpu_page.js";
import { serveFolders } from "./serve_folder.js";

const web = fileURLToPath(new URL("../../", import.meta.url));
const pairs = (process.env["FB_ARCHIVES"] ?? "").split(" ").filter(Boolean).map((pair) => pair.split("=")) as [string, string][];
const files: Record<string, string> = { "/": web };
pairs.forEach(([archive], index) => { files[`/archive${index}/`] = `${dirname(archive)}/`; });
const refused = readFileSync(process.env["FB_REFUSED"]!, "utf8").trimEnd().split("\n").map((line) => line.split("\t"));
const broken = refused.find(([, status, message]) => status === "5" && /byte/.test(message!)) as [string, string, string];
files["/refused/"] = `${dirname(broken[0])}/`;

const { server, address } = await serveFolders(files);
const browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: [
  "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
  "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] });
try {
  const page = await browser.newPage({ viewport: { width: 500, height: 500 } });
  const errors: string[] = [];
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("console", (message) => { if (message.type() === "error") errors.push(message.text()); });
  await page.goto(`${address}/tests-built/browser/page.html`);
  await page.waitForFunction("globalThis.facebakerTests");
  const call = <Result>(name: string, ...values: string[]): Promise<Result> =>
    page.evaluate(`facebakerTests.${name}(${values.map((value) => JSON.stringify(value)).join(", ")})`);
  const archive = (index: number) => `/archive${index}/${basename(pairs[index]![0])}`;
  const dump = (index: number) => `/expected/${basename(pairs[index]![1])}`;

  for (let i = 0; i < pairs.length; ++i)
    console.log(`${basename(archive(i))}: ${await call("sameBits", archive(i), dump(i))}: the same bits`);
  const withMeshes = pairs.findIndex(([path]) => path.endsWith("character.fbk"));
  console.log(`worker: ${await call("inWorker", archive(withMeshes))}`);
  assert.equal(await call("refuses", `/refused/${basename(broken[0])}`), `FB_ERROR_CORRUPT: ${broken[2]}`);
  assert.match(await call("refuses", "/nothing.fbk"), /FB_ERROR_IO: .*404/);
  console.log("broken and missing archives are refused");
  for (const index of new Set([withMeshes, pairs.length - 1])) {
    const gpu = await call<GpuDifference>("drawOnGpu", archive(index), dump(index));
    console.log(`${basename(archive(index))} on the GPU: ${JSON.stringify(gpu)}`);
    assert(gpu.position < 5e-5, `positions differ by ${gpu.position} of the diagonal`);
    assert(gpu.normal < 0.5, `normals differ by ${gpu.normal} degrees`);
    await page.screenshot({ path: `${web}gpu-${basename(archive(index), ".fbk")}.png` });
    assert(gpu.covered > 1000 && gpu.differing < 0.002, "the pictures differ");
  }
  assert.deepEqual(errors.filter((text) => !text.includes("404")), []);
} finally {
  await browser.close();
  server.close();
}
