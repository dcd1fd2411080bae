const ID = /^[0-9a-f-]{36}$/;
const LATE = ["lots", "compare", "report", "recordings"];

/** Parts of the page that are read late. */
export type PartName = "fly" | "maps" | "figures";

/** An address as `placeOf` reads it, as far as it says what is asked for first. A guest's begins with the token of a link. */
function read(hash: string): { token: string; view: string; lot: string; ids: string[]; isAsking: boolean } {
  const [path = "", search] = hash.replace(/^#/, "").split("?");
  const [token = "", view = "", lot = "", ...ids] = path.split("/");
  const known = LATE.includes(view) ? view : token === "" ? "" : "lots"; // a guest does not fly
  return { token, view: known, lot, ids: ids.filter((id) => ID.test(id)), isAsking: search !== undefined };
}

/** The part in which the view of an address is. */
export function firstPart(hash: string): PartName {
  const { view, isAsking, ids } = read(hash);
  if (view === "") return "fly";
  const isPlain = view === "report" || (view === "recordings" && !hash.includes(".mcap")) || (isAsking && ids.length === 0 && /[?&]show=(document|links|arrivals)/.test(hash));
  return isPlain ? "figures" : "maps";
}

/** What the view of an address asks the drone for first, below its API: asked for while the page itself is still read. */
export function firstReads(hash: string): string[] {
  const { token, view, lot, ids: named, isAsking } = read(hash);
  if (view === "") return [];
  const base = token === "" ? `lots/${lot}` : `shared/${token}`;
  const use = `${base}/statistics`;
  const newest = `${use}/surveys?newest=8`;
  const lists = token !== "" ? [newest] : [view === "recordings" ? "recordings?limit=1000" : "", "lots/places"].filter((each) => each !== "");
  if (!ID.test(lot) && token === "") return lists;
  if (isAsking || view === "recordings") return lists;
  if (view === "report") return [`${use}/ask`, ...lists];
  const ids = named.slice(0, view === "compare" ? 2 : 1);
  const pictures = (id: string): string[] => (token === "" ? [`surveys/${id}/ground`, `surveys/${id}/ground/whole`] : []); // a link shows none
  const about = ids.map((id) => `${use}/surveys?survey=${id}`);
  const between = view === "compare" && ids.length === 2 ? [`${use}/between?before=${ids[0]}&after=${ids[1]}`] : [];
  const first = view === "compare" || ids.length === 0 ? [newest] : [];
  return [...new Set([...ids.flatMap((id) => [`${base}/surveys/${id}/map`, ...pictures(id)]), ...first, ...about, ...between, ...lists])];
}
