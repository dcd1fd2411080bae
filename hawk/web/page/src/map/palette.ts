/** Colours of what is drawn on the map, from the style sheet's properties. */
export interface Palette {
  fog: string;
  grid: string;
  fence: string;
  zone: string;
  plan: string;
  planCase: string;
  asphalt: string;
  ground: string;
  veil: string;
  begins: string;
  ends: string;
  confirmed: string;
}

export function readPalette(element: Element): Palette {
  const style = getComputedStyle(element);
  const read = (name: string): string => style.getPropertyValue(name).trim();
  return {
    fog: read("--fog"),
    grid: read("--grid"),
    fence: read("--fence"),
    zone: read("--zone"),
    plan: read("--plan"),
    planCase: read("--plan-case"),
    asphalt: read("--asphalt"),
    ground: read("--ground"),
    veil: read("--veil"),
    begins: read("--ok"),
    ends: read("--bad"),
    confirmed: read("--ok"),
  };
}

export type Rgb = readonly [number, number, number];

/** Reads "#rrggbb". */
export function rgb(colour: string): Rgb {
  const value = Number.parseInt(colour.slice(1), 16);
  return [(value >> 16) & 255, (value >> 8) & 255, value & 255];
}
