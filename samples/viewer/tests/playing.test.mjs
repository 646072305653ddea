// Clips over time: playing them, and their errors as a curve. Run by test.sh.
import assert from "node:assert/strict";
import { test } from "node:test";
import { openPage, picture, settings, settle, start, violations } from "./browser.mjs";

const { browser, server } = await start(settings.face, "--beside", settings.source);

const player = (page) => page.evaluate(() => {
  const { frame, playing, loop, speed, clip } = globalThis.facebakerViewer.viewer.player;
  return { frame, playing, loop, speed, frames: clip.frames, fps: clip.fps };
});
const playing = (page, yes) => page.waitForFunction((yes) => globalThis.facebakerViewer.viewer.player.playing === yes, yes);

/** Opens the first clip by its button, as a user does; resolves when its errors are measured. */
async function openClip(page) {
  await page.getByRole("tab", { name: "Clips" }).click();
  await page.locator("#clips .clips button").first().click();
  await page.waitForFunction(() => {
    const { curve } = globalThis.facebakerViewer.viewer;
    return curve.measured > 0 && !curve.measuring;
  });
}

test("Space plays and pauses, also after a click on a button and on a slider", async () => {
  const { page, errors, close } = await openPage(browser, server.address);
  await openClip(page);
  await page.keyboard.press("Space");
  await playing(page, true);
  await page.keyboard.press("Space");
  await playing(page, false);
  await page.getByRole("radio", { name: "Normals" }).click();
  await page.keyboard.press("Space");
  await playing(page, true);
  await page.getByRole("radio", { name: "Wireframe" }).click();
  await page.keyboard.press("Space");
  await playing(page, false);
  assert.equal(await page.evaluate(() => globalThis.facebakerViewer.viewer.mode), "wireframe");
  await page.getByLabel("Frame", { exact: true }).focus();
  await page.keyboard.press("Space");
  await playing(page, true);
  assert.deepEqual(errors, []);
  await close();
});

test("a clip is played slower and faster, and again or once", async () => {
  const { page, close } = await openPage(browser, server.address);
  await openClip(page);
  // The frame after so many milliseconds, by the page's own clock.
  const frameAfter = (milliseconds) => page.evaluate((milliseconds) => {
    const { player } = globalThis.facebakerViewer.viewer;
    player.seek(0);
    player.toggle();
    player.advance(performance.now() + milliseconds);
    player.pause();
    return player.frame;
  }, milliseconds);
  const { frames, fps, loop } = await player(page);
  assert.ok(loop);
  for (const speed of [0.25, 0.5, 1, 2]) {
    await page.getByLabel("Speed").selectOption(`${speed}×`);
    const frame = await frameAfter(400);
    assert.ok(Math.abs(frame - 0.4 * speed * fps) < 1.5, `at speed ${speed} it is at frame ${frame}`);
  }
  const long = ((frames + 5) / (2 * fps)) * 1000; // once through, and a bit
  assert.ok((await frameAfter(long)) < 8);
  await page.getByRole("button", { name: "Loop" }).click();
  assert.equal(await frameAfter(long), frames - 1, "it stays at its end");
  assert.equal((await player(page)).playing, false);
  await page.keyboard.press("Space");
  assert.ok((await player(page)).frame < frames - 1, "it begins again");
  await page.keyboard.press("l");
  assert.equal((await player(page)).loop, true);
  await close();
});

test("an edit pauses the clip and stays", async () => {
  const { page, close } = await openPage(browser, server.address);
  await openClip(page);
  await page.keyboard.press("Space");
  await playing(page, true);
  const set = await page.evaluate(() => {
    const { pose } = globalThis.facebakerViewer.viewer;
    pose.set(3, pose.controls[3].maximum);
    return pose.values[3];
  });
  await playing(page, false);
  await settle(page);
  assert.equal(await page.evaluate(() => globalThis.facebakerViewer.viewer.pose.values[3]), set);
  await close();
});

/** The largest error of each frame of the clip, by posing and the true positions alone. */
const largestErrors = (page) => page.evaluate(async () => {
  const { viewer } = globalThis.facebakerViewer;
  const { face } = viewer.first;
  const { clip } = viewer.player;
  const points = await clip.reference();
  const width = clip.controls.length / clip.frames;
  return Array.from({ length: clip.frames }, (_, frame) => {
    const posed = face.evaluate(clip.controls.slice(frame * width, (frame + 1) * width));
    let largest = 0;
    for (let i = 0; i < posed.length; i += 3)
      largest = Math.max(largest, Math.hypot(...[0, 1, 2].map((axis) => posed[i + axis] - points[frame * posed.length + i + axis])));
    return largest;
  });
});

test("the curve has each frame's largest error, a click goes to the frame, and the button to the worst ones", async () => {
  const { page, errors, close } = await openPage(browser, server.address);
  await openClip(page);
  const expected = await largestErrors(page);
  const curve = await page.evaluate(() => [...globalThis.facebakerViewer.viewer.curve.largest]);
  assert.equal(curve.length, expected.length);
  expected.forEach((error, frame) => assert.ok(Math.abs(curve[frame] - error) < 1e-5 * error, `frame ${frame}: ${curve[frame]}, not ${error}`));
  const worst = expected.indexOf(Math.max(...expected));

  const box = await page.locator(".curve").boundingBox();
  await page.mouse.click(box.x + 0.5 * box.width, box.y + 0.7 * box.height);
  assert.ok(Math.abs((await player(page)).frame - 0.5 * (expected.length - 1)) <= 1);
  const units = await page.evaluate(() => globalThis.facebakerViewer.viewer.first.face.units);
  const millimetres = Number((expected[worst] * { m: 1000, cm: 10, mm: 1 }[units]).toPrecision(3));
  assert.match(await page.locator(".curve p").textContent(), new RegExp(`worst ${millimetres} mm`.replace(".", "\\.")));
  assert.match(await page.locator(".curve").getAttribute("aria-label"), new RegExp(`at frame ${worst + 1}\\.`));

  await page.getByRole("button", { name: "Next worst" }).click();
  assert.equal((await player(page)).frame, worst);
  await page.keyboard.press("w");
  const second = (await player(page)).frame;
  assert.ok(second !== worst && expected[second] <= expected[worst] && Math.abs(second - worst) > 3, `frame ${second} after ${worst}`);
  const apart = expected.filter((_, frame) => Math.abs(frame - worst) > 8);
  assert.ok(expected[second] >= Math.max(...apart), "no frame far from the worst is worse");

  await page.getByRole("radio", { name: "Error", exact: true }).click();
  await settle(page);
  const shown = await page.evaluate(() => globalThis.facebakerViewer.viewer.errors.max);
  assert.ok(Math.abs(shown - expected[second]) < 1e-5 * shown);
  for (const [width, height, dark] of [[1400, 900, false], [390, 844, false], [390, 844, true], [1400, 900, true]]) {
    await page.setViewportSize({ width, height });
    await page.emulateMedia({ colorScheme: dark ? "dark" : "light" });
    if (await page.evaluate((dark) => (document.documentElement.dataset.theme === "dark") !== dark, dark))
      await page.getByRole("button", { name: "Dark theme" }).click();
    await picture(page, `curve_${width}_${dark ? "dark" : "light"}`);
    assert.deepEqual(await violations(page), []);
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "nothing sticks out");
  }
  await page.setViewportSize({ width: 320, height: 700 });
  await settle(page);
  const outside = await page.evaluate(() => {
    const bar = document.getElementById("player").getBoundingClientRect();
    const frame = document.querySelector("#player output");
    if (frame.scrollWidth > frame.clientWidth) return ["the frame's number is cut"];
    return [...document.querySelectorAll("#player *")].map((part) => [part.className || part.tagName, part.getBoundingClientRect()])
      .filter(([, box]) => box.width > 0 && (box.left < bar.left || box.right > bar.right)).map(([name]) => String(name));
  });
  assert.deepEqual(outside, [], "the player's parts are in its bar");
  await picture(page, "curve_320");
  assert.deepEqual(errors, []);
  await close();
});

test("the page goes on while a long clip is measured, and another clip takes its place", async () => {
  const { page, errors, close } = await openPage(browser, server.address);
  const result = await page.evaluate(async () => {
    const { viewer } = globalThis.facebakerViewer;
    const { face } = viewer.first;
    const frames = 600;
    const points = new Float32Array(frames * 3 * face.vertexCount);
    const clip = { name: "long", origin: "test", fps: 30, frames, notes: [], reference: async () => points,
                   controls: Float32Array.from({ length: frames * face.controlCount }, (_, i) => face.restControls[i % face.controlCount]) };
    viewer.openClip(clip);
    let turns = 0;
    while (viewer.curve.measured < frames) {
      await new Promise((resolve) => setTimeout(resolve));
      ++turns;
    }
    viewer.openClip(clip);
    await clip.reference();
    await new Promise((resolve) => setTimeout(resolve));
    const begun = viewer.curve.measured;
    viewer.openClip(null);
    await new Promise((resolve) => setTimeout(resolve, 100));
    return { turns, begun, after: viewer.curve.measured };
  });
  assert.ok(result.turns > 5, JSON.stringify(result));
  assert.ok(result.begun > 0 && result.after === 0, JSON.stringify(result));
  assert.deepEqual(errors, []);
  await close();
});

test("a clip without true positions has no curve", async () => {
  const { page, close } = await openPage(browser, server.address);
  await page.evaluate(() => {
    const { viewer } = globalThis.facebakerViewer;
    viewer.openClip({ ...viewer.clips[0], reference: undefined });
  });
  await page.getByRole("button", { name: "Play" }).waitFor();
  await settle(page);
  assert.ok(await page.locator(".curve").isHidden());
  // Its frames are measured as they are shown, where a live rig is beside the face.
  if (await page.evaluate(() => globalThis.facebakerViewer.viewer.truth.live)) {
    await page.getByRole("radio", { name: "Error", exact: true }).click();
    await page.waitForFunction(() => globalThis.facebakerViewer.viewer.curve.measured === 1);
    await settle(page);
    assert.ok(await page.locator(".curve").isVisible());
  }
  await close();
});
