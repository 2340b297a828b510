#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Tables and plots of accuracy_bench.

    accuracy_bench precision -o DIR
    tests/bench/accuracy/report.py DIR [PAGE.md]

Reads the comma-separated tables of DIR and writes DIR/plots/*.svg and DIR/tables.md; with a page, its parts between
markers <!-- precision --> ... <!-- /precision --> as well. Needs matplotlib (Debian: python3-matplotlib).
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
EQUAL = 1.25  # a peer that takes so many times as long as we do is still as fast: times vary by this between runs
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
    # A third of the size: coordinates (not numbers in words) to a hundredth of a point, no comments, no line breaks within elements.
    text = path.read_text(encoding="utf-8")
    text = re.sub(r"<!--.*?-->|<metadata>.*?</metadata>", "", text, flags=re.S)
    text = re.sub(r"<[^>]*>", lambda tag: re.sub(r"(\d+\.\d\d)\d+", r"\1", tag[0]), text)
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
        x = [p["min_s"] for p in points]
        y = [max(p["error"], FLOOR) for p in points]
        bars = [[0] * len(points), [p["max_s"] - p["min_s"] for p in points]]
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
    figure.text(0.77, 0.02, "peers: solid default, dashed best,\ndotted third; bars: slowest run", fontsize=6.5,
                color="#555555")
    save(figure, path)


def is_our_default(row):
    return is_ours(row) and row["curve"] == "time_stepping" and abs(row["dt"] - 1 / 60) < 1e-4


def compare(rows, counts=is_ours):
    """(error ratio at equal time, time ratio at equal error) of that run of ours (of those that count) which stands best
    against the best peer; infinite: no peer is as fast, or none as accurate; None: nothing to compare. Peers take part
    with all their runs."""
    ours = [(p["min_s"], max(p["error"], FLOOR)) for p in rows if counts(p) and math.isfinite(p["error"])]
    peers = [(p["min_s"], max(p["error"], FLOOR)) for p in rows if not is_ours(p) and math.isfinite(p["error"])]
    errors, times = [], []
    for t, e in ours:
        as_fast = [pe for pt, pe in peers if pt <= EQUAL * t]
        as_good = [pt for pt, pe in peers if pe <= e]
        if as_fast:
            errors.append(min(as_fast) / e)
        elif peers and all(pt >= 10 * t for pt, pe in peers if pe < 100 * e):
            errors.append(math.inf)
        times.append(min(as_good) / t if as_good else math.inf)
    if not ours or not peers:
        return None
    # Being faster than every peer proves something only where those that come near our error take ten times as long.
    return max(errors, default=0), max(times)


def summary_plot(data, path):
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
    # Names beside the points, in the column at the edge to the left; where many share a place, in one block.
    to_axes = lambda x, y: axes.transAxes.inverted().transform(axes.transData.transform((x, y)))
    places = {}
    for x, y, name in texts:
        places.setdefault((x, y), []).append(name)
    for column in (True, False):
        chosen = []
        for (x, y), names in places.items():
            if (x >= edge) != column:
                continue
            if len(names) > 3:
                lines = [", ".join(names[k:k + 3]) for k in range(0, len(names), 3)]
                left, top = to_axes(x, y)
                axes.annotate(f"{len(names)} scenes:\n" + ",\n".join(lines), xy=(left, top), xytext=(left - 0.17, top - 0.05),
                              xycoords="axes fraction", textcoords="axes fraction", fontsize=7.5, va="top", ha="right",
                              linespacing=1.35, arrowprops={"arrowstyle": "-", "color": "#aaaaaa", "linewidth": 0.5,
                                                            "shrinkA": 0, "relpos": (1, 1)})
            else:
                chosen.append((x, y, ", ".join(names)))
        if not chosen:
            continue
        at = [to_axes(x, y) for x, y, _ in chosen]
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


def overview_plot(data, scenes, engines, path):
    """Everybody as it comes, at 60 Hz: the error on the left, the time of a step on the right, a line a scene."""
    names = list(data)
    figure, panels = plt.subplots(1, 2, figsize=(11, 0.3 * len(names) + 1.75), sharey=True,
                                  gridspec_kw={"width_ratios": [1.75, 1]})
    height = figure.get_figheight()
    figure.subplots_adjust(left=0.335, right=0.985, top=1 - 1.02 / height, bottom=0.55 / height, wspace=0.05)
    highest = 1e3  # what fails altogether stands there
    for k, name in enumerate(names):
        at60 = [r for r in data[name] if abs(r["dt"] - 1 / 60) < 1e-4]
        found = {}
        for row in at60:
            if is_our_default(row) or not is_ours(row):
                found.setdefault(row["engine"], row)
        for axes in panels:
            axes.axhspan(k - 0.5, k + 0.5, color="#f6f6f4" if k % 2 else "white", zorder=0, linewidth=0)
        for place, engine in enumerate((*engines, "skerry")):
            row = found.get(engine)
            if row is None or math.isnan(row["error"]):
                continue
            ours = engine == "skerry"
            style = {"color": COLOURS[engine], "linestyle": "", "zorder": 3 if ours else 4}
            # Peers one below the other, so that nobody hides anybody.
            y = k if ours else k + 0.64 * (place / max(len(engines) - 1, 1) - 0.5)
            error = min(max(row["error"], FLOOR), highest)
            panels[0].plot(error, y, marker="D" if ours else "o" if error < highest else "X", markersize=7 if ours else 4.5,
                           **style)
            panels[1].plot(1e6 * row["min_s"] / row["steps"], y, marker="D" if ours else "o",
                           markersize=7 if ours else 4.5, **style)
    for axes in panels:
        axes.set_xscale("log")
        axes.grid(True, axis="x", which="major")
        axes.tick_params(axis="y", length=0)
        axes.spines["left"].set_visible(False)
    panels[0].set_ylim(len(names) - 0.5, -0.5)
    panels[0].set_xlim(FLOOR / 4, highest * 4)
    panels[0].set_xticks([10.0**k for k in range(-16, 4, 2)])
    panels[1].set_xlim(left=0.05)
    panels[0].set_yticks(range(len(names)), [scenes[name]["title"].removesuffix(" (bisection)") for name in names], fontsize=8)
    panels[0].set_xlabel("error, each scene by its own measure (rounding of a double: 1e-16)")
    panels[1].set_xlabel("time of a step [us]")
    figure.text(0.012, 1 - 0.32 / height, "The same scenes, every engine as it comes, 60 Hz", fontsize=13, fontweight="bold")
    figure.text(0.012, 1 - 0.56 / height, "left: how wrong, against a formula; right: what a step costs; further left is better in both",
                fontsize=9, color="#555555")
    handles = [plt.Line2D([], [], color=COLOURS[e], marker="D" if e == "skerry" else "o", linestyle="", markersize=6.5)
               for e in ("skerry", *engines)]
    figure.legend(handles, ["Skerry", *engines], loc="upper right", ncol=len(handles), fontsize=9, frameon=False,
                  bbox_to_anchor=(0.99, 1 - 0.58 / height), handletextpad=0.2, columnspacing=1.4)
    save(figure, path)


def text(value, infinite="fails"):
    if math.isnan(value):
        return "too slow"
    if not math.isfinite(value):
        return infinite
    if value == 0:
        return "0"
    return f"{value:.1e}".replace("e-0", "e-").replace("e+00", "").replace("e+0", "e+")


def tables(data, engines):
    """Markdown: defaults at 60 Hz, best settings, and the aim."""
    lines = ["### Error and time of a step, defaults at 60 Hz", "",
             "Error / microseconds a step (the least time of the runs). Too slow: given up after 1.5 s; not found: the limit of "
             "a bisection is outside its bracket. `event_driven` has its default accuracy, "
             "1e-13, but where a coarser one, the finest that was run, stands in brackets.", "",
             "| scene | " + " | ".join(("skerry time_stepping", "skerry event_driven", *engines)) + " |",
             "| --- |" + " --- |" * (len(engines) + 2)]

    def error_of(row):
        return text(row["error"], "not found" if row["scene"].endswith("_limit") else "fails")

    def cell(row):
        return f"{error_of(row)} / {1e6 * row['min_s'] / row['steps']:.3g}" if row else "-"

    for name, rows in data.items():
        at60 = [r for r in rows if abs(r["dt"] - 1 / 60) < 1e-4]
        cells = []
        for curve in ("time_stepping", "event_driven"):
            found = [r for r in at60 if is_ours(r) and r["curve"] == curve]
            finest = min(found, key=lambda r: r["accuracy"] or 1, default=None)
            coarser = finest is not None and finest["accuracy"] > 1.01e-13
            cells.append(cell(finest) + (f" ({finest['accuracy']:g})" if coarser else ""))
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
            best = min(found, key=lambda r: (max(r["error"], FLOOR), r["min_s"]), default=None)
            cells.append(f"{error_of(best)} / {1e3 * best['min_s']:.3g}" if best else "-")
        lines.append(f"| {name} | " + " | ".join(cells) + " |")

    lines += ["", "### The aim: error 100 times smaller in equal time, or 10 times faster at equal error", "",
              "The best of all runs of ours against the best of all runs of all peers; the last column does not let us "
              "choose: our default (`time_stepping`, 1/60 s) alone against the same peers. "
              f"Equal time: a peer may take {EQUAL:g} times ours, as times vary so much from run to run.", "",
              "| scene | error of the best peer in our time / our error | time of the fastest peer with our error / "
              "our time | aim | our default alone |", "| --- | --- | --- | --- | --- |"]

    def verdict(ratios):
        return ratios is not None and (ratios[0] >= 100 or (math.isfinite(ratios[1]) and ratios[1] >= 10))

    reached = by_default = 0
    for name, rows in data.items():
        ratios = compare(rows)
        if ratios is None:
            continue
        error, time = ratios
        good, default = verdict(ratios), verdict(compare(rows, is_our_default))
        reached += good
        by_default += default
        lines.append(f"| {name} | {text(error) if math.isfinite(error) else 'no peer is as fast'} | "
                     f"{text(time) if math.isfinite(time) else 'no peer gets there'} | "
                     f"{'reached' if good else '**not reached**'} | {'reached' if default else '**not reached**'} |")
    lines += ["", f"Reached on {reached} of {len(data)} scenes, by our default alone on {by_default}. Errors below "
              f"{FLOOR:g} count as {FLOOR:g}.", ""]
    return lines


VERDICTS = {"exact": ("#0072B2", "", "exact (1e-8 of a body's size)"), "good": ("#8CC5E8", "", "good (1e-3)"),
            "jitters": ("#F7E58A", "j", "jitters (over 1 cm/s at rest)"), "drifts": ("#F0B93A", "d", "drifts (1e-3 to 0.1)"),
            "fails": ("#D55E00", "f", "fails (over 0.1)"), "tunnels": ("#A04000", "t", "leaves through a wall"),
            "explodes": ("#000000", "E", "explodes (gains energy)"), "not a number": ("#000000", "N", "not a number"),
            "too slow": ("#B5B5B5", "s", "too slow, or cut")}


def stress_map(rows, path):
    """One panel an axis: engines down, values across, coloured by verdict."""
    axes_names, lines = [], []
    for row in rows:
        if row["axis"] not in axes_names:
            axes_names.append(row["axis"])
        line = (row["engine"], row["curve"])
        if line not in lines:
            lines.append(line)
    lines.sort(key=lambda line: line[0] != "skerry")  # ours first, whoever ran last
    cells = {(r["axis"], r["engine"], r["curve"], float(r["value"])): r["verdict"] for r in rows}
    columns = 2
    height = math.ceil(len(axes_names) / columns)
    figure, grid = plt.subplots(height, columns, figsize=(10.5, 0.9 + 2.75 * height))
    figure.subplots_adjust(left=0.15, right=0.985, top=1 - 0.95 / (0.9 + 2.75 * height), bottom=0.025, wspace=0.08,
                           hspace=0.3)
    for axes in grid.flat[len(axes_names):]:
        axes.axis("off")
    for k, (name, axes) in enumerate(zip(axes_names, grid.flat)):
        values = sorted({key[3] for key in cells if key[0] == name})
        for y, (engine, curve) in enumerate(lines):
            for x, value in enumerate(values):
                verdict = cells.get((name, engine, curve, value))
                if verdict is None:
                    continue
                colour, letter, _ = VERDICTS[verdict]
                axes.add_patch(plt.Rectangle((x, y), 0.94, 0.9, facecolor=colour, edgecolor="none"))
                axes.text(x + 0.47, y + 0.47, letter, ha="center", va="center", fontsize=7,
                          color="white" if verdict in ("explodes", "not a number", "fails", "tunnels") else "#222222")
        axes.set_xlim(0, len(values))
        axes.set_ylim(len(lines), 0)
        axes.set_xticks([x + 0.47 for x in range(len(values))], [f"{v:g}".replace("e+0", "e") for v in values],
                        fontsize=7.5)
        names = [f"{engine} {curve}" for engine, curve in lines]
        axes.set_yticks([y + 0.45 for y in range(len(lines))], names if k % columns == 0 else [], fontsize=7.5)
        for label, (engine, _) in zip(axes.get_yticklabels(), lines):
            label.set_fontweight("bold" if engine == "skerry" else "normal")
        axes.tick_params(length=0)
        axes.spines[:].set_visible(False)
        axes.set_title(name, fontsize=9.5, loc="left", fontweight="bold")
    figure.text(0.02, 1 - 0.28 / (0.9 + 2.75 * height), "Where the envelope ends", fontsize=13, fontweight="bold")
    handles = [plt.Rectangle((0, 0), 1, 1, facecolor=colour) for colour, _, _ in VERDICTS.values()]
    figure.legend(handles, [(f"{letter}: " if letter else "") + text for _, letter, text in VERDICTS.values()],
                  loc="upper right", ncol=3, fontsize=7.5, frameon=False, handlelength=1.2)
    save(figure, path)


def exponent(points):
    """Slope of log time over log bodies, least squares, from 100 bodies on."""
    points = [(math.log(n), math.log(t)) for n, t in points if n >= 100]
    if len(points) < 3:
        return None
    mx = sum(x for x, _ in points) / len(points)
    my = sum(y for _, y in points) / len(points)
    return sum((x - mx) * (y - my) for x, y in points) / sum((x - mx) ** 2 for x, _ in points)


def scaling_plots(rows, folder):
    families, lines = [], defaultdict(list)
    for row in rows:
        if row["scene"] not in families:
            families.append(row["scene"])
        lines[row["scene"], row["engine"], row["threads"]].append(row)
    stages = [key for key in rows[0] if key in ("forces", "broad", "narrow", "islands", "assemble", "solve", "impact",
                                                 "apply", "report", "broad phase", "narrow phase")]
    for kind in ("engines", "stages"):
        columns = 3
        height = math.ceil(len(families) / columns)
        figure, grid = plt.subplots(height, columns, figsize=(14, 4.1 * height), squeeze=False)
        figure.subplots_adjust(left=0.05, right=0.88, top=0.86 if height == 1 else 0.9, bottom=0.14 if height == 1 else 0.07, wspace=0.75, hspace=0.3)
        for axes in grid.flat[len(families):]:
            axes.axis("off")
        for family, axes in zip(families, grid.flat):
            labels = []
            axes.set_xscale("log")
            axes.set_yscale("log")
            if kind == "engines":
                for (scene, engine, threads), points in lines.items():
                    if scene != family:
                        continue
                    x = [int(p["bodies"]) for p in points]
                    y = [float(p["median_us"]) for p in points]
                    bars = [[float(p["median_us"]) - float(p["min_us"]) for p in points],
                            [float(p["max_us"]) - float(p["median_us"]) for p in points]]
                    two = threads == "2"
                    axes.errorbar(x, y, yerr=bars, color=COLOURS[engine], linestyle="--" if two else "-", marker="o",
                                  markersize=3.5, markerfacecolor="white" if two else COLOURS[engine], linewidth=1.3,
                                  elinewidth=0.6)
                    slope = exponent(list(zip(x, y)))
                    text = engine + (" 2 threads" if two else "") + (f"  n^{slope:.2f}" if slope is not None else "")
                    labels.append((x[-1], y[-1], text, COLOURS[engine]))
            else:
                points = lines.get((family, "skerry", "1"), [])
                palette = ["#000000", "#E69F00", "#56B4E9", "#009E73", "#999900", "#0072B2", "#D55E00", "#CC79A7",
                           "#999999"]
                for stage, colour in zip(stages, palette):
                    x = [int(p["bodies"]) for p in points if float(p[stage]) > 0]
                    y = [float(p[stage]) for p in points if float(p[stage]) > 0]
                    if not x:
                        continue
                    axes.plot(x, y, color=colour, marker="o", markersize=3, linewidth=1.2)
                    slope = exponent(list(zip(x, y)))
                    labels.append((x[-1], y[-1], stage + (f"  n^{slope:.2f}" if slope is not None else ""), colour))
            axes.grid(True, which="major")
            axes.set_title(family, loc="left", fontweight="bold", fontsize=10)
            axes.set_xlabel("bodies")
            axes.set_ylabel("us a step")
            axes.get_xlim(), axes.get_ylim()  # autoscale now: the labels need the final limits
            ends = [axes.transAxes.inverted().transform(axes.transData.transform((e[0], e[1]))) for e in labels]
            heights = spread([float(e[1]) for e in ends], 0.062)
            for (_, _, text, colour), end, y in zip(labels, ends, heights):
                axes.annotate(text, xy=end, xytext=(1.03, y), xycoords="axes fraction", textcoords="axes fraction",
                              color=colour, va="center", fontsize=7.5, annotation_clip=False,
                              arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.4, "alpha": 0.6})
        figure.text(0.02, 0.955, {"engines": "Time of a step against the number of bodies; exponents fitted from 100 bodies on",
                                  "stages": "Stages of our step (time_stepping, one thread)"}[kind], fontsize=12,
                    fontweight="bold")
        save(figure, folder / {"engines": "scaling.svg", "stages": "scaling_stages.svg"}[kind])


def scaling_table(rows):
    counts = sorted({int(r["bodies"]) for r in rows})
    shown = [n for n in counts if n in (10, 100, 1000, 10000, 100000)]
    lines = ["### Scaling: median microseconds a step, exponent from 100 bodies on", "",
             "| scene | engine | " + " | ".join(f"{n}" for n in shown) + " | slowest step, largest scene | exponent | contacts of 1000 bodies | residual |",
             "| --- | --- |" + " --- |" * (len(shown) + 4)]
    groups = defaultdict(list)
    for row in rows:
        groups[row["scene"], row["engine"], row["threads"]].append(row)
    for (scene, engine, threads), points in groups.items():
        times = {int(p["bodies"]): float(p["median_us"]) for p in points}
        slope = exponent(list(times.items()))
        residuals = [float(p["residual"]) for p in points if p["residual"]]
        contacts = [p["contacts"] for p in points if p["bodies"] == "1000"]
        slowest = float(max(points, key=lambda p: int(p["bodies"]))["max_us"])
        lines.append(f"| {scene} | {engine}{' (2 threads)' if threads == '2' else ''} | " +
                     " | ".join(f"{times[n]:.3g}" if n in times else "-" for n in shown) +
                     f" | {slowest:.3g} | {'-' if slope is None else f'{slope:.2f}'} | "
                     f"{contacts[0] if contacts and contacts[0] else '-'} | "
                     f"{f'{max(residuals):.0e}' if residuals else '-'} |")
    return lines + [""]


def skips_table(rows, title="What each skip saves", first="scene"):
    lines = [f"### {title}", "",
             "Median microseconds a step with all skips, and how many times as long a step takes with one of them off. "
             "In brackets: the final state differs in its bits.", ""]
    switches, scenes = [], []
    for row in rows:
        if row["switch"] not in switches:
            switches.append(row["switch"])
        if row["scene"] not in scenes:
            scenes.append(row["scene"])
    found = {(r["scene"], r["switch"]): r for r in rows}
    ratios = {switch: [] for switch in switches[1:]}
    lines += [f"| {first} | " + " | ".join(["all on [us]"] + switches[1:]) + " |", "| --- |" + " --- |" * len(switches)]
    for scene in scenes:
        base = float(found[scene, switches[0]]["median_us"])
        cells = [f"{base:.3g}"]
        for switch in switches[1:]:
            row = found[scene, switch]
            ratios[switch].append((float(row["median_us"]) / base, scene))
            ratio = f"{ratios[switch][-1][0]:.2f}"
            cells.append(ratio if row["bits"] == "same" else f"({ratio})")
        lines.append(f"| {scene} | " + " | ".join(cells) + " |")
    lines += ["", f"| off | geometric mean | {first}s a tenth slower or more | a tenth faster or more | slowest without it | fastest without it |",
              "| --- | --- | --- | --- | --- | --- |"]
    for switch, values in ratios.items():
        mean = math.exp(sum(math.log(v) for v, _ in values) / len(values))
        most, least = max(values), min(values)
        lines.append(f"| {switch} | {mean:.2f} | {sum(v >= 1.1 for v, _ in values)} of {len(values)} | "
                     f"{sum(v <= 1 / 1.1 for v, _ in values)} | {most[1]} {most[0]:.2f} | {least[1]} {least[0]:.2f} |")
    keys = ["pairs", "pairs_out_of_reach", "manifolds_reused", "axes_tested", "axes_skipped", "rows", "friction_rows",
            "factorisations", "resolves", "symbolic_skipped", "islands", "islands_asleep", "islands_at_rest",
            "islands_in_flight"]
    lines += ["", "Counters a step, all skips on:", "",
              f"| {first} | " + " | ".join(k.replace("_", " ") for k in keys) + " |", "| --- |" + " --- |" * len(keys)]
    for scene in scenes:
        row = found[scene, switches[0]]
        lines.append(f"| {scene} | " + " | ".join(f"{float(row[k]):.4g}" for k in keys) + " |")
    return lines + [""]


def frames_table(rows):
    """Frames that were not drawn again, and what they would have cost."""
    found = defaultdict(dict)
    for row in rows:
        found[row["scene"]][row["switch"]] = row
    lines = ["### Frames that need not be drawn", "",
             "Processor time of a frame, steps and encoder included; ratio: with every frame drawn, converted and copied.", "",
             "| demo | frames | unchanged | ms a frame | all drawn |", "| --- | --- | --- | --- | --- |"]
    for demo, ways in found.items():
        kept, drawn = ways["unchanged kept"], ways["all drawn"]
        lines.append(f"| {demo} | {kept['frames']} | {kept['unchanged']} | {float(kept['median_ms']):.3g} | "
                     f"{float(drawn['median_ms']) / float(kept['median_ms']):.2f} |")
    return lines + [""]


def envelope_table(rows):
    """How many points of each axis an engine passes (exact, good or drifts)."""
    axes_names, lines = [], []
    for row in rows:
        if row["axis"] not in axes_names:
            axes_names.append(row["axis"])
        if (row["engine"], row["curve"]) not in lines:
            lines.append((row["engine"], row["curve"]))
    lines.sort(key=lambda line: line[0] != "skerry")
    out = ["### Stress: points passed (exact or good) of all", "",
           "| engine | " + " | ".join(axes_names) + " | all |", "| --- |" + " --- |" * (len(axes_names) + 1)]
    for engine, curve in lines:
        cells, total, count = [], 0, 0
        for name in axes_names:
            mine = [r for r in rows if (r["axis"], r["engine"], r["curve"]) == (name, engine, curve)]
            passed = sum(r["verdict"] in ("exact", "good") for r in mine)
            cells.append(f"{passed} / {len(mine)}")
            total += passed
            count += len(mine)
        out.append(f"| {engine} {curve} | " + " | ".join(cells) + f" | {total} / {count} |")
    return out + [""]


def insert(page, name, lines):
    """Replaces what stands between the page's markers of that name."""
    text = page.read_text(encoding="utf-8")
    begin, end = f"<!-- {name} -->\n", f"<!-- /{name} -->"
    if begin in text and end in text:
        head, rest = text.split(begin, 1)
        page.write_text(head + begin + "\n".join(lines) + "\n" + end + rest.split(end, 1)[1], encoding="utf-8")


def main():
    if len(sys.argv) < 2:
        sys.exit(f"usage: {sys.argv[0]} DIR [PAGE.md] [--png]")
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
    parts = {}
    if data:
        for name, rows in data.items():
            precision_plot(scenes[name], rows, plots / f"{name}.svg")
        summary_plot(data, plots / "summary.svg")
        overview_plot(data, scenes, engines, plots / "overview.svg")
        parts["precision"] = tables(data, list(engines))
    stress = rows_of(folder / "stress.csv")
    if stress:
        stress_map(stress, plots / "stress.svg")
        parts["stress"] = envelope_table(stress)
    scaling = rows_of(folder / "scaling.csv")
    if scaling:
        scaling_plots(scaling, plots)
        parts["scaling"] = scaling_table(scaling)
    skips = rows_of(folder / "skips.csv")
    if skips:
        parts["skips"] = skips_table(skips)
    demos = rows_of(folder / "demos.csv")
    if demos:
        parts["demos"] = skips_table(demos, "What each skip saves in the demos", "demo")
    frames = rows_of(folder / "frames.csv")
    if frames:
        parts["frames"] = frames_table(frames)
    (folder / "tables.md").write_text("\n".join(line for part in parts.values() for line in part), encoding="utf-8")
    pages = [a for a in sys.argv[2:] if not a.startswith("--")]
    for page in pages:
        for name, lines in parts.items():
            insert(Path(page), name, lines)


if __name__ == "__main__":
    main()
