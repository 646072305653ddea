// A web server of some folders, with a Content-Security-Policy as strict as docs/browser.md says is possible.
import { createReadStream, statSync } from "node:fs";
import { createServer, type Server } from "node:http";
import type { AddressInfo } from "node:net";
import { extname, normalize } from "node:path";

const types: Record<string, string> = {
  ".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm",
};

// 'sha256-...' of an import map would do in place of 'unsafe-inline'; nothing of the package needs it.
const strictPolicy = "default-src 'self'; script-src 'self' 'unsafe-inline' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; img-src 'self' blob:; worker-src 'self'";

/** `files`: where addresses that begin so are. */
export async function serveFolders(files: Record<string, string>, policy = strictPolicy): Promise<{ server: Server; address: string }> {
  const server = createServer((request, answer) => {
    const path = normalize(decodeURIComponent(new URL(request.url ?? "/", "http://x").pathname));
    const prefix = Object.keys(files).filter((known) => path.startsWith(known)).sort((a, b) => b.length - a.length)[0];
    const file = prefix === undefined ? "" : files[prefix] + path.slice(prefix.length);
    const info = file ? statSync(file, { throwIfNoEntry: false }) : undefined;
    if (!info?.isFile()) {
      answer.writeHead(404).end();
      return;
    }
    answer.writeHead(200, { "Content-Type": types[extname(file)] ?? "application/octet-stream",
                            "Content-Length": info.size, "Content-Security-Policy": policy });
    createReadStream(file).pipe(answer);
  });
  await new Promise<void>((resolve) => server.listen(0, "127.0.0.1", resolve));
  return { server, address: `http://127.0.0.1:${(server.address() as AddressInfo).port}` };
}
