#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws the work-precision plot of the solvers: time to a residual, one panel a scene.

    solver_precision_bench precision.csv
    python3 tests/bench/solver_plot.py precision.csv precision.svg

Scenes with friction; at rest in full lines, after a shock dashed. A line ends at the smallest residual that was
reached. Both axes are logarithmic. Standard library only.
"""
import csv
import math
import sys
from collections import defaultdict
from xml.sax.saxutils import escape

# Okabe and Ito's colours, which colour-blind readers can tell apart.
COLOURS = {"auto": "#000000", "body_space": "#E69F00", "small_exact": "#999999", "sparse_contact": "#56B4E9",
           "dense_lu": "#009E73", "incremental_ldlt": "#CC79A7", "lemke": "#F0E442", "pgs": "#D55E00",
           "nncg": "#0072B2", "convex_step": "#7F3F98", "tgs_soft": "#8B5A2B"}
WIDTH, HEIGHT, COLUMNS, LEFT, LEGEND = 250, 220, 4, 46, 150
FIRST, LAST = -2, -12  # powers of ten of the residual


def read(path):
    """Returns {scene: {(solver, load): [(residual, seconds)]}} of the problems with friction."""
    panels = defaultdict(lambda: defaultdict(list))
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if float(row["friction"]) > 0 and float(row["seconds"]) > 0:
                panels[row["scene"]][row["solver"], row["load"]].append(
                    (float(row["target"]), float(row["seconds"])))
    return panels


def panel(left, top, title, series):
    """Returns the SVG elements of one panel."""
    values = [seconds for points in series.values() for _, seconds in points]
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)) + 1e-9)
    high = max(high, low + 1)

    def x(residual):
        return left + LEFT + (FIRST - math.log10(residual)) / (FIRST - LAST) * (WIDTH - LEFT - 14)

    def y(seconds):
        return top + 28 + (high - math.log10(seconds)) / (high - low) * (HEIGHT - 58)

    out = [f'<text x="{left + LEFT}" y="{top + 18}" font-weight="bold">{escape(title)}</text>']
    for power in (-2, -4, -8, -12):
        out.append(f'<line x1="{x(10.0 ** power):.1f}" x2="{x(10.0 ** power):.1f}" y1="{top + 28}" '
                   f'y2="{top + HEIGHT - 30}" stroke="#ddd"/><text x="{x(10.0 ** power):.1f}" '
                   f'y="{top + HEIGHT - 16}" text-anchor="middle">1e{power}</text>')
    for power in range(low, high + 1):
        out.append(f'<line x1="{x(1e-2):.1f}" x2="{x(1e-12):.1f}" y1="{y(10.0 ** power):.1f}" '
                   f'y2="{y(10.0 ** power):.1f}" stroke="#ddd"/><text x="{left + LEFT - 5}" '
                   f'y="{y(10.0 ** power) + 4:.1f}" text-anchor="end">1e{power} s</text>')
    for (solver, load), points in sorted(series.items()):
        colour = COLOURS.get(solver, "#444444")
        dash = "" if load == "rest" else ' stroke-dasharray="5 3"'
        path = " ".join(f"{x(r):.1f},{y(s):.1f}" for r, s in sorted(points, reverse=True))
        out.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.6"{dash}/>')
        out += [f'<circle cx="{x(r):.1f}" cy="{y(s):.1f}" r="2.4" fill="{colour}"/>' for r, s in points]
    return out


def main():
    if len(sys.argv) != 3:
        sys.exit(f"usage: {sys.argv[0]} input.csv output.svg")
    panels = read(sys.argv[1])
    if not panels:
        sys.exit(f"{sys.argv[1]}: no rows of solver_precision_bench with friction")
    rows = math.ceil(len(panels) / COLUMNS)
    columns = min(COLUMNS, len(panels))
    width, height = columns * WIDTH + LEGEND, rows * HEIGHT + 20
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" '
           f'font-size="11"><rect width="{width}" height="{height}" fill="white"/>']
    for i, (scene, series) in enumerate(panels.items()):
        out += panel(i % COLUMNS * WIDTH, i // COLUMNS * HEIGHT, scene.replace("_", " "), series)
    out.append(f'<text x="{columns * WIDTH / 2}" y="{height - 8}" text-anchor="middle">relative residual; '
               'full lines: at rest, dashed: after a shock</text>')
    solvers = sorted({solver for series in panels.values() for solver, _ in series})
    for i, solver in enumerate(solvers):
        left, top = columns * WIDTH + 10, 30 + 16 * i
        out.append(f'<line x1="{left}" x2="{left + 24}" y1="{top - 4}" y2="{top - 4}" stroke-width="2" '
                   f'stroke="{COLOURS.get(solver, "#444444")}"/><text x="{left + 30}" y="{top}">{escape(solver)}'
                   '</text>')
    out.append("</svg>")
    with open(sys.argv[2], "w", encoding="utf-8") as file:
        file.write("\n".join(out) + "\n")


if __name__ == "__main__":
    main()
