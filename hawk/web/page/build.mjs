// Bundles the operator page into ../static (or the folder given as first argument).
import { build } from "esbuild";
import { cp, mkdir, readFile, readdir, rm, writeFile } from "node:fs/promises";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const out = resolve(process.argv[2] ?? join(here, "..", "static"));

const shared = {
  absWorkingDir: here,
  bundle: true,
  minify: true,
  legalComments: "none",
  target: ["chrome110", "firefox115", "safari16.4"],
  format: "esm",
  metafile: true,
  logLevel: "warning",
};

await rm(out, { recursive: true, force: true });
await mkdir(out, { recursive: true });
const results = await Promise.all([
  build({ ...shared, entryPoints: ["src/main.ts"], outfile: join(out, "app.js") }),
  build({ ...shared, entryPoints: ["src/link/life-worker.ts"], outfile: join(out, "life-worker.js") }),
  build({ ...shared, entryPoints: ["src/styles/app.css"], outfile: join(out, "app.css") }),
]);
await cp(join(here, "public"), out, { recursive: true });
const inputs = results.flatMap((result) => Object.keys(result.metafile.inputs));
await writeFile(join(out, "licences.txt"), await licences(inputs));

/** Text of the licence of every package that the bundle took code from. */
async function licences(files) {
  const names = new Set();
  for (const file of files) {
    const found = /node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(file);
    if (found) names.add(found[1]);
  }
  const parts = await Promise.all([...names].sort().map(licence));
  return `The operator page of Parking Lot Hawk contains code of these packages.\n\n${parts.join("\n")}`;
}

async function licence(name) {
  const folder = join(here, "node_modules", name);
  const about = JSON.parse(await readFile(join(folder, "package.json"), "utf8"));
  const file = (await readdir(folder)).find((entry) => /^(licen[cs]e|copying)/i.test(entry));
  const text = file ? await readFile(join(folder, file), "utf8") : `Licence: ${about.license}`;
  return `${"=".repeat(78)}\n${name} ${about.version} (${about.license})\n\n${text.trim()}\n`;
}
