import { registerHooks } from "node:module";
import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { transformSync } from "esbuild";

/** Messages as build.mjs bundles them: the English text itself, of any other language the address. */
registerHooks({
  load(url, context, next) {
    if (!url.endsWith(".ftl")) return next(url, context);
    const content = url.endsWith("/en.ftl") ? readFileSync(fileURLToPath(url), "utf8") : url;
    return { format: "module", source: `export default ${JSON.stringify(content)};`, shortCircuit: true };
  },
});

/** Components use decorators, which Node cannot strip as it strips types: the page's own bundler translates them. */
registerHooks({
  load(url, context, next) {
    if (!/\/src\/(ui|views|shell|replay)\//.test(url)) return next(url, context);
    const source = readFileSync(fileURLToPath(url), "utf8");
    const { code } = transformSync(source, {
      loader: "ts",
      sourcefile: fileURLToPath(url),
      sourcemap: "inline",
      tsconfigRaw: { compilerOptions: { experimentalDecorators: true, useDefineForClassFields: false } },
    });
    return { format: "module", source: code, shortCircuit: true };
  },
});
