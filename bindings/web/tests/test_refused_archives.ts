// Broken archives fail as in the native library, with its message.
//   FB_REFUSED: a file of lines: archive, tab, status, tab, message
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";
import { FaceBakerError, load } from "facebaker";

const lines = readFileSync(process.env["FB_REFUSED"]!, "utf8").trimEnd().split("\n").map((line) => line.split("\t"));

test("broken archives fail with the native library's message", async () => {
  let refused = 0, offsets = 0;
  for (const [archive, status, message] of lines as [string, string, string][]) {
    const bytes = readFileSync(archive);
    if (status === "0") {
      (await load(bytes)).dispose();
      continue;
    }
    await assert.rejects(load(bytes), (error: unknown) => {
      assert(error instanceof FaceBakerError, archive);
      assert.equal(error.message, message, archive);
      assert.equal(error.status, Number(status), archive);
      return true;
    });
    ++refused;
    if (/byte \d+/.test(message)) ++offsets;
  }
  assert(refused > 100 && offsets > 50, `${refused} refused, ${offsets} of them at a byte`);
});

test("an archive that is cut short names the byte", async () => {
  const whole = readFileSync(lines[0]![0]!.replace(/rejected\/.*/, "accepted/character.fbk"));
  await assert.rejects(load(whole.subarray(0, whole.length - 100)),
                       (error: FaceBakerError) => error.statusName === "FB_ERROR_CORRUPT" && /byte/.test(error.message));
});

test("what is not there fails", async () => {
  await assert.rejects(load("/nowhere/face.fbk"), (error: FaceBakerError) => error.statusName === "FB_ERROR_IO");
});
