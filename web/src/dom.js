// Making elements; strings always become text nodes, so names can never turn into markup.

export function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key === "class") node.className = value;
    else if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (key in node && typeof value !== "string") node[key] = value;
    else node.setAttribute(key, value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined && child !== ""));
  return node;
}

export const section = (id) => document.getElementById(id);

export function show(id, ...children) {
  const node = section(id);
  node.append(...children);
  node.hidden = false;
}

export function swatch(color, look = "") {
  const node = element("span", { class: `swatch ${look}`, "aria-hidden": "true" });
  node.style.setProperty("--color", color);
  return node;
}

// rows: arrays of strings or nodes; the first of each row is its heading.
export function table(heads, rows, look = "") {
  const head = element("tr", {}, ...heads.map((text) => element("th", { scope: "col" }, text)));
  const body = rows.map(([first, ...others]) => element("tr", {},
    element("th", { scope: "row" }, first), ...others.map((cell) => element("td", {}, cell))));
  return element("div", { class: "wide" },
    element("table", { class: look }, element("thead", {}, head), element("tbody", {}, ...body)));
}

// Buttons of which one is pressed.
export function choice(label, names, selected, chosen) {
  const buttons = names.map((name, index) => element("button", {
    type: "button", "aria-pressed": String(index === selected),
    onclick: () => {
      buttons.forEach((button, other) => button.setAttribute("aria-pressed", String(other === index)));
      chosen(index);
    },
  }, name));
  return element("div", { class: "choice", role: "group", "aria-label": label }, ...buttons);
}
