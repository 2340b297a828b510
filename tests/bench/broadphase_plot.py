#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws the crossover plot of the broad-phase benchmark: time a body and step against the number of bodies.

    broadphase_bench --benchmark_format=csv > all.csv
    python3 tests/bench/broadphase_plot.py all.csv crossover.svg [tables.md]

One panel a distribution, both axes logarithmic. Ours are solid, peers are dashed. `tables.md` gets the numbers: times,
bytes, and the ratios that the aims speak of. Standard library only. tests/bench/broadphase.sh does all of it.
"""
import csv
import math
import sys
from collections import defaultdict
from xml.sax.saxutils import escape

# Okabe and Ito's colours, which colour-blind readers can tell apart, and a brown.
COLOURS = ["#000000", "#E69F00", "#56B4E9", "#009E73", "#D55E00", "#0072B2", "#CC79A7", "#999999",
           "#7A4A1E"]
TITLES = {"U": "U: equal, all move", "M": "M: sizes 1:300, all move", "C": "C: pile, all tremble",
          "S": "S: 99 % asleep", "F": "F: one bullet"}
WIDTH, HEIGHT, MARGIN, LEFT = 300, 280, 55, 25
COLUMNS = 3


def read(path):
    """Returns {distribution: {name: [(bodies, ns)]}} from Google Benchmark's CSV."""
    panels = defaultdict(lambda: defaultdict(list))
    with open(path, newline="", encoding="utf-8") as file:
        lines = [line for line in file if line.startswith('"') or line.startswith("name,")]
    for row in csv.DictReader(lines):
        parts = row["name"].split("/")
        if len(parts) >= 3 and row.get("ns_body") and not parts[0].endswith("_threads"):
            panels[parts[1]][parts[0]].append((int(parts[2]), float(row["ns_body"])))
    return panels


def size_name(bodies):
    return f"1e{round(math.log10(bodies))}" if bodies == 10 ** round(math.log10(bodies)) else str(bodies)


def number(value):
    return f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def tables(path, panels, names):
    """Returns Markdown: ns a body and step, bytes a body, and ratios."""
    nbytes = {}
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(line for line in file if line.startswith('"') or line.startswith("name,")):
            parts = row["name"].split("/")
            if len(parts) >= 3 and parts[1] == "U" and row.get("bytes_body"):
                nbytes[parts[0], int(parts[2])] = float(row["bytes_body"])
    out = []
    units = {"S": ("us a step", 1e-3), "F": ("us a step", 1e-3), "R": ("ns a ray", None)}
    for d in (d for d in "UMCSFR" if d in panels):
        sizes = sorted({n for points in panels[d].values() for n, _ in points})
        unit, factor = units.get(d, ("ns a body and step", None))
        columns = [f"{d} {size_name(n)}" for n in sizes]
        if d == "U":
            columns += [f"bytes a body, {size_name(n)}" for n in sizes]
        out += [f"| {unit} | " + " | ".join(columns) + " |", "| --- |" + " --- |" * len(columns)]
        for name in names:
            times = dict(panels[d].get(name, []))
            if not times:
                continue
            cells = [number(times[n] * (factor * n if factor else 1)) if n in times else "-" for n in sizes]
            if d == "U":
                cells += [number(nbytes[name, n]) if (name, n) in nbytes else "-" for n in sizes]
            out.append(f"| {name} | " + " | ".join(cells) + " |")
        out.append("")
    out += ["| | our best | ns | best peer | ns | peer / ours | auto / our best | S / U of auto |",
            "| --- | --- | --- | --- | --- | --- | --- | --- |"]
    for d in (d for d in "UMCSF" if d in panels):
        for n in sorted({n for points in panels[d].values() for n, _ in points}):
            row = {name: dict(points)[n] for name, points in panels[d].items() if n in dict(points)}
            ours = {k: v for k, v in row.items() if k == k.lower()}
            peers = {k: v for k, v in row.items() if k != k.lower()}
            best = min((k for k in ours if k != "auto"), key=ours.get, default=None)
            peer = min(peers, key=peers.get, default=None)
            if best is None:
                continue
            least = min(ours.values())
            u = dict(panels["U"].get("auto", [])).get(n)
            share = f"{100 * ours['auto'] / u:.1f} %" if d == "S" and u and "auto" in ours else ""
            out.append(f"| {d} {size_name(n)} | {best} | {number(ours[best])} | {peer or '-'} | "
                       f"{number(peers[peer]) if peer else '-'} | {peers[peer] / least if peer else 0:.1f} | "
                       f"{ours['auto'] / ours[best] if 'auto' in ours else 0:.2f} | {share} |")
    return "\n".join(out) + "\n"


def panel(title, series, styles, low, high):
    """Returns the SVG elements of one panel."""
    def x(bodies):
        return MARGIN + (math.log10(bodies) - 3) / 3 * (WIDTH - MARGIN - 10)

    def y(ns):
        return 30 + (math.log10(high) - math.log10(ns)) / (math.log10(high) - math.log10(low)) * (HEIGHT - 60)

    out = [f'<text x="{MARGIN}" y="18" font-weight="bold">{escape(title)}</text>']
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
    if len(sys.argv) not in (3, 4):
        sys.exit(f"usage: {sys.argv[0]} input.csv output.svg [tables.md]")
    panels = read(sys.argv[1])
    if not panels:
        sys.exit(f"{sys.argv[1]}: no rows of broadphase_bench with ns_body")
    names = sorted({name for series in panels.values() for name in series})
    ours = [name for name in names if name == name.lower()]
    others = [name for name in names if name not in ours]
    styles = {name: (COLOURS[i % len(COLOURS)], "") for i, name in enumerate(ours)}
    styles.update({name: (COLOURS[i % len(COLOURS)], "5 3") for i, name in enumerate(others)})
    order = [d for d in "UMCSF" if d in panels]
    rows = len(order) // COLUMNS + 1
    width, height = LEFT + COLUMNS * WIDTH, max(rows * HEIGHT, 60 + 15 * len(names))
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" '
           f'font-size="11"><rect width="{width}" height="{height}" fill="white"/>']
    for i, d in enumerate(order):
        values = [ns for points in panels[d].values() for _, ns in points]
        low, high = 10 ** math.floor(math.log10(min(values))), 10 ** math.ceil(math.log10(max(values)) + 1e-9)
        out.append(f'<g transform="translate({LEFT + i % COLUMNS * WIDTH} {i // COLUMNS * HEIGHT})">')
        out += panel(TITLES[d], panels[d], styles, low, max(high, 10 * low)) + ["</g>"]
    out.append(f'<text x="12" y="{height / 2}" transform="rotate(-90 12 {height / 2})" text-anchor="middle">'
               'ns a body and step, against the number of bodies</text>')
    # The legend takes the place after the last panel.
    left = LEFT + len(order) % COLUMNS * WIDTH + 40
    for i, name in enumerate(ours + others):
        colour, dash = styles[name]
        top = len(order) // COLUMNS * HEIGHT + 20 + 15 * i
        out.append(f'<line x1="{left}" x2="{left + 25}" y1="{top - 4}" y2="{top - 4}" stroke="{colour}" '
                   f'stroke-width="1.6" stroke-dasharray="{dash}"/><text x="{left + 30}" y="{top}">{escape(name)}'
                   '</text>')
    out.append("</svg>")
    with open(sys.argv[2], "w", encoding="utf-8") as file:
        file.write("\n".join(out) + "\n")
    if len(sys.argv) == 4:
        with open(sys.argv[3], "w", encoding="utf-8") as file:
            file.write(tables(sys.argv[1], panels, ours + others))


if __name__ == "__main__":
    main()
