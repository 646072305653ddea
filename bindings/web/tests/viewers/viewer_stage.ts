// What the test wants of a viewer. Each viewer has a stage: a scene with lights and a camera that looks at the face.
import type { Face } from "facebaker";

/** The size of pictures, in pixels. */
export const size = 320;

/** A face that is shown as docs/web-engines.md has it. */
export interface ShownFace {
  /** `turns`: an angle by joint of a skin, about its x axis, in radians; null where no joint is turned. */
  pose(controls: Float32Array, turns: readonly number[] | null): void;
  /** When its pictures are there. */
  ready(): Promise<void>;
  remove(): void;
}

export interface Stage {
  /** "webgl" or "webgpu": what it draws with. */
  readonly backend: string;
  /** `archive`: where the face was loaded from. */
  showFace(face: Face, archive: string): Promise<ShownFace>;
  /** Shows a .glb by the viewer's own loader; gives what takes it away again. */
  showGlb(bytes: Uint8Array): Promise<() => void>;
  /** Draws, and gives red, green, blue and alpha of the pixels. */
  draw(): Promise<Uint8ClampedArray>;
  /** What the viewer counts of its scene: meshes, materials, ... */
  counts(): Record<string, number>;
}

/** Where the camera of a stage is, in metres. */
export interface View {
  readonly centre: readonly [number, number, number];
  readonly eye: readonly [number, number, number];
  readonly near: number;
  readonly far: number;
}

/** Degrees, from top to bottom. */
export const fieldOfView = 30;

/** Where light comes from, and how strong ambient light is beside it. */
export const light = { from: [0.5, 1, 1.5], intensity: 2.5, ambient: 0.6 } as const;

/** Makes a stage on a canvas of `size`. */
export type MakeStage = (canvas: HTMLCanvasElement, view: View) => Promise<Stage>;

/** The pixels of a canvas that was drawn in this task. */
export function pixelsOf(canvas: CanvasImageSource): Uint8ClampedArray {
  const flat = new OffscreenCanvas(size, size).getContext("2d")!;
  flat.drawImage(canvas, 0, 0, size, size);
  return flat.getImageData(0, 0, size, size).data;
}

/** Waits for what comes later by itself, at most ten seconds. */
export async function until(done: () => boolean, what: string): Promise<void> {
  for (let i = 0; !done(); ++i) {
    if (i === 1000) throw new Error(`${what} does not come`);
    await new Promise((resolve) => setTimeout(resolve, 10));
  }
}
