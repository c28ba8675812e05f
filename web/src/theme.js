// Colours come from page.css; whoever draws on a canvas asks here and is told when they change.

const listeners = [];

export function color(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

export const component_colors = () => [color("first"), color("second"), color("third")];

export function body_color(index) {
  const colours = 10;  // those of page.css
  return color(`body${index % colours}`);
}

export function on_theme_change(listener) {
  listeners.push(listener);
}

function tell() {
  for (const listener of listeners) listener();
}

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", tell);

// Paper is white whatever the screen shows.
addEventListener("beforeprint", () => {
  document.documentElement.dataset.paper = "";
  tell();
});
addEventListener("afterprint", () => {
  delete document.documentElement.dataset.paper;
  tell();
});
