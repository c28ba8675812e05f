// The motion section: the picture, its buttons, the slider and the keys.
import { Vector3 } from "three";
import { element, choice, show, swatch } from "./dom.js";
import { Picture, VIEWS } from "./scene.js";
import { body_color, color, on_theme_change } from "./theme.js";

const SPEEDS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 50];
const SVG = "http://www.w3.org/2000/svg";

// A small cross of axes that turns with the camera.
function axes_cross(picture) {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("viewBox", "-40 -40 80 80");
  svg.setAttribute("class", "axes");
  svg.setAttribute("aria-hidden", "true");
  const parts = ["e₁", "e₂", "e₃"].map((name) => {
    const line = svg.appendChild(document.createElementNS(SVG, "line"));
    const label = svg.appendChild(document.createElementNS(SVG, "text"));
    label.textContent = name;
    return { line, label };
  });
  picture.listeners.push((camera) => parts.forEach(({ line, label }, axis) => {
    const tip = new Vector3().setComponent(axis, 1).applyQuaternion(camera.quaternion.clone().invert());
    line.setAttribute("x2", (24 * tip.x).toFixed(1));
    line.setAttribute("y2", (-24 * tip.y).toFixed(1));
    label.setAttribute("x", (33 * tip.x).toFixed(1));
    label.setAttribute("y", (-33 * tip.y).toFixed(1));
    label.setAttribute("opacity", Math.hypot(tip.x, tip.y) < 0.15 ? "0" : "1");
  }));
  return svg;
}

function stage(runs, clock) {
  const canvas = element("canvas", { tabindex: "0", role: "img", "aria-keyshortcuts": "Space",
    "aria-label": "Animated three-dimensional view of the swimmer. Arrow keys turn it, + and − zoom, space plays." });
  const frame = element("div", { class: "stage" }, canvas);
  let picture = null;
  try {
    picture = new Picture(canvas, runs);
  } catch {
    frame.replaceChildren(element("p", { class: "lacking" },
      "This browser offers no WebGL, so the three-dimensional view is left out. Everything below still works."));
    frame.classList.add("empty");
    return { frame, picture };
  }
  frame.append(axes_cross(picture), element("p", { class: "hint" }, `grid ${picture.grid_step} m`));
  const step = Math.PI / 36;
  const keys = {
    ArrowLeft: () => picture.orbit(-step, 0), ArrowRight: () => picture.orbit(step, 0),
    ArrowUp: () => picture.orbit(0, step), ArrowDown: () => picture.orbit(0, -step),
    "+": () => picture.zoom(0.9), "-": () => picture.zoom(1 / 0.9), " ": () => clock.toggle(),
  };
  canvas.addEventListener("keydown", (event) => {
    if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    keys[event.key]();
    event.preventDefault();
  });
  clock.listen(() => picture.place(clock.time));
  copy_for_paper(canvas);
  on_theme_change(() => picture.recolor());
  return { frame, picture };
}

// A picture drawn by WebGL reaches paper a frame too late: print a copy of it.
function copy_for_paper(canvas) {
  const paper = element("canvas", { class: "paper" });
  addEventListener("beforeprint", () => {
    paper.width = canvas.width;
    paper.height = canvas.height;
    paper.getContext("2d").drawImage(canvas, 0, 0);
    canvas.after(paper);
  });
  addEventListener("afterprint", () => paper.remove());
}

function speed_menu(clock) {
  const wanted = clock.duration / 6;
  clock.speed = SPEEDS.reduce((best, speed) =>
    Math.abs(Math.log(speed / wanted)) < Math.abs(Math.log(best / wanted)) ? speed : best);
  const options = SPEEDS.map((speed) => element("option", { value: String(speed), selected: speed === clock.speed },
    speed === 1 ? "real time" : `× ${speed}`));
  return element("label", {}, "Speed ",
    element("select", { onchange: (event) => { clock.speed = Number(event.target.value); } }, ...options));
}

function time_bar(clock, frames, periodic) {
  const play = element("button", { type: "button", class: "play", onclick: () => clock.toggle() });
  const slider = element("input", { type: "range", min: "0", max: String(clock.duration), "aria-label": "Time",
    step: String(clock.duration / Math.max(frames - 1, 1)), oninput: () => clock.set(Number(slider.value)) });
  const readout = element("output", { class: "time" });
  const digits = Math.max(0, Math.min(6, 3 - Math.floor(Math.log10(clock.duration))));
  clock.listen(() => {
    play.textContent = clock.playing ? "Pause" : "Play";
    slider.value = String(clock.time);
    slider.setAttribute("aria-valuetext", `${clock.time.toFixed(digits)} seconds`);
    readout.textContent = `t = ${clock.time.toFixed(digits)} s`;
  });
  clock.loop = periodic;
  const loop = element("label", {},
    element("input", { type: "checkbox", checked: periodic, onchange: (event) => { clock.loop = event.target.checked; } }), " Loop");
  return element("div", { class: "bar" }, play, slider, readout, speed_menu(clock), loop);
}

// What of the picture lies in the way.
function obstacle_key({ sphere, half_space, waypoint }) {
  const item = (name, words) => {
    const mark = swatch(color(name));
    on_theme_change(() => mark.style.setProperty("--color", color(name)));
    return element("li", {}, mark, words);
  };
  return [sphere.length + half_space.length ? item("keep-out", "to keep out of") : null, waypoint.length ? item("path", "waypoints") : null]
    .filter((one) => one);
}

function key(runs, has_picture) {
  const bodies = runs[0].bodies;
  const shown = bodies.slice(0, 12).map((body, i) => ({ body, mark: swatch(body_color(i)), i }));
  on_theme_change(() => shown.forEach(({ mark, i }) => mark.style.setProperty("--color", body_color(i))));
  const items = shown.map(({ body, mark }) => element("li", {}, mark, body.name));
  if (bodies.length > shown.length) items.push(element("li", {}, `and ${bodies.length - shown.length} more`));
  if (has_picture) {
    const path = swatch(color("path"), "line");
    on_theme_change(() => path.style.setProperty("--color", color("path")));
    items.push(element("li", {}, path, "path of the root’s mass centre"), element("li", {}, "pale: the start"));
    items.push(...obstacle_key(runs[0].obstacles));
  }
  if (runs.length > 1) items.push(element("li", {}, "solid: A, translucent: B"));
  return element("ul", { class: "key" }, ...items);
}

export function show_motion(runs, clock) {
  const { frame, picture } = stage(runs, clock);
  const names = Object.keys(VIEWS);
  const first = names.indexOf(runs.every((run) => run.flat) ? "Top" : names[0]);  // ellipses have no depth
  const views = picture && choice("View", names, first, (index) => picture.look(names[index]));
  show("motion", element("div", { class: "above" }, key(runs, picture !== null), views), frame,
    time_bar(clock, runs[0].frames.time.length, runs.every((run) => run.periodic)));
  if (!picture) return;
  picture.controls.addEventListener("start", () => {
    picture.view = null;
    for (const button of views.children) button.setAttribute("aria-pressed", "false");
  });
  picture.resize();
  picture.look(names[first]);
}
