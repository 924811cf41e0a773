#!/usr/bin/env python3
"""Plots error against render time, both logarithmic, from the CSV that `lodestar` writes.

    python3 lodestar_plot.py FILE.csv... -o PLOT.png [--metric relmse_trimmed] [--title TEXT]

One line a method. With several seeds the line is the mean at common times and the bars are one sample standard deviation. The default metric is
relmse_trimmed where the file has it (a reference was given), else relmse_estimated.

Exit codes: 0 drawn, 1 nothing to draw or a file that is not such a CSV, 2 wrong arguments, 3 no matplotlib.
"""
import argparse
import csv
import math
import sys

TITLES = {
    "relmse_trimmed": "relMSE (worst 0.1 % of pixels left out)",
    "relmse_estimated": "estimated relMSE",
    "relmse": "relMSE",
    "rmse": "RMSE",
    "mse": "MSE",
    "mae": "MAE",
}


def read_rows(paths):
    rows = []
    for path in paths:
        with open(path, newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file)
            missing = {"method", "seed", "seconds", "spp", "relmse_estimated"} - set(reader.fieldnames or [])
            if missing:
                raise ValueError(f"{path}: no column {', '.join(sorted(missing))}; is it a CSV of lodestar?")
            rows += reader
    return rows


def curves(rows, metric):
    """{method: {seed: [(seconds, error), ...]}}, ascending, with only what a logarithm can show."""
    result = {}
    for row in rows:
        try:
            seconds, error = float(row["seconds"]), float(row.get(metric) or "nan")
        except ValueError:
            continue
        if seconds > 0 and error > 0 and math.isfinite(error):
            result.setdefault(row["method"], {}).setdefault(row["seed"], []).append((seconds, error))
    for seeds in result.values():
        for points in seeds.values():
            points.sort()
    return result


def interpolate(points, seconds):
    """Log-log between neighbours; none outside."""
    for (t0, e0), (t1, e1) in zip(points, points[1:]):
        if t0 <= seconds <= t1:
            share = 0.0 if t1 == t0 else math.log(seconds / t0) / math.log(t1 / t0)
            return e0 * (e1 / e0) ** share
    return points[0][1] if len(points) == 1 and seconds == points[0][0] else None


def summary(seeds, steps=24):
    """Mean and sample standard deviation over the seeds at common times: [(seconds, mean, deviation)]."""
    if len(seeds) == 1:
        return [(t, e, 0.0) for t, e in next(iter(seeds.values()))]
    start = max(points[0][0] for points in seeds.values())
    end = min(points[-1][0] for points in seeds.values())
    if end <= start:
        times = [start]
    else:
        times = [start * (end / start) ** (i / (steps - 1)) for i in range(steps)]
        times[-1] = end
    result = []
    for time in times:
        values = [v for v in (interpolate(points, time) for points in seeds.values()) if v is not None]
        if not values:
            continue
        mean = sum(values) / len(values)
        spread = math.sqrt(sum((v - mean) ** 2 for v in values) / (len(values) - 1)) if len(values) > 1 else 0.0
        result.append((time, mean, spread))
    return result


def draw(plt, by_method, metric, title, output):
    figure, axes = plt.subplots(figsize=(8, 5), dpi=120)
    for method, seeds in by_method.items():
        points = summary(seeds)
        if not points:
            continue
        times, means, spreads = zip(*points)
        # A bar down to zero or below cannot be drawn on a logarithmic axis: it ends just above.
        lower = [min(s, 0.99 * m) for m, s in zip(means, spreads)]
        label = method if len(seeds) == 1 else f"{method} ({len(seeds)} seeds)"
        if any(spreads):
            axes.errorbar(times, means, yerr=[lower, spreads], label=label, capsize=2, linewidth=1.5, elinewidth=0.8)
        else:
            axes.plot(times, means, label=label, marker=".", linewidth=1.5)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("render time [s]")
    axes.set_ylabel(TITLES.get(metric, metric))
    if title:
        axes.set_title(title)
    axes.grid(True, which="both", alpha=0.25)
    axes.legend()
    figure.tight_layout()
    figure.savefig(output)


def main(arguments=None):
    parser = argparse.ArgumentParser(description="Plot error against render time.")
    parser.add_argument("csv", nargs="+")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--metric", choices=sorted(TITLES))
    parser.add_argument("--title", default="")
    options = parser.parse_args(arguments)
    try:
        import matplotlib
        matplotlib.use("Agg")
        import matplotlib.pyplot as plt
    except ImportError:
        return 3
    try:
        rows = read_rows(options.csv)
    except (OSError, ValueError, csv.Error) as error:
        print(f"lodestar_plot: {error}", file=sys.stderr)
        return 1
    metric = options.metric or ("relmse_trimmed" if any(row.get("relmse_trimmed") for row in rows) else "relmse_estimated")
    by_method = curves(rows, metric)
    if not by_method:
        print(f"lodestar_plot: no point of {metric} above zero in {', '.join(options.csv)}", file=sys.stderr)
        return 1
    draw(plt, by_method, metric, options.title, options.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
