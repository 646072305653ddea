// Points of the face that are dragged, while controls follow. Run by test.sh.
import assert from "node:assert/strict";
import { test } from "node:test";
import { openPage, picture, placeOf, settings, settle, start, violations } from "./browser.mjs";

const { browser, server } = await start(settings.face);

const values = (page) => page.evaluate(() => [...globalThis.facebakerViewer.viewer.pose.values]);
const camera = (page) => page.evaluate(() => globalThis.facebakerViewer.viewer.stage.view);
/** Waits until the camera is at rest. */
async function still(page) {
  for (let before = ""; ; ) {
    await settle(page);
    const view = String(await camera(page));
    if (view === before) return;
    before = view;
    await page.waitForTimeout(100);
  }
}

const button = (page, name) => page.getByRole("button", { name, exact: true });

/** Switches dragging on and waits for the solver. */
async function drag(page) {
  await button(page, "Drag points").click();
  await page.waitForFunction(() => !globalThis.facebakerViewer.dragging.loading);
  await still(page);
}

/** How far the point that is held is from a place, in pixels. */
const offBy = (page, { x, y }) => page.evaluate(({ x, y }) => {
  const { viewer, dragging } = globalThis.facebakerViewer;
  const { left, top } = viewer.stage.canvas.getBoundingClientRect();
  return Math.hypot(dragging.place.x + left - x, dragging.place.y + top - y);
}, { x, y });

const valueOf = (page, control) => page.evaluate((control) => {
  const { viewer } = globalThis.facebakerViewer;
  return viewer.pose.values[viewer.first.face.findControl(control)];
}, control);

/** Presses at a place and moves by some pixels, in steps; the point stays held. Returns where the pointer is. */
async function pull(page, from, right, down) {
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  const to = { x: from.x + right, y: from.y + down };
  await page.mouse.move(to.x, to.y, { steps: 6 });
  await settle(page);
  return to;
}

test("the corner of the mouth is dragged up: the smile rises, the point follows the pointer, and undo has the very bits", async () => {
  const { page, errors, close } = await openPage(browser, server.address);
  const asked = [];
  page.on("request", (request) => asked.push(request.url()));
  await button(page, "Face").click(); // from the front
  await page.keyboard.press("x"); // some other pose
  await page.keyboard.press("r");
  const before = await values(page);
  await still(page);
  const from = await placeOf(page, "smile_L");
  assert.ok(!asked.some((url) => /solve/.test(url)), "nothing of the solver is loaded before");
  await drag(page);
  await page.getByLabel("Search controls").fill("smile_L"); // opens its group
  assert.ok(asked.some((url) => /facebaker_solve.*\.wasm/.test(url)));
  const to = await pull(page, from, 6, -16);
  assert.ok((await offBy(page, to)) < 3, `${await offBy(page, to)} pixels`);
  assert.ok((await valueOf(page, "smile_L")) > 0.2, `smile_L ${await valueOf(page, "smile_L")}`);
  assert.match(await page.locator("#pose [role=status].hint").textContent(), /^A point is held; \d+ controls follow\.$/);
  await picture(page, "dragging");
  const times = await page.evaluate(() => globalThis.facebakerViewer.dragging.milliseconds);
  console.log(`a solve: ${times.toFixed(1)} ms`);
  await page.mouse.up();
  const dragged = await values(page);
  const slider = await page.getByLabel("smile_L", { exact: true }).inputValue();
  assert.equal(Math.fround(Number(slider)), await valueOf(page, "smile_L"), "the slider follows");
  await page.keyboard.press("Control+z");
  assert.deepEqual(await values(page), before);
  assert.ok(await page.evaluate(() => globalThis.facebakerViewer.viewer.pose.history.canUndo), "the steps before are still there");
  await page.keyboard.press("Control+Shift+z");
  assert.deepEqual(await values(page), dragged);
  assert.deepEqual(errors, []);
  await close();
});

test("a chin that is pulled down opens the jaw, and a brow is lifted by its own control", async () => {
  const { page, close } = await openPage(browser, server.address);
  await button(page, "Face").click();
  await drag(page);
  for (const [control, pixels, most] of [["jaw_open", 20, 8], ["brow_inner_L", -8, 3]]) {
    await page.keyboard.press("r");
    await still(page);
    const to = await pull(page, await placeOf(page, control), 0, pixels);
    assert.ok((await offBy(page, to)) < 3, `${control}: off by ${await offBy(page, to)}`);
    await page.mouse.up();
    const moved = await page.evaluate(() => globalThis.facebakerViewer.viewer.pose.movedCount());
    assert.ok((await valueOf(page, control)) > 0.1 && moved <= most, `${control}: ${await valueOf(page, control)}, ${moved} moved`);
  }
  await close();
});

test("both sides follow where left and right are linked", async () => {
  const { page, close } = await openPage(browser, server.address);
  await button(page, "Face").click();
  await drag(page);
  await button(page, "Mirror").click();
  const to = await pull(page, await placeOf(page, "smile_L"), 5, -14);
  assert.ok((await offBy(page, to)) < 3);
  await page.mouse.up();
  const [left, right] = [await valueOf(page, "smile_L"), await valueOf(page, "smile_R")];
  assert.ok(left > 0.2 && Math.abs(left - right) < 0.1, `${left} and ${right}`);
  await close();
});

test("beside the face the pointer turns it; a face that is let go is one step; keys drag, too", async () => {
  const { page, close } = await openPage(browser, server.address);
  await button(page, "Face").click();
  await drag(page);
  const at = await camera(page);
  await pull(page, { x: 60, y: 500 }, 80, 0);
  await page.mouse.up();
  assert.notDeepEqual(await camera(page), at, "it is turned");
  await still(page);
  await button(page, "Face").click();
  await still(page);
  const rest = await values(page);
  await page.locator("#canvas").focus();
  await still(page);
  await page.keyboard.press("Enter");
  const held = await camera(page);
  for (let i = 0; i < 4; ++i) await page.keyboard.press("ArrowDown");
  await settle(page);
  (await camera(page)).forEach((x, i) => assert.ok(Math.abs(x - held[i]) < 1e-9, "arrows do not turn it")); // but for rounding
  assert.notDeepEqual(await values(page), rest);
  await page.keyboard.press("Escape");
  assert.deepEqual(await values(page), rest, "Escape takes it back");
  assert.ok(!(await page.evaluate(() => globalThis.facebakerViewer.viewer.pose.history.canUndo)));
  await page.keyboard.press("Enter");
  await page.keyboard.press("Shift+ArrowUp");
  await page.keyboard.press("Enter");
  assert.notDeepEqual(await values(page), rest);
  await page.keyboard.press("Control+z");
  assert.deepEqual(await values(page), rest);
  await page.keyboard.press("ArrowLeft");
  await settle(page);
  const turned = (await camera(page)).some((x, i) => Math.abs(x - held[i]) > 1e-3);
  assert.ok(turned, "arrows turn it when nothing is held");
  await page.locator("#canvas").press("d");
  assert.equal(await button(page, "Drag points").getAttribute("aria-pressed"), "false");
  await close();
});

test("only controls of open groups follow, where that is asked for", async () => {
  const { page, close } = await openPage(browser, server.address);
  await button(page, "Face").click();
  await drag(page);
  await button(page, "Open groups only").click();
  const groups = await page.evaluate(() => {
    const { viewer } = globalThis.facebakerViewer;
    const group = (name) => viewer.pose.controls[viewer.first.face.findControl(name)].group;
    return { smile: group("smile_L"), brow: group("brow_inner_L") };
  });
  const openOnly = (name) => page.evaluate((name) => {
    for (const details of document.querySelectorAll("#pose details.group"))
      details.open = details.querySelector("summary").firstChild.textContent === name;
  }, name);
  const from = await placeOf(page, "smile_L");
  await openOnly(groups.brow);
  await pull(page, from, 0, -14);
  await page.getByText("No control of the open groups moves this point.").waitFor();
  await page.mouse.up();
  await openOnly(groups.smile);
  await pull(page, from, 0, -14);
  await page.mouse.up();
  const moved = await page.evaluate(() => {
    const { pose } = globalThis.facebakerViewer.viewer;
    return [...new Set(pose.controls.filter(({ index }) => !pose.isAtRest(index)).map(({ group }) => group))];
  });
  assert.deepEqual(moved, [groups.smile]);
  for (const [width, dark] of [[1400, false], [390, true]]) {
    await page.setViewportSize({ width, height: 844 });
    if (dark) await page.getByRole("button", { name: "Dark theme" }).click();
    await picture(page, `dragging_${width}`);
    assert.deepEqual(await violations(page), []);
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "nothing sticks out");
  }
  await close();
});

test("another face is dragged by a solver of its own", async () => {
  const { page, errors, close } = await openPage(browser, server.address);
  await drag(page);
  await page.locator("#files").setInputFiles(settings.body);
  await button(page, "In place of it").click();
  await page.waitForFunction((count) => globalThis.facebakerViewer.viewer.pose.values.length === count, 2);
  await page.waitForFunction(() => !globalThis.facebakerViewer.dragging.loading);
  await still(page);
  const { x, y, width, height } = await page.locator("#canvas").boundingBox();
  await pull(page, { x: x + width / 2, y: y + height / 2 }, 0, -20);
  await page.mouse.up();
  assert.ok((await values(page)).some((value) => value !== 0));
  assert.deepEqual(errors, []);
  await close();
});
