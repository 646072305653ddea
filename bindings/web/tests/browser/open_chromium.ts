// Headless Chromium on a page of the tests.
import { basename, dirname } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium, type Browser, type Page } from "playwright-core";
import { serveFolders } from "./serve_folder.js";

/** The folder of the package. */
export const web = fileURLToPath(new URL("../../", import.meta.url));

export interface OpenPage {
  page: Page;
  /** Calls a function of in_page.ts. */
  call<Result>(name: string, ...values: (string | number)[]): Promise<Result>;
  /** Messages of errors so far. */
  errors: string[];
  close(): Promise<void>;
}

/** For WebGPU by SwiftShader. */
export const webGpuFlags: readonly string[] = [
  "--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--enable-features=Vulkan", "--use-vulkan=swiftshader",
  "--disable-gpu-watchdog"];

/** A page of its own, and the messages of errors so far. */
export async function launchChromium(flags: readonly string[] = []): Promise<{ browser: Browser; page: Page; errors: string[] }> {
  const browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: [
    "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader", ...flags] });
  const page = await browser.newPage({ viewport: { width: 500, height: 500 } });
  const errors: string[] = [];
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("console", (message) => { if (message.type() === "error") errors.push(message.text()); });
  return { browser, page, errors };
}

/** `files`: by the address they are served at, beside the package. */
export async function openChromium(files: Record<string, string>,
                                   start = "/tests-built/browser/page.html",
                                   flags: readonly string[] = []): Promise<OpenPage> {
  const folders: Record<string, string> = { "/": web };
  for (const [address, file] of Object.entries(files)) folders[`${dirname(address)}/`] = `${dirname(file)}/`;
  const { server, address } = await serveFolders(folders);
  const { browser, page, errors } = await launchChromium(flags);
  await page.goto(address + start);
  if (start.startsWith("/tests")) await page.waitForFunction("globalThis.facebakerTests");
  return {
    page, errors,
    call: (name, ...values) =>
      page.evaluate(`facebakerTests.${name}(${values.map((value) => JSON.stringify(value)).join(", ")})`),
    close: async () => {
      await browser.close();
      server.close();
    },
  };
}

/** Where a file is served that `openChromium` is given as `/NAME/FILE`. */
export const addressOf = (name: string, file: string): string => `/${name}/${basename(file)}`;
