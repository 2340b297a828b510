#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws the crossover plot of the broad-phase benchmark: time a body and step against the number of bodies.

    broadphase_bench --benchmark_format=csv > all.csv
    python3 tests/bench/broadphase_plot.py all.csv crossover.svg

One panel a distribution, both axes logarithmic. Ours are solid, peers are dashed. Standard library only.
"""
import csv
import math
import sys
from collections import defaultdict
from xml.sax.saxutils import escape

# Okabe and Ito's colours, which colour-blind readers can tell apart.
COLOURS = ["#000000", "#E69F00", "#56B4E9", "#009E73", "#D55E00", "#0072B2", "#CC79A7", "#999999"]
TITLES = {"U": "U: equal, all move", "M": "M: sizes 1:300, all move", "C": "C: pile, all tremble",
          "S": "S: 99 % asleep", "F": "F: one bullet"}
WIDTH, HEIGHT, MARGIN, LEGEND = 300, 260, 50, 230


def read(path):
    """Returns {distribution: {name: [(bodies, ns)]}} from Google Benchmark's CSV."""
    panels = defaultdict(lambda: defaultdict(list))
    with open(path, newline="", encoding="utf-8") as file:
        lines = [line for line in file if line.startswith('"') or line.startswith("name,")]
    for row in csv.DictReader(lines):
        parts = row["name"].split("/")
        if len(parts) >= 3 and row.get("ns_body"):
            panels[parts[1]][parts[0]].append((int(parts[2]), float(row["ns_body"])))
    return panels


def panel(left, title, series, styles, low, high):
    """Returns the SVG elements of one panel."""
    def x(bodies):
        return left + MARGIN + (math.log10(bodies) - 3) / 3 * (WIDTH - MARGIN - 10)

    def y(ns):
        return 30 + (math.log10(high) - math.log10(ns)) / (math.log10(high) - math.log10(low)) * (HEIGHT - 60)

    out = [f'<text x="{left + MARGIN}" y="18" font-weight="bold">{escape(title)}</text>']
    for power in range(3, 7):
        out.append(f'<line x1="{x(10 ** power):.1f}" x2="{x(10 ** power):.1f}" y1="30" y2="{HEIGHT - 30}" '
                   'stroke="#ddd"/>')
        out.append(f'<text x="{x(10 ** power):.1f}" y="{HEIGHT - 15}" text-anchor="middle">1e{power}</text>')
    for power in range(math.ceil(math.log10(low)), math.floor(math.log10(high)) + 1):
        out.append(f'<line x1="{x(1e3):.1f}" x2="{x(1e6):.1f}" y1="{y(10 ** power):.1f}" '
                   f'y2="{y(10 ** power):.1f}" stroke="#ddd"/>')
        out.append(f'<text x="{x(1e3) - 4:.1f}" y="{y(10 ** power) + 4:.1f}" text-anchor="end">{10.0 ** power:g}'
                   '</text>')
    for name, points in series.items():
        colour, dash = styles[name]
        path = " ".join(f"{x(n):.1f},{y(ns):.1f}" for n, ns in sorted(points))
        out.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.6" '
                   f'stroke-dasharray="{dash}"/>')
        out += [f'<circle cx="{x(n):.1f}" cy="{y(ns):.1f}" r="2.2" fill="{colour}"/>' for n, ns in points]
    return out


def main():
    if len(sys.argv) != 3:
        sys.exit(f"usage: {sys.argv[0]} input.csv output.svg")
    panels = read(sys.argv[1])
    if not panels:
        sys.exit(f"{sys.argv[1]}: no rows of broadphase_bench with ns_body")
    names = sorted({name for series in panels.values() for name in series})
    ours = [name for name in names if name == name.lower()]
    others = [name for name in names if name not in ours]
    styles = {name: (COLOURS[i % len(COLOURS)], "") for i, name in enumerate(ours)}
    styles.update({name: (COLOURS[i % len(COLOURS)], "5 3") for i, name in enumerate(others)})
    order = [d for d in "UMCSF" if d in panels]
    width = len(order) * WIDTH + LEGEND
    height = max(HEIGHT, 40 + 15 * len(names))
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" '
           f'font-size="11"><rect width="{width}" height="{height}" fill="white"/>']
    for i, d in enumerate(order):
        values = [ns for points in panels[d].values() for _, ns in points]
        low, high = 10 ** math.floor(math.log10(min(values))), 10 ** math.ceil(math.log10(max(values)) + 1e-9)
        out += panel(i * WIDTH, TITLES[d], panels[d], styles, low, max(high, 10 * low))
    out.append(f'<text x="12" y="{HEIGHT / 2}" transform="rotate(-90 12 {HEIGHT / 2})" text-anchor="middle">'
               'ns a body and step</text>')
    for i, name in enumerate(ours + others):
        colour, dash = styles[name]
        left, top = len(order) * WIDTH + 10, 35 + 15 * i
        out.append(f'<line x1="{left}" x2="{left + 25}" y1="{top - 4}" y2="{top - 4}" stroke="{colour}" '
                   f'stroke-width="1.6" stroke-dasharray="{dash}"/><text x="{left + 30}" y="{top}">{escape(name)}'
                   '</text>')
    out.append("</svg>")
    with open(sys.argv[2], "w", encoding="utf-8") as file:
        file.write("\n".join(out) + "\n")


if __name__ == "__main__":
    main()
