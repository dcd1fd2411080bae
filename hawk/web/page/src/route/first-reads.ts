const ID = /^[0-9a-f-]{36}$/;

/** What the view of an address asks the drone for first, below its API: asked for while the page itself is still read. */
export function firstReads(hash: string): string[] {
  const [path = "", search] = hash.split("?");
  const [, view = "", lot = "", ...surveys] = path.split("/");
  if (!["lots", "compare", "report", "recordings"].includes(view)) return [];
  const listed = [view === "recordings" ? "recordings?limit=1000" : "", "lots?limit=1000"].filter((each) => each !== "");
  if (!ID.test(lot) || search !== undefined) return listed;
  const use = `lots/${lot}/statistics`;
  if (view === "report") return [`${use}/ask`, ...listed];
  const ids = surveys.filter((id) => ID.test(id)).slice(0, view === "compare" ? 2 : view === "lots" ? 1 : 0);
  const maps = ids.flatMap((id) => [`lots/${lot}/surveys/${id}/stalls`, `surveys/${id}/ground`, `surveys/${id}/ground/whole`]);
  const named = ids.map((id) => `${use}/surveys?survey=${id}`);
  if (view === "lots") return [...maps, ...(ids.length === 0 ? [`${use}/surveys?newest=8`] : named), ...listed];
  if (view === "compare") return [...maps, `${use}/surveys?newest=8`, ...named, ...(ids.length === 2 ? [`${use}/between?before=${ids[0]}&after=${ids[1]}`] : []), ...listed];
  return listed;
}
