// The page of docs/browser.md, as it is written there.
import assert from "node:assert/strict";
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { openChromium, web } from "./open_chromium.js";

/** Opens the page with a face in place of sample.fbk and takes pictures of it. */
export async function checkDocsPage(docs: string, archive: string): Promise<void> {
  const html = /```html\n([^]*?)```/.exec(readFileSync(docs, "utf8"))![1]!;
  mkdirSync(`${web}docs-page`, { recursive: true });
  writeFileSync(`${web}docs-page/index.html`, html);
  copyFileSync(archive, `${web}docs-page/sample.fbk`);
  const { page, errors, close } = await openChromium({ "/docs-page/facebaker/package.json": `${web}package.json`,
    "/docs-page/three/package.json": `${web}node_modules/three/package.json` }, "/docs-page/index.html");
  try {
    await page.waitForSelector("canvas");
    const pictures = new Set<string>();
    for (let i = 0; i < 4; ++i) {
      await page.waitForTimeout(400);
      pictures.add((await page.screenshot(i === 3 ? { path: `${web}docs-page.png` } : {})).toString("base64"));
    }
    assert(pictures.size > 1, "the face does not move");
    assert.deepEqual(errors.filter((text) => !text.includes("404")), []); // there is no icon
  } finally {
    await close();
  }
}
