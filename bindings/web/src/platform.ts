// Node has what browsers have but files and its own threads; its modules are named so that no bundler looks for them.
export const isNode: boolean =
  typeof process !== "undefined" && typeof process.versions?.node === "string" && !("document" in globalThis);

interface NodeModules {
  "fs/promises": { readFile(path: string): Promise<Uint8Array> };
  url: { fileURLToPath(url: string): string };
  worker_threads: {
    Worker: new (script: URL | string) => {
      postMessage(message: unknown, transfer?: readonly unknown[]): void;
      on(event: "message" | "error", listener: (value: unknown) => void): void;
      terminate(): Promise<number>;
      unref(): void;
    };
    parentPort: {
      postMessage(message: unknown, transfer?: readonly unknown[]): void;
      on(event: "message", listener: (value: unknown) => void): void;
    } | null;
  };
}

declare const process: { versions?: { node?: string }; getBuiltinModule?(specifier: string): unknown };

/** A module of Node; older than 20.16 it has nothing but `import` for that. */
export async function nodeModule<Name extends keyof NodeModules>(name: Name): Promise<NodeModules[Name]> {
  const specifier = `node:${name}`;
  return (process.getBuiltinModule?.(specifier) ??
          (await import(/* @vite-ignore */ /* webpackIgnore: true */ specifier))) as NodeModules[Name];
}
