// Line charts that share one cursor; each shows the time of the animation and seeks to where it is clicked.
import uPlot from "uplot";
import { element } from "./dom.js";
import { color, on_theme_change } from "./theme.js";

const HEIGHT = 250;
const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";
const made = [];

const superscript = (power) => String(power).replace("-", "⁻").replace(/\d/g, (digit) => SUPERSCRIPTS[digit]);

export function number_text(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e6 && size >= 1e-3) return String(Number(value.toPrecision(Math.max(digits, Math.ceil(Math.log10(size)))))).replace("-", "−");
  const [mantissa, power] = value.toExponential(digits - 1).split("e");
  const front = String(Number(mantissa)).replace("-", "−");
  return `${front === "1" ? "" : front === "−1" ? "−" : `${front}×`}10${superscript(Number(power))}`;
}

// As the summary writes costs: eight digits, in groups of three from ten thousand on.
export function cost_text(value) {
  const size = Math.abs(value);
  if (!(size >= 1e4 && size < 1e12)) return number_text(value, 8);
  const [whole, part] = String(Number(size.toPrecision(8))).split(".");
  return `${value < 0 ? "−" : ""}${whole.replace(/\B(?=(\d{3})+$)/g, "\u202f")}${part ? `.${part}` : ""}`;
}

function axis(scale, label, options = {}) {
  return { scale, label, labelSize: 20, labelGap: 2, labelFont: "12px system-ui, sans-serif", font: "11px system-ui, sans-serif",
    stroke: color("muted"), grid: { stroke: color("rule"), width: 1 }, ticks: { stroke: color("rule"), width: 1, size: 5 },
    values: (chart, splits) => splits.map((split) => (split === null ? "" : number_text(split, 6))), ...options };
}

const ROOM_FOR_BOUNDS = 0.35;  // of a curve's own range, on each side

// A range with some air, never narrower than what is round-off beside `floor`, the largest value of its kind. It widens towards
// bounds that are near, and leaves out those that would press the curve flat.
function padded_range(floor, bounds = []) {
  return (chart, low, high) => {
    if (low === null) return [0, 1];
    const middle = 0.5 * (low + high), half = Math.max(0.54 * (high - low), 1e-6 * floor || 1e-12);
    const range = [middle - half, middle + half];
    for (const { value } of bounds) {
      if (Math.abs(value - middle) > (1 + 2 * ROOM_FOR_BOUNDS) * half) continue;
      range[0] = Math.min(range[0], value - 0.06 * half);
      range[1] = Math.max(range[1], value + 0.06 * half);
    }
    return range;
  };
}

// Dashed lines at the bounds that lie in the picture.
function draw_bounds(bounds) {
  return (chart) => {
    const { ctx, bbox } = chart, ratio = devicePixelRatio;
    ctx.save();
    ctx.setLineDash([5 * ratio, 4 * ratio]);
    ctx.lineWidth = 1.25 * ratio;
    for (const { value, color: colour } of bounds) {
      const y = chart.valToPos(value, "y", true);
      if (!(y >= bbox.top && y <= bbox.top + bbox.height)) continue;
      ctx.strokeStyle = colour();
      ctx.beginPath();
      ctx.moveTo(bbox.left, y);
      ctx.lineTo(bbox.left + bbox.width, y);
      ctx.stroke();
    }
    ctx.restore();
  };
}

// "limit ±0.8 rad, dashed", or where none lies in the picture "beyond this picture".
function bounds_text(bounds, unit, range) {
  const values = [...new Set(bounds.map(({ value }) => value))].sort((a, b) => a - b);
  const shown = values.filter((value) => value >= range[0] && value <= range[1]).length;
  const pairs = values.filter((value) => value > 0 && values.includes(-value));
  const alone = values.filter((value) => !pairs.includes(Math.abs(value)));
  const names = [...pairs.map((value) => `±${number_text(value)}`), ...alone.map((value) => number_text(value))];
  const where = shown === 0 ? "beyond this picture" : shown < values.length ? "dashed where they are in this picture" : "dashed";
  return `${names.length > 1 ? "limits" : "limit"} ${names.join(", ")} ${unit}, ${where}`;
}

function add_time_mark(chart, clock) {
  const mark = element("div", { class: "time-mark" });
  chart.over.append(mark);
  const follow = () => {
    const left = chart.valToPos(clock.time, "x");
    mark.hidden = !(left >= 0 && left <= chart.over.clientWidth);
    mark.style.transform = `translateX(${left.toFixed(1)}px)`;
    if (!(chart.cursor.left >= 0)) chart.setLegend({ idx: nearest(chart.data[0], clock.time) }, false);
  };
  chart.hooks.setCursor = [...(chart.hooks.setCursor ?? []), () => { if (!(chart.cursor.left >= 0)) follow(); }];
  chart.hooks.draw = [...(chart.hooks.draw ?? []), follow];
  chart.over.addEventListener("click", () => clock.set(chart.posToVal(chart.cursor.left, "x")));
  return follow;
}

function nearest(sorted, value) {
  let low = 0, high = sorted.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= value) low = middle;
    else high = middle;
  }
  return value - sorted[low] <= sorted[high] - value ? low : high;
}

function draw(entry) {
  entry.chart?.destroy();
  entry.canvas_home.replaceChildren();
  const { options, data } = entry.make();
  const width = () => Math.max(entry.canvas_home.clientWidth, 240);
  entry.chart = new uPlot({ width: width(), height: HEIGHT, ...options }, data, entry.canvas_home);
  entry.follow = entry.clock ? add_time_mark(entry.chart, entry.clock) : () => {};
  entry.follow();
  entry.width = width;
}

// make() → {options, data} in today's colours; clock: none where the abscissa is not time.
function figure(title, make, clock, note = "") {
  const canvas_home = element("div", { class: "chart", role: "img", "aria-label": `Chart: ${title}` });
  const entry = { make, clock, canvas_home };
  made.push(entry);
  const node = element("figure", {}, element("figcaption", {}, title, note ? element("span", {}, ` ${note}`) : ""), canvas_home);
  new ResizeObserver(() => {
    if (!canvas_home.clientWidth) return;
    if (!entry.chart) draw(entry);
    else if (entry.chart.width !== entry.width()) entry.chart.setSize({ width: entry.width(), height: HEIGHT });
  }).observe(canvas_home);
  return node;
}

on_theme_change(() => made.filter((entry) => entry.chart).forEach(draw));

export function follow_clock(clock) {
  clock.listen(() => made.forEach((entry) => entry.chart && entry.follow()));
}

// curves: for each run {time, columns: [values, …]}; lines: [{label, color: () => colour, width}] for the columns of a run;
// bounds: [{value, color: () => colour}].
export function time_chart(title, unit, floor, lines, curves, clock, bounds = []) {
  const make = () => {
    const tables = curves.map(({ time, columns }) => [time, ...columns]);
    const series = curves.flatMap((curve, run) => lines.map((line) => ({
      label: curves.length > 1 ? `${line.label} ${"AB"[run]}` : line.label, stroke: line.color(), width: line.width ?? 1.75,
      dash: run ? [6, 4] : undefined, spanGaps: true, pxAlign: 0, points: { show: false }, value: (chart, value) => number_text(Math.abs(value) < 1e-10 * floor ? 0 : value),
    })));
    return {
      data: tables.length > 1 ? uPlot.join(tables) : tables[0],
      options: {
        scales: { x: { time: false, range: (chart, low, high) => [low, high] }, y: { range: padded_range(floor, bounds) } },
        hooks: { draw: [draw_bounds(bounds)] },
        axes: [axis("x", "time [s]", { size: 34 }), axis("y", unit, { size: 58 })],
        series: [{ label: "t [s]", value: (chart, value) => number_text(value) }, ...series],
        cursor: { sync: { key: "time" }, y: false, points: { size: 6 } }, legend: { markers: { width: 3, dash: (chart, index) => (chart.series[index].dash ? "dashed" : "solid") } },
      },
    };
  };
  if (!bounds.length) return figure(title, make, clock);
  const extent = extent_of(curves);
  return figure(title, make, clock, bounds_text(bounds, unit, padded_range(floor, bounds)(null, ...extent)));
}

// Least and largest value of all columns.
function extent_of(curves) {
  let low = null, high = null;
  for (const { columns } of curves) for (const values of columns) for (const value of values) {
    if (value === null) continue;
    if (low === null || value < low) low = value;
    if (high === null || value > high) high = value;
  }
  return [low, high];
}

// Powers of ten from low to high, at most about eight of them.
function decades(chart, index, low, high) {
  const first = Math.ceil(Math.log10(low) - 1e-9), last = Math.floor(Math.log10(high) + 1e-9), step = Math.ceil((last - first + 1) / 8);
  return Array.from({ length: Math.max(Math.floor((last - first) / step) + 1, 0) }, (unused, k) => 10 ** (first + k * step));
}

const positive = (values) => values.map((value) => (value > 0 ? value : null));

// history: {iteration, cost, goal_error, kkt}, cost on the right.
export function history_chart(title, history) {
  const make = () => {
    const columns = [positive(history.goal_error), positive(history.kkt), history.cost];
    const costs = history.cost.filter((cost) => cost !== null), least = Math.min(...costs), most = Math.max(...costs);
    const log_cost = least > 0 && most > 20 * least;
    const shows = (values) => values.some((value) => value !== null);
    const powers = { splits: decades, filter: (chart, splits) => splits, values: (chart, splits) => splits.map((split) => `10${superscript(Math.round(Math.log10(split)))}`) };
    const line = (label, scale, name, dash, visible) => ({ label, scale, stroke: color(name), width: 1.75, dash, show: visible,
      spanGaps: true, points: { show: history.iteration.length < 120, size: 5 }, value: (chart, value) => number_text(value) });
    return {
      data: [history.iteration, ...columns],
      options: {
        scales: { x: { time: false }, y: { distr: 3 }, cost: log_cost ? { distr: 3 } : { range: padded_range(most) } },
        axes: [axis("x", "iteration", { size: 34, incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000] }),
               axis("y", "goal error [rad, m], KKT", { size: 52, ...powers }),
               axis("cost", "cost [(N m)² s]", { side: 1, size: 54, grid: { show: false }, ...(log_cost ? powers : {}) })],
        series: [{ label: "iteration" }, line("goal error", "y", "second", [], shows(columns[0])),
                 line("KKT", "y", "third", [8, 4], shows(columns[1])), line("cost", "cost", "first", [2, 3], shows(columns[2]))],
        cursor: { y: false, points: { size: 6 } },
      },
    };
  };
  return figure(title, make, null);
}
