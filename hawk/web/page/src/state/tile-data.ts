/** Classes of a map cell, as the map's tiles hold them. */
export const CELL = { unknown: 0, nonLot: 1, lot: 2, free: 3, taken: 4 } as const;

/** Inflates a tile: base64 of zlib of cells × cells bytes. Throws when it is anything else. */
export async function inflateTile(data: string, cells: number): Promise<Uint8Array> {
  const packed = Uint8Array.from(atob(data), (character) => character.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  if (bytes.length !== cells * cells) throw new Error(`tile of ${bytes.length} bytes instead of ${cells * cells}`);
  return bytes;
}

/** Tile and cell index of a place, metres. Row 0 lies south of north = 0. */
export function cellAt(
  north: number,
  east: number,
  cells: number,
  cellSize: number,
): { row: number; column: number; index: number } {
  const down = Math.floor(-north / cellSize);
  const right = Math.floor(east / cellSize);
  const row = Math.floor(down / cells);
  const column = Math.floor(right / cells);
  return { row, column, index: (down - row * cells) * cells + (right - column * cells) };
}
