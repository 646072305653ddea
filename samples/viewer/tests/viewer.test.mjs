// The viewer in Chromium. Run by test.sh, which says by the environment what with.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { test } from "node:test";
import { openPage, picture, settings, settle, shareOf, start, view, violations } from "./browser.mjs";

const SLOWEST_FACE = 1000; // milliseconds
const POSES = 256;

const { browser, server } = await start(settings.face, "--beside", settings.source);

const controlsOf = (page) => page.evaluate(() => [...globalThis.facebakerViewer.viewer.pose.values]);
const mode = (page, name) => page.getByRole("radio", { name, exact: true }).click();

test("shows the face within a second of the page's start, without an error", async () => {
  const times = [];
  for (let run = 0; run < 5; ++run) {
    const { page, errors, close } = await openPage(browser, server.address);
    times.push(await page.evaluate(() => globalThis.facebakerViewer.timing.milliseconds));
    assert.deepEqual(errors, []);
    await close();
  }
  times.sort((a, b) => a - b);
  console.log(`first face on the screen after ${times.map(Math.round).join(", ")} ms`);
  if (!process.env.VIEWER_UNTIMED) assert.ok(times[0] < SLOWEST_FACE, `${times[0]} ms`);
});

test("moves a control by the keyboard, its mirror image with it, and resets it", async () => {
  const { page, close } = await openPage(browser, server.address);
  const before = await page.evaluate(() => {
    const { viewer } = globalThis.facebakerViewer;
    const index = viewer.pose.partners.findIndex((partner) => partner >= 0);
    return { index, partner: viewer.pose.partners[index], name: viewer.pose.controls[index].name };
  });
  assert.ok(before.index >= 0, "the face has pairs");
  await page.getByLabel("Search controls").fill(before.name);
  await page.getByRole("button", { name: "Mirror" }).click();
  const slider = page.getByLabel(before.name, { exact: true });
  await slider.focus();
  for (let press = 0; press < 10; ++press) await page.keyboard.press("ArrowRight");
  await settle(page);
  const moved = await controlsOf(page);
  const rest = await page.evaluate(() => [...globalThis.facebakerViewer.viewer.pose.rest]);
  assert.ok(moved[before.index] > rest[before.index]);
  assert.equal(moved[before.partner], moved[before.index]);
  assert.equal(moved.filter((value, i) => value !== rest[i]).length, 2);
  await page.getByRole("button", { name: `Reset ${before.name}`, exact: true }).click();
  await page.getByRole("button", { name: "Reset all" }).click();
  assert.deepEqual(await controlsOf(page), rest);
  await close();
});

/** A face alone, and its poses by the native library. */
async function compareBits(t, face, poses) {
  const alone = await view(face);
  t.after(alone.stop);
  const { page, errors, close } = await openPage(browser, alone.address);
  await mode(page, "Wireframe");
  for (const part of ["controls", "positions"])
    await page.route(`**/poses/${part}`, (route) => route.fulfill({ body: readFileSync(`${poses}.${part}`) }));
  const result = await page.evaluate(async () => {
    const [controls, expected] = await Promise.all(["controls", "positions"].map(async (part) =>
      new Uint32Array(await (await fetch(`/poses/${part}`)).arrayBuffer())));
    const { viewer } = globalThis.facebakerViewer;
    const { face, object } = viewer.first;
    const values = new Float32Array(controls.buffer);
    const [width, size] = [face.controlCount, 3 * face.vertexCount];
    const count = controls.length / width;
    const wrong = [];
    let moved = 0;
    for (let pose = 0; pose < count; ++pose) {
      viewer.pose.assign(values.subarray(pose * width, (pose + 1) * width));
      viewer.stage.beforeDraw(performance.now()); // poses; to draw them all by software takes half a minute
      const shown = new Uint32Array(object.analysis.positions.buffer);
      for (const mesh of face.meshes)
        for (let i = 3 * mesh.firstVertex; i < 3 * (mesh.firstVertex + mesh.vertexCount); ++i)
          if (shown[i] !== expected[pose * size + i]) {
            wrong.push(`pose ${pose}, mesh "${mesh.name}", number ${i}`);
            break;
          }
      if (object.analysis.positions.some((x, i) => x !== face.restPositions[i])) ++moved;
    }
    return { count, wrong: wrong.slice(0, 5), moved };
  });
  assert.deepEqual({ ...result, moved: result.moved > POSES / 3 }, { count: POSES, wrong: [], moved: true });
  await mode(page, "Shaded");
  await settle(page);
  assert.deepEqual(errors, []);
  await close();
}

test("random poses have the native bits", (t) => compareBits(t, settings.face, settings.poses));
test("random poses of a character of several meshes have the native bits", (t) => compareBits(t, settings.character, settings.characterPoses));

test("random poses of a face with driven joints have the native bits", (t) =>
  compareBits(t, settings.jaw, settings.jawPoses));

test("a face with driven joints is posed, played and measured as any other", async (t) => {
  const { address, stop } = await view(settings.jaw, "--beside", settings.jawSource, "--joints", "controls");
  t.after(stop);
  const { page, errors, close } = await openPage(browser, address);
  const slider = page.getByLabel("jaw.rx", { exact: true });
  await slider.focus();
  await page.keyboard.press("End");
  for (const look of ["Wireframe", "Normals", "Shaded", "Error"]) {
    await mode(page, look);
    await picture(page, `jaw_${look.toLowerCase()}`);
  }
  const measured = () => page.evaluate(() => {
    const { viewer } = globalThis.facebakerViewer;
    const { face, object } = viewer.first;
    const numbers = () => new Float32Array(3 * face.vertexCount);
    const before = face.evaluateInto(viewer.pose.values, { positions: numbers(), unskinned: true }).positions;
    const largest = (from) => Math.max(...object.analysis.positions.map((x, i) => Math.abs(x - from[i])));
    return { joints: face.drivenJoints.map(({ name }) => name), error: viewer.errors.max / face.diagonal,
             moved: largest(before) / face.diagonal, frame: viewer.player.frame };
  });
  await page.waitForFunction(() => globalThis.facebakerViewer.viewer.errors?.max > 0);
  const posed = await measured();
  assert.deepEqual(posed.joints, ["jaw"]);
  assert.ok(posed.moved > 0.1 && posed.error < 1e-4, JSON.stringify(posed));

  await page.getByRole("tab", { name: "Clips" }).click();
  await page.locator("#clips .clips button").first().click();
  await page.getByLabel("Frame", { exact: true }).fill("10");
  await settle(page);
  await page.waitForFunction(() => globalThis.facebakerViewer.viewer.errors?.max > 0);
  const played = await measured();
  assert.ok(played.frame === 10 && played.moved > 0.05 && played.error < 1e-4, JSON.stringify(played));
  await page.getByRole("tab", { name: "About" }).click();
  await page.getByText("Driven joints").waitFor();
  assert.deepEqual(errors, []);
  await close();
});

test("draws a face with an alpha-masked texture as soon as its picture is there, untouched", async (t) => {
  const alone = await view(settings.masked);
  t.after(alone.stop);
  const { page, errors, close } = await openPage(browser, alone.address, { script: () => {
    // Pictures come later than everything else.
    const { set, ...rest } = Object.getOwnPropertyDescriptor(HTMLImageElement.prototype, "src");
    Object.defineProperty(HTMLImageElement.prototype, "src", { ...rest, set(address) {
      setTimeout(() => {
        set.call(this, address);
        this.decode().then(() => { globalThis.pictureCame = true; });
      }, 2000);
    } });
  } });
  await page.waitForFunction(() => globalThis.pictureCame);
  await settle(page);
  await picture(page, "masked");
  const share = await shareOf(page, [255, 0, 200]);
  assert.ok(share > 0.005, `its colour has ${share} of the picture`);
  assert.deepEqual(errors, []);
  await close();
});

test("says what is wrong with a broken file, and keeps the face", async () => {
  const { page, close } = await openPage(browser, server.address);
  const bytes = readFileSync(settings.face);
  const chooser = page.locator("#files");
  await chooser.setInputFiles({ name: "cut.fbk", mimeType: "", buffer: bytes.subarray(0, bytes.length - 1000) });
  await page.getByRole("button", { name: "In place of it" }).click();
  const message = page.getByRole("alert");
  await message.waitFor();
  assert.match(await message.textContent(), /cut\.fbk: .{10}/);
  await chooser.setInputFiles({ name: "notes.npy", mimeType: "", buffer: Buffer.from("no numbers") });
  await page.getByText("notes.npy: this is no NumPy file").waitFor();
  assert.equal(await page.evaluate(() => globalThis.facebakerViewer.viewer.faces.length), 1);
  await close();
});

test("plays and scrubs a clip beside the face, with its error", async () => {
  const { page, errors, close } = await openPage(browser, server.address);
  await page.getByRole("tab", { name: "Clips" }).click();
  await page.locator("#clips .clips button").first().click();
  await page.getByRole("button", { name: "Play" }).click();
  await page.waitForFunction(() => globalThis.facebakerViewer.viewer.player.frame > 2);
  await page.getByRole("button", { name: "Pause" }).click();
  await mode(page, "Error");
  await page.getByLabel("Frame", { exact: true }).fill("2");
  await settle(page);
  await page.waitForFunction(() => globalThis.facebakerViewer.viewer.errors?.max > 0);
  const { shown, truth } = await page.evaluate(() => {
    const { viewer } = globalThis.facebakerViewer;
    const [posed, truth] = [viewer.first.object.analysis.positions, viewer.truePositions()];
    let largest = 0;
    for (let v = 0; v < posed.length; v += 3)
      largest = Math.max(largest, Math.hypot(posed[v] - truth[v], posed[v + 1] - truth[v + 1], posed[v + 2] - truth[v + 2]));
    return { shown: viewer.errors.max, truth: largest };
  });
  assert.ok(Math.abs(shown - truth) < 1e-6 * truth);
  assert.match(await page.locator("#legend").textContent(), /Worst vertex off by [\d.e-]+ mm \([\d.e-]+ D\) (at|in .*,) vertex/);
  await picture(page, "error");
  if (await page.evaluate(() => globalThis.facebakerViewer.viewer.truth.live)) {
    await page.evaluate(() => {
      const { pose } = globalThis.facebakerViewer.viewer;
      pose.reset();
      pose.set(3, pose.controls[3].maximum);
    });
    await page.waitForFunction(() => globalThis.facebakerViewer.viewer.errors?.max > 0);
  }
  assert.deepEqual(errors, []);
  await close();
});

test("opens a dataset folder, and measures against its points", { skip: !settings.data }, async () => {
  const { page, errors, close } = await openPage(browser, server.address);
  await page.locator("input[webkitdirectory]").setInputFiles(settings.data);
  await page.waitForFunction(() => globalThis.facebakerViewer.viewer.player.clip?.origin.startsWith("dataset"));
  await page.evaluate(() => globalThis.facebakerViewer.viewer.player.seek(1));
  await mode(page, "Error");
  await page.waitForFunction(() => globalThis.facebakerViewer.viewer.errors?.max > 0);
  const worst = await page.evaluate(() => globalThis.facebakerViewer.viewer.errors.max / globalThis.facebakerViewer.viewer.first.face.diagonal);
  assert.ok(worst < 0.2, `${worst} of the diagonal`);
  assert.deepEqual(errors, []);
  await close();
});

test("reads a take of Live Link Face", async () => {
  const { page, close } = await openPage(browser, server.address);
  const name = await page.evaluate(() => globalThis.facebakerViewer.viewer.pose.controls[3].name);
  const rows = Array.from({ length: 31 }, (_, i) => `10:00:0${Math.floor(i / 30)}:${String(i % 30).padStart(2, "0")}.5,61,${i / 60}`);
  const csv = [`Timecode,BlendshapeCount,${name}`, ...rows].join("\n");
  await page.locator("#files").setInputFiles({ name: "take.csv", mimeType: "text/csv", buffer: Buffer.from(csv) });
  await page.waitForFunction(() => globalThis.facebakerViewer.viewer.player.clip?.name === "take.csv");
  const clip = await page.evaluate(() => {
    const { clip } = globalThis.facebakerViewer.viewer.player;
    return { fps: clip.fps, frames: clip.frames, value: clip.controls[15 * (clip.controls.length / clip.frames) + 3] };
  });
  assert.deepEqual(clip, { fps: 30, frames: 31, value: 0.25 });
  await close();
});

test("a link carries pose, mode and camera", async () => {
  const { page, close } = await openPage(browser, server.address);
  const set = await page.evaluate(() => {
    const { viewer } = globalThis.facebakerViewer;
    viewer.pose.assign(viewer.pose.controls.map(({ minimum, maximum, neutral }, i) =>
      i % 7 === 0 ? minimum + (maximum - minimum) * Math.random() : neutral));
    viewer.mode = "normals";
    viewer.stage.turn(3, 1);
    return [...viewer.pose.values];
  });
  await page.getByRole("button", { name: "Share pose" }).click();
  const address = await page.evaluate(() => navigator.clipboard.readText());
  const camera = await page.evaluate(() => globalThis.facebakerViewer.viewer.stage.view);
  await close();
  assert.doesNotMatch(address, /token/);
  const other = await openPage(browser, address);
  await other.page.waitForFunction(() => globalThis.facebakerViewer.viewer.mode === "normals");
  assert.deepEqual(await controlsOf(other.page), set);
  const seen = await other.page.evaluate(() => globalThis.facebakerViewer.viewer.stage.view);
  camera.forEach((x, i) => assert.ok(Math.abs(x - seen[i]) < 0.01));
  await other.close();
});

test("without the token in its address it shows the face, and says what runs no rig", async () => {
  const { page, close } = await openPage(browser, new URL("/", server.address).href);
  await page.getByRole("tab", { name: "Clips" }).click();
  await page.locator("#clips .clips button").first().click();
  await page.getByText(/takes the token in the address/).first().waitFor();
  await page.getByText("The true positions could not be read.").waitFor();
  await close();
});

test("a link of a page of elsewhere opens it; a frame, a picture and a script of one do not", async (t) => {
  const here = new URL("/", server.address).href;
  const elsewhere = createServer((_, answer) => answer.writeHead(200, { "Content-Type": "text/html" }).end(
    `<iframe src="${here}index.html"></iframe><img src="${here}icon.svg"><script src="${here}view.json"></script><a href="${here}">the viewer</a>`));
  await new Promise((resolve) => elsewhere.listen(0, "127.0.0.1", resolve));
  t.after(() => elsewhere.close());
  const { page, close } = await openPage(browser, "about:blank", { ready: false });
  const answers = new Map();
  page.on("response", (answer) => answers.set(answer.url(), answer.status()));
  page.on("requestfailed", (request) => answers.set(request.url(), "kept from the page"));
  await page.goto(`http://localhost:${elsewhere.address().port}/`);
  const asked = ["icon.svg", "index.html", "view.json"].map((name) => here + name);
  for (const address of asked) assert.ok([403, "kept from the page"].includes(answers.get(address)), `${address}: ${answers.get(address)}`);
  assert.equal(await page.evaluate(() => document.images[0].naturalWidth), 0);
  await page.getByText("the viewer").click();
  await page.waitForFunction(() => globalThis.facebakerViewer?.timing.milliseconds > 0);
  await close();
});

test("shows two archives side by side, and their difference", async (t) => {
  const two = await view(settings.face, settings.face);
  t.after(two.stop);
  const { page, errors, close } = await openPage(browser, two.address);
  await page.waitForFunction(() => globalThis.facebakerViewer.viewer.faces.length === 2);
  await mode(page, "Difference");
  await page.evaluate(() => {
    const { pose } = globalThis.facebakerViewer.viewer;
    pose.set(3, pose.controls[3].maximum);
  });
  await settle(page);
  assert.equal(await page.evaluate(() => globalThis.facebakerViewer.viewer.errors.max), 0);
  assert.deepEqual(errors, []);
  await mode(page, "Shaded");
  await picture(page, "side_by_side");
  await close();
});

test("bars do not lie on each other at any width", async () => {
  const { page, close } = await openPage(browser, server.address);
  for (const width of [1600, 1280, 1000, 800, 600, 390, 320]) {
    await page.setViewportSize({ width, height: 700 });
    const boxes = await page.evaluate(() =>
      ["shows", "cameras", "stats"].map((id) => document.getElementById(id)).filter((bar) => !bar.hidden)
        .map((bar) => [bar.id, ...["left", "right", "top", "bottom"].map((side) => bar.getBoundingClientRect()[side])]));
    for (const [a, ...first] of boxes)
      for (const [b, ...other] of boxes)
        if (a < b)
          assert.ok(first[0] >= other[1] || other[0] >= first[1] || first[2] >= other[3] || other[2] >= first[3], `${a} and ${b} at ${width}`);
  }
  await close();
});

for (const [name, size] of [["wide", { width: 1280, height: 800 }], ["narrow", { width: 390, height: 844 }]])
  for (const dark of [false, true])
    test(`is accessible: ${name}, ${dark ? "dark" : "light"}`, async () => {
      const { page, close } = await openPage(browser, server.address, { ...size, dark });
      const label = `${name}_${dark ? "dark" : "light"}`;
      await page.waitForFunction(() => globalThis.facebakerViewer.viewer.clips.length > 0); // which come after the face
      await page.evaluate(() => {
        const { viewer } = globalThis.facebakerViewer;
        const frames = viewer.clips[0];
        const width = viewer.pose.values.length;
        viewer.pose.assign(frames.controls.subarray(Math.floor(frames.frames / 2) * width, (Math.floor(frames.frames / 2) + 1) * width));
      });
      await picture(page, label);
      assert.deepEqual(await violations(page), []);
      assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "nothing sticks out");
      for (const look of ["Expected error", "Regions", "Wireframe"]) {
        const button = page.getByRole("radio", { name: look, exact: true });
        if (await button.isDisabled()) continue;
        await button.click();
        await picture(page, `${label}_${look.toLowerCase().replace(" ", "_")}`);
        assert.deepEqual(await violations(page), [], look);
      }
      for (const tab of ["Clips", "About"]) {
        await page.getByRole("tab", { name: tab }).click();
        if (tab === "Clips") await page.locator("#clips .clips button").first().click();
        await picture(page, `${label}_${tab.toLowerCase()}`);
        assert.deepEqual(await violations(page), [], tab);
      }
      await page.getByRole("button", { name: "Keys and mouse" }).click();
      await picture(page, `${label}_keys`);
      assert.deepEqual(await violations(page), [], "keys");
      await close();
    });

test("greets where the face that is asked for is not there", async () => {
  const { page, close } = await openPage(browser, new URL("/?face=none.fbk", server.address).href, { ready: false });
  await page.getByRole("heading", { name: "This face cannot be shown" }).waitFor();
  assert.match(await page.getByRole("alert").textContent(), /none\.fbk/);
  await picture(page, "welcome");
  assert.deepEqual(await violations(page), []);
  await close();
});
