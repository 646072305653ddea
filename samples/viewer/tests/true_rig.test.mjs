// The true rig beside the face, and the scale of errors. Run by test.sh.
import assert from "node:assert/strict";
import { test } from "node:test";
import { openPage, picture, settings, settle, start, violations } from "./browser.mjs";

const { browser, server } = await start(settings.jaw, "--beside", settings.jawSource, "--joints", "controls");

const toggle = (page) => page.getByRole("button", { name: "True rig beside" });

/** What the picture has in the place of the true rig, and what it should have. */
const shown = (page) => page.evaluate(() => {
  const { viewer } = globalThis.facebakerViewer;
  const { trueRig, first } = viewer;
  const truth = viewer.truePositions();
  const [drawn, normals] = [trueRig.analysis.positions, trueRig.analysis.normals];
  const own = { positions: new Float32Array(drawn.length), normals: new Float32Array(drawn.length) };
  first.face.evaluateInto(viewer.pose.values, own);
  const farthest = (a, b) => a.reduce((most, x, i) => Math.max(most, Math.abs(x - b[i])), 0);
  return { visible: trueRig.visible, known: truth !== null, off: truth && farthest(drawn, truth), moved: farthest(drawn, first.face.restPositions),
           normals: farthest(normals, own.normals), apart: trueRig.position.x - first.object.position.x };
});

test("the true rig stands beside the face in any pose of a live rig, in every look", async () => {
  const { page, errors, close } = await openPage(browser, server.address);
  await toggle(page).click();
  await page.waitForFunction(() => globalThis.facebakerViewer.viewer.trueRig?.visible);
  await page.getByLabel("jaw.rx", { exact: true }).focus();
  await page.keyboard.press("End");
  await picture(page, "true_rig_shaded");
  for (const look of ["Wireframe", "Normals", "Error"]) {
    await page.getByRole("radio", { name: look, exact: true }).click();
    await page.waitForFunction(() => globalThis.facebakerViewer.viewer.truePositions());
    await settle(page);
    const is = await shown(page);
    assert.ok(is.visible && is.off === 0 && is.moved > 0.1 && is.normals < 1e-3 && is.apart > 0.5, `${look}: ${JSON.stringify(is)}`);
    await picture(page, `true_rig_${look.toLowerCase()}`);
  }
  assert.match(await page.locator("#names").textContent(), /True rig$/);
  assert.deepEqual(await violations(page), []);
  await page.locator("#canvas").focus();
  await page.keyboard.press("t");
  await page.locator("#names").waitFor({ state: "hidden" });
  assert.equal(await page.evaluate(() => globalThis.facebakerViewer.viewer.stage.faces.children.length), 1);
  assert.deepEqual(errors, []);
  await close();
});

test("beside a clip with recorded positions it is there in the clip's frames, says so elsewhere, and goes with the clip", async () => {
  const { page, errors, close } = await openPage(browser, server.address, { width: 390, height: 844, dark: true });
  await page.getByRole("tab", { name: "Clips" }).click();
  await page.locator("#clips .clips button").first().click();
  await page.evaluate(() => {
    const { viewer } = globalThis.facebakerViewer;
    viewer.truth.live = false;
    viewer.modeChanged.emit();
    viewer.player.seek(10);
    viewer.mode = "wireframe";
  });
  await toggle(page).click();
  await page.waitForFunction(() => globalThis.facebakerViewer.viewer.trueRig?.visible);
  const is = await shown(page);
  assert.ok(is.off === 0 && is.moved > 0.05, JSON.stringify(is));
  await page.evaluate(() => globalThis.facebakerViewer.viewer.pose.reset());
  await page.getByText("True rig: not known here").waitFor();
  await picture(page, "true_rig_not_known");
  assert.equal((await shown(page)).visible, false);
  await page.evaluate(() => globalThis.facebakerViewer.viewer.player.seek(5));
  await page.waitForFunction(() => globalThis.facebakerViewer.viewer.trueRig.visible);
  assert.deepEqual(await violations(page), []);
  await page.getByRole("button", { name: "Close the clip" }).click();
  await toggle(page).waitFor({ state: "hidden" });
  assert.equal(await page.evaluate(() => globalThis.facebakerViewer.viewer.trueRigBeside), false);
  assert.deepEqual(errors, []);
  await close();
});

test("the scale of errors ends at 1e-4 of the diagonal at least, so that micrometres are pale", async () => {
  const { page, close } = await openPage(browser, server.address);
  // The end of the scale, and the colour of the worst vertex, where all vertices are as far off, in diagonals.
  const seen = (error) => page.evaluate(async (error) => {
    const { viewer } = globalThis.facebakerViewer;
    const { face, object } = viewer.first;
    viewer.mode = "error";
    viewer.truth.at = (controls) => face.evaluate(controls).map((x, i) => (i % 3 === 0 ? x + error * face.diagonal : x));
    viewer.refresh();
    await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
    const { worst, max } = viewer.errors;
    return { end: viewer.scaleEnd / face.diagonal, max: max / face.diagonal, colour: [...object.analysis.colours.subarray(3 * worst, 3 * worst + 3)] };
  }, error);
  const pale = (await seen(0)).colour;
  const micrometres = await seen(3e-6); // of a head about 1 µm
  assert.ok(Math.abs(micrometres.end - 1e-4) < 1e-9 && Math.abs(micrometres.max - 3e-6) < 1e-6, JSON.stringify(micrometres));
  micrometres.colour.forEach((x, c) => assert.ok(Math.abs(x - pale[c]) < 0.2, `${micrometres.colour}, pale is ${pale}`));
  assert.match(await page.locator("#legend").textContent(), /1\.0e-4 D/);
  const large = await seen(3e-3);
  assert.ok(Math.abs(large.end - 5e-3) < 1e-8, JSON.stringify(large));
  assert.ok(Math.abs(large.colour[1] - pale[1]) > 0.3, `${large.colour}`);
  await page.getByLabel("Scale").selectOption("1.0e-5 D");
  const chosen = await seen(3e-6);
  assert.ok(Math.abs(chosen.end - 1e-5) < 1e-10, "an end that is chosen counts");
  await close();
});
