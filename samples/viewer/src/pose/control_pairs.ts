import type { Control } from "facebaker";

/** Left and right in names, in the order in which they are tried: whole words first, then letters set apart. */
const SIDES: readonly (readonly [RegExp, string])[] = [
  [/left/, "right"],
  [/Left/, "Right"],
  [/LEFT/, "RIGHT"],
  [/(^|[^A-Za-z])l(?=$|[^A-Za-z])/, "$1r"],
  [/(^|[^A-Za-z])L(?=$|[^A-Za-z])/, "$1R"],
  [/(?<=[a-z0-9])L(?=$|[A-Z_.\-\s])/, "R"],
];

/**
 * The control that does the same on the other side, one index a control; -1 where there is none. An archive's own pairs
 * count first, then names that differ in left and right alone: browL and browR, lid_l and lid_r, mouthSmileLeft and
 * mouthSmileRight.
 */
export function findPairs(controls: readonly Control[]): Int32Array {
  const partners = new Int32Array(controls.length).fill(-1);
  const byName = new Map(controls.map((control, index) => [control.name, index]));
  const link = (a: number, b: number): void => {
    if (a === b || partners[a] >= 0 || partners[b] >= 0) return;
    partners[a] = b;
    partners[b] = a;
  };
  controls.forEach((control, index) => {
    if (control.mirror !== undefined && control.mirror >= 0 && control.mirror < controls.length) link(index, control.mirror);
  });
  controls.forEach((control, index) => {
    for (const [left, right] of SIDES) {
      const other = left.test(control.name) ? byName.get(control.name.replace(left, right)) : undefined;
      if (other !== undefined) link(index, other);
    }
  });
  return partners;
}
