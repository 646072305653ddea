// Opens what a bundler made, in Chromium, and waits for what tests/bundlers/check_face.js reports.
//   check_bundled.js NAME FOLDER                 a folder of static files, under a strict Content-Security-Policy
//   check_bundled.js NAME FOLDER COMMAND...      a server that is started in that folder and prints its address
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { launchChromium } from "./open_chromium.js";
import { serveFolders } from "./serve_folder.js";

async function serve(folder: string, command: readonly string[]): Promise<{ address: string; stop(): void }> {
  if (command.length === 0) {
    const { server, address } = await serveFolders({ "/": `${folder}/` });
    return { address: `${address}/index.html`, stop: () => server.close() };
  }
  const child = spawn(command[0]!, command.slice(1), { cwd: folder, detached: true,
                                                       env: { ...process.env, NO_COLOR: "1", FORCE_COLOR: "0" } });
  const stop = () => { if (child.exitCode === null) process.kill(-child.pid!, "SIGTERM"); };
  let said = "";
  const address = await new Promise<string>((resolve, reject) => {
    const listen = (text: Buffer) => {
      said += String(text);
      const found = /https?:\/\/(localhost|127\.0\.0\.1):\d+/.exec(said.replace(/\x1b\[[0-9;]*m/g, ""));
      if (found) resolve(found[0]);
    };
    child.stdout.on("data", listen);
    child.stderr.on("data", listen);
    child.once("exit", () => reject(new Error(`${command.join(" ")} ended:\n${said}`)));
  });
  return { address, stop };
}

// Icons that there are not, and what React's development server says of Node 20.
const ignored = /404|favicon|does not implement ArrayBuffer\.prototype\.detached/;

interface Reported { vertices?: number; error?: string }

const [name, folder, ...command] = process.argv.slice(2) as [string, string, ...string[]];
const { address, stop } = await serve(folder, command);
const { browser, page, errors } = await launchChromium();
try {
  for (let tried = 0; ; ++tried)
    try {
      await page.goto(address, { timeout: 120_000 });
      break;
    } catch (error) {
      if (tried === 20) throw error;
      await page.waitForTimeout(500); // it says where it is before it is there
    }
  await page.waitForFunction(() => "facebakerResult" in globalThis, undefined, { timeout: 120_000 })
    .catch((error: Error) => { throw new Error([error.message, ...errors].join("\n")); });
  const result: Reported = await page.evaluate(() => (globalThis as unknown as { facebakerResult: Reported }).facebakerResult);
  assert.equal(result.error, undefined, errors.join("\n"));
  assert((result.vertices ?? 0) > 0);
  const server = page.locator("#server");
  if (await server.count()) assert.equal(await server.textContent(), String(result.vertices));
  assert.deepEqual(errors.filter((text) => !ignored.test(text)), []);
  console.log(`${name}: ${result.vertices} vertices, here and in a worker`);
} finally {
  await browser.close();
  stop();
}
