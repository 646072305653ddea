// As packager/export has them, with a longer name of the inch.
const metres: Record<string, number> = {
  m: 1, dm: 0.1, cm: 0.01, mm: 0.001, in: 0.0254, inch: 0.0254, ft: 0.3048,
};

/** Metres of a unit of length, such as a face's `units`; null where that is not known. */
export function metresPerUnit(units: string): number | null {
  return metres[units] ?? null;
}
