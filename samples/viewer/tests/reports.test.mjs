// The tool's report pages in Chromium: narrow, dark, explained, accessible. Run by test.sh.
import assert from "node:assert/strict";
import { readdirSync } from "node:fs";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { fullPicture, launch, openPage, settings, violations } from "./browser.mjs";

let browser;
before(async () => {
  browser = await launch();
});
after(() => browser?.close());

for (const report of readdirSync(settings.reports))
  for (const [name, size] of [["wide", { width: 1280, height: 800 }], ["narrow", { width: 390, height: 844 }]])
    for (const dark of [false, true])
      test(`the report of ${report}: ${name}, ${dark ? "dark" : "light"}`, async () => {
        const address = pathToFileURL(`${settings.reports}/${report}/index.html`).href;
        const { page, close } = await openPage(browser, address, { ...size, dark, ready: false });
        await fullPicture(page, `report_${report}_${name}_${dark ? "dark" : "light"}`);
        assert.deepEqual(await violations(page), []);
        const height = await page.evaluate(() => document.documentElement.scrollHeight);
        const folded = await page.locator("summary").all();
        assert.ok(folded.length > 5, "sections are folded");
        for (const heading of folded) await heading.click();
        await fullPicture(page, `report_${report}_${name}_${dark ? "dark" : "light"}_unfolded`);
        assert.ok((await page.evaluate(() => document.documentElement.scrollHeight)) > 3 * height, "all of it is far longer");
        assert.deepEqual(await violations(page), []);
        assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "nothing sticks out");
        const figure = page.getByRole("button", { name: "rms", exact: true }).first();
        await figure.focus();
        await page.keyboard.press("Enter");
        await page.getByText("Root of the mse: the same as a length, over D.").first().waitFor({ state: "visible" });
        await page.screenshot({ path: `${settings.pictures}/report_${report}_${name}_${dark ? "dark" : "light"}_explained.png` });
        assert.match(await page.locator("pre").first().textContent(), /facebaker view /);
        await close();
      });
