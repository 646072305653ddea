// Poses over time: a list that is played, saved as a clip and opened again. Run by test.sh.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { test } from "node:test";
import { openPage, picture, settings, settle, start, violations } from "./browser.mjs";

const { browser, server } = await start(settings.face);

const values = (page) => page.evaluate(() => [...globalThis.facebakerViewer.viewer.pose.values]);
const frames = (page) => page.evaluate(() => globalThis.facebakerViewer.viewer.keyframes.all.map(({ frame }) => frame));
const button = (page, name) => page.getByRole("button", { name, exact: true });

/** Adds so many random poses by key; returns their values. */
async function addPoses(page, count) {
  const poses = [];
  for (let i = 0; i < count; ++i) {
    await page.locator("#canvas").focus();
    await page.keyboard.press("x");
    await page.keyboard.press("k");
    poses.push(await values(page));
  }
  return poses;
}

async function save(page, name, path) {
  const started = page.waitForEvent("download");
  await button(page, name).click();
  const file = await started;
  await file.saveAs(path);
  return file.suggestedFilename();
}

/** The pose that is shown at a frame of the clip. */
const at = (page, frame) => page.evaluate((frame) => {
  const { viewer } = globalThis.facebakerViewer;
  viewer.player.seek(frame);
  return [...viewer.pose.values];
}, frame);

test("poses are added, moved, set and removed", async () => {
  const { page, errors, close } = await openPage(browser, server.address);
  const poses = await addPoses(page, 3);
  await page.getByText("The pose is added at 1.00 seconds.").waitFor();
  assert.deepEqual(await frames(page), [0, 15, 30]);
  await page.getByRole("tab", { name: "Clips" }).click();
  await page.getByLabel("Time of pose 1, seconds").fill("2");
  await page.keyboard.press("Tab");
  assert.deepEqual(await frames(page), [15, 30, 60]);
  await page.getByLabel("Time of pose 3, seconds").fill("0.5"); // where another one is
  await page.keyboard.press("Tab");
  assert.deepEqual(await frames(page), [15, 16, 30]);
  await page.locator(".keyframes .show").nth(1).click();
  assert.deepEqual(await values(page), poses[0]);
  await page.keyboard.press("Control+z");
  assert.deepEqual(await values(page), poses[2], "to show one is a step");
  await button(page, "Set pose 1 to what is shown").click();
  await page.locator(".keyframes .show").first().click();
  assert.deepEqual(await values(page), poses[2]);
  await button(page, "Remove pose 2").click();
  assert.deepEqual(await frames(page), [15, 30]);
  for (const [width, dark] of [[1400, false], [390, true]]) {
    await page.setViewportSize({ width, height: 844 });
    if (dark) await page.getByRole("button", { name: "Dark theme" }).click();
    await picture(page, `keyframes_${width}`);
    assert.deepEqual(await violations(page), []);
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "nothing sticks out");
  }
  assert.deepEqual(errors, []);
  await close();
});

test("they are played straight from one to the next, saved as a clip that the tool and the page read, and as a table", async () => {
  const { page, errors, close } = await openPage(browser, server.address);
  const [a, b] = await addPoses(page, 2);
  await page.getByRole("tab", { name: "Clips" }).click();
  await button(page, "Preview").click();
  await page.waitForFunction(() => globalThis.facebakerViewer.viewer.player.frame > 0);
  const check = async () => {
    assert.deepEqual(await at(page, 0), a);
    assert.deepEqual(await at(page, 15), b);
    const middle = await at(page, 5);
    middle.forEach((value, i) => assert.ok(Math.abs(value - (a[i] + (b[i] - a[i]) / 3)) < 1e-6, `control ${i}`));
  };
  await check();

  const clip = `${settings.pictures}/keyframes_saved.npy`;
  const table = `${settings.pictures}/keyframes_saved.csv`;
  assert.match(await save(page, "Save as a clip", clip), /\.clip\.npy$/);
  assert.match(await save(page, "Save the poses", table), /\.keyframes\.csv$/);
  const command = ["pose", settings.face, "--clip", clip, "--frame", "5", "--out", `${settings.pictures}/keyframes_saved.obj`];
  const posed = spawnSync(settings.tool, command, { encoding: "utf8" });
  assert.equal(posed.status, 0, posed.stderr);

  await page.reload();
  await page.waitForFunction(() => globalThis.facebakerViewer?.timing.milliseconds > 0);
  await page.locator("#files").setInputFiles(clip);
  await page.waitForFunction(() => globalThis.facebakerViewer.viewer.player.clip?.name === "keyframes_saved.npy");
  assert.equal(await page.evaluate(() => globalThis.facebakerViewer.viewer.player.clip.frames), 16);
  await check();
  assert.deepEqual(await frames(page), []);
  await page.locator("#files").setInputFiles(table);
  await page.getByText("keyframes_saved.csv: 2 poses are the keyframes now.").waitFor();
  const kept = await page.evaluate(() => globalThis.facebakerViewer.viewer.keyframes.all.map(({ values }) => [...values]));
  assert.deepEqual(kept, [a, b]);
  assert.deepEqual(errors, []);
  await close();
});

test("a table of keyframes that is broken is named with what is wrong", async () => {
  const { page, close } = await openPage(browser, server.address);
  const name = await page.evaluate(() => globalThis.facebakerViewer.viewer.pose.controls[0].name);
  for (const [text, message] of [
    [`seconds,${name}\n0,much\n`, `bad.csv, line 2, column "${name}": "much" is no number`],
    [`seconds,${name}\nsoon,0.5\n`, 'bad.csv, pose 1: "soon" is no time from 0 to 600 seconds'],
    [`seconds,${name}\n-1,0.5\n`, 'bad.csv, pose 1: "-1" is no time from 0 to 600 seconds'],
    [`seconds,${name}\n1,0.5\n1.001,0.5\n`, "bad.csv, pose 2: another pose is at 1.001 seconds, too"],
    ["seconds,nose_of_wax\n1,0.5\n", 'bad.csv: this face has no controls "nose_of_wax"'],
    [`seconds,${name}\n`, "bad.csv: there are no poses below its first line"],
  ]) {
    await page.locator("#files").setInputFiles({ name: "bad.csv", mimeType: "text/csv", buffer: Buffer.from(text) });
    await page.getByRole("alert").filter({ hasText: message }).waitFor();
    await page.getByRole("button", { name: "Close this message" }).first().click();
  }
  assert.deepEqual(await frames(page), []);
  await settle(page);
  await close();
});
