// Every archive that native_poses.c dumped evaluates to the same bits, with SIMD and without.
//   FB_ARCHIVES: a list of ARCHIVE=DUMP, separated by blanks
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";
import { load } from "facebaker";
import { readExpectedPoses } from "./expected_poses.js";
import { checkSameBits } from "./same_bits_checks.js";

const pairs = (process.env["FB_ARCHIVES"] ?? "").split(" ").filter(Boolean).map((pair) => pair.split("="));
assert(pairs.length > 0, "FB_ARCHIVES names no archives");
let meshes = 0;

for (const [archive, dump] of pairs as [string, string][])
  for (const simd of [true, false])
    test(`${archive.replace(/.*\//, "")} ${simd ? "with SIMD" : "without SIMD"}`, async () => {
      const face = await load(archive, { simd });
      assert.equal(face.instructionSet, simd ? "wasm-simd" : "scalar");
      const bytes = readFileSync(dump);
      const expected = readExpectedPoses(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength) as ArrayBuffer);
      assert(expected.poses >= 256);
      checkSameBits(face, expected);
      meshes = Math.max(meshes, face.meshes.length);
      face.dispose();
    });

test("one of them has several meshes", () => assert(meshes > 1));
