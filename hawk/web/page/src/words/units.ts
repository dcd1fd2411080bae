import { typedNumber } from "./say.ts";

/** Units in which lengths, speeds and areas are shown and typed. The drone's own messages are always metric. */
export type Units = "metres" | "feet";

interface Scale {
  /** Of a length, beside a field in which it is typed. */
  symbol: string;
  metres: number;
  metresPerSecond: number;
  squareMetres: number;
  /** Square metres of the unit of large areas: from a tenth of it on, areas are given in it. */
  largeSquareMetres: number;
}

/** The international foot, mile and acre. */
const FOOT_M = 0.3048;
const MILE_M = 1609.344;
const ACRE_M2 = 4046.8564224;

export const SCALES: Record<Units, Scale> = {
  metres: { symbol: "m", metres: 1, metresPerSecond: 1, squareMetres: 1, largeSquareMetres: 10_000 },
  feet: {
    symbol: "ft",
    metres: FOOT_M,
    metresPerSecond: MILE_M / 3600,
    squareMetres: FOOT_M ** 2,
    largeSquareMetres: ACRE_M2,
  },
};

/** A length as it is offered for typing: without its unit, to the centimetre or a tenth of a foot. */
export function typed(metres: number, units: Units): string {
  return typedNumber(metres / SCALES[units].metres, units === "metres" ? 2 : 1);
}

/** Metres of a length that was typed; null for what is no number above 0. Feet are taken to the centimetre. */
export function metresOf(text: string, units: Units): number | null {
  const value = Number(text.trim().replace(",", ".") || Number.NaN);
  if (!Number.isFinite(value) || value <= 0) return null;
  return units === "metres" ? value : Number((value * SCALES[units].metres).toFixed(2));
}

/** Metres of a distance that was typed, below 0 on the other side; null for what is no number. */
export function signedMetresOf(text: string, units: Units): number | null {
  const value = Number(text.trim().replace(",", ".").replace("−", "-") || Number.NaN);
  return Number.isFinite(value) ? Number((value * SCALES[units].metres).toFixed(2)) : null;
}

/** Metres of a typed length; one that still is as it was offered stays exactly what it was. */
export function metresKept(text: string, before: number | null, units: Units): number | null {
  return before !== null && text === typed(before, units) ? before : metresOf(text, units);
}
