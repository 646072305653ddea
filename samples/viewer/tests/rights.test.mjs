// What binds of the rights of a face is said, an end that is past at first sight. Run by test.sh.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { openPage, picture, settings, start, view, violations } from "./browser.mjs";

const { browser, server } = await start(settings.face);

/** The face with these rights. */
function withRights(folder, name, rights) {
  const about = join(folder, "about.json"), out = join(folder, `${name}.fbk`);
  writeFileSync(about, JSON.stringify({ rights }));
  const packed = spawnSync(settings.tool, ["pack", settings.face, "--about", about, "--out", out], { encoding: "utf8" });
  assert.equal(packed.status, 0, packed.stderr);
  return out;
}

const shown = (page) => page.locator("#rights");

test("reads rights as the tool does", async () => {
  const { page, errors, close } = await openPage(browser, server.address);
  const cases = JSON.parse(readFileSync(settings.rights, "utf8"));
  assert.ok(cases.length > 30);
  const found = await page.evaluate((all) => all.map(({ about, on }) => globalThis.facebakerViewer.readRights(about, on)), cases);
  for (const [i, { what, about, expired, binding }] of cases.entries())
    assert.deepEqual(found[i], { expired, binding }, `${what}: ${about}`);
  assert.deepEqual(errors, []);
  await close();
});

test("says nothing of a face whose rights bind to nothing", async () => {
  const { page, close } = await openPage(browser, server.address);
  assert.ok(await shown(page).isHidden());
  await page.getByRole("tab", { name: "About" }).click();
  assert.equal(await page.getByText("What binds of its rights").count(), 0);
  await close();
});

test("says that a face was made without learning", async (t) => {
  const folder = mkdtempSync(join(tmpdir(), "facebaker-learned-"));
  t.after(() => rmSync(folder, { recursive: true }));
  const out = join(folder, "linear.fbk");
  const baked = spawnSync(settings.tool, ["bake", settings.source, "--recipe", "linear", "--poses", "60", "--no-thumbnail", "--out", out], { encoding: "utf8" });
  assert.equal(baked.status, 0, baked.stderr);
  const alone = await view(out);
  t.after(alone.stop);
  const { page, errors, close } = await openPage(browser, alone.address);
  await page.getByRole("tab", { name: "About" }).click();
  assert.equal(await page.locator("#about dt", { hasText: /^Learned$/ }).locator("+ dd").textContent(), "no");
  assert.deepEqual(errors, []);
  await close();
});

test("shows that rights have ended, and what else binds, of each face", async (t) => {
  const folder = mkdtempSync(join(tmpdir(), "facebaker-rights-"));
  t.after(() => rmSync(folder, { recursive: true }));
  const ended = withRights(folder, "ended", {
    expires: "2020-02-29", learning: "forbidden", uses: "test renders", suspendable: "yes", consent_state: "https://ada.example/state",
  });
  const alone = await view(ended);
  t.after(alone.stop);
  for (const [size, shape] of [[{ width: 1280, height: 800 }, "wide"], [{ width: 390, height: 844 }, "narrow"]])
    for (const dark of [false, true]) {
      const { page, errors, close } = await openPage(browser, alone.address, { ...size, dark });
      const end = shown(page).getByText("expired: the rights ended on 2020-02-29");
      assert.ok(await end.isVisible());
      assert.ok(await shown(page).getByText("permitted uses: test renders").isHidden());
      await shown(page).getByText("3 rights bind").click();
      for (const clause of ["learning from it is forbidden (learning: forbidden)", "permitted uses: test renders",
        "the consent can be suspended; its state is asked at: https://ada.example/state"])
        assert.ok(await shown(page).getByText(clause, { exact: true }).isVisible(), clause);
      await page.getByRole("tab", { name: "About" }).click();
      assert.equal(await page.locator("#about .binding li").first().textContent(), "expired: the rights ended on 2020-02-29");
      await picture(page, `rights_${shape}_${dark ? "dark" : "light"}`);
      assert.deepEqual(await violations(page), []);
      assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "nothing sticks out");
      assert.deepEqual(errors, []);
      await close();
    }
  const both = await view(ended, withRights(folder, "mined", { data_mining: "notAllowed" }));
  t.after(both.stop);
  const { page, close } = await openPage(browser, both.address);
  await page.waitForFunction(() => globalThis.facebakerViewer.viewer.faces.length === 2);
  assert.equal(await shown(page).locator(".expired").count(), 1);
  assert.match(await shown(page).textContent(), /: expired: the rights ended.*: 3 rights bind.*: 1 right binds/);
  await close();
});
