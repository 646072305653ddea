"""How bakes and poses grow with vertices and controls, from the table in large-faces.md."""
import os

from svg import Axes, Svg

PAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "large-faces.md")
POSES, RECIPE = 1000, "compact"  # of the rows that are drawn
VERTICES, CONTROLS = 25237, 60   # of those along which the other grows


def read_table():
    """Rows as dictionaries of numbers by column, of the recipe and number of poses that are drawn."""
    rows, columns = [], None
    with open(PAGE, encoding="utf-8") as file:
        for line in file:
            cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
            if cells[0] == "vertices":
                columns = cells
            elif columns and len(cells) == len(columns) and cells[0][:1].isdigit():
                row = {column: cell if column == "recipe" else float(cell.replace(",", "")) for column, cell in zip(columns, cells)}
                if row["recipe"] == RECIPE and row["poses"] == POSES:
                    rows.append(row)
    return rows


def scale_plot():
    """CPU seconds of a bake, its peak of memory, and the time of a pose, over vertices, solid, and controls, dotted."""
    rows = read_table()
    svg = Svg(900, 330, "Bakes and poses over vertices and controls")
    plots = (("CPU s", "CPU seconds of a bake", (10, 1000), (10, 100, 1000)), ("peak MB", "peak of memory, MB", (100, 10000), (100, 1000, 10000)),
             ("pose us", "microseconds a pose", (10, 1000), (10, 100, 1000)))
    along_vertices = sorted((row for row in rows if row["controls"] == CONTROLS), key=lambda row: row["vertices"])
    along_controls = sorted((row for row in rows if row["vertices"] == VERTICES), key=lambda row: row["controls"])
    for i, (column, name, bounds, ticks) in enumerate(plots):
        axes = Axes(svg, 60 + 290 * i, 34, 235, 220, (0.7, 90), bounds, log_x=True, log_y=True)
        axes.ticks((1, 4, 16, 64), ticks, "{:g}")
        for line, key, colour, dotted in ((along_vertices, "vertices", 2, False), (along_controls, "controls", 1, True)):
            xs = [row[key] / line[0][key] for row in line]
            axes.curve(xs, [row[column] for row in line], colour, dotted)
            for x, row in zip(xs, line):
                axes.dot(x, row[column], colour)
        axes.labels("times as many", "", name)
    for i, (words, colour, dash) in enumerate(((f"vertices from {along_vertices[0]['vertices']:,.0f}, {CONTROLS} controls", 2, ""),
                                               (f"controls from {along_controls[0]['controls']:,.0f}, {VERTICES:,} vertices", 1, ' stroke-dasharray="3 4"'))):
        x = 60 + 330 * i
        svg.add(f'<line class="curve s{colour}" x1="{x}" x2="{x + 30}" y1="311" y2="311"{dash}/>')
        svg.text(x + 38, 315, words, "start", "small")
    return svg.page()
