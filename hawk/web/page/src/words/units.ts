/** Units in which lengths, speeds and areas are shown and typed. The drone's own messages are always metric. */
export type Units = "metres" | "feet";

interface Scale {
  /** Of a length, and its metres. */
  symbol: string;
  metres: number;
  speed: { symbol: string; metresPerSecond: number };
  area: { symbol: string; squareMetres: number };
  /** From a tenth of it on, areas are given in it. */
  land: { symbol: string; squareMetres: number };
}

/** The international foot, mile and acre. */
const FOOT_M = 0.3048;
const MILE_M = 1609.344;
const ACRE_M2 = 4046.8564224;

export const SCALES: Record<Units, Scale> = {
  metres: {
    symbol: "m",
    metres: 1,
    speed: { symbol: "m/s", metresPerSecond: 1 },
    area: { symbol: "m²", squareMetres: 1 },
    land: { symbol: "ha", squareMetres: 10_000 },
  },
  feet: {
    symbol: "ft",
    metres: FOOT_M,
    speed: { symbol: "mph", metresPerSecond: MILE_M / 3600 },
    area: { symbol: "ft²", squareMetres: FOOT_M ** 2 },
    land: { symbol: "acres", squareMetres: ACRE_M2 },
  },
};

/** A length as it is offered for typing: without its unit, to the centimetre or a tenth of a foot. */
export function typed(metres: number, units: Units): string {
  return String(Number((metres / SCALES[units].metres).toFixed(units === "metres" ? 2 : 1)));
}

/** Metres of a length that was typed; null for what is no number above 0. Feet are taken to the centimetre. */
export function metresOf(text: string, units: Units): number | null {
  const value = Number(text.trim().replace(",", ".") || Number.NaN);
  if (!Number.isFinite(value) || value <= 0) return null;
  return units === "metres" ? value : Number((value * SCALES[units].metres).toFixed(2));
}

/** Metres of a typed length; one that still is as it was offered stays exactly what it was. */
export function metresKept(text: string, before: number | null, units: Units): number | null {
  return before !== null && text === typed(before, units) ? before : metresOf(text, units);
}
