// The loop of shapes over the height functions of a swimmer that moves in a plane.
import { number_text } from "./charts.js";
import { element, show, table } from "./dom.js";
import { color, on_theme_change } from "./theme.js";

const MARGIN = { left: 56, right: 10, top: 8, bottom: 42 };
const PIXELS = 160; // of the picture of heights, along each variable
const LEVELS = [-0.75, -0.5, -0.25, 0.25, 0.5, 0.75]; // of the largest height, beside zero
const AXES = ["e₁", "e₂", "e₃"];

const rgb = (name) => {
  const digits = color(name).replace("#", "");
  return [0, 2, 4].map((k) => parseInt(digits.slice(k, k + 2), 16));
};

// Heights at node i of the first variable and j of the second, linear between them.
class Field {
  constructor(values, count) {
    this.values = values;
    this.count = count;
    this.largest = Math.max(...values.map(Math.abs));
  }

  at_node(i, j) { return this.values[i * this.count + j]; }

  at(x, y) { // each from 0 to 1 over the rectangle
    const last = this.count - 1, i = Math.min(Math.floor(x * last), last - 1), j = Math.min(Math.floor(y * last), last - 1);
    const s = x * last - i, t = y * last - j;
    return (1 - s) * ((1 - t) * this.at_node(i, j) + t * this.at_node(i, j + 1)) +
      s * ((1 - t) * this.at_node(i + 1, j) + t * this.at_node(i + 1, j + 1));
  }

  // Stretches of the line where the height is `level`: [[x, y], [x, y]] each, cell by cell.
  contour(level) {
    const last = this.count - 1, stretches = [];
    for (let i = 0; i < last; ++i) for (let j = 0; j < last; ++j) {
      const corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]], crossings = [];
      corners.forEach(([a, b], k) => {
        const [c, d] = corners[(k + 1) % 4], from = this.at_node(a, b) - level, to = this.at_node(c, d) - level;
        if ((from < 0) === (to < 0)) return;
        const share = from / (from - to);
        crossings.push([(a + share * (c - a)) / last, (b + share * (d - b)) / last]);
      });
      for (let k = 0; k + 1 < crossings.length; k += 2) stretches.push([crossings[k], crossings[k + 1]]);
    }
    return stretches;
  }
}

function picture(field) {
  const canvas = element("canvas", { width: PIXELS, height: PIXELS }), pen = canvas.getContext("2d");
  const image = pen.createImageData(PIXELS, PIXELS), ground = rgb("panel"), low = rgb("first"), high = rgb("second");
  for (let row = 0; row < PIXELS; ++row) for (let column = 0; column < PIXELS; ++column) {
    const height = field.at((column + 0.5) / PIXELS, 1 - (row + 0.5) / PIXELS) / (field.largest || 1);
    const tint = height < 0 ? low : high, share = 0.8 * Math.min(Math.abs(height), 1);
    for (let k = 0; k < 3; ++k) image.data[4 * (row * PIXELS + column) + k] = ground[k] + share * (tint[k] - ground[k]);
    image.data[4 * (row * PIXELS + column) + 3] = 255;
  }
  pen.putImageData(image, 0, 0);
  return canvas;
}

// Round numbers within a range, about five.
function ticks(low, high) {
  const rough = (high - low) / 5, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((digit) => digit * power >= rough);
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (unused, k) => (first + k) * step);
}

class LoopChart {
  constructor(field, at, runs, time, names) {
    Object.assign(this, { field, at, runs, time, names });
    this.canvas = element("canvas", { role: "img", "aria-label": `Height function over ${names.join(" and ")}, with the motion's loop` });
    this.still = document.createElement("canvas");
    new ResizeObserver(() => this.lay_out()).observe(this.canvas);
    on_theme_change(() => this.lay_out());
  }

  lay_out() {
    const width = this.canvas.clientWidth;
    if (!width) return;
    const ratio = window.devicePixelRatio || 1;
    this.side = width - MARGIN.left - MARGIN.right;
    const height = this.side + MARGIN.top + MARGIN.bottom;
    this.canvas.style.height = `${height}px`;
    for (const canvas of [this.canvas, this.still]) Object.assign(canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
    this.ratio = ratio;
    this.draw_still();
    this.draw();
  }

  place([first, second]) {
    const share = (n, value) => (value - this.at[n][0]) / (this.at[n][this.at[n].length - 1] - this.at[n][0]);
    return [MARGIN.left + this.side * share(0, first), MARGIN.top + this.side * (1 - share(1, second))];
  }

  draw_still() {
    const pen = this.still.getContext("2d");
    pen.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    pen.clearRect(0, 0, this.still.width, this.still.height);
    pen.imageSmoothingEnabled = true;
    pen.drawImage(picture(this.field), MARGIN.left, MARGIN.top, this.side, this.side);
    const stroke = (level) => {
      pen.beginPath();
      for (const stretch of this.field.contour(level)) {
        const [from, to] = stretch.map(([x, y]) => [MARGIN.left + this.side * x, MARGIN.top + this.side * (1 - y)]);
        pen.moveTo(...from);
        pen.lineTo(...to);
      }
      pen.stroke();
    };
    pen.strokeStyle = color("muted");
    pen.lineWidth = 0.5;
    if (this.field.largest > 0) {
      LEVELS.forEach((level) => stroke(level * this.field.largest));
      pen.lineWidth = 1.5;
      stroke(0);
    }
    this.draw_axes(pen);
    this.draw_loop(pen);
  }

  draw_axes(pen) {
    pen.strokeStyle = color("rule");
    pen.lineWidth = 1;
    pen.strokeRect(MARGIN.left, MARGIN.top, this.side, this.side);
    pen.fillStyle = color("muted");
    pen.font = "11px system-ui, sans-serif";
    const [low, high] = [0, 1].map((n) => [this.at[n][0], this.at[n][this.at[n].length - 1]]);
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const tick of ticks(...low)) pen.fillText(number_text(tick, 3), this.place([tick, 0])[0], MARGIN.top + this.side + 5);
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const tick of ticks(...high)) pen.fillText(number_text(tick, 3), MARGIN.left - 6, this.place([0, tick])[1]);
    pen.font = "12px system-ui, sans-serif";
    pen.textAlign = "center";
    pen.textBaseline = "bottom";
    pen.fillText(`${this.names[0]} [rad]`, MARGIN.left + this.side / 2, MARGIN.top + this.side + MARGIN.bottom - 4);
    pen.save();
    pen.translate(13, MARGIN.top + this.side / 2);
    pen.rotate(-Math.PI / 2);
    pen.fillText(`${this.names[1]} [rad]`, 0, 4);
    pen.restore();
  }

  draw_loop(pen) {
    const points = this.runs[0].map((first, k) => this.place([first, this.runs[1][k]]));
    pen.strokeStyle = pen.fillStyle = color("ink");
    pen.lineWidth = 2;
    pen.lineJoin = "round";
    pen.beginPath();
    points.forEach((point, k) => (k ? pen.lineTo(...point) : pen.moveTo(...point)));
    pen.stroke();
    // an arrow a quarter of the way along
    const lengths = points.map((point, k) => (k ? Math.hypot(point[0] - points[k - 1][0], point[1] - points[k - 1][1]) : 0));
    const whole = lengths.reduce((sum, length) => sum + length, 0);
    let done = 0;
    const k = lengths.findIndex((length) => (done += length) > 0.25 * whole);
    if (k < 1) return;
    const turn = Math.atan2(points[k][1] - points[k - 1][1], points[k][0] - points[k - 1][0]);
    pen.save();
    pen.translate(...points[k]);
    pen.rotate(turn);
    pen.beginPath();
    pen.moveTo(7, 0);
    pen.lineTo(-5, 5);
    pen.lineTo(-5, -5);
    pen.fill();
    pen.restore();
  }

  draw() {
    if (!this.side) return;
    const pen = this.canvas.getContext("2d");
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    pen.drawImage(this.still, 0, 0);
    pen.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    pen.fillStyle = color("path");
    pen.strokeStyle = color("panel");
    pen.lineWidth = 1.5;
    pen.beginPath();
    pen.arc(...this.place(this.shape_now()), 5.5, 0, 2 * Math.PI);
    pen.fill();
    pen.stroke();
  }

  shape_now() {
    const { time } = this;
    let k = time.findIndex((t) => t >= this.now);
    if (k < 0) k = time.length - 1;
    if (k === 0) return [this.runs[0][0], this.runs[1][0]];
    const share = (this.now - time[k - 1]) / (time[k] - time[k - 1]);
    return this.runs.map((run) => run[k - 1] + share * (run[k] - run[k - 1]));
  }

  follow(clock) {
    this.now = clock.time;
    this.draw();
  }
}

// To four digits of what is as large as the heights: less of it is nothing.
function sum_text(value, scale, unit) {
  if (!Number.isFinite(value)) return "–";
  if (!(scale > 0)) return `0 ${unit}`;
  const digits = Math.min(Math.max(3 - Math.floor(Math.log10(scale)), 0), 20);
  return `${number_text(Number(value.toFixed(digits)))} ${unit}`;
}

function figures(run, clock) {
  const { heights, frames } = run, count = heights.at[0].length;
  const along = [AXES[(heights.normal + 1) % 3], AXES[(heights.normal + 2) % 3]];
  const kinds = [[`Along ${along[0]}`, "m"], [`Along ${along[1]}`, "m"], [`Turn about ${AXES[heights.normal]}`, "rad"]];
  return element("div", { class: "heights" }, ...kinds.map(([title, unit], k) => {
    const field = new Field(heights.height[k], count), chart = new LoopChart(field, heights.at, heights.run, frames.time, heights.variable);
    clock.listen(() => chart.follow(clock));
    const size = element("span", {}, field.largest > 0 ? ` ±${number_text(field.largest, 3)} ${unit}/rad²` : " none");
    const sums = heights.moved ? element("p", { class: "sums" }, `Volume over the loop ${sum_text(heights.by_volume[k], field.largest, unit)}, moved ${sum_text(heights.moved[k], field.largest, unit)}`) : null;
    return element("figure", {}, element("figcaption", {}, title, size), chart.canvas, sums);
  }));
}

function modes(run) {
  const { heights } = run;
  if (!heights.modes) return "";
  return element("details", {}, element("summary", {}, `s₁ and s₂ span the plane nearest to the motion’s shapes, which are beside it by up to ${number_text(heights.beside, 3)} rad`),
    table(["Angle [rad]", "by s₁", "by s₂"], heights.modes, "numbers"));
}

export function show_shapes(runs, clock) {
  const known = runs.filter((run) => run.heights);
  if (!known.length) return;
  show("shapes", element("p", {}, "Each map shows how much a small loop of shapes, run counter-clockwise, moves the swimmer (orange forward, blue backward; contours at quarters of the maximum, heavy at zero). " +
    "The swimmer moves by roughly the volume its loop encloses, measured in the frame that changes of shape disturb least, so it differs slightly from the root’s displacement. " +
    "The loop is this motion’s, the dot its shape at the time of the animation."));
  for (const run of known) {
    if (runs.length > 1) show("shapes", element("h3", {}, `${"AB"[runs.indexOf(run)]}: ${run.name}`));
    const lacking = run.heights.lacking ? element("p", { class: "sums" }, `No volume is compared with a displacement: ${run.heights.lacking}.`) : "";
    show("shapes", figures(run, clock), lacking, modes(run));
  }
}
