// Runs the viewers of docs/web-engines.md in headless Chromium, each with the code of its section.
//   run_viewers.js FOLDER VIEWER... -- ARCHIVE...
// FOLDER has the engines, and this folder as `src` with the examples of that page; an ARCHIVE has its .glb of morph targets
// beside it.
import assert from "node:assert/strict";
import { copyFileSync, mkdirSync, readdirSync, writeFileSync } from "node:fs";
import { basename, dirname } from "node:path";
import { build } from "esbuild";
import { launchChromium, web, webGpuFlags } from "../browser/open_chromium.js";
import { serveFolders } from "../browser/serve_folder.js";
import type { Compared, CompareOptions, PoseDifference } from "./compare_viewer.js";

interface Viewer {
  stage: string;
  /** Of the page's address. */
  query?: string;
  backend: "webgl" | "webgpu";
  /** Modules that it has in place of others. */
  alias?: Record<string, string>;
  /** Shows a .glb in place of the archive. */
  morphTargets?: boolean;
}

const viewers: Record<string, Viewer> = {
  "three-webgl": { stage: "three_webgl_stage.ts", backend: "webgl" },
  "three-webgpu": { stage: "three_webgpu_stage.ts", backend: "webgpu" },
  react: { stage: "react_stage.tsx", backend: "webgl" },
  babylon: { stage: "babylon_stage.ts", backend: "webgl" },
  "babylon-left": { stage: "babylon_stage.ts", query: "?handed=left", backend: "webgl" },
  playcanvas: { stage: "playcanvas_stage.ts", backend: "webgl" },
  aframe: { stage: "aframe_stage.ts", backend: "webgl", alias: { three: "super-three" } },
  "model-viewer": { stage: "model_viewer_stage.ts", backend: "webgl", morphTargets: true,
                    alias: { "@google/model-viewer": "@google/model-viewer/dist/model-viewer.min.js" } }, // with its own three.js
};

// Pictures of both may differ at edges, where what one puts into a matrix the other has in its vertices.
const mostDiffering = 0.005, leastTurned = 0.01, leastCovered = 0.03;

// Loaders of engines fetch the pictures of a .glb from addresses of the page.
const policy = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval' blob:; style-src 'self' 'unsafe-inline'; " +
  "img-src 'self' blob: data:; worker-src 'self' blob:; connect-src 'self' blob: data:";

// Their pictures are no pictures: they get others, but for model-viewer, whose .glb has the archive's own.
const golden = new Set(["character", "body", "driven"]);

// There is no icon; and those pictures.
const ignored = /404|Couldn't load texture/;

async function bundle(folder: string, name: string, viewer: Viewer): Promise<void> {
  await build({ entryPoints: [`${folder}/src/${viewer.stage}`], outfile: `${folder}/www/${name}.js`, bundle: true, format: "esm", jsx: "automatic",
                logLevel: "warning", define: { "process.env.NODE_ENV": '"production"' },
                alias: viewer.alias ?? {} });
  writeFileSync(`${folder}/www/${name}.html`,
                `<!doctype html><meta charset="utf-8"><title>${name}</title><script type="module" src="${name}.js"></script>\n`);
}

function checkPose(what: string, { pose, covered, differing, signTurned, control }: PoseDifference): void {
  assert(covered > leastCovered, `${what}, ${pose}: the face covers ${covered} of the picture`);
  assert(differing < mostDiffering, `${what}, ${pose}: ${differing} of the face's pixels differ`);
  if (signTurned !== null)
    assert(signTurned > leastTurned, `${what}, ${pose}: with the sign of ${control} turned only ${signTurned} of the pixels differ`);
}

function save(folder: string, name: string, { pose, pictures }: PoseDifference): void {
  pictures.forEach((address, index) =>
    writeFileSync(`${folder}/pictures/${name}-${pose}${index === 0 ? "" : "-expected"}.png`, Buffer.from(address.split(",")[1]!, "base64")));
}

async function runViewer(folder: string, name: string, viewer: Viewer, archive: string): Promise<void> {
  const face = basename(archive, ".fbk"), morphTargets = viewer.morphTargets ?? false;
  const { server, address } = await serveFolders({ "/": `${folder}/www/`, "/archives/": `${dirname(archive)}/` }, policy);
  const { browser, page, errors } = await launchChromium(viewer.backend === "webgpu" ? webGpuFlags : []);
  try {
    await page.goto(`${address}/${name}.html${viewer.query ?? ""}`);
    await page.waitForFunction("globalThis.facebakerViewer", undefined, { timeout: 120_000 })
      .catch((error: Error) => { throw new Error([error.message, ...errors].join("\n")); });
    const options: CompareOptions = { archive: `/archives/${basename(archive)}`, morphTargets, dressed: !morphTargets && golden.has(face),
                                      zUp: !morphTargets && face === "driven" };
    const found = await page.evaluate<Compared>(`facebakerViewer(${JSON.stringify(options)})`);
    const what = `${name}, ${face}`;
    for (const pose of found.poses) {
      save(folder, `${name}-${face}`, pose);
      const { pictures: _, ...figures } = pose;
      console.log(`${what}: ${JSON.stringify(figures)}`);
    }
    console.log(`${what}: ${found.materials} materials, ${found.turnedJoints} joints turned, left: ${JSON.stringify(found.after)}`);
    assert.equal(found.backend, viewer.backend);
    for (const pose of found.poses) checkPose(what, pose);
    if (!morphTargets) { // model-viewer keeps its last picture, and files
      assert.equal(found.remains, 0, `${what}: it is drawn on`);
      assert.deepEqual(found.after, found.before, `${what}: not all is freed`);
    }
    assert.deepEqual(errors.filter((text) => !ignored.test(text)), []);
  } finally {
    await browser.close();
    server.close();
  }
}

const [folder, ...rest] = process.argv.slice(2) as [string, ...string[]];
const names = rest.slice(0, rest.indexOf("--")), archives = rest.slice(rest.indexOf("--") + 1);
for (const made of ["www", "pictures"]) mkdirSync(`${folder}/${made}`, { recursive: true });
for (const file of readdirSync(`${web}dist`).filter((file) => file.endsWith(".wasm"))) copyFileSync(`${web}dist/${file}`, `${folder}/www/${file}`);
for (const name of names.length > 0 ? names : Object.keys(viewers)) {
  const viewer = viewers[name];
  if (!viewer) throw new Error(`no viewer "${name}": there are ${Object.keys(viewers).join(", ")}`);
  await bundle(folder, name, viewer);
  for (const archive of archives) await runViewer(folder, name, viewer, archive);
}
