"""The pictures that need no baked face: diagrams of the model and of a bake, and plots of the formulas."""
from budget_plot import budget_plot
from scale_plot import scale_plot
from svg import Axes, Svg


def model_diagram():
    """From controls to vertices."""
    svg = Svg(900, 430, "The model: from controls to vertices")
    svg.box(20, 150, 110, 60, ["controls", "c[C]"], 0)
    svg.box(160, 150, 110, 60, ["clamp", "to min, max"], 0)
    svg.box(300, 110, 150, 140, ["features", "identity, ramp, hat,", "product, minimum;", "each 0 at rest"], 1)
    svg.box(490, 40, 190, 56, ["direct coefficients", "sparse blendshapes"], 2)
    for i in range(2, -1, -1):
        svg.box(490 + 8 * i, 150 + 8 * i, 190, 172, [], 3)
    svg.text(585, 172, "region", cls="bold")
    svg.box(508, 184, 120, 26, [], None)
    svg.text(568, 201, "dense, silu", cls="small")
    svg.box(508, 222, 120, 26, [], None)
    svg.text(568, 239, "dense, silu  + x", cls="small")
    svg.box(508, 260, 120, 26, [], None)
    svg.text(568, 277, "dense, linear", cls="small")
    svg.text(568, 309, "minus rest, times gate", cls="small")
    svg.arrow((568, 210), (568, 222))
    svg.arrow((568, 248), (568, 260))
    svg.arrow((568, 286), (568, 299))
    svg.add('<path class="arrow" d="M 628 215 C 662 215 662 254 632 254"/>')
    svg.text(658, 237, "skip", "start", "small")
    svg.arrow((130, 180), (160, 180))
    svg.arrow((270, 180), (300, 180))
    svg.arrow((450, 130), (470, 130), (470, 68), (490, 68))
    svg.arrow((450, 200), (490, 200))
    svg.box(720, 110, 160, 76, ["coefficients", "one vector: direct,", "then each region's"], 4)
    svg.arrow((680, 68), (800, 68), (800, 110))
    svg.arrow((696, 230), (708, 230), (708, 150), (720, 150))
    svg.box(720, 226, 160, 76, ["row blocks", "quantise, then exact", "integer sums"], 5)
    svg.arrow((800, 186), (800, 226))
    svg.box(720, 342, 160, 56, ["positions", "rest + step x sum"], 6)
    svg.arrow((800, 302), (800, 342))
    svg.box(500, 342, 160, 56, ["normals, tangents", "from the positions"], 7)
    svg.arrow((720, 370), (660, 370))
    svg.box(300, 342, 150, 56, ["rest mesh", "polygons"], 0)
    svg.arrow((450, 370), (500, 370))
    return svg.page()


def bake_diagram():
    """The stages of a bake and what goes from one to the next."""
    svg = Svg(900, 350, "The stages of a bake")
    stages = [("rig", "plugin, glTF, dataset", 0), ("sample", "controls, positions", 1), ("analyse", "sparse blendshapes", 2),
              ("regions", "vertices, controls", 3), ("local bases", "PCA of the residual", 3), ("train", "one network a region", 4),
              ("compress", "blockwise PCA", 5), ("quantise", "8 and 16 bits", 5), ("pack", "entropy coding", 6),
              ("measure", "unseen clips", 7), ("certify", "errors, reference poses", 7), ("verify", "the bytes on disk", 7)]
    places = []
    for i, (name, what, colour) in enumerate(stages):
        row, column = divmod(i, 4)
        column = column if row % 2 == 0 else 3 - column
        x, y = 20 + 222 * column, 30 + 112 * row
        svg.box(x, y, 180, 60, [name, what], colour)
        places.append((x, y))
    for (x0, y0), (x1, y1) in zip(places, places[1:]):
        if y0 == y1:
            svg.arrow((x0 + 180, y0 + 30), (x1, y1 + 30)) if x1 > x0 else svg.arrow((x0, y0 + 30), (x1 + 180, y1 + 30))
        else:
            svg.arrow((x0 + 90, y0 + 60), (x1 + 90, y1))
    (x0, y0), (x1, y1) = places[0], places[2]
    svg.arrow((x0 + 90, y0), (x0 + 90, 14), (x1 + 90, 14), (x1 + 90, y1))
    svg.text((x0 + x1) / 2 + 90, 26, "finite differences: pairs, triples, quads of controls", cls="small")
    svg.text(20 + 222 * 3 + 90, 30 + 112 * 2 + 84, "rename to FACE.fbk", cls="small")
    return svg.page()


def clamp(x, low, high):
    return min(max(x, low), high)


def hat(u, threshold, fall):
    t = u - threshold
    return max(min(t, 1 + (1 - t) * fall), 0)


def feature_plots():
    """The five kinds of feature over one or two controls."""
    svg = Svg(900, 250, "The kinds of feature")
    xs = [i / 50 for i in range(-50, 51)]
    plots = [("identity", [xs]), ("ramp", [[max(x - t, 0) for x in xs] for t in (0, 0.5)]),
             ("hat", [[hat(2 * x, 0, 1) for x in xs], [hat(4 * x, 1, 3) for x in xs]])]
    for i, (name, curves) in enumerate(plots):
        axes = Axes(svg, 40 + 170 * i, 34, 130, 150, (-1, 1), (-1, 1.1))
        axes.ticks([-1, 0, 1], [-1, 0, 1])
        for k, ys in enumerate(curves):
            axes.curve(xs, ys, 1 + k)
        axes.labels("u", "", name)
    cells = 11
    for i, (name, combine) in enumerate((("product", lambda a, b: a * b), ("minimum", min))):
        x, y, size = 560 + 175 * i, 34, 150
        for a in range(cells):
            for b in range(cells):
                value = combine(a / (cells - 1), b / (cells - 1))
                step = size / cells
                svg.add(f'<rect x="{x + a * step:.2f}" y="{y + (cells - 1 - b) * step:.2f}" width="{step:.2f}" '
                        f'height="{step:.2f}" class="f2" shape-rendering="crispEdges" opacity="{0.04 + 0.96 * value:.2f}"/>')
        svg.add(f'<rect class="frame" x="{x}" y="{y}" width="{size}" height="{size}"/>')
        svg.text(x, y - 7, name, "start", "bold")
        svg.text(x + size / 2, y + size + 15, "first, 0 to 1", cls="small")
        svg.add(f'<text class="small" transform="translate({x - 6} {y + size / 2}) rotate(-90)" text-anchor="middle">second, 0 to 1</text>')
    svg.text(40, 238, "ramp: thresholds 0 and 0.5. hat: scale 2, threshold 0, fall 1; scale 4, threshold 1, fall 3.", "start", "small")
    return svg.page()


def gate_plot():
    """The gate of a region over the second largest feature."""
    svg = Svg(520, 240, "The gate of a region")
    axes = Axes(svg, 50, 34, 440, 150, (0, 0.4), (0, 1.1))
    axes.ticks([0, 0.1, 0.2, 0.3, 0.4], [0, 0.5, 1])
    xs = [i / 100 for i in range(41)]
    axes.curve(xs, [clamp(10 * x, 0, 1) for x in xs], 3)
    axes.labels("sum of |f| less the largest |f|", "gate", "gate, slope 10")
    svg.text(52, 230, "0: at most one control of the region is away from rest, and the network is not run.", "start", "small")
    return svg.page()


DIAGRAMS = {"model.svg": model_diagram, "bake.svg": bake_diagram, "features.svg": feature_plots, "gate.svg": gate_plot,
            "rig_budget.svg": budget_plot, "scale.svg": scale_plot}
