/** Numbers for people. */

import { metresPerUnit } from "facebaker";

/** Three significant digits, in powers of ten where it is small or large. */
export function figure(value: number): string {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size < 1e-3 || size >= 1e5 ? value.toExponential(1) : String(Number(value.toPrecision(3)));
}

/** A length of the rig: in millimetres where they are known of its unit, else in the unit. */
export function lengthText(length: number, units: string): string {
  const metres = metresPerUnit(units);
  return metres === null ? `${figure(length)} ${units}` : `${figure(1000 * metres * length)} mm`;
}

/** A length, and as a fraction of the diagonal D. */
export function errorText(length: number, units: string, diagonal: number): string {
  return `${lengthText(length, units)} (${figure(length / diagonal)} D)`;
}

export function bytesText(bytes: number): string {
  if (bytes < 1e4) return `${bytes} B`;
  return bytes < 1e6 ? `${(bytes / 1e3).toFixed(1)} kB` : `${(bytes / 1e6).toFixed(2)} MB`;
}
