// A browser and a server for the viewer's tests.
import { spawn } from "node:child_process";
import { mkdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { after } from "node:test";
import { chromium } from "playwright-core";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

process.once("SIGTERM", () => process.exit(1));

export const settings = {
  tool: process.env.FACEBAKER,
  page: process.env.VIEWER_PAGE,
  face: process.env.VIEWER_FACE,
  source: process.env.VIEWER_SOURCE,
  poses: process.env.VIEWER_POSES,
  data: process.env.VIEWER_DATA,
  character: process.env.VIEWER_CHARACTER,
  masked: process.env.VIEWER_MASKED,
  body: process.env.VIEWER_BODY,
  characterPoses: process.env.VIEWER_CHARACTER_POSES,
  jaw: process.env.VIEWER_JAW,
  jawSource: process.env.VIEWER_JAW_SOURCE,
  jawPoses: process.env.VIEWER_JAW_POSES,
  reports: process.env.VIEWER_REPORTS,
  rights: process.env.VIEWER_RIGHTS,
  pictures: process.env.VIEWER_PICTURES,
};

export function launch() {
  mkdirSync(settings.pictures, { recursive: true });
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
      "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
  });
}

/** `facebaker view` with these arguments, until stop(). */
export async function view(...arguments_) {
  const child = spawn(settings.tool, ["view", "--no-open", "--port", "0", "--page", settings.page, ...arguments_],
    { stdio: ["ignore", "pipe", "inherit"] });
  const address = await new Promise((resolve, reject) => {
    child.stdout.once("data", (text) => resolve(String(text).trim()));
    child.once("exit", (code) => reject(new Error(`facebaker view ended with ${code}`)));
  });
  process.once("exit", () => child.kill("SIGKILL")); // where a test leaves it running
  const ended = new Promise((resolve) => child.once("exit", resolve));
  return { address, stop: () => (child.kill("SIGINT"), ended) };
}

/** Chromium and `facebaker view` with these arguments, until all tests of the file have run. */
export async function start(...arguments_) {
  const [browser, server] = await Promise.all([launch(), view(...arguments_)]);
  after(async () => {
    await browser.close();
    await server.stop();
  });
  return { browser, server };
}

/** A page of that size, in which `script` runs first; whatever it logs as an error ends up in `errors`. */
export async function openPage(browser, address, { width = 1280, height = 800, dark = false, ready = true, script } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: dark ? "dark" : "light" });
  await context.grantPermissions(["clipboard-read", "clipboard-write"]);
  if (script) await context.addInitScript(script);
  const page = await context.newPage();
  const errors = [];
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  page.on("pageerror", (error) => errors.push(String(error)));
  await page.goto(address);
  if (ready) await page.waitForFunction(() => globalThis.facebakerViewer?.timing.milliseconds > 0);
  return { page, errors, close: () => context.close() };
}

/** Where the vertex is seen that a control moves the farthest. */
export function placeOf(page, control) {
  return page.evaluate((control) => {
    const { viewer, dragging } = globalThis.facebakerViewer;
    const { face, object } = viewer.first;
    const index = face.findControl(control);
    const pose = viewer.pose.rest.slice();
    pose[index] = viewer.pose.controls[index].maximum;
    const moved = face.evaluate(pose);
    const shown = face.evaluate(viewer.pose.values);
    const move = (v) => Math.hypot(...[0, 1, 2].map((axis) => moved[3 * v + axis] - face.restPositions[3 * v + axis]));
    let farthest = 0;
    for (let v = 1; v < face.vertexCount; ++v) if (move(v) > move(farthest)) farthest = v;
    const { x, y } = dragging.rays.placeOf([...shown.subarray(3 * farthest, 3 * farthest + 3)], object.toScene);
    const { left, top } = viewer.stage.canvas.getBoundingClientRect();
    return { x: x + left, y: y + top };
  }, control);
}

/** Waits until what was asked for is on the screen. */
export async function settle(page) {
  await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(resolve)))));
}

export async function picture(page, name) {
  await settle(page);
  await page.screenshot({ path: `${settings.pictures}/${name}.png` });
}

/** Pictures of a whole page, from the top: in one, Chromium repeats the first 8,192 rows below them. */
export async function fullPicture(page, name) {
  const { width, height } = await page.evaluate(() => ({ width: innerWidth, height: document.documentElement.scrollHeight }));
  for (let y = 0, part = 1; y < height; y += 8000, ++part)
    await page.screenshot({ path: `${settings.pictures}/${name}${part > 1 ? `_${part}` : ""}.png`, fullPage: true,
      clip: { x: 0, y, width, height: Math.min(8000, height - y) } });
}

/** The share of the pixels of a page's picture that have about that colour. */
export async function shareOf(page, colour) {
  const png = (await page.screenshot()).toString("base64");
  return page.evaluate(async ([png, colour]) => {
    const image = await createImageBitmap(new Blob([Uint8Array.from(atob(png), (c) => c.charCodeAt(0))], { type: "image/png" }));
    const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) count += colour.every((value, c) => Math.abs(data[i + c] - value) < 60) ? 1 : 0;
    return (4 * count) / data.length;
  }, [png, colour]);
}

/** What axe finds, a line each. */
export async function violations(page) {
  await page.evaluate(axe);
  const found = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
  return found.violations.flatMap(({ id, nodes }) => nodes.map(({ html, failureSummary }) => `${id}: ${html.slice(0, 160)} ${failureSummary}`));
}
