// What the viewer says while there is no picture. Run by test.sh.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { openPage, picture, settings, settle, shareOf, start, view, violations } from "./browser.mjs";

const { browser, server } = await start(settings.face);

const archive = (name, buffer) => ({ name, mimeType: "", buffer });

test("says that a face is loading until it is there", async () => {
  const { page, errors, close } = await openPage(browser, "about:blank", { ready: false });
  let go;
  const held = new Promise((resolve) => { go = resolve; });
  await page.route("**/*.fbk", async (route) => {
    await held;
    await route.continue();
  });
  await page.goto(server.address);
  await page.getByRole("status").filter({ hasText: "Loading" }).waitFor();
  await picture(page, "start_loading");
  assert.deepEqual(await violations(page), []);
  go();
  await page.waitForFunction(() => globalThis.facebakerViewer?.timing.milliseconds > 0);
  await page.locator("#start").waitFor({ state: "hidden" });
  assert.deepEqual(errors, []);
  await close();
});

test("where there is no face it says how to open one, and opens it", async () => {
  const { page, errors, close } = await openPage(browser, "about:blank", { ready: false });
  await page.route("**/view.json", (route) => route.fulfill({ json: { faces: [] } }));
  await page.goto(server.address);
  await page.getByRole("heading", { name: "Drop a face here" }).waitFor();
  assert.ok(await page.getByRole("button", { name: "Open a file…" }).isVisible());
  await page.locator("#files").setInputFiles(archive("notes.npy", Buffer.from("no numbers")));
  await page.getByText("notes.npy: open a face first, which the clip is of").waitFor();
  assert.ok(await page.getByRole("heading", { name: "Drop a face here" }).isVisible());
  await page.locator("#files").setInputFiles(settings.face);
  await page.waitForFunction(() => globalThis.facebakerViewer.timing.milliseconds > 0);
  await page.locator("#start").waitFor({ state: "hidden" });
  assert.deepEqual(errors, []);
  await close();
});

test("a face that is refused at the start is named with the reason, and another one can be opened", async () => {
  const { page, close } = await openPage(browser, "about:blank", { ready: false });
  const bytes = readFileSync(settings.face);
  await page.route("**/*.fbk", (route) => route.fulfill({ body: bytes.subarray(0, bytes.length - 1000) }));
  await page.goto(server.address);
  await page.getByRole("heading", { name: "This face cannot be shown" }).waitFor();
  assert.match(await page.getByRole("alert").textContent(), /\.fbk: .{10}/);
  await picture(page, "start_refused");
  assert.deepEqual(await violations(page), []);
  await page.locator("#files").setInputFiles(archive("cut.fbk", bytes.subarray(0, 2000)));
  await page.getByRole("alert").filter({ hasText: "cut.fbk" }).waitFor();
  await page.locator("#files").setInputFiles(archive("whole.fbk", bytes));
  await page.locator("#start").waitFor({ state: "hidden" });
  assert.equal(await page.evaluate(() => globalThis.facebakerViewer.viewer.first.name), "whole.fbk");
  await close();
});

test("says so where there is no WebGL", async () => {
  const { page, close } = await openPage(browser, server.address, { ready: false, width: 390, height: 844, script: () => {
    const { getContext } = HTMLCanvasElement.prototype;
    HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
      return kind.startsWith("webgl") ? null : getContext.call(this, kind, ...more);
    };
  } });
  await page.getByRole("heading", { name: "There is no WebGL 2 here" }).waitFor();
  await picture(page, "start_no_webgl");
  assert.deepEqual(await violations(page), []);
  await close();
});

test("says that the graphics card is lost, and draws again when it is back, with the pose", async () => {
  const { page, close } = await openPage(browser, server.address);
  await page.evaluate(() => {
    const { viewer } = globalThis.facebakerViewer;
    viewer.pose.set(3, viewer.pose.controls[3].maximum);
    viewer.mode = "normals";
  });
  await settle(page);
  const colour = [130, 130, 250]; // of what looks at the camera
  const before = await shareOf(page, colour);
  assert.ok(before > 0.01, `its colour has ${before} of the picture`);
  await page.evaluate(() => {
    const context = document.getElementById("canvas").getContext("webgl2");
    globalThis.lostContext = context.getExtension("WEBGL_lose_context");
    globalThis.lostContext.loseContext();
  });
  await page.getByRole("heading", { name: "The picture is gone for now" }).waitFor();
  await picture(page, "start_lost");
  assert.deepEqual(await violations(page), []);
  await page.evaluate(() => globalThis.lostContext.restoreContext());
  await page.locator("#start").waitFor({ state: "hidden" });
  await settle(page);
  const again = await shareOf(page, colour);
  assert.ok(Math.abs(again - before) < 0.2 * before, `${again} of the picture, which was ${before}`);
  await close();
});

test("a page whose graphics card stays lost is opened again with its pose", async () => {
  const { page, close } = await openPage(browser, server.address);
  const set = await page.evaluate(() => {
    const { viewer } = globalThis.facebakerViewer;
    viewer.pose.set(3, viewer.pose.controls[3].maximum);
    document.getElementById("canvas").getContext("webgl2").getExtension("WEBGL_lose_context").loseContext();
    return viewer.pose.values[3];
  });
  const loaded = page.waitForEvent("load");
  await page.getByRole("button", { name: "Reload with this pose" }).click();
  await loaded;
  await page.waitForFunction(() => globalThis.facebakerViewer?.timing.milliseconds > 0);
  assert.equal(await page.evaluate(() => globalThis.facebakerViewer.viewer.pose.values[3]), set);
  await close();
});
