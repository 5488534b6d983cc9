// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Builds ../templates/report.js and report.css, which the page carries inline: one script and one style, with the licences of
// what they bundle on top, since every page that is handed on hands these on too.
import { createHash } from "node:crypto";
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { build } from "esbuild";

const BUNDLED = { leaflet: "Leaflet", three: "three.js" };
const OUT = new URL("../templates/", import.meta.url);

/** Returns a hash of package.json and all sources, by which a test tells whether the built files are those of the sources. */
function sourcesHash() {
  const hash = createHash("sha256");
  for (const name of ["package.json", ...readdirSync(new URL("src/", import.meta.url)).sort().map((file) => `src/${file}`)]) {
    hash.update(`${name}\n`).update(readFileSync(new URL(name, import.meta.url)));
  }
  return hash.digest("hex");
}

function licences() {
  const texts = Object.entries(BUNDLED).map(([name, title]) => {
    const { version } = JSON.parse(readFileSync(new URL(`node_modules/${name}/package.json`, import.meta.url), "utf8"));
    return `${title} ${version}\n\n${readFileSync(new URL(`node_modules/${name}/LICENSE`, import.meta.url), "utf8").trim()}`;
  });
  return `/*! hullrecon's report page, Apache-2.0, of sources ${sourcesHash()}. Bundled:\n\n${texts.join("\n\n---\n\n").replaceAll("*/", "* /")}\n*/`;
}

const result = await build({
  entryPoints: { report: "src/main.js" },
  absWorkingDir: new URL(".", import.meta.url).pathname,
  bundle: true,
  minify: true,
  format: "iife",
  target: ["chrome100", "firefox100", "safari15"],
  charset: "utf8",
  legalComments: "none", // their whole texts are in the banner
  loader: { ".png": "dataurl" },
  outdir: OUT.pathname,
  write: false,
});
for (const file of result.outputFiles) {
  const text = file.text.trimEnd();
  if (/<\/(script|style)/i.test(text)) throw new Error(`${file.path} would end its own element in the page`);
  writeFileSync(file.path, `${licences()}\n${text}\n`);
  console.log(file.path, `${(text.length / 1000).toFixed(0)} kB`);
}
