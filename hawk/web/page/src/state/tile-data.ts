/** Classes of a map cell, as the map's tiles hold them. */
export const CELL = { unknown: 0, nonLot: 1, lot: 2, free: 3, taken: 4 } as const;

/** Inflates a tile: base64 of zlib of cells × cells bytes. Throws when it is anything else. */
export async function inflateTile(data: string, cells: number): Promise<Uint8Array> {
  const packed = Uint8Array.from(atob(data), (character) => character.charCodeAt(0));
  const bytes = await inflate(packed);
  if (bytes.length !== cells * cells) throw new Error(`tile of ${bytes.length} bytes instead of ${cells * cells}`);
  return bytes;
}

/** What the comment of a JPEG begins with that holds a mask. */
const MASK_MARK = "hawk seen\0";

/**
 * Which cells the picture of a tile shows: 1 or 0, cells × cells of them; null where all are shown. The mask stands in the
 * JPEG's first segment, a comment: zlib of one bit a cell. Throws when it is of another size.
 */
export async function maskOf(jpeg: Uint8Array<ArrayBuffer>, cells: number): Promise<Uint8Array | null> {
  const start = 6 + MASK_MARK.length;
  if (jpeg[2] !== 0xff || jpeg[3] !== 0xfe) return null;
  if (String.fromCharCode(...jpeg.subarray(6, start)) !== MASK_MARK) return null;
  const end = 4 + (jpeg[4] ?? 0) * 256 + (jpeg[5] ?? 0);
  const bits = await inflate(jpeg.slice(start, end));
  if (bits.length * 8 !== cells * cells) throw new Error(`mask of ${bits.length} bytes instead of ${(cells * cells) / 8}`);
  return Uint8Array.from({ length: cells * cells }, (_, cell) => ((bits[cell >> 3] ?? 0) >> (7 - (cell & 7))) & 1);
}

async function inflate(packed: Uint8Array<ArrayBuffer>): Promise<Uint8Array> {
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
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
