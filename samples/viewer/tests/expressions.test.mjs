// Poses with names, and values as text. Run by test.sh.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { openPage, picture, settings, settle, start, view, violations } from "./browser.mjs";

const { browser, server } = await start(settings.face);

const values = (page) => page.evaluate(() => [...globalThis.facebakerViewer.viewer.pose.values]);
const randomise = (page) => page.keyboard.press("x");
const table = (name, text) => ({ name, mimeType: "text/csv", buffer: Buffer.from(text) });
const names = (page) => page.evaluate(() => globalThis.facebakerViewer.viewer.expressions.all.map(({ name }) => name));

async function keep(page, name) {
  await randomise(page);
  await page.locator("#canvas").focus();
  await page.keyboard.press("e");
  await page.keyboard.type(name);
  await page.keyboard.press("Enter");
  return values(page);
}

/** Saves the list and gives the file's text. */
async function save(page, path) {
  const started = page.waitForEvent("download");
  await page.getByRole("button", { name: "Save as a file" }).click();
  const file = await started;
  await file.saveAs(path);
  return file.suggestedFilename();
}

test("expressions are kept, shown, saved and opened again, with the very values", async () => {
  const { page, errors, close } = await openPage(browser, server.address);
  const smile = await keep(page, "smile");
  await page.locator("#canvas").focus();
  const other = await keep(page, "smile"); // a name that is taken
  assert.deepEqual(await names(page), ["smile", "smile 2"]);
  await page.locator(".expressions .show").first().click();
  assert.deepEqual(await values(page), smile);
  await page.keyboard.press("Control+z");
  assert.deepEqual(await values(page), other, "to show one is a step");
  const path = `${settings.pictures}/expressions.csv`;
  assert.match(await save(page, path), /\.expressions\.csv$/);
  await page.getByRole("button", { name: "Remove smile", exact: true }).click();
  assert.deepEqual(await names(page), ["smile 2"]);
  await page.locator("#files").setInputFiles(path);
  await page.getByText("expressions.csv: 1 expression is new in the list.").waitFor();
  assert.deepEqual(await names(page), ["smile 2", "smile"]);
  const all = await page.evaluate(() => globalThis.facebakerViewer.viewer.expressions.all.map(({ values }) => [...values]));
  assert.deepEqual(all, [other, smile]);

  for (const [width, dark] of [[1400, false], [390, true]]) {
    await page.setViewportSize({ width, height: 844 });
    if (dark) await page.getByRole("button", { name: "Dark theme" }).click();
    await picture(page, `expressions_${width}`);
    assert.deepEqual(await violations(page), []);
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "nothing sticks out");
  }
  await page.reload();
  await page.waitForFunction(() => globalThis.facebakerViewer?.timing.milliseconds > 0);
  assert.deepEqual(await names(page), ["smile 2", "smile"], "the browser has kept them");
  await page.getByRole("tab", { name: "Expressions" }).click();
  for (const name of ["smile 2", "smile"]) await page.getByRole("button", { name: `Remove ${name}`, exact: true }).click();
  await page.reload();
  await page.waitForFunction(() => globalThis.facebakerViewer?.timing.milliseconds > 0);
  assert.deepEqual(await names(page), []);
  assert.deepEqual(errors, []);
  await close();
});

test("a file of expressions that is broken is named with the line and the column", async () => {
  const { page, close } = await openPage(browser, server.address);
  const [a, b] = await page.evaluate(() => globalThis.facebakerViewer.viewer.pose.controls.slice(0, 2).map(({ name }) => name));
  const cases = [
    [`expression,${a},${b}\nsmile,0.5,much\n`, `bad.csv, line 2, column "${b}": "much" is no number`],
    [`expression,${a},${b}\nsmile,0.5,0\nfrown,0.1\n`, "bad.csv, line 3: 2 cells where the first line names 3"],
    [`expression,${a},${a}\nsmile,0,0\n`, `bad.csv: two columns are the control "${a}"`],
    ["expression,nose_of_wax\nsmile,0.5\n", 'bad.csv: this face has no controls "nose_of_wax"'],
    [`expression,${a}\n`, "bad.csv: there are no expressions below its first line"],
  ];
  for (const [text, message] of cases) {
    await page.locator("#files").setInputFiles(table("bad.csv", text));
    await page.getByRole("alert").filter({ hasText: message }).waitFor();
    await page.getByRole("button", { name: "Close this message" }).first().click();
  }
  assert.deepEqual(await names(page), []);
  // A spreadsheet of a country with a decimal comma, a control that the face does not have, and a value out of range.
  await page.locator("#files").setInputFiles(table("good.csv", `\ufeff"Expression";"${a}";wax\r\n"a smile";0,25;1\r\nmore;99;1\r\n`));
  await page.getByText('good.csv: this face has no controls "wax"; they are left out.').waitFor();
  await page.getByText("good.csv: 1 value is outside the range of the control, and clamped.").waitFor();
  assert.deepEqual(await names(page), ["a smile", "more"]);
  assert.equal(await page.evaluate(() => globalThis.facebakerViewer.viewer.expressions.all[0].values[0]), 0.25);
  await close();
});

test("the tool bakes a saved file's expressions exactly, and poses by the values that are copied", async (t) => {
  const { address, stop } = await view(settings.body);
  t.after(stop);
  const { page, close } = await openPage(browser, address);
  await page.getByRole("tab", { name: "Expressions" }).click();
  for (const set of [[0.3, 0.7], [1, 0]]) {
    await page.evaluate((set) => globalThis.facebakerViewer.viewer.pose.assign(set), set);
    await page.getByLabel("Name of this pose").fill("smile");
    await page.getByRole("button", { name: "Keep", exact: true }).click();
  }
  const [path, baked, posed] = ["body.csv", "body_exact.fbk", "body_posed.obj"].map((name) => `${settings.pictures}/${name}`);
  await save(page, path);
  const run = (...command) => {
    const { status, stdout, stderr } = spawnSync("/bin/sh", ["-c", command.join(" ")], { encoding: "utf8" });
    assert.equal(status, 0, stderr);
    return stdout;
  };
  run(settings.tool, "bake", settings.body.replace(/fbk$/, "glb"), "--recipe linear --exact", path, "--out", baked);
  assert.equal(run(settings.tool, "inspect", baked).match(/body\.csv:[01]/g)?.length, 2);

  await page.evaluate(() => globalThis.facebakerViewer.viewer.pose.assign([0.123456789, 0.9]));
  await page.getByRole("button", { name: "Copy values" }).click();
  const options = await page.evaluate(() => navigator.clipboard.readText());
  run(settings.tool, "pose", settings.body, options, "--out", posed);
  const written = readFileSync(posed, "utf8").split("\n").filter((line) => line.startsWith("v ")).flatMap((line) => line.slice(2).split(" ").map(Number));
  const shown = await page.evaluate(() => {
    const { first, pose } = globalThis.facebakerViewer.viewer;
    return [...first.face.evaluate(pose.values)];
  });
  assert.equal(written.length, shown.length);
  written.forEach((x, i) => assert.ok(Math.abs(x - shown[i]) < 1e-6, `number ${i}: ${x}, not ${shown[i]}`));
  await close();
});

test("values are copied and pasted by keys, with the very floats", async () => {
  const { page, errors, close } = await openPage(browser, server.address);
  await randomise(page);
  const set = await values(page);
  await page.locator("#canvas").focus();
  await page.keyboard.press("Control+c");
  await page.getByText("The values are copied").waitFor();
  assert.match(await page.evaluate(() => navigator.clipboard.readText()), /^--set \S+=\S+( --set \S+=\S+)*$/);
  await page.keyboard.press("r");
  assert.notDeepEqual(await values(page), set);
  await page.keyboard.press("Control+v");
  await page.getByText(/as in the text, all others at rest/).waitFor();
  assert.deepEqual(await values(page), set);
  await page.keyboard.press("r");
  await page.keyboard.press("Control+c");
  await page.getByText("All controls are at rest: there is nothing to copy.").waitFor();
  // In a text they are the text's own.
  await page.getByLabel("Search controls").focus();
  await page.keyboard.press("Control+v");
  assert.match(await page.getByLabel("Search controls").inputValue(), /--set/);
  assert.deepEqual(await values(page), await page.evaluate(() => [...globalThis.facebakerViewer.viewer.pose.rest]));
  assert.deepEqual(errors, []);
  await close();
});

test("a text that is pasted is read as lines or as a command; what is wrong with it is said", async () => {
  const { page, close } = await openPage(browser, server.address);
  const [a, b, c] = await page.evaluate(() => globalThis.facebakerViewer.viewer.pose.controls.slice(0, 3).map(({ name }) => name));
  await page.getByRole("tab", { name: "Expressions" }).click();
  await page.getByRole("button", { name: "Paste values…" }).click();
  const text = page.getByRole("dialog").getByRole("textbox");
  const pose = page.getByRole("button", { name: "Pose the face" });
  const wrong = page.getByRole("dialog").getByRole("alert");
  await picture(page, "paste_values");
  assert.deepEqual(await violations(page), []);
  for (const [given, message] of [
    [`${a} = 0.5\n\nnonsense`, 'Line 3: "nonsense" is not NAME = VALUE'],
    [`${a} = half`, `Line 1: "${a}" is to be "half", which is no number`],
    [`facebaker pose face.fbk --set ${a}`, `--set: "${a}" is not NAME = VALUE`],
    ["", "There are no values in it"],
    ["nose_of_wax = 1", 'No value is of this face: there is no control "nose_of_wax"; the closest is '],
  ]) {
    await text.fill(given);
    await pose.click();
    await wrong.filter({ hasText: message }).waitFor();
  }
  await text.fill(`# a smile\n${a} = 0.5\n${b}: 0.25\nnose_of_wax = 1\n`);
  await pose.click();
  await page.getByRole("alert").filter({ hasText: '1 left out: there is no control "nose_of_wax"; the closest is' }).waitFor();
  assert.deepEqual((await values(page)).slice(0, 3), [0.5, 0.25, 0]);
  await page.getByRole("button", { name: "Paste values…" }).click();
  await text.fill(`facebaker pose face.fbk --set '${c}=0.75' \\\n  --set="${a}=1e-1" --out smile.obj`);
  await pose.click();
  await settle(page);
  assert.deepEqual((await values(page)).slice(0, 3), [Math.fround(0.1), 0, 0.75]);
  await close();
});
