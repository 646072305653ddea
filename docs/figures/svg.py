"""SVG pictures that read on light and dark pages: boxes, arrows, curves and axes. Standard library only."""
from html import escape
import math

LIGHT = {"ink": "#22242a", "faint": "#5f646d", "line": "#b9bec7", "paper": "#fdfdfc", "shade": "#eef0f3",
         "colours": ("#7a808a", "#c2410c", "#2563a8", "#15803d", "#9333a8", "#a16207", "#0e7490", "#be185d")}
DARK = {"ink": "#e4e6ea", "faint": "#a4aab4", "line": "#4a4f59", "paper": "#16181c", "shade": "#23272d",
        "colours": ("#9aa0aa", "#fb8a4c", "#6cb0f5", "#5fd08a", "#d58af0", "#e0b23c", "#4fc7e0", "#f57cb5")}


def rules(theme):
    """Classes: f0 to f7 fill with a colour, s0 to s7 draw with it."""
    text = (f".ink {{ fill: {theme['ink']}; }} .small {{ fill: {theme['faint']}; }} .paper {{ fill: {theme['paper']}; }}\n"
            f".box {{ fill: {theme['shade']}; stroke: {theme['line']}; }} .grid, .frame {{ stroke: {theme['line']}; }}\n"
            f".arrow {{ stroke: {theme['faint']}; }} .head {{ fill: {theme['faint']}; }}\n")
    return text + " ".join(f".f{i} {{ fill: {c}; }} .s{i} {{ stroke: {c}; }}" for i, c in enumerate(theme["colours"])) + "\n"


STYLE = f"""<style>
text {{ font: 13px system-ui, sans-serif; }} .small {{ font-size: 11px; }} .bold {{ font-weight: 600; }}
.grid {{ stroke-width: 0.6; opacity: 0.7; }} .frame {{ fill: none; }} .arrow {{ fill: none; stroke-width: 1.4; }}
.curve {{ fill: none; stroke-width: 1.8; stroke-linejoin: round; }}
{rules(LIGHT)}@media (prefers-color-scheme: dark) {{
{rules(DARK)}}}
</style>"""


def number(value):
    return f"{value:.2f}".rstrip("0").rstrip(".")


class Svg:
    def __init__(self, width, height, title):
        self.width, self.height, self.title, self.parts = width, height, title, []

    def add(self, part):
        self.parts.append(part)

    def text(self, x, y, words, anchor="middle", cls=""):
        cls = cls if "small" in cls else f"ink {cls}".strip()
        self.add(f'<text x="{number(x)}" y="{number(y)}" text-anchor="{anchor}" class="{cls}">{escape(words)}</text>')

    def box(self, x, y, width, height, lines=(), colour=None):
        """A rounded box; the first line is bold, the others small. `colour`: of its left edge."""
        self.add(f'<rect class="box" x="{number(x)}" y="{number(y)}" width="{number(width)}" height="{number(height)}" rx="5"/>')
        if colour is not None:
            self.add(f'<rect x="{number(x)}" y="{number(y)}" width="5" height="{number(height)}" rx="2" class="f{colour}"/>')
        first = y + height / 2 + 5 - 8 * (len(lines) - 1)
        for i, line in enumerate(lines):
            self.text(x + width / 2, first + 16 * i, line, cls="bold" if i == 0 else "small")

    def arrow(self, *points):
        """Through the points, with a head at the last."""
        (x0, y0), (x1, y1) = points[-2:]
        length = math.hypot(x1 - x0, y1 - y0)
        ux, uy = (x1 - x0) / length, (y1 - y0) / length
        stem = [*points[:-1], (x1 - 7 * ux, y1 - 7 * uy)]
        self.add('<polyline class="arrow" points="' + " ".join(f"{number(x)},{number(y)}" for x, y in stem) + '"/>')
        corners = [(x1, y1), (x1 - 8 * ux - 4 * uy, y1 - 8 * uy + 4 * ux), (x1 - 8 * ux + 4 * uy, y1 - 8 * uy - 4 * ux)]
        self.add('<polygon class="head" points="' + " ".join(f"{number(x)},{number(y)}" for x, y in corners) + '"/>')

    def page(self):
        return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {self.height}" width="{self.width}" '
                f'height="{self.height}" role="img">\n<title>{escape(self.title)}</title>\n{STYLE}\n'
                f'<rect class="paper" width="{self.width}" height="{self.height}" rx="6"/>\n' + "\n".join(self.parts) + "\n</svg>\n")


class Axes:
    """A plot within an Svg. Ranges are of values; logarithmic axes take positive ones."""

    def __init__(self, svg, x, y, width, height, x_range, y_range, log_x=False, log_y=False):
        self.svg, self.x, self.y, self.width, self.height = svg, x, y, width, height
        self.x_range, self.y_range, self.log_x, self.log_y = x_range, y_range, log_x, log_y
        svg.add(f'<rect class="frame" x="{number(x)}" y="{number(y)}" width="{number(width)}" height="{number(height)}"/>')

    @staticmethod
    def share(value, bounds, log):
        if log:
            value, bounds = math.log10(value), [math.log10(b) for b in bounds]
        return (value - bounds[0]) / (bounds[1] - bounds[0])

    def at(self, x, y):
        return (self.x + self.width * self.share(x, self.x_range, self.log_x),
                self.y + self.height * (1 - self.share(y, self.y_range, self.log_y)))

    def ticks(self, xs=(), ys=(), form="{:g}"):
        for value in xs:
            px, _ = self.at(value, self.y_range[0])
            self.svg.add(f'<line class="grid" x1="{number(px)}" x2="{number(px)}" y1="{number(self.y)}" y2="{number(self.y + self.height)}"/>')
            self.svg.text(px, self.y + self.height + 15, form.format(value), cls="small")
        for value in ys:
            _, py = self.at(self.x_range[0], value)
            self.svg.add(f'<line class="grid" x1="{number(self.x)}" x2="{number(self.x + self.width)}" y1="{number(py)}" y2="{number(py)}"/>')
            self.svg.text(self.x - 5, py + 4, form.format(value), "end", "small")

    def curve(self, xs, ys, colour, dotted=False):
        points = " ".join("{},{}".format(*map(number, self.at(x, y))) for x, y in zip(xs, ys))
        dash = ' stroke-dasharray="3 4"' if dotted else ""
        self.svg.add(f'<polyline class="curve s{colour}" points="{points}"{dash}/>')

    def dot(self, x, y, colour):
        px, py = self.at(x, y)
        self.svg.add(f'<circle cx="{number(px)}" cy="{number(py)}" r="4" class="f{colour}"/>')

    def labels(self, x="", y="", title=""):
        self.svg.text(self.x + self.width / 2, self.y + self.height + 31, x, cls="small")
        self.svg.text(self.x, self.y - 7, title, "start", "bold")
        self.svg.text(self.x + self.width, self.y - 7, y, "end", "small")
