"""Diagrams with logarithmic axes as SVG, of the look that bench/work_precision.cpp gives; colours follow the reader's light or dark setting."""
import dataclasses
import math

LIGHT = ("#c0392b", "#8e5bb5", "#3b7fb5", "#2a9d7c", "#b8860b")
DARK = ("#ff7b6b", "#c49be8", "#6fb1d8", "#5fd3b0", "#f0c541")
WIDTH, PANEL_WIDTH, PANEL_HEIGHT = 980.0, 380.0, 300.0
LEFTS, TOP, ROW = (84.0, 574.0), 84.0, 388.0


@dataclasses.dataclass
class Curve:
    name: str
    points: list  # (x, y), both positive
    dashed: bool  # a method on the continuous equations


@dataclasses.dataclass
class Panel:
    title: str
    x_label: str
    y_label: str
    curves: list


def style():
    def colours(palette):
        return "".join(f".c{n}{{stroke:{c}}}.m{n}{{fill:{c}}}" for n, c in enumerate(palette))

    day = ".card{fill:#ffffff}text{fill:#3d4653}.strong{fill:#1c2430}.grid{stroke:#e2e6ea}.frame{stroke:#9aa3ae}"
    night = ".card{fill:#161b22}text{fill:#b9c2cd}.strong{fill:#f0f3f6}.grid{stroke:#2b323b}.frame{stroke:#6e7681}"
    return f"{day}{colours(LIGHT)}@media (prefers-color-scheme: dark){{{night}{colours(DARK)}}}"


def decade(exponent):
    return f'10<tspan dy="-6" font-size="10">{"−" if exponent < 0 else ""}{abs(exponent)}</tspan>'


def mark(n, dashed, x, y):
    if dashed:
        return f'<rect class="m{n}" x="{x - 3.5:.1f}" y="{y - 3.5:.1f}" width="7" height="7"/>'
    return f'<circle class="m{n}" cx="{x:.1f}" cy="{y:.1f}" r="3.8"/>'


def dash(dashed):
    return ' stroke-dasharray="6 4"' if dashed else ""


class Axes:
    def __init__(self, panel, left, top):
        xs, ys = zip(*(point for curve in panel.curves for point in curve.points))
        self.left, self.top, self.right, self.bottom = left, top, left + PANEL_WIDTH, top + PANEL_HEIGHT
        self.x_from, self.x_to = math.floor(2.0 * math.log10(min(xs))) / 2.0, math.ceil(2.0 * math.log10(max(xs))) / 2.0
        self.y_from, self.y_to = math.floor(math.log10(min(ys))), math.ceil(math.log10(max(ys)))

    def x(self, value):
        return self.left + PANEL_WIDTH * (math.log10(value) - self.x_from) / (self.x_to - self.x_from)

    def y(self, value):
        return self.bottom - PANEL_HEIGHT * (math.log10(value) - self.y_from) / (self.y_to - self.y_from)

    def svg(self, panel):
        out = [f'<text x="{self.left:g}" y="{self.top - 14:g}" class="strong">{panel.title}</text>']
        for e in range(math.ceil(self.x_from), math.floor(self.x_to) + 1):
            x = self.x(10.0**e)
            out.append(f'<path class="grid" d="M{x:.1f} {self.top:g}V{self.bottom:g}"/>'
                       f'<text x="{x:.1f}" y="{self.bottom + 20:g}" text-anchor="middle">{decade(e)}</text>')
        for e in range(self.y_from, self.y_to + 1):
            y = self.y(10.0**e)
            out.append(f'<path class="grid" d="M{self.left:g} {y:.1f}H{self.right:g}"/>'
                       f'<text x="{self.left - 8:g}" y="{y + 4.5:.1f}" text-anchor="end">{decade(e)}</text>')
        middle = 0.5 * (self.left + self.right)
        out.append(f'<path class="frame" fill="none" d="M{self.left:g} {self.top:g}V{self.bottom:g}H{self.right:g}"/>'
                   f'<text x="{middle:g}" y="{self.bottom + 42:g}" text-anchor="middle">{panel.x_label}</text>'
                   f'<text transform="translate({self.left - 56:g} {0.5 * (self.top + self.bottom):g}) rotate(-90)" '
                   f'text-anchor="middle">{panel.y_label}</text>')
        return "\n".join(out)


def lines(axes, panel):
    for n, curve in enumerate(panel.curves):
        places = [(axes.x(x), axes.y(y)) for x, y in curve.points]
        path = "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
        marks = "".join(mark(n, curve.dashed, x, y) for x, y in places)
        yield f'<path class="c{n}" fill="none" stroke-width="2"{dash(curve.dashed)} d="M{path}"/>{marks}'


def legend(curves):
    x = LEFTS[0]
    for n, curve in enumerate(curves):
        yield (f'<path class="c{n}" stroke-width="2"{dash(curve.dashed)} d="M{x:g} 50.5h30"/>{mark(n, curve.dashed, x + 15, 50.5)}'
               f'<text x="{x + 38:g}" y="55">{curve.name}</text>')
        x += 62 + 6.7 * len(curve.name)


def svg(title, panels):
    """Panels two in a row, with the same curves in each."""
    height = TOP + ROW * math.ceil(len(panels) / 2)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH:g} {height:g}" width="{WIDTH:g}" height="{height:g}" '
           f'role="img" font-family="system-ui, \'DejaVu Sans\', sans-serif" font-size="13"><title>{title}</title>'
           f'<style>{style()}</style><rect class="card" width="{WIDTH:g}" height="{height:g}" rx="10"/>',
           f'<text x="{LEFTS[0]:g}" y="28" font-size="16" class="strong">{title}</text>', *legend(panels[0].curves)]
    for n, panel in enumerate(panels):
        axes = Axes(panel, LEFTS[n % 2], TOP + 22 + ROW * (n // 2))
        out += [axes.svg(panel), *lines(axes, panel)]
    return "\n".join(out) + "\n</svg>\n"
