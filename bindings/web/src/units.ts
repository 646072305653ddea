// As packager/export has them, with a longer name of the inch.
const metres: Record<string, number> = {
  m: 1, dm: 0.1, cm: 0.01, mm: 0.001, in: 0.0254, inch: 0.0254, ft: 0.3048,
};

/** Metres of a unit of length, such as a face's `units`; null where that is not known. */
export function metresPerUnit(units: string): number | null {
  return metres[units] ?? null;
}

/** What to scale a face by, for an engine that counts in metres. Throws where its unit is not known. */
export function scaleToMetres(units: string): number {
  const scale = metresPerUnit(units);
  if (scale === null)
    throw new Error(`metres: the face is in "${units}", which is no known unit of length; scale it by yourself`);
  return scale;
}
