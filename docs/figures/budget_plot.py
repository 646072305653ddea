"""The error of a production rig over the poses asked or recorded, from the table in experiments.md."""
import os

from svg import Axes, Svg

PAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "experiments.md")
CLIPS = ("talking", "expressive", "random")
LINES = (("hero", "live", 2, False), ("hero", "recorded", 1, False), ("linear", "live", 2, True), ("linear", "recorded", 1, True))


def read_table():
    """(recipe, source) -> [(poses, [mse of each clip])], of the rows that begin with a recipe, live or recorded, and N."""
    rows = {}
    with open(PAGE, encoding="utf-8") as file:
        for line in file:
            cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
            if len(cells) == 3 + len(CLIPS) and cells[1] in ("live", "recorded"):
                poses = int(cells[2].replace(",", ""))
                rows.setdefault(tuple(cells[:2]), []).append((poses, [float(cell) for cell in cells[3:]]))
    return rows


def budget_plot():
    """A plot for each clip: the mse of hero, solid, and of linear blendshapes, dotted, live and recorded."""
    svg = Svg(900, 330, "Error over the number of poses, live and recorded")
    rows = read_table()
    for clip, name in enumerate(CLIPS):
        axes = Axes(svg, 60 + 290 * clip, 34, 235, 220, (800, 40000), (1e-8, 4e-6), log_x=True, log_y=True)
        axes.ticks((1000, 3000, 9000, 30000), (1e-8, 1e-7, 1e-6), "{:g}")
        for recipe, source, colour, dotted in LINES:
            points = rows[recipe, source]
            axes.curve([n for n, _ in points], [mse[clip] for _, mse in points], colour, dotted)
            for n, mse in points:
                if not dotted:
                    axes.dot(n, mse[clip], colour)
        axes.labels("poses asked or recorded", "mse", name)
    for i, (recipe, source, colour, dotted) in enumerate(LINES):
        x = 60 + 200 * i
        dash = ' stroke-dasharray="3 4"' if dotted else ""
        svg.add(f'<line class="curve s{colour}" x1="{x}" x2="{x + 30}" y1="311" y2="311"{dash}/>')
        svg.text(x + 38, 315, f"{recipe}, {source}", "start", "small")
    return svg.page()
