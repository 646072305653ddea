// What run_chromium.ts calls in the page.
import { FaceBakerError, hasSimd, load } from "facebaker";
import { load as loadInWorker } from "facebaker/worker";
import { readExpectedPoses } from "../expected_poses.js";
import { checkSameBits } from "../same_bits_checks.js";
import { evaluateOnGpu } from "./gpu_evaluator_page.js";
import { drawOnGpu } from "./gpu_page.js";

const expectedOf = async (dump: string) => readExpectedPoses(await (await fetch(dump)).arrayBuffer());

/** Compares 256 poses, with SIMD and without. */
async function sameBits(archive: string, dump: string): Promise<string> {
  const expected = await expectedOf(dump), said: string[] = [];
  for (const simd of [true, false]) {
    const face = await load(archive, { simd });
    said.push(checkSameBits(face, expected));
    face.dispose();
  }
  return said.join("; ");
}

async function inWorker(archive: string): Promise<string> {
  const loaded: number[] = [];
  const face = await load(archive), far = await loadInWorker(archive, { progress: (bytes) => loaded.push(bytes) });
  const controls = face.createPose().fill(0.5);
  const here = face.evaluate(controls), there = await far.evaluate(controls);
  if (here.some((value, i) => value !== there[i])) throw new Error("the worker gives other positions");
  if (loaded.length === 0) throw new Error("no progress");
  await far.dispose();
  face.dispose();
  return `${here.length / 3} vertices`;
}

async function refuses(archive: string): Promise<string> {
  try {
    await load(archive);
  } catch (error) {
    if (error instanceof FaceBakerError) return `${error.statusName}: ${error.message}`;
    throw error;
  }
  throw new Error("a broken archive was loaded");
}

/** Microseconds a pose by the clock, median over rounds and the quickest round; the poses of the dump. */
async function time(archive: string, dump: string): Promise<Record<"all" | "fifth" | "load" | "again", number> &
                                                           { quickest: { all: number; fifth: number } }> {
  const began = performance.now();
  (await load(archive)).dispose();
  const there = performance.now(), face = await load(archive), loaded = performance.now();
  const { controls, poses } = await expectedOf(dump);
  const n = face.controlCount, positions = new Float32Array(3 * face.vertexCount);
  const measure = (first: number) => {
    const times: number[] = [];
    for (let round = 0; round < 31; ++round) {
      const begin = performance.now();
      for (let p = first; p < poses; p += 2) face.evaluate(controls.subarray(p * n, p * n + n), positions);
      times.push((1000 * (performance.now() - begin)) / (poses / 2));
    }
    times.sort((a, b) => a - b);
    return { median: times[15]!, quickest: times[0]! };
  };
  measure(0);
  const all = measure(0), fifth = measure(1);
  const result = { all: all.median, fifth: fifth.median, quickest: { all: all.quickest, fifth: fifth.quickest }, load: there - began, again: loaded - there };
  face.dispose();
  return result;
}

Object.assign(globalThis, { facebakerTests: { sameBits, inWorker, refuses, time, drawOnGpu, evaluateOnGpu, hasSimd } });
