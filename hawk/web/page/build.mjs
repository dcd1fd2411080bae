// Bundles the operator page, and the page of lots over time, into ../static (or the folder given as first argument).
import { build } from "esbuild";
import { cp, mkdir, readFile, readdir, rm, writeFile } from "node:fs/promises";
import { basename, dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

const here = dirname(fileURLToPath(import.meta.url));
const out = resolve(process.argv[2] ?? join(here, "..", "static"));
/** Bytes of everything that a browser loads in one language, compressed. */
const LARGEST_GZIP = 300_000;
/** The same of the page of lots over time. */
const LARGEST_ARCHIVE_GZIP = 160_000;
/** Messages of the page of lots over time have keys, and its files have names, that begin so. */
const ARCHIVE = /^archive-/;

/**
 * English is part of the page; a browser loads any other language as a file, with the sentences of the drone's program
 * (drone-fr.ftl) behind those of the page. Comments are for translators.
 */
const messages = (hasArchive) => ({
  name: "messages",
  setup(building) {
    building.onLoad({ filter: /\.ftl$/ }, async ({ path }) => {
      const all = messageLines(await readFile(path, "utf8"));
      const lines = hasArchive ? all : withoutArchive(all);
      if (basename(path) === "en.ftl") return { contents: `${lines.join("\n")}\n`, loader: "text" };
      const drone = messageLines(await readFile(join(dirname(path), `drone-${basename(path)}`), "utf8"));
      const contents = [...lines, ...drone.map((line) => line.replace(/^(?=[a-z])/, "drone-"))];
      return { contents: `${contents.join("\n")}\n`, loader: "file", watchFiles: [path] };
    });
  },
});

/** A message has further lines, which begin with a space. */
function withoutArchive(lines) {
  let isOut = false;
  return lines.filter((line) => {
    if (!line.startsWith(" ")) isOut = ARCHIVE.test(line);
    return !isOut;
  });
}

/** Fluent needs one space before the further lines of a message, and none within the braces of a value. */
function messageLines(text) {
  const lines = text.split("\n").filter((line) => line !== "" && !line.startsWith("#"));
  return lines.map((line) => line.replace(/^ +/, " ").replace(/\{ (\$[\w-]+) \}/g, "{$1}"));
}

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
  build({ ...shared, entryPoints: ["src/main.ts"], outfile: join(out, "app.js"), plugins: [messages(false)], assetNames: "[name]-[hash]" }),
  build({ ...shared, entryPoints: ["src/archive/main.ts"], outfile: join(out, "archive.js"), plugins: [messages(true)], assetNames: "archive-[name]-[hash]" }),
  build({ ...shared, entryPoints: ["src/replay/main.ts"], outfile: join(out, "replay.js"), plugins: [messages(true)], assetNames: "archive-[name]-[hash]" }),
  build({ ...shared, entryPoints: ["src/link/life-worker.ts"], outfile: join(out, "life-worker.js") }),
  build({
    ...shared,
    entryPoints: ["src/styles/app.css"],
    outfile: join(out, "app.css"),
    loader: { ".woff2": "file" },
    assetNames: "[name]-[hash]",
  }),
  ...["archive", "replay"].map((name) =>
    build({
      ...shared,
      entryPoints: [`src/${name}/${name}.css`],
      outfile: join(out, `${name}.css`),
      loader: { ".woff2": "file" },
      assetNames: "[name]-[hash]",
    }),
  ),
]);
await cp(join(here, "public"), out, { recursive: true });
const outputs = results.flatMap((result) => Object.keys(result.metafile.outputs));
for (const name of ["index.html", "archive.html", "replay.html"]) await preloadFonts(name, outputs);
const inputs = results.flatMap((result) => Object.keys(result.metafile.inputs));
const isOf = (name, file) => file.startsWith(`${name}.`) || /^archive-|\.woff2$/.test(file);
await checkSize("page", (file) => !/^(archive|replay)\b/.test(file), LARGEST_GZIP);
await checkSize("lots over time", (file) => isOf("archive", file), LARGEST_ARCHIVE_GZIP);
await checkSize("replay", (file) => isOf("replay", file), LARGEST_ARCHIVE_GZIP);
await writeFile(join(out, "licences.txt"), await licences(inputs));

/** Over a weak link the page must come quickly. Fails when it grew too large. */
async function checkSize(name, belongs, largest) {
  const files = (await readdir(out)).filter(belongs);
  const size = async (file) => gzipSync(await readFile(join(out, file)), { level: 9 }).length;
  const sizes = await Promise.all(files.filter((file) => !file.endsWith(".ftl")).map(size));
  const languages = await Promise.all(files.filter((file) => file.endsWith(".ftl")).map(size));
  const total = sizes.reduce((sum, each) => sum + each, Math.max(0, ...languages));
  if (total > largest) throw new Error(`The ${name} has ${total} bytes (gzip), at most ${largest} are allowed.`);
  console.log(`${name}: ${(total / 1000).toFixed(1)} kB (gzip)`);
}

/** The browser asks for the fonts at once, not when it has read the style sheet: nothing moves when they come. */
async function preloadFonts(page, outputs) {
  const names = [...new Set(outputs)].filter((name) => name.endsWith(".woff2")).map((name) => basename(name));
  const links = names.map((name) => `<link rel="preload" href="${name}" as="font" type="font/woff2" crossorigin />`);
  const index = join(out, page);
  const text = await readFile(index, "utf8");
  await writeFile(index, text.replace('<link rel="stylesheet"', `${links.join("\n    ")}\n    <link rel="stylesheet"`));
}

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
