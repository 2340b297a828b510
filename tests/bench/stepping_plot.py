#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws the work-precision plot of the stepping benchmark: error against wall time, one panel a scene.

    stepping_bench > stepping.csv
    python3 tests/bench/stepping_plot.py stepping.csv stepping.svg

Both axes logarithmic. Solid: given step lengths, 1/30 to 1/1920 s; dashed: accuracies asked for, 1e-2 to 1e-8.
Standard library only.
"""
import csv
import math
import sys
from collections import defaultdict
from xml.sax.saxutils import escape

# Okabe and Ito's colours, which colour-blind readers can tell apart.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#000000", "#CC79A7"]
WIDTH, HEIGHT, MARGIN, LEGEND = 300, 280, 55, 210
FLOOR = 1e-16  # an error of zero is drawn here


def read(path):
    """Returns {scene: {(stepper, asked): [(seconds, error)]}} in the order of the file."""
    panels = defaultdict(lambda: defaultdict(list))
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            key = (row["stepper"], float(row["accuracy"]) > 0)
            panels[row["scene"]][key].append((float(row["least seconds"]), max(float(row["error"]), FLOOR)))
    return panels


def powers(values):
    return math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)) + 1e-9)


def panel(left, title, series, colours, times, errors):
    """Returns the SVG elements of one panel."""
    def x(seconds):
        return left + MARGIN + (math.log10(seconds) - times[0]) / (times[1] - times[0]) * (WIDTH - MARGIN - 12)

    def y(error):
        return 30 + (errors[1] - math.log10(error)) / (errors[1] - errors[0]) * (HEIGHT - 65)

    out = [f'<text x="{left + MARGIN}" y="18" font-weight="bold">{escape(title)}</text>']
    for power in range(times[0], times[1] + 1):
        at = x(10.0 ** power)
        out.append(f'<line x1="{at:.1f}" x2="{at:.1f}" y1="30" y2="{HEIGHT - 35}" stroke="#ddd"/>'
                   f'<text x="{at:.1f}" y="{HEIGHT - 20}" text-anchor="middle">1e{power}</text>')
    for power in range(errors[0], errors[1] + 1, 2):
        at = y(10.0 ** power)
        out.append(f'<line x1="{left + MARGIN}" x2="{left + WIDTH - 12}" y1="{at:.1f}" y2="{at:.1f}" stroke="#ddd"/>'
                   f'<text x="{left + MARGIN - 4}" y="{at + 4:.1f}" text-anchor="end">1e{power}</text>')
    out.append(f'<text x="{left + MARGIN + (WIDTH - MARGIN) / 2:.0f}" y="{HEIGHT - 5}" text-anchor="middle">'
               'wall time [s]</text>')
    for (stepper, asked), points in series.items():
        path = " ".join(f"{x(t):.1f},{y(e):.1f}" for t, e in points)
        dash = "5 3" if asked else ""
        out.append(f'<polyline points="{path}" fill="none" stroke="{colours[stepper]}" stroke-width="1.6" '
                   f'stroke-dasharray="{dash}"/>')
        out += [f'<circle cx="{x(t):.1f}" cy="{y(e):.1f}" r="2.2" fill="{colours[stepper]}"/>' for t, e in points]
    return out


def main():
    if len(sys.argv) != 3:
        sys.exit(f"usage: {sys.argv[0]} input.csv output.svg")
    panels = read(sys.argv[1])
    if not panels:
        sys.exit(f"{sys.argv[1]}: no rows of stepping_bench")
    names = list(dict.fromkeys(stepper for series in panels.values() for stepper, _ in series))
    colours = {name: COLOURS[i % len(COLOURS)] for i, name in enumerate(names)}
    every = [point for series in panels.values() for points in series.values() for point in points]
    times, errors = powers([t for t, _ in every]), powers([e for _, e in every])
    width = len(panels) * WIDTH + LEGEND
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{HEIGHT}" font-family="sans-serif" '
           f'font-size="11"><rect width="{width}" height="{HEIGHT}" fill="white"/>']
    for i, (scene, series) in enumerate(panels.items()):
        out += panel(i * WIDTH, scene, series, colours, times, errors)
    out.append(f'<text x="12" y="{HEIGHT / 2}" transform="rotate(-90 12 {HEIGHT / 2})" text-anchor="middle">'
               'error of the position [m]</text>')
    rows = [(f"{name}, {what}", colours[name], dash) for name in names
            for what, dash in (("given steps", ""), ("asked accuracy", "5 3"))]
    for i, (label, colour, dash) in enumerate(rows):
        left, top = len(panels) * WIDTH + 10, 40 + 16 * i
        out.append(f'<line x1="{left}" x2="{left + 25}" y1="{top - 4}" y2="{top - 4}" stroke="{colour}" '
                   f'stroke-width="1.6" stroke-dasharray="{dash}"/><text x="{left + 30}" y="{top}">{escape(label)}'
                   '</text>')
    out.append("</svg>")
    with open(sys.argv[2], "w", encoding="utf-8") as file:
        file.write("\n".join(out) + "\n")


if __name__ == "__main__":
    main()
