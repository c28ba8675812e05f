// The sections made of words and numbers.
import { cost_text, history_chart } from "./charts.js";
import { element, section, show, table } from "./dom.js";

const MARKS = { true: "✓", false: "✗", null: "" };
const READINGS = { true: "holds", false: "does not hold", null: "" };
const LONG_NUMBER = 28;  // letters of a certificate's value, which are words then
const LONG_FACT = 90;  // letters, beyond which it has a line of its own
const label = (runs, index) => (runs.length > 1 ? `${"AB"[index]}: ` : "");

function facts(rows, look) {
  return element("dl", { class: look }, ...rows.map(([name, value]) => element("div", { class: value.length > LONG_FACT ? "long" : "" },
    element("dt", {}, name), element("dd", { class: name === "Cost" ? "cost" : "" }, value))));
}

function verdict_card(run, prefix) {
  return element("div", { class: "card" },
    element("h1", {}, prefix + run.name),
    run.source ? element("p", { class: "source" }, run.source) : null,
    element("p", { class: `status ${run.good ? "good" : "poor"}` },
      element("span", { class: "badge", "aria-hidden": "true" }, run.good ? "✓" : "!"), run.verdict),
    run.warning ? element("p", { class: "status warning" }, element("span", { class: "badge", "aria-hidden": "true" }, "⚠"), run.warning) : null,
    ...run.paragraphs.map((words) => element("p", { class: "message" }, words)),
    run.remedies.length ? element("p", { class: "try" }, "Try:") : null,
    run.remedies.length ? element("ul", { class: "remedies" }, ...run.remedies.map((words) => element("li", {}, words))) : null,
    facts(run.figures, "facts figures-first"),
    run.details.length ? element("details", {}, element("summary", {}, "Details"), facts(run.details, "facts")) : null);
}

export function show_verdict(runs) {
  section("verdict").append(element("p", { class: "overline" }, runs.length > 1 ? "Lamprey · comparison" : "Lamprey · report"),
    element("div", { class: "cards" }, ...runs.map((run, index) => verdict_card(run, label(runs, index)))));
}

function certificate_cells({ value, mark, holds }) {
  return element("span", { class: value === "not computed" ? "lacks" : value.length > LONG_NUMBER ? "words" : "cell" }, value, holds === null ? null
    : element("span", { class: holds ? "holds" : "fails", "aria-label": READINGS[holds] }, ` ${MARKS[holds]}`));
}

export function show_certificate(runs) {
  const certified = runs.filter((run) => run.certificate);
  if (!certified.length) return;
  const names = runs.length > 1 ? certified.map((run) => "AB"[runs.indexOf(run)]) : ["Value"];
  const rows = certified[0].certificate.map((row, index) => [
    element("span", {}, row.name, row.stored ? element("span", { class: "stored" }, " (stored by the solver)") : null,
      element("span", { class: "meaning" }, row.meaning)),
    ...certified.map((run) => certificate_cells(run.certificate[index])), row.mark]);
  show("certificate", element("p", {}, "Computed from the stored numbers alone, by other code than the solver’s, but for rows that are the solver’s own records."),
    table(["Number", ...names, "Required"], rows, "certificate"));
}

function minima(run) {
  const rows = run.minima.slice(0, 50).map(([cost, count], index) => [String(index + 1), cost_text(cost), String(count)]);
  const rest = run.minima.length - rows.length;
  return [element("p", {}, `${run.search.solved} of ${run.search.starts} first guesses${run.search.hops ? ` and ${run.search.hops} hops` : ""} arrived; the minima that they found, by rising cost (stored by the solver):`),
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
