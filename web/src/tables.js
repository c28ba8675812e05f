// The sections made of words and numbers.
import { history_chart, number_text } from "./charts.js";
import { element, section, show, table } from "./dom.js";

const MARKS = { true: "✓", false: "✗", null: "" };
const READINGS = { true: "holds", false: "does not hold", null: "" };
const LONG_FACT = 90;  // letters, beyond which it has a line of its own
const label = (runs, index) => (runs.length > 1 ? `${"AB"[index]}: ` : "");

function verdict_card(run, prefix) {
  return element("div", { class: "card" },
    element("h1", {}, prefix + run.name),
    run.source ? element("p", { class: "source" }, run.source) : null,
    element("p", { class: `status ${run.good ? "good" : "poor"}` },
      element("span", { class: "badge", "aria-hidden": "true" }, run.good ? "✓" : "!"), run.verdict),
    run.message ? element("p", { class: "message" }, run.message) : null,
    element("dl", { class: "facts" }, ...run.facts.map(([name, value]) => element("div", { class: value.length > LONG_FACT ? "long" : "" },
      element("dt", {}, name), element("dd", { class: name === "Cost" ? "cost" : "" }, value)))));
}

export function show_verdict(runs) {
  section("verdict").append(element("p", { class: "overline" }, runs.length > 1 ? "Lamprey · comparison" : "Lamprey · report"),
    element("div", { class: "cards" }, ...runs.map((run, index) => verdict_card(run, label(runs, index)))));
}

function certificate_cells({ value, mark, holds }) {
  return element("span", { class: value === "not computed" ? "lacks" : "cell" }, value, holds === null ? null
    : element("span", { class: holds ? "holds" : "fails", "aria-label": READINGS[holds] }, ` ${MARKS[holds]}`));
}

export function show_certificate(runs) {
  const certified = runs.filter((run) => run.certificate);
  if (!certified.length) return;
  const names = runs.length > 1 ? certified.map((run) => "AB"[runs.indexOf(run)]) : ["Value"];
  const rows = certified[0].certificate.map((row, index) => [
    element("span", {}, row.name, element("span", { class: "meaning" }, row.meaning)),
    ...certified.map((run) => certificate_cells(run.certificate[index])), row.mark]);
  show("certificate", element("p", {}, "Computed from the stored numbers alone, by other code than the solver’s."),
    table(["Number", ...names, "Held to"], rows, "certificate"));
}

function minima(run) {
  const rows = run.minima.slice(0, 50).map(([cost, count], index) => [String(index + 1), number_text(cost, 10), String(count)]);
  const rest = run.minima.length - rows.length;
  return [element("p", {}, `${run.search.solved} of ${run.search.starts} starts${run.search.hops ? ` and ${run.search.hops} hops` : ""} reached a solution; distinct minima found, by rising cost:`),
    table(["", "Cost [(N m)² s]", "Times found"], rows, "numbers"),
    rest > 0 ? element("p", {}, `and ${rest} more`) : ""];
}

export function show_search(runs) {
  runs.forEach((run, index) => {
    if (!run.search && !run.history) return;
    if (runs.length > 1) show("search", element("h3", {}, label(runs, index) + run.name));
    show("search", element("div", { class: "figures" }, run.search ? element("div", {}, ...minima(run)) : null,
      run.history ? history_chart("Progress of the solver", run.history) : null));
  });
}

export function show_problem(runs) {
  runs.forEach((run, index) => {
    const { problem } = run;
    show("problem", ...[runs.length > 1 ? element("h3", {}, label(runs, index) + run.name) : null,
      table(["Setting", "Value"], problem.settings, "settings"),
      element("h3", {}, "Bodies"), table(problem.body_heads, problem.body_rows, "numbers"),
      ...(problem.joint_rows.length ? [element("h3", {}, "Joints"), table(problem.joint_heads, problem.joint_rows, "numbers")] : []),
    ].filter((node) => node !== null));
  });
}

export function show_provenance(runs) {
  runs.forEach((run, index) => show("provenance", ...(runs.length > 1 ? [element("h3", {}, label(runs, index) + run.name)] : []),
    table(["What", "Value"], run.provenance, "settings")));
}
