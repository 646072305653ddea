// Facial capture that drives the pose: packets of VMC, as programs for avatars send them. Run by test.sh.
import assert from "node:assert/strict";
import dgram from "node:dgram";
import { test } from "node:test";
import { openPage, picture, settings, settle, start, violations } from "./browser.mjs";

const { browser, server } = await start(settings.face, "--capture", "vmc:0");
const { capture } = await (await fetch(new URL("/view.json", server.address))).json();

function oscText(text) {
  const length = Buffer.byteLength(text);
  return Buffer.concat([Buffer.from(text), Buffer.alloc(4 - (length % 4))]);
}

function floatBytes(value) {
  const bytes = Buffer.alloc(4);
  bytes.writeFloatBE(value);
  return bytes;
}

/** Sends a value of each name as a frame. */
function sendFrame(socket, values) {
  const messages = Object.entries(values).map(([name, value]) =>
    Buffer.concat([oscText("/VMC/Ext/Blend/Val"), oscText(",sf"), oscText(name), floatBytes(value)]));
  messages.push(Buffer.concat([oscText("/VMC/Ext/Blend/Apply"), oscText(",")]));
  for (const message of messages) socket.send(message, capture.port, "127.0.0.1");
}

/** Sends what `frame()` returns from a port of its own, 60 times a second, until the returned function is called. */
function keepSending(frame) {
  const socket = dgram.createSocket("udp4");
  const timer = setInterval(() => sendFrame(socket, frame()), 1000 / 60);
  return () => {
    clearInterval(timer);
    setTimeout(() => socket.close(), 100);
  };
}

/** Two controls that are not beside each other, with values within their ranges. */
const chooseControls = (page) => page.evaluate(() =>
  [0, 5].map((index) => {
    const { name, minimum, maximum, neutral } = globalThis.facebakerViewer.viewer.pose.controls[index];
    return { name, index, value: Math.fround(neutral + 0.625 * (maximum - neutral)), least: minimum };
  }));
const valueOf = (page, index) => page.evaluate((index) => globalThis.facebakerViewer.viewer.pose.values[index], index);
const untilValue = (page, { index }, value) =>
  page.waitForFunction(([index, value]) => globalThis.facebakerViewer.viewer.pose.values[index] === value, [index, Math.fround(value)]);

test("the face and the sliders follow, the line says what comes, and the last pose stays", async () => {
  const { page, errors, close } = await openPage(browser, server.address);
  const line = page.locator("#capture");
  await line.getByText(`VMC: waits for packets on 127.0.0.1, UDP port ${capture.port}`).waitFor();
  await picture(page, "capture_waits");
  const [first, second] = await chooseControls(page);
  await page.evaluate((index) => globalThis.facebakerViewer.viewer.pose.set(index, 1), second.index);
  const edited = await valueOf(page, second.index);
  const stop = keepSending(() => ({ [first.name.toUpperCase()]: first.value, Sorrow: 1, "other <b>": 0.5 }));
  await untilValue(page, first, first.value);
  assert.equal(await valueOf(page, second.index), edited, "what is not captured stays");
  await settle(page);
  const slider = page.getByRole("slider", { name: first.name, exact: true });
  assert.ok(Math.abs(Number(await slider.inputValue()) - first.value) < 0.02, "its slider is there");
  await line.getByText(/^[2-7]\d frames a second$/).waitFor();
  await line.getByText("2 of 3 captured names have no control").click();
  await line.getByText("Sorrow, other <b>").waitFor();
  await picture(page, "capture_drives");
  assert.deepEqual(await violations(page), []);
  stop();
  await line.getByText(/^VMC: no packets for [1-9] s; the last pose stays$/).waitFor();
  assert.equal(await valueOf(page, first.index), first.value);
  for (const [width, height, dark] of [[390, 844, true], [320, 700, false]]) {
    await page.setViewportSize({ width, height });
    await page.emulateMedia({ colorScheme: dark ? "dark" : "light" });
    await picture(page, `capture_silent_${width}`);
    assert.deepEqual(await violations(page), []);
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "nothing sticks out");
  }
  assert.deepEqual(errors, []);
  await close();
});

test("Hold keeps the pose for edits, and a clip pauses for the capture", async () => {
  const { page, errors, close } = await openPage(browser, server.address);
  const [first] = await chooseControls(page);
  let value = first.value;
  const stop = keepSending(() => ({ [first.name]: value }));
  await untilValue(page, first, first.value);
  await page.getByRole("button", { name: "Hold" }).click();
  await page.locator("#capture").getByText("VMC: held").waitFor();
  value = first.least;
  await page.evaluate((index) => globalThis.facebakerViewer.viewer.pose.reset([index]), first.index);
  const edited = await valueOf(page, first.index);
  await new Promise((resolve) => setTimeout(resolve, 300));
  assert.equal(await valueOf(page, first.index), edited);
  value = first.value;
  await page.evaluate(() => {
    const { viewer } = globalThis.facebakerViewer;
    const { face } = viewer.first;
    const controls = Float32Array.from({ length: 9 * face.controlCount }, (_, i) => face.restControls[i % face.controlCount]);
    viewer.openClip({ name: "rest", origin: "test", fps: 1, frames: 9, notes: [], controls });
    viewer.player.toggle();
  });
  await page.getByRole("button", { name: "Hold" }).click();
  await untilValue(page, first, first.value);
  assert.equal(await page.evaluate(() => globalThis.facebakerViewer.viewer.player.playing), false);
  stop();
  assert.deepEqual(errors, []);
  await close();
});

test("a page that is slow asks for one frame at a time, and shows the newest", async () => {
  const slow = () => {
    const { fetch } = globalThis;
    const counts = { asked: 0, open: 0, most: 0 };
    globalThis.captureCounts = counts;
    globalThis.fetch = async (url, options) => {
      if (!String(url).includes("capture.json")) return fetch(url, options);
      counts.asked += 1;
      counts.open += 1;
      counts.most = Math.max(counts.most, counts.open);
      await new Promise((resolve) => setTimeout(resolve, 200));
      const answer = await fetch(url, options);
      counts.open -= 1;
      return answer;
    };
  };
  const { page, close } = await openPage(browser, server.address, { script: slow });
  const [first] = await chooseControls(page);
  let count = 0;
  const stop = keepSending(() => ({ [first.name]: (first.value * ++count) / 1000 }));
  await page.waitForFunction(() => globalThis.captureCounts.asked > 8);
  stop();
  await untilValue(page, first, (first.value * count) / 1000);
  const { most, asked } = await page.evaluate(() => globalThis.captureCounts);
  assert.equal(most, 1);
  assert.ok(count > 2 * asked, `${count} frames, ${asked} asked for`);
  await close();
});
