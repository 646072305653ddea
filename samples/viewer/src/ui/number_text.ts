/** Numbers for people. */

/** Three significant digits, in powers of ten where it is small or large. */
export function figure(value: number): string {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size < 1e-3 || size >= 1e5 ? value.toExponential(1) : String(Number(value.toPrecision(3)));
}

const MILLIMETRES: Record<string, number> = { m: 1000, dm: 100, cm: 10 };

/** A length of the rig: in its unit, in millimetres too where that is a larger metric one, and as a fraction of the
 * diagonal D. */
export function lengthText(length: number, units: string, diagonal: number): string {
  const factor = MILLIMETRES[units];
  const millimetres = factor === undefined ? "" : ` (${figure(length * factor)} mm)`;
  return `${inUnits(length, units)}${millimetres} = ${figure(length / diagonal)} D`;
}

/** In millimetres where the unit is metric, else in the unit. */
export function millimetresText(length: number, units: string): string {
  const factor = units === "mm" ? 1 : MILLIMETRES[units];
  return factor === undefined ? inUnits(length, units) : `${figure(length * factor)} mm`;
}

export function inUnits(length: number, units: string): string {
  return `${figure(length)} ${units}`;
}

export function bytesText(bytes: number): string {
  if (bytes < 1e4) return `${bytes} B`;
  return bytes < 1e6 ? `${(bytes / 1e3).toFixed(1)} kB` : `${(bytes / 1e6).toFixed(2)} MB`;
}
