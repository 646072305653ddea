// Edits of the pose: undo, random poses. Run by test.sh.
import assert from "node:assert/strict";
import { test } from "node:test";
import { openPage, settings, settle, start } from "./browser.mjs";

const { browser, server } = await start(settings.face);

const values = (page) => page.evaluate(() => [...globalThis.facebakerViewer.viewer.pose.values]);
const rest = (page) => page.evaluate(() => [...globalThis.facebakerViewer.viewer.pose.rest]);
const undo = (page) => page.getByRole("button", { name: "Undo", exact: true });
const redo = (page) => page.getByRole("button", { name: "Redo", exact: true });

test("a drag is undone at once, and done again; by keys and by buttons", async () => {
  const { page, errors, close } = await openPage(browser, server.address);
  const before = await values(page);
  assert.ok(await undo(page).isDisabled() && await redo(page).isDisabled());
  const box = await page.locator("#pose input[type=range]").first().boundingBox();
  const at = (share) => [box.x + share * box.width, box.y + box.height / 2];
  await page.mouse.move(...at(0.1));
  await page.mouse.down();
  for (const share of [0.2, 0.4, 0.6, 0.8]) await page.mouse.move(...at(share));
  await page.mouse.up();
  const dragged = await values(page);
  assert.notDeepEqual(dragged, before);
  await page.keyboard.press("Control+z"); // the slider has the focus
  assert.deepEqual(await values(page), before);
  assert.ok(await undo(page).isDisabled());
  await page.keyboard.press("Control+Shift+z");
  assert.deepEqual(await values(page), dragged);
  await undo(page).click();
  assert.deepEqual(await values(page), before);
  await redo(page).click();
  assert.deepEqual(await values(page), dragged);
  assert.ok(await redo(page).isDisabled());

  await page.getByRole("button", { name: "Reset all" }).click();
  assert.deepEqual(await values(page), await rest(page));
  await undo(page).click();
  assert.deepEqual(await values(page), dragged, "a reset is a step");
  await page.locator("#pose input[type=range]").nth(1).focus();
  await page.keyboard.down("ArrowRight");
  await page.keyboard.down("ArrowRight");
  await page.keyboard.up("ArrowRight");
  await page.keyboard.press("ArrowRight");
  assert.ok(await redo(page).isDisabled(), "what was undone is gone after another edit");
  await page.keyboard.press("Control+z");
  await page.keyboard.press("Control+z");
  assert.deepEqual(await values(page), dragged, "a key is a step until it comes up");
  assert.deepEqual(errors, []);
  await close();
});

test("Ctrl+Z in a text is the text's own; played frames are no steps", async () => {
  const { page, close } = await openPage(browser, server.address);
  await page.keyboard.press("x");
  const random = await values(page);
  await page.getByRole("button", { name: "Keys and mouse" }).click();
  await page.keyboard.press("r");
  assert.deepEqual(await values(page), random, "a dialog has the keys");
  await page.getByRole("button", { name: "Close", exact: true }).click();
  await page.getByLabel("Search controls").fill("jaw");
  await page.keyboard.press("Control+z");
  assert.deepEqual(await values(page), random);
  const steps = await page.evaluate(async () => {
    const { viewer } = globalThis.facebakerViewer;
    const width = viewer.pose.values.length;
    const controls = Float32Array.from({ length: 20 * width }, (_, i) => viewer.pose.rest[i % width]);
    viewer.openClip({ name: "still", origin: "test", fps: 30, frames: 20, controls, notes: [] });
    for (let frame = 0; frame < 20; ++frame) viewer.player.seek(frame);
    let count = 0;
    for (; viewer.pose.history.canUndo; ++count) viewer.pose.undo();
    return count;
  });
  assert.equal(steps, 1);
  await close();
});

test("a random pose moves a few controls of up to three groups; both sides where they are linked", async () => {
  const { page, close } = await openPage(browser, server.address);
  const moved = () => page.evaluate(() => {
    const { pose } = globalThis.facebakerViewer.viewer;
    const indices = [...pose.values.keys()].filter((i) => !pose.isAtRest(i));
    return {
      count: indices.length,
      groups: new Set(indices.map((i) => pose.controls[i].group)).size,
      inside: indices.every((i) => pose.values[i] >= pose.controls[i].minimum && pose.values[i] <= pose.controls[i].maximum),
      single: indices.filter((i) => pose.partners[i] >= 0 && pose.values[pose.partners[i]] !== pose.mirrored(i, pose.partners[i], pose.values[i])).length,
      paired: indices.filter((i) => pose.partners[i] >= 0).length,
    };
  });
  const seen = new Set();
  const button = page.getByRole("button", { name: "Random" });
  for (let i = 0; i < 12; ++i) {
    if (i % 2 === 0) await button.click();
    else await page.keyboard.press("x");
    const pose = await moved();
    assert.ok(pose.count >= 2 && pose.count <= 9 && pose.groups >= 1 && pose.groups <= 3 && pose.inside, JSON.stringify(pose));
    seen.add(String(await values(page)));
  }
  assert.equal(seen.size, 12, "each pose is another one");
  await page.getByRole("button", { name: "Mirror" }).click();
  let paired = 0;
  for (let i = 0; i < 12; ++i) {
    await button.click();
    const pose = await moved();
    assert.equal(pose.single, 0, JSON.stringify(pose));
    paired += pose.paired;
  }
  assert.ok(paired > 0);
  await undo(page).click();
  await settle(page);
  await close();
});
