/** Colours of values, the same as in the pictures of reports: pale where there is nothing to see. sRGB, 0 to 1. */
const STOPS: readonly (readonly [number, number, number])[] = [
  [0.9, 0.91, 0.92],
  [0.96, 0.84, 0.42],
  [0.97, 0.64, 0.2],
  [0.87, 0.33, 0.2],
  [0.6, 0.11, 0.33],
  [0.2, 0.02, 0.3],
];

/** Colours of regions, those of reports. */
const PARTS: readonly (readonly [number, number, number])[] = [
  [230, 85, 45],
  [45, 125, 210],
  [60, 165, 75],
  [155, 80, 190],
  [240, 175, 40],
  [20, 160, 165],
  [215, 75, 140],
  [135, 100, 60],
  [130, 190, 60],
  [90, 90, 200],
  [185, 45, 45],
  [120, 150, 175],
];

const linear = (s: number): number => (s <= 0.04045 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4);

/** Linear RGB of 0 to 1 in 256 steps, for vertices. */
const TABLE = (() => {
  const table = new Float32Array(256 * 3);
  for (let i = 0; i < 256; ++i) {
    const [below, part] = stopOf(i / 255);
    for (let c = 0; c < 3; ++c)
      table[3 * i + c] = linear(STOPS[below][c] + part * (STOPS[below + 1][c] - STOPS[below][c]));
  }
  return table;
})();

function stopOf(share: number): [number, number] {
  const at = Math.min(Math.max(share, 0), 1) * (STOPS.length - 1);
  const below = Math.min(Math.floor(at), STOPS.length - 2);
  return [below, at - below];
}

/** CSS stops of a gradient over the whole scale. */
export function gradientStops(): string {
  return STOPS.map(([r, g, b], i) => `rgb(${r * 255} ${g * 255} ${b * 255}) ${(100 * i) / (STOPS.length - 1)}%`).join(", ");
}

/** Writes linear RGB of each value: 0 is pale, `end` and above are darkest. */
export function colourValues(values: ArrayLike<number>, end: number, colours: Float32Array): void {
  const steps = end > 0 ? 255 / end : 0;
  for (let v = 0; v < values.length; ++v) {
    const step = 3 * Math.min(Math.round(values[v] * steps), 255);
    colours[3 * v] = TABLE[step];
    colours[3 * v + 1] = TABLE[step + 1];
    colours[3 * v + 2] = TABLE[step + 2];
  }
}

export function partColour(part: number): string {
  return `rgb(${PARTS[part % PARTS.length].join(" ")})`;
}

/** Writes linear RGB of each part, an index a vertex. */
export function colourParts(parts: ArrayLike<number>, colours: Float32Array): void {
  for (let v = 0; v < parts.length; ++v)
    for (let c = 0; c < 3; ++c) colours[3 * v + c] = linear(PARTS[parts[v] % PARTS.length][c] / 255);
}

/** 1, 2 or 5 times a power of ten, not less than value. */
export function roundScale(value: number): number {
  if (!(value > 0)) return 1e-6;
  const decade = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((step) => step * decade).find((end) => end >= value * (1 - 1e-9)) ?? value;
}
