// How long a pose takes: the native library on SSE2, WebAssembly in Node and in Chromium, in the same run; and how large
// the package is. The poses are those of native_poses.c.
//   node bench_face.js ARCHIVE DUMP NATIVE_POSES
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { gzipSync } from "node:zlib";
import { load } from "facebaker";
import { addressOf, openChromium, web } from "./browser/open_chromium.js";
import { readExpectedPoses } from "./expected_poses.js";

type Times = { all: number; fifth: number };

const [archive, dump, native] = process.argv.slice(2) as [string, string, string];

function nativeTimes(instructionSet: string): Times {
  const said = execFileSync(native, ["time", archive, "256"],
                            { env: { ...process.env, FB_INSTRUCTION_SET: instructionSet }, encoding: "utf8" });
  return { all: Number(/all (\S+)/.exec(said)![1]), fifth: Number(/fifth (\S+)/.exec(said)![1]) };
}

async function nodeTimes(simd: boolean): Promise<Times> {
  const face = await load(archive, { simd }), bytes = readFileSync(dump), n = face.controlCount;
  const { controls, poses } = readExpectedPoses(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length) as ArrayBuffer);
  const positions = new Float32Array(3 * face.vertexCount);
  const measure = (first: number) => {
    const times: number[] = [];
    for (let round = 0; round < 31; ++round) {
      const before = process.cpuUsage();
      for (let p = first; p < poses; p += 2) face.evaluate(controls.subarray(p * n, p * n + n), positions);
      const { user, system } = process.cpuUsage(before);
      times.push((user + system) / (poses / 2));
    }
    return times.sort((a, b) => a - b)[15]!;
  };
  measure(0);
  const times = { all: measure(0), fifth: measure(1) };
  face.dispose();
  return times;
}

const row = (name: string, { all, fifth }: Times, base?: Times) =>
  console.log(`${name.padEnd(34)} ${all.toFixed(1).padStart(8)} ${fifth.toFixed(1).padStart(8)}` +
              (base ? `   ${(all / base.all).toFixed(2)} and ${(fifth / base.fifth).toFixed(2)} times SSE2` : ""));

console.log("microseconds of processor time a pose  all    fifth   of the controls moved");
const base = nativeTimes("sse2");
row("native, SSE2", base);
row("WebAssembly SIMD, Node", await nodeTimes(true), base);
row("native, SSE2, again", nativeTimes("sse2"));
row("native, the processor's best", nativeTimes(""), base);
row("WebAssembly without SIMD, Node", await nodeTimes(false), base);
const served = { archive: addressOf("archive", archive), dump: addressOf("expected", dump) };
const { call, close } = await openChromium({ [served.archive]: archive, [served.dump]: dump });
const inPage = await call<Times & { quickest: Times; load: number; again: number }>("time", served.archive, served.dump);
await close();
row("the same in Chromium, by the clock", inPage);
row("quickest of 31 rounds", inPage.quickest, base);
console.log(`loading in Chromium: ${inPage.load.toFixed(0)} ms with the module, ${inPage.again.toFixed(0)} ms once it is there`);

const size = (files: string[]) => files.reduce((sum, file) => sum + gzipSync(readFileSync(`${web}dist/${file}`), { level: 9 }).length, 0);
const glue = ["index", "contents", "errors", "face", "fetch_bytes", "heap", "instance", "load_archive", "model", "platform",
              "polygons", "read_contents", "row_blocks", "staging", "struct_layouts"].map((name) => `${name}.js`);
console.log(`gzip: facebaker.wasm ${size(["facebaker.wasm"])}, its scripts ${size(glue)}, together ` +
            `${size(["facebaker.wasm", ...glue])} bytes; facebaker-scalar.wasm ${size(["facebaker-scalar.wasm"])}`);
