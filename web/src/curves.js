// Which curves are drawn: the panels of the paper's Figures 2 and 3.
import { time_chart } from "./charts.js";
import { choice, element, show, table } from "./dom.js";
import { color } from "./theme.js";

const AXES = ["e₁", "e₂", "e₃"];
const FIRST_SHOWN = 8;
const components = ["first", "second", "third"].map((name, k) => ({ label: AXES[k], color: () => color(name) }));
// What the entries of a joint's angle are, by its kind.
const TURNS = { hinge: ["θ"], universal: ["θ₁", "θ₂"], ball: AXES, fixed: [] };
// What those of its moment are.
const MOMENTS = { hinge: ["axis"], universal: ["axis 1", "axis 2"], ball: AXES, fixed: [] };
const OWN_CURVES = ["ink", "muted"];  // colours of what only limits ask for
const shares = [
  { label: "bodies", color: () => color("first") }, { label: "fluid", color: () => color("second") },
  { label: "total", color: () => color("ink"), width: 2.25 },
];

// Every stride-th value of a flat array, from the first-th on.
const column = (values, stride, first) => Array.from({ length: values.length / stride }, (unused, k) => values[k * stride + first]);

function largest(runs, pick) {
  let most = 0;
  for (const run of runs) for (const value of pick(run.frames)) if (Math.abs(value) > most) most = Math.abs(value);
  return most;
}

const ROUND_OFF = 1e-9;  // of the largest of its kind: less is none

// Of a motion in the plane the curves that are not zero throughout; the others are so by what the plane is.
const is_shown = (runs, curves, floor, k) => !runs.every((run) => run.planar) ||
  curves.some(({ columns }) => columns[k].some((value) => Math.abs(value) > ROUND_OFF * floor));

// The chart of those lines that show, each with its place; none where they all are zero while others of their kind are not.
function chart_of(title, unit, floor, lines, curves, runs, clock, bounds = [], always = () => false) {
  const chosen = lines.map((unused, k) => k).filter((k) => always(k) || is_shown(runs, curves, floor, k));
  if (!chosen.length && floor > 0) return null;
  const kept = chosen.length ? chosen : lines.map((unused, k) => k);
  return time_chart(title, unit, floor, kept.map((k) => lines[k]),
    curves.map(({ time, columns }) => ({ time, columns: kept.map((k) => columns[k]) })), clock, bounds);
}

// Three components of one vector among those that each frame stores in `pick(frames)`.
function vector_chart(title, unit, runs, pick, count, index, clock) {
  const curves = runs.map(({ frames }) => ({ time: frames.time,
    columns: [0, 1, 2].map((k) => column(pick(frames), 3 * count, 3 * index + k)) }));
  return chart_of(title, unit, largest(runs, pick), components, curves, runs, clock);
}

// Bounds of a chart: each in its curve's colour, or, where several curves share it, in none.
function bounds_of(limits, colours) {
  const users = new Map();
  limits.forEach((limit, n) => limit.bounds.forEach((value) => users.set(value, [...(users.get(value) ?? []), colours[n]])));
  return [...users].map(([value, its]) => ({ value, color: its.length > 1 ? () => color("muted") : its[0] }));
}

// Curves of one joint, with the bounds that limits set them and the curves that only limits ask for.
function joint_chart({ title, unit, kind, labels, pick, floor }, index, runs, clock) {
  const count = runs[0].joints.length;
  const lines = labels.map((label, k) => ({ ...components[k], label }));
  const limits = runs[0].limit_curves.filter((limit) => limit.joint === index && limit.kind === kind);
  const own = limits.filter((limit) => limit.line === undefined);
  const own_lines = own.map(({ label }, n) => ({ label, color: () => color(lines.length ? OWN_CURVES[n % 2] : ["first", "second", "third"][n % 3]) }));
  const in_run = (run, wanted) => run.limit_curves.find((limit) => limit.joint === index && limit.kind === kind && limit.label === wanted.label);
  const curves = runs.map((run) => ({ time: run.frames.time, columns: [
    ...lines.map((line, k) => column(pick(run.frames), 3 * count, 3 * index + k)),
    ...own.map((wanted) => in_run(run, wanted)?.values ?? run.frames.time.map(() => null))] }));
  const colours = limits.map((limit) => (limit.line === undefined ? own_lines[own.indexOf(limit)].color : components[limit.line].color));
  const limited = (k) => k >= lines.length || limits.some((limit) => limit.line === k);
  return chart_of(title, unit, floor, [...lines, ...own_lines], curves, runs, clock, bounds_of(limits, colours), limited);
}

// How far a joint has turned from its zero angle.
function angle_chart(joint, index, runs, clock) {
  const what = joint.kind === "ball" ? "rotation vector" : joint.kind === "hinge" ? "angle" : "angles";
  return joint_chart({ title: `${joint.name}: ${what} from zero`, unit: "rad", kind: "angle", labels: TURNS[joint.kind],
    pick: (f) => f.joint_angle, floor: largest(runs, (f) => f.joint_angle) }, index, runs, clock);
}

function moment_chart(joint, index, runs, clock) {
  const parent = runs[0].bodies[joint.parent].name;
  const what = joint.kind === "hinge" ? "moment of its motor" : joint.kind === "universal" ? "moments of its motors" : "moment";
  return joint_chart({ title: `${joint.name}: ${what} on ${parent}${joint.kind === "ball" ? ", its frame" : ""}`, unit: "N m", kind: "moment",
    labels: MOMENTS[joint.kind], pick: (f) => f.joint_moment, floor: largest(runs, (f) => f.joint_moment) }, index, runs, clock);
}

function rate_chart(joint, index, runs, clock) {
  return joint_chart({ title: `${joint.name}: rate, mean over the step before`, unit: "rad/s", kind: "rate", labels: [], floor: 0 }, index, runs, clock);
}

function momentum_chart(kind, unit, preposition, runs, axis, clock) {
  const of = (frames, share) => frames[`${kind}_momentum`][share];
  const curves = runs.map(({ frames }) => ({ time: frames.time,
    columns: shares.map(({ label }) => column(of(frames, label), 3, axis)) }));
  const name = kind[0].toUpperCase() + kind.slice(1);
  return time_chart(`${name} momentum ${preposition} ${AXES[axis]}`, unit,
    largest(runs, (frames) => [...of(frames, "bodies"), ...of(frames, "fluid")]), shares, curves, clock);
}

const grid = (...figures) => element("div", { class: "figures" }, ...figures.filter((one) => one));

// The first few at once, the others on request.
function many(figure, count, what) {
  const shown = Math.min(count, FIRST_SHOWN);
  const nodes = [grid(...Array.from({ length: shown }, (unused, i) => figure(i)))];
  if (count > shown) {
    const more = element("details", {}, element("summary", {}, `${count - shown} more ${what}`));
    more.addEventListener("toggle", () => {
      more.append(grid(...Array.from({ length: count - shown }, (unused, i) => figure(shown + i))));
    }, { once: true });
    nodes.push(more);
  }
  return nodes;
}

// One kind of momentum with the choice of its axis, which begins where there is most to see.
function momentum_by_axis(kind, unit, preposition, runs, clock) {
  const home = element("div");
  const fill = (axis) => home.replaceChildren(momentum_chart(kind, unit, preposition, runs, axis, clock));
  const most = [0, 1, 2].map((axis) => largest(runs, (f) =>
    ["bodies", "fluid"].flatMap((share) => column(f[`${kind}_momentum`][share], 3, axis))));
  const first = most.indexOf(Math.max(...most));
  fill(first);
  const axes = [0, 1, 2].filter((axis) => !runs.every((run) => run.planar) || most[axis] > ROUND_OFF * most[first] || axis === first);
  return element("div", {}, choice(`Axis of the ${kind} momentum`, axes.map((axis) => AXES[axis]), axes.indexOf(first), (index) => fill(axes[index])), home);
}

function momentum(runs, clock) {
  return [element("h3", {}, "Momentum of the bodies, of the fluid, and total (world frame)"),
    grid(momentum_by_axis("linear", "kg m/s", "along", runs, clock), momentum_by_axis("angular", "kg m²/s", "about", runs, clock))];
}

export function show_curves(runs, clock) {
  const { bodies, joints } = runs[0];
  const heading = (text) => element("h3", {}, text);
  show("curves",
    heading("Velocities"),
    ...many((i) => (i === 0
      ? vector_chart(`V₀: linear velocity of ${bodies[0].name}, its own frame`, "m/s", runs, (f) => f.linear_velocity, 1, 0, clock)
      : vector_chart(`Ω${i <= 10 ? "₀₁₂₃₄₅₆₇₈₉"[i - 1] : ` ${i - 1}`}: angular velocity of ${bodies[i - 1].name}, its own frame`, "rad/s", runs,
        (f) => f.angular_velocity, bodies.length, i - 1, clock)), bodies.length + 1, "angular velocities"),
    ...momentum(runs, clock));
  if (!joints.length) return;
  const asked = runs.filter((run) => run.demands.length);
  if (asked.length) {
    show("curves", heading("What the motion asks of the joints"), ...asked.flatMap((run) => [
      runs.length > 1 ? element("p", {}, `${"AB"[runs.indexOf(run)]}: ${run.name}`) : "", table(run.demand_heads, run.demands, "numbers")]));
  }
  const all = joints.map((joint, j) => [joint, j]), moving = all.filter(([joint]) => TURNS[joint.kind].length);
  const limited = all.filter(([, j]) => runs[0].limit_curves.some((limit) => limit.joint === j && limit.kind === "rate"));
  const charts = (chart, chosen) => many((i) => chart(...chosen[i], runs, clock), chosen.length, "joints");
  if (moving.length && runs.every(({ frames }) => frames.joint_angle.length)) {
    show("curves", heading("Joint angles"), ...charts(angle_chart, moving));
  }
  if (limited.length) show("curves", heading("Joint rates"), ...charts(rate_chart, limited));
  if (moving.length) show("curves", heading("Control moments"), ...charts(moment_chart, moving));
}
