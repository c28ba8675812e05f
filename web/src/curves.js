// Which curves are drawn: the panels of the paper's Figures 2 and 3.
import { time_chart } from "./charts.js";
import { choice, element, show, table } from "./dom.js";
import { color } from "./theme.js";

const AXES = ["e₁", "e₂", "e₃"];
const FIRST_SHOWN = 8;
const components = ["first", "second", "third"].map((name, k) => ({ label: AXES[k], color: () => color(name) }));
// What the entries of a joint's angle are, by its kind.
const TURNS = { hinge: ["θ"], universal: ["θ₁", "θ₂"], ball: AXES, fixed: [] };
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

// Three components of one vector among those that each frame stores in `pick(frames)`.
function vector_chart(title, unit, runs, pick, count, index, clock) {
  const curves = runs.map(({ frames }) => ({ time: frames.time,
    columns: [0, 1, 2].map((k) => column(pick(frames), 3 * count, 3 * index + k)) }));
  return time_chart(title, unit, largest(runs, pick), components, curves, clock);
}

// How far a joint has turned from its zero angle.
function angle_chart(joint, index, runs, count, clock) {
  const lines = TURNS[joint.kind].map((label, k) => ({ ...components[k], label }));
  const curves = runs.map(({ frames }) => ({ time: frames.time,
    columns: lines.map((line, k) => column(frames.joint_angle, 3 * count, 3 * index + k)) }));
  const what = joint.kind === "ball" ? "rotation vector" : joint.kind === "hinge" ? "angle" : "angles";
  return time_chart(`${joint.name}: ${what} from zero`, "rad", largest(runs, (f) => f.joint_angle), lines, curves, clock);
}

function momentum_chart(kind, unit, preposition, runs, axis, clock) {
  const of = (frames, share) => frames[`${kind}_momentum`][share];
  const curves = runs.map(({ frames }) => ({ time: frames.time,
    columns: shares.map(({ label }) => column(of(frames, label), 3, axis)) }));
  const name = kind[0].toUpperCase() + kind.slice(1);
  return time_chart(`${name} momentum ${preposition} ${AXES[axis]}`, unit,
    largest(runs, (frames) => [...of(frames, "bodies"), ...of(frames, "fluid")]), shares, curves, clock);
}

const grid = (...figures) => element("div", { class: "figures" }, ...figures);

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
  return element("div", {}, choice(`Axis of the ${kind} momentum`, AXES, first, fill), home);
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
  const moving = joints.map((joint, j) => [joint, j]).filter(([joint]) => TURNS[joint.kind].length);
  if (moving.length && runs.every(({ frames }) => frames.joint_angle.length)) {
    show("curves", heading("Joint angles"), ...many((i) => angle_chart(...moving[i], runs, joints.length, clock), moving.length, "joints"));
  }
  show("curves", heading("Control moments"), ...many((j) => vector_chart(
    `${joints[j].name}: moment on ${bodies[joints[j].parent].name}, its frame`, "N m", runs, (f) => f.control, joints.length, j, clock),
  joints.length, "joints"));
}
