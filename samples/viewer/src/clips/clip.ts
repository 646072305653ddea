/** Controls over time, and where the vertices truly are where that is known. */
export interface Clip {
  name: string;
  /** Where it comes from: a file, or the source beside the face. */
  origin: string;
  fps: number;
  frames: number;
  /** frames x controls of the face. */
  controls: Float32Array;
  /** What there is to say about how it was read. */
  notes: string[];
  /** frames x vertices x 3 positions in the rig's unit, read when first asked for. */
  reference?: () => Promise<Float32Array>;
}

/** Something is wrong with a file; the message names it. */
export class ClipError extends Error {}
