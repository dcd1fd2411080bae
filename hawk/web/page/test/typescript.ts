import { registerHooks } from "node:module";
import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { transformSync } from "esbuild";

/** Components use decorators, which Node cannot strip as it strips types: the page's own bundler translates them. */
registerHooks({
  load(url, context, next) {
    if (!url.includes("/src/ui/")) return next(url, context);
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
