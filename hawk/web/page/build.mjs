// Bundles the page, with its views that are loaded when they are opened, into ../static (or the folder given as first argument).
import { build } from "esbuild";
import { cp, mkdir, readFile, readdir, rm, writeFile } from "node:fs/promises";
import { basename, dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

const here = dirname(fileURLToPath(import.meta.url));
const out = resolve(process.argv[2] ?? join(here, "..", "static"));
/** Bytes of everything that a browser loads in one language before the first view can be used, compressed. */
const LARGEST_GZIP = 300_000;
/** The same of the views that are loaded when one of them is opened. */
const LARGEST_VIEWS_GZIP = 60_000;
/** The same of what Fly reads when it is shown already: the editor of fences, and plots. */
const LARGEST_DRAWN_GZIP = 80_000;

/**
 * English is part of the page; a browser loads any other language as a file, with the sentences of the drone's program
 * (drone-fr.ftl) behind those of the page. Comments are for translators.
 */
const messages = {
  name: "messages",
  setup(building) {
    building.onLoad({ filter: /\.ftl$/ }, async ({ path }) => {
      const lines = messageLines(await readFile(path, "utf8"));
      if (basename(path) === "en.ftl") return { contents: `${lines.join("\n")}\n`, loader: "text" };
      const drone = messageLines(await readFile(join(dirname(path), `drone-${basename(path)}`), "utf8"));
      const contents = [...lines, ...drone.map((line) => line.replace(/^(?=[a-z])/, "drone-"))];
      return { contents: `${contents.join("\n")}\n`, loader: "file", watchFiles: [path] };
    });
  },
};

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
  build({
    ...shared,
    entryPoints: { app: "src/main.ts", guest: "src/guest.ts" },
    outdir: out,
    splitting: true,
    chunkNames: "part-[hash]",
    assetNames: "[name]-[hash]",
    plugins: [messages],
  }),
  build({ ...shared, entryPoints: ["src/link/life-worker.ts"], outfile: join(out, "life-worker.js") }),
  build({ ...shared, entryPoints: ["src/early.ts"], outfile: join(out, "early.js"), format: "iife" }),
  build({
    ...shared,
    entryPoints: { app: "src/styles/app.css", views: "src/styles/views.css" },
    outdir: out,
    loader: { ".woff2": "file" },
    assetNames: "[name]-[hash]",
  }),
]);
await cp(join(here, "public"), out, { recursive: true });
const { outputs } = results[0].metafile;
const everything = results.flatMap((result) => Object.keys(result.metafile.outputs));
const fonts = everything.filter((name) => name.endsWith(".woff2"));
const languages = everything.filter((name) => name.endsWith(".ftl"));
/** Files of each late part of the page, besides those that its page needs anyway. */
const PARTS = { fly: [], maps: ["views.css"], figures: ["views.css"] };
for (const [name, entry, parts] of [["index.html", "app.js", Object.keys(PARTS)], ["lots.html", "app.js", ["maps", "figures"]], ["shared.html", "guest.js", ["maps", "figures"]]]) {
  await preload(name, entry, parts);
}
const shell = before("app.js");
const flight = new Set([...shell, ...partFiles("fly")]);
const views = new Set(["maps", "figures"].flatMap(partFiles).filter((name) => !flight.has(name)));
const drawn = Object.keys(outputs).filter((name) => name.endsWith(".js") && !flight.has(name) && !views.has(name) && basename(name) !== "guest.js");
const first = ["early.js", "app.css", "index.html"].map((name) => join(out, name));
await checkSize("first view", [...[...flight].map((name) => join(here, name)), ...first, ...fonts], LARGEST_GZIP);
await checkSize("views opened later", [...views, join(out, "views.css")], LARGEST_VIEWS_GZIP, false);
await checkSize("what is drawn later in flight", drawn, LARGEST_DRAWN_GZIP, false);
const inputs = results.flatMap((result) => Object.keys(result.metafile.inputs));
await writeFile(join(out, "licences.txt"), await licences(inputs));

/** The entry and all parts that the browser must have before it can run: what is imported late is none of them. */
function before(entry) {
  const found = new Set();
  const take = (name) => {
    if (found.has(name)) return;
    found.add(name);
    for (const { path, kind } of outputs[name].imports) if (kind === "import-statement") take(path);
  };
  take(Object.keys(outputs).find((name) => basename(name) === entry));
  return found;
}

/** Over a weak link the page must come quickly. Fails when it grew too large. */
async function checkSize(name, files, largest, inOneLanguage = true) {
  const size = async (file) => gzipSync(await readFile(resolve(here, file)), { level: 9 }).length;
  const [sizes, spoken] = await Promise.all([files, languages].map((all) => Promise.all(all.map(size))));
  const total = sizes.reduce((sum, each) => sum + each, inOneLanguage ? Math.max(0, ...spoken) : 0);
  if (total > largest) throw new Error(`The ${name} has ${total} bytes (gzip), at most ${largest} are allowed.`);
  console.log(`${name}: ${(total / 1000).toFixed(1)} kB (gzip)`);
}

/** Scripts of a late part, which is a file of src/parts. */
function partFiles(part) {
  return [...before(basename(Object.keys(outputs).find((name) => outputs[name].entryPoint === `src/parts/${part}.ts`)))];
}

/** The browser asks for fonts and parts at once, not when it has read what wants them: nothing moves when they come. */
async function preload(page, entry, parts) {
  const needed = [...before(entry)];
  const late = parts.map((part) => `data-${part}="${[...partFiles(part).filter((name) => !needed.includes(name)).map((name) => basename(name)), ...PARTS[part]].join(" ")}"`);
  const links = [
    `<script src="early.js" ${late.join(" ")}></script>`,
    ...new Set(fonts.map((name) => `<link rel="preload" href="${basename(name)}" as="font" type="font/woff2" crossorigin />`)),
    ...needed.map((name) => basename(name)).filter((name) => name !== entry).map((name) => `<link rel="modulepreload" href="${name}" />`),
  ];
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
