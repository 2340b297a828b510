#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Tables and plots of accuracy_bench.

    accuracy_bench precision -o DIR
    tests/bench/accuracy/report.py DIR

Reads the comma-separated tables of DIR and writes DIR/plots/*.svg and DIR/tables.md. Needs matplotlib
(Debian: python3-matplotlib).
"""
import csv
import math
import re
import sys
from collections import defaultdict
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

# Okabe and Ito's colours, which colour-blind readers can tell apart. Ours are dark, peers have one hue each.
COLOURS = {"Box2D 2.4": "#E69F00", "Box2D 3": "#D55E00", "Chipmunk": "#009E73", "Bullet": "#56B4E9",
           "ODE": "#CC79A7", "skerry": "#000000"}
OURS = {"time_stepping": ("#000000", "o", "-"), "event_driven": ("#0072B2", "D", "-"), "auto": ("#0072B2", "s", "--"),
        "nncg": ("#777777", "v", "--"), "tgs_soft": ("#AAAAAA", "^", ":")}
FLOOR = 1e-16  # of a double: what is smaller is drawn and compared as this
plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "skerry", "font.family": "DejaVu Sans", "font.size": 9,
                     "axes.spines.top": False, "axes.spines.right": False, "axes.axisbelow": True,
                     "grid.color": "#e4e4e4", "grid.linewidth": 0.6})


def rows_of(path):
    if not path.exists():
        return []
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def save(figure, path):
    """Writes without a date, so that equal data give equal files."""
    figure.savefig(path, metadata={"Date": None})
    # A third of the size: coordinates to a hundredth of a point, no comments, no line breaks within elements.
    text = path.read_text(encoding="utf-8")
    text = re.sub(r"<!--.*?-->|<metadata>.*?</metadata>", "", text, flags=re.S)
    text = re.sub(r"(\d+\.\d\d)\d+", r"\1", text)
    path.write_text(re.sub(r"\s*\n\s*", "\n", text), encoding="utf-8")
    if "--png" in sys.argv:
        figure.savefig(path.with_suffix(".png"), dpi=110)
    plt.close(figure)


def is_ours(row):
    return row["engine"] == "skerry"


def engine_curves(engine, rows):
    """The names of the engine's settings, its default first: solid, dashed, dotted."""
    names = []
    for row in rows:
        if row["engine"] == engine and row["curve"] not in names:
            names.append(row["curve"])
    return names


def spread(positions, least):
    """Moves sorted positions apart by at least `least`, as little as possible, within [0, 1]."""
    order = sorted(range(len(positions)), key=lambda i: positions[i])
    placed = [0.0] * len(positions)
    for k, i in enumerate(order):
        placed[i] = positions[i] if k == 0 else max(positions[i], placed[order[k - 1]] + least)
    top = 1.0
    for i in reversed(order):
        placed[i] = min(placed[i], top)
        top = placed[i] - least
    return placed


def precision_plot(scene, rows, path):
    """Error against time, log-log; each engine once a setting, named at the right."""
    figure, axes = plt.subplots(figsize=(7.2, 4.4))
    figure.subplots_adjust(left=0.1, right=0.76, top=0.86, bottom=0.13)
    labels = []  # (error at the label, text, colour, time)
    curves = defaultdict(list)
    for row in rows:
        curves[row["engine"], row["curve"]].append(row)
    best = {}
    for (engine, curve), points in curves.items():
        points = [p for p in points if math.isfinite(p["error"])]
        if not points:
            continue
        if engine == "skerry":
            colour, marker, line = OURS.get(curve, ("#444444", "x", "-."))
            face = colour
        else:
            colour = COLOURS[engine]
            index = engine_curves(engine, rows).index(curve)
            marker, line = "o", ["-", "--", ":"][index]
            face = [colour, "white", "white"][index]
        x = [p["median_s"] for p in points]
        y = [max(p["error"], FLOOR) for p in points]
        bars = [[p["median_s"] - p["min_s"] for p in points], [p["max_s"] - p["median_s"] for p in points]]
        axes.errorbar(x, y, xerr=bars, color=colour, linestyle=line, marker=marker, markersize=4.5,
                      markerfacecolor=face, linewidth=1.4 if engine == "skerry" else 1.1, elinewidth=0.7,
                      zorder=3 if engine == "skerry" else 2)
        k = len(x) - 1
        name = f"skerry {curve}" if engine == "skerry" else engine
        if name not in best or (y[k] < best[name][0]):
            best[name] = (y[k], name, colour, x[k])
    labels = list(best.values())
    axes.set_xscale("log")
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, FLOOR / 3) if low < 3 * FLOOR else low, high * 2)
    axes.grid(True, which="major")
    axes.set_xlabel("processor time of the run [s]")
    axes.set_ylabel(scene["measure"])
    figure.text(0.015, 0.955, scene["title"], fontsize=11, fontweight="bold")
    figure.text(0.015, 0.91, scene["source"], fontsize=8, color="#555555")
    ends = [axes.transAxes.inverted().transform(axes.transData.transform((e[3], e[0]))) for e in labels]
    heights = spread([float(e[1]) for e in ends], 0.055)
    for (_, text, colour, _), end, y in zip(labels, ends, heights):
        axes.annotate(text, xy=end, xytext=(1.03, y), xycoords="axes fraction", textcoords="axes fraction",
                      color=colour, va="center", fontsize=8.5, fontweight="bold" if "skerry" in text else "normal",
                      annotation_clip=False,
                      arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.5, "alpha": 0.6})
    figure.text(0.77, 0.02, "peers: solid default, dashed best,\ndotted third solver; bars: min to max", fontsize=6.5,
                color="#555555")
    save(figure, path)


def compare(rows):
    """(error ratio at equal time, time ratio at equal error) of ours against the best peer; infinite: no peer is as
    fast, or none as accurate; None: nothing to compare."""
    ours = [(p["median_s"], max(p["error"], FLOOR)) for p in rows if is_ours(p) and math.isfinite(p["error"])]
    peers = [(p["median_s"], max(p["error"], FLOOR)) for p in rows if not is_ours(p) and math.isfinite(p["error"])]
    errors, times = [], []
    for t, e in ours:
        as_fast = [pe for pt, pe in peers if pt <= t]
        as_good = [pt for pt, pe in peers if pe <= e]
        errors.append(min(as_fast) / e if as_fast else math.inf)
        times.append(min(as_good) / t if as_good else math.inf)
    if not ours or not peers:
        return None
    finite = [r for r in errors if math.isfinite(r)]
    # Being faster than every peer at some bad setting proves nothing: prefer a comparison that has a peer in it.
    return (max(finite) if finite else math.inf), max(times)


def summary_plot(scenes, data, path):
    figure, axes = plt.subplots(figsize=(8.2, 6.4))
    figure.subplots_adjust(left=0.1, right=0.97, top=0.88, bottom=0.1)
    points = []
    for name in data:
        ratios = compare(data[name])
        if ratios is not None:
            points.append((name, *ratios))
    edge = 1e5
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(1e-3, edge * 8)
    axes.set_ylim(1e-4, 1e17)
    axes.axhspan(100, 1e17, color="#0072B2", alpha=0.06)
    axes.axvspan(10, edge * 8, color="#0072B2", alpha=0.06)
    axes.axhline(1, color="#999999", linewidth=0.8)
    axes.axvline(1, color="#999999", linewidth=0.8)
    texts = []
    for name, error, time in points:
        x = min(max(time, 1.5e-3), edge)
        y = min(max(error, 2e-4), 1e16)
        reached = (math.isfinite(time) and time >= 10) or error >= 100
        axes.plot(x, y, marker=">" if not math.isfinite(time) else "o", color="#0072B2" if reached else "#D55E00",
                  markersize=6, zorder=3)
        texts.append((x, y, name))
    # Names beside the points; in the column at the edge to the left, kept apart.
    for column in (True, False):
        chosen = [t for t in texts if (t[0] >= edge) == column]
        if not chosen:
            continue
        at = [axes.transAxes.inverted().transform(axes.transData.transform((x, y))) for x, y, _ in chosen]
        heights = spread([float(a[1]) for a in at], 0.024)
        for (x, y, name), a, height in zip(chosen, at, heights):
            axes.annotate(name, xy=(a[0], a[1]), xytext=(a[0] - 0.018 if column else a[0] + 0.018, height),
                          xycoords="axes fraction", textcoords="axes fraction", fontsize=7.5, va="center",
                          ha="right" if column else "left",
                          arrowprops={"arrowstyle": "-", "color": "#aaaaaa", "linewidth": 0.5, "shrinkA": 0})
    axes.grid(True, which="major")
    axes.set_xlabel("time of the fastest peer with our error / our time     (triangles: no peer setting reaches our error)")
    axes.set_ylabel("error of the best peer in our time / our error")
    figure.text(0.02, 0.955, "Accurate and fast: every scene against the best peer at its best setting", fontsize=12,
                fontweight="bold")
    figure.text(0.02, 0.915, "shaded: the aim (error 100 times smaller in equal time, or 10 times faster at equal error); "
                "orange: not reached", fontsize=8.5, color="#555555")
    save(figure, path)


def text(value):
    if not math.isfinite(value):
        return "fails"
    if value == 0:
        return "0"
    return f"{value:.1e}".replace("e-0", "e-").replace("e+00", "").replace("e+0", "e+")


def tables(scenes, data, engines, out):
    """Markdown: defaults at 60 Hz, best settings, and the aim."""
    lines = ["### Error and time of a step, defaults at 60 Hz", "",
             "Error / microseconds a step (median).", "",
             "| scene | " + " | ".join(("skerry time_stepping", "skerry event_driven", *engines)) + " |",
             "| --- |" + " --- |" * (len(engines) + 2)]

    def cell(row):
        return f"{text(row['error'])} / {1e6 * row['median_s'] / row['steps']:.3g}" if row else "-"

    for name, rows in data.items():
        at60 = [r for r in rows if abs(r["dt"] - 1 / 60) < 1e-4]
        cells = []
        for curve in ("time_stepping", "event_driven"):
            found = [r for r in at60 if is_ours(r) and r["curve"] == curve]
            cells.append(cell(min(found, key=lambda r: r["accuracy"] or 1) if found else None))
        for engine in engines:
            found = [r for r in at60 if r["engine"] == engine]
            cells.append(cell(found[0] if found else None))
        lines.append(f"| {name} | " + " | ".join(cells) + " |")

    lines += ["", "### Smallest error of each engine over all its settings, and the time of that run", "",
              "Error / milliseconds.", "", "| scene | skerry | " + " | ".join(engines) + " |",
              "| --- |" + " --- |" * (len(engines) + 1)]
    for name, rows in data.items():
        cells = []
        for engine in ("skerry", *engines):
            found = [r for r in rows if r["engine"] == engine]
            best = min(found, key=lambda r: (max(r["error"], FLOOR), r["median_s"]), default=None)
            cells.append(f"{text(best['error'])} / {1e3 * best['median_s']:.3g}" if best else "-")
        lines.append(f"| {name} | " + " | ".join(cells) + " |")

    lines += ["", "### The aim: error 100 times smaller in equal time, or 10 times faster at equal error", "",
              "| scene | error of the best peer in our time / our error | time of the fastest peer with our error / "
              "our time | aim |", "| --- | --- | --- | --- |"]
    reached = 0
    for name, rows in data.items():
        ratios = compare(rows)
        if ratios is None:
            continue
        error, time = ratios
        good = error >= 100 or (math.isfinite(time) and time >= 10)
        reached += good
        lines.append(f"| {name} | {text(error) if math.isfinite(error) else 'no peer is as fast'} | "
                     f"{text(time) if math.isfinite(time) else 'no peer gets there'} | "
                     f"{'reached' if good else '**not reached**'} |")
    lines += ["", f"Reached on {reached} of {len(data)} scenes. Errors below {FLOOR:g} count as {FLOOR:g}.", ""]
    out.write_text("\n".join(lines), encoding="utf-8")


def main():
    if len(sys.argv) < 2:
        sys.exit(f"usage: {sys.argv[0]} DIR [--png]")
    folder = Path(sys.argv[1])
    plots = folder / "plots"
    plots.mkdir(exist_ok=True)
    scenes = {row["scene"]: row for row in rows_of(folder / "scenes.csv")}
    found = defaultdict(list)
    engines = {}
    for row in rows_of(folder / "precision.csv"):
        for key in ("dt", "accuracy", "error", "median_s", "min_s", "max_s"):
            row[key] = float(row[key])
        row["steps"] = int(row["steps"])
        found[row["scene"]].append(row)
        if not is_ours(row):
            engines[row["engine"]] = row["version"]
    data = {name: found[name] for name in scenes if name in found}
    for name, rows in data.items():
        precision_plot(scenes[name], rows, plots / f"{name}.svg")
    if data:
        summary_plot(scenes, data, plots / "summary.svg")
        tables(scenes, data, list(engines), folder / "tables.md")


if __name__ == "__main__":
    main()
