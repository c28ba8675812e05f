// Builds dist/report.html: the report page with its script and style inside, allowed by their hashes and nothing else.
// report_html (src/report/report.cpp) fills the marks %TITLE%, %SNAPSHOTS% and %DATA%.
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync, mkdirSync } from "node:fs";
import { buildSync } from "esbuild";

const LIBRARIES = ["three", "uplot"];
const TARGET = ["chrome110", "firefox110", "safari16"];

const text = (path) => readFileSync(path, "utf8");
const digest = (content) => `sha256-${createHash("sha256").update(content, "utf8").digest("base64")}`;

function bundle(entry, options) {
  const built = buildSync({ entryPoints: [entry], bundle: true, minify: true, write: false, target: TARGET,
                            legalComments: "eof", logLevel: "warning", ...options });
  return built.outputFiles[0].text;
}

function licences() {
  return LIBRARIES.map((name) => {
    const { version } = JSON.parse(text(`node_modules/${name}/package.json`));
    return `${name} ${version}\n\n${text(`node_modules/${name}/LICENSE`).replace(/\r/g, "").trim()}\n`;
  }).join("\n----\n\n");
}

function insert(page, mark, content) {
  const parts = page.split(mark);
  if (parts.length !== 2) throw new Error(`page.html: ${mark} must stand there once, found ${parts.length - 1}`);
  return parts[0] + content + parts[1];
}

mkdirSync("dist", { recursive: true });
const notices = licences();
const script = bundle("src/main.js", { format: "iife", banner: { js: `/*!\n${notices}*/` } });
const style = bundle("src/page.css", {});
for (const mark of ["%TITLE%", "%SNAPSHOTS%", "%DATA%"]) {
  if (script.includes(mark) || style.includes(mark)) throw new Error(`the bundle contains the mark ${mark}`);
}
let page = text("src/page.html");
page = insert(page, "%SCRIPT_HASH%", digest(script));
page = insert(page, "%STYLE_HASH%", digest(style));
page = insert(page, "%STYLE%", style);
page = insert(page, "%SCRIPT%", script);
writeFileSync("dist/report.html", page);
writeFileSync("dist/THIRD_PARTY_LICENSES.txt", notices);
