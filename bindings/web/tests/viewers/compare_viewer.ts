// Draws three poses of a face by a viewer's adapter, and the same poses from the processor's positions as .glb files that
// the viewer's own loader reads, and compares pixels; then turns the sign of one control, which has to show; and looks at
// what is left when the face is taken away.
import { Face, load, metresPerUnit, type Material } from "facebaker";
import { dressFaces } from "./dressed_face.js";
import { liveOnGpu, watchGpu } from "./live_gpu_objects.js";
import { clay, normalsOfTriangles, plainGlb, plainMaterial, type PosedVertices } from "./plain_glb.js";
import { turnJoints, turnsOf } from "./turned_joints.js";
import { size, type MakeStage, type Stage, type View } from "./viewer_stage.js";

export interface PoseDifference {
  pose: string;
  /** Largest difference of a colour channel, 0 to 255. */
  largest: number;
  /** Share of the pixels of the face that differ by more than 8. */
  differing: number;
  /** The same with the sign of one control turned; null of the rest pose, where all are 0. */
  signTurned: number | null;
  /** Which one. */
  control: string;
  /** Of all pixels, that are not background. */
  covered: number;
  /** Two PNG files, as addresses: the adapter's and what it is compared with. */
  pictures: [string, string];
}

export interface Compared {
  backend: string;
  poses: PoseDifference[];
  /** What is counted without a face, and after faces were shown and taken away. */
  before: Record<string, number>;
  after: Record<string, number>;
  /** The share of the picture that is still drawn. */
  remains: number;
  materials: number;
  turnedJoints: number;
}

export interface CompareOptions {
  archive: string;
  /** Gives the face materials of all kinds in place of its own. */
  dressed: boolean;
  /** The viewer shows the .glb of morph targets that `facebaker export` writes: joints stay at rest, poses have one control
   * each at an end of its range, normals are those of triangles. */
  morphTargets: boolean;
  /** Takes the face for one whose z axis points up. */
  zUp: boolean;
}

interface Pose {
  name: string;
  controls: Float32Array;
  /** The control that moves most, -1 at rest. */
  turned: number;
}

interface End {
  value: number;
  /** The sum of squared distances that vertices move. */
  reach: number;
  /** By how much that differs between left and right. */
  oneSided: number;
}

// The end of its range at which each control by itself moves vertices most.
function strongestEnds(face: Face): End[] {
  const rest = face.restPositions, controls = face.createPose(), across = rest.filter((_, i) => i % 3 === 0);
  const middle = (across.reduce((a, b) => Math.min(a, b)) + across.reduce((a, b) => Math.max(a, b))) / 2;
  return face.controls.map(({ minimum, maximum, neutral }, index) => {
    const ends = [minimum, maximum].map((value): End => {
      controls[index] = value;
      const moved = face.evaluateInPlace(controls), sides = [0, 0];
      moved.forEach((at, i) => { sides[rest[3 * Math.floor(i / 3)]! > middle ? 1 : 0]! += (at - rest[i]!) ** 2; });
      return { value, reach: sides[0]! + sides[1]!, oneSided: Math.abs(sides[0]! - sides[1]!) };
    }) as [End, End];
    controls[index] = neutral;
    return ends[0].reach > ends[1].reach ? ends[0] : ends[1];
  });
}

function choosePoses(face: Face, single: boolean): Pose[] {
  const ends = strongestEnds(face);
  const by = (what: "reach" | "oneSided") => ends.map((_, i) => i).sort((a, b) => ends[b]![what] - ends[a]![what]);
  const posed = (chosen: readonly number[]) => {
    const controls = face.createPose();
    for (const index of chosen) controls[index] = ends[index]!.value;
    return controls;
  };
  const strong = by("reach").slice(0, single ? 1 : 3), oneSided = by("oneSided").find((index) => index !== strong[0])!;
  return [{ name: "rest", controls: face.createPose(), turned: -1 },
          { name: "strong", controls: posed(strong), turned: strong[0]! },
          { name: "asymmetric", controls: posed([oneSided]), turned: oneSided }];
}

function compare(a: Uint8ClampedArray, b: Uint8ClampedArray, background: Uint8ClampedArray) {
  let largest = 0, differing = 0, covered = 0;
  for (let i = 0; i < a.length; i += 4) {
    const by = (x: Uint8ClampedArray, y: Uint8ClampedArray) =>
      Math.max(...[0, 1, 2, 3].map((c) => Math.abs(x[i + c]! - y[i + c]!)));
    const difference = by(a, b);
    largest = Math.max(largest, difference);
    if (difference > 8) ++differing;
    if (by(b, background) > 4) ++covered;
  }
  return { largest, differing: differing / Math.max(covered, 1), covered: covered / (a.length / 4) };
}

async function asPng(pixels: Uint8ClampedArray): Promise<string> {
  const canvas = new OffscreenCanvas(size, size);
  canvas.getContext("2d")!.putImageData(new ImageData(new Uint8ClampedArray(pixels), size, size), 0, 0);
  const blob = await canvas.convertToBlob({ type: "image/png" });
  return new Promise((resolve) => {
    const reader = new FileReader();
    reader.onload = () => resolve(String(reader.result));
    reader.readAsDataURL(blob);
  });
}

function viewOf(face: Face, scale: number): View {
  const b = Array.from(face.evaluateInto(face.createPose(), { bounds: new Float32Array(6) }).bounds, (value) => scale * value);
  const away = 2.1 * scale * face.diagonal, upright = ([x, y, z]: [number, number, number]): [number, number, number] =>
    face.upAxis === "z" ? [x, z, -y] : [x, y, z];
  const centre = upright([0, 1, 2].map((axis) => (b[axis]! + b[axis + 3]!) / 2) as [number, number, number]);
  const from = upright([0.35 * away, 0.2 * away, 0.9 * away]); // in front of it
  return { centre, eye: [centre[0] + from[0], centre[1] + from[1], centre[2] + from[2]], near: away / 20, far: 10 * away };
}

class Comparison {
  private background: Uint8ClampedArray = new Uint8ClampedArray(4 * size * size);

  constructor(private readonly stage: Stage, private readonly face: Face, private readonly options: CompareOptions,
              private readonly scale: number, private readonly turns: readonly number[] | null) {}

  counts(): Record<string, number> {
    return { ...this.stage.counts(), ...liveOnGpu() };
  }

  /** Draws the scene without a face, which is the background from then on. */
  async drawBackground(): Promise<void> {
    this.background = await this.stage.draw();
  }

  /** The share of pixels that are not background. */
  async drawnShare(): Promise<number> {
    return compare(this.background, await this.stage.draw(), this.background).covered;
  }

  private async drawPlain(controls: Float32Array): Promise<Uint8ClampedArray> {
    const { face, turns, scale, options: { morphTargets } } = this, n = 3 * face.vertexCount;
    const posed: PosedVertices = face.evaluateInto(controls, { positions: new Float32Array(n), normals: new Float32Array(n) });
    const lit = morphTargets ? { ...posed, normals: normalsOfTriangles(face, posed.positions) } : posed;
    const remove = await this.stage.showGlb(
      plainGlb(face, turns ? turnJoints(face, lit, turns) : lit, scale, this.plainMaterial()));
    const pixels = await this.stage.draw();
    remove();
    return pixels;
  }

  private plainMaterial(): Material | null {
    if (!this.options.morphTargets) return plainMaterial;
    return this.face.materials.length === 0 ? clay : null;
  }

  /** Each pose by the adapter, and with one control's sign turned. */
  async drawFace(poses: readonly Pose[]): Promise<{ plain: Uint8ClampedArray; turned: Uint8ClampedArray | null }[]> {
    const shown = await this.stage.showFace(this.face, this.options.archive);
    await shown.ready();
    const drawn = [];
    for (const { controls, turned } of poses) {
      shown.pose(controls, this.turns);
      const plain = await this.stage.draw();
      if (turned >= 0) {
        const other = controls.slice();
        other[turned] = -other[turned]!;
        shown.pose(other, this.turns);
      }
      drawn.push({ plain, turned: turned < 0 ? null : await this.stage.draw() });
    }
    shown.remove();
    return drawn;
  }

  async run(poses: readonly Pose[]): Promise<PoseDifference[]> {
    const expected = [];
    for (const { controls } of poses) expected.push(await this.drawPlain(controls));
    const drawn = await this.drawFace(poses), results: PoseDifference[] = [];
    for (const [index, { name, turned }] of poses.entries()) {
      const { plain, turned: signTurned } = drawn[index]!, wanted = expected[index]!, { background } = this;
      results.push({ pose: name, ...compare(plain, wanted, background),
                     signTurned: signTurned && compare(signTurned, wanted, background).differing,
                     control: this.face.controls[turned]?.name ?? "", pictures: [await asPng(plain), await asPng(wanted)] });
    }
    return results;
  }
}

/** Puts `facebakerViewer` on the page, which the test calls. */
export function offer(makeStage: MakeStage): void {
  const run = async (options: CompareOptions): Promise<Compared> => {
    const { archive, morphTargets, dressed, zUp } = options;
    watchGpu();
    if (dressed) await dressFaces();
    if (zUp) Object.defineProperty(Face.prototype, "upAxis", { value: "z" });
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = size;
    document.body.append(canvas);
    const face = await load(archive), scale = metresPerUnit(face.units) ?? 1;
    const stage = await makeStage(canvas, viewOf(face, scale)), turns = turnsOf(face, morphTargets ? 0 : 0.15);
    const comparison = new Comparison(stage, face, options, scale, turns), poses = choosePoses(face, morphTargets);
    await comparison.drawBackground();
    await comparison.run(poses.slice(0, 1)); // engines make things of their own at first, and keep them
    await comparison.drawnShare();
    const before = comparison.counts(), compared = await comparison.run(poses), remains = await comparison.drawnShare();
    return { backend: stage.backend, poses: compared, before, after: comparison.counts(), remains, materials: face.materials.length,
             turnedJoints: turns?.filter((angle) => angle !== 0).length ?? 0 };
  };
  Object.assign(globalThis, { facebakerViewer: run });
}


