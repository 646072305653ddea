import type { Pose } from "./pose";

const MOST_GROUPS = 3;
const MOST_IN_GROUP = 3;

const below = (count: number): number => Math.floor(Math.random() * count);

function shuffled<T>(list: readonly T[]): T[] {
  const all = [...list];
  for (let i = all.length - 1; i > 0; --i) {
    const j = below(i + 1);
    [all[i], all[j]] = [all[j], all[i]];
  }
  return all;
}

/** A pose as a face may have it: a few controls of one to three groups, a quarter to all of the way to an end of their
 * range, the farther one more often. Where left and right are linked, both sides do the same. */
export function randomPose(pose: Pose): Float32Array {
  const groups = new Map<string, number[]>();
  pose.controls.forEach(({ group, minimum, maximum }, index) => {
    if (maximum > minimum) groups.set(group, [...(groups.get(group) ?? []), index]);
  });
  const values = pose.rest.slice();
  const chosen = shuffled([...groups.values()]).slice(0, 1 + below(MOST_GROUPS));
  const least = chosen.length === 1 ? 2 : 1; // one control alone is no expression
  for (const group of chosen)
    for (const index of shuffled(group).slice(0, least + below(MOST_IN_GROUP))) {
      const { minimum, maximum, neutral } = pose.controls[index];
      const up = Math.random() < (maximum - neutral) / (maximum - minimum);
      values[index] = neutral + (0.25 + 0.75 * Math.random()) * ((up ? maximum : minimum) - neutral);
      const partner = pose.partners[index];
      if (pose.linked && partner >= 0) values[partner] = pose.mirrored(index, partner, values[index]);
    }
  return values;
}
