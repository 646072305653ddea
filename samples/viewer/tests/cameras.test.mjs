// Where the viewer looks from. Run by test.sh.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { launch, openPage, picture, settings, settle, view } from "./browser.mjs";

let browser;
before(async () => {
  browser = await launch();
});
after(() => browser?.close());

/** Where the corners of boxes are in the picture, -1 to 1 from edge to edge: of what moves, and of all of the face. */
const seen = (page) => page.evaluate(() => {
  const { viewer } = globalThis.facebakerViewer;
  const { object } = viewer.first;
  const { camera } = viewer.stage;
  camera.updateMatrixWorld();
  const all = object.moving.clone().makeEmpty().expandByObject(object);
  const height = (box) => {
    const [low, high] = [box.min.clone().project(camera).y, box.max.clone().project(camera).y];
    return { low, high };
  };
  const direction = camera.getWorldDirection(object.position.clone()).toArray();
  return { moving: height(object.moving.clone().translate(object.position)), all: height(all), direction };
});

test("of a body it shows at first what moves; Fit shows the whole, and Face what moves again, from the front", async (t) => {
  const { address, stop } = await view(settings.body);
  t.after(stop);
  const { page, errors, close } = await openPage(browser, address);
  const check = async (what) => {
    const { moving, all, direction } = await seen(page);
    assert.ok(moving.low > -1 && moving.high < 1 && moving.high - moving.low > 0.8, `${what}: ${JSON.stringify(moving)}`);
    assert.ok(all.low < -3, `${what}: ${JSON.stringify(all)}`);
    assert.ok(direction[2] < -0.999, `${what}: ${direction}`);
  };
  await check("at first");
  await picture(page, "camera_face");
  await page.getByRole("button", { name: "Fit the face into the picture" }).click();
  await settle(page);
  const { moving, all } = await seen(page);
  assert.ok(all.low > -1 && all.high < 1 && moving.high - moving.low < 0.4, JSON.stringify(all));
  await page.getByRole("button", { name: "Side", exact: true }).click();
  await page.getByRole("button", { name: "Face", exact: true }).click();
  await settle(page);
  await check("by the button");
  await page.keyboard.press("Home");
  await page.locator("#canvas").focus();
  await page.keyboard.press("f");
  await settle(page);
  await check("by the key");
  assert.deepEqual(errors, []);
  await close();
});

test("a head, of which much moves, is shown as a whole at first", async (t) => {
  const { address, stop } = await view(settings.face);
  t.after(stop);
  const { page, close } = await openPage(browser, address);
  const { all } = await seen(page);
  assert.ok(all.low > -1 && all.high < 1, JSON.stringify(all));
  await page.getByRole("button", { name: "Face", exact: true }).click();
  await picture(page, "camera_face_of_head");
  const { moving } = await seen(page);
  assert.ok(moving.low > -1 && moving.high < 1, JSON.stringify(moving));
  await close();
});
