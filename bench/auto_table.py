#!/usr/bin/python3
"""How close `auto` comes to the best method that could have been forced, scene by scene.

    bench/auto_table.py 20s scenes/*.pbrt SCENES/veach-ajar/veach-ajar.pbrt
    bench/auto_table.py 300s --seeds 3 --at-once 2 --methods sdtree --output out/auto-300 scenes/corridor.pbrt

Runs `lodestar compare` for each scene, seed and method, and prints a Markdown table: estimated trimmed relMSE of each
method (mean of the seeds), the best that was forced, auto's efficiency over its (1 / (error * seconds), geometric mean
of the seeds' ratios with its standard error; the goals are 0.85 at 20 s, 0.93 at 60 s and 0.97 at 300 s), and what auto
chose. A budget without a unit is samples per pixel: then efficiency leaves time out and the table means little beyond
the choice.

Methods take turns within a seed. A machine that grows slower from one run to the next by more than what is to be seen
asks for --at-once: so many methods run side by side, each on its part of the cores, and share what the machine does.

An error estimated from variances is too small where a method has not met the light at all. A picture that is darker than
another method's (mean of its PNG below nine tenths) is therefore marked * and measured against the best of the others;
not one of fewer than 64 samples a pixel, which clipping darkens by its noise alone.
"""
import argparse
import concurrent.futures
import json
import math
import os
import pathlib
import re
import statistics
import subprocess
import sys

import matplotlib.image

FORCED = ["path", "sdtree", "focal", "grid"]
ROOT = pathlib.Path(__file__).resolve().parent.parent


def run(arguments, scene, method, seed, folder):
    """One run as compare.json tells it, or None where the method was refused."""
    budget = ["--time" if arguments.budget.endswith(("s", "m")) else "--spp", arguments.budget]
    command = [arguments.lodestar, "compare", scene, "--methods", method, "--seed", str(seed), "--seeds", "1", "--filter", "box",
               "--quiet", "--output", str(folder)] + budget
    if arguments.resolution:
        command += ["--resolution", arguments.resolution]
    if arguments.at_once > 1:
        command += ["--threads", str(max(1, len(os.sched_getaffinity(0)) // arguments.at_once))]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        print(f"{scene}, {method}: {done.stderr.strip()}", file=sys.stderr)
        return None
    measured = json.loads((folder / "compare.json").read_text())["methods"][0]
    picture = folder / measured["runs"][0]["picture"]
    return {"error": measured["relmse_estimated"]["mean"], "seconds": measured["seconds"]["mean"],
            "spp": measured["spp"]["mean"], "brightness": float(matplotlib.image.imread(picture)[..., :3].mean()),
            "image": picture.with_suffix(".exr"), "missed": False,
            "choice": measured["runs"][0].get("choice", "").split(";")[0].split(":")[0]}


def measure_what_missed_light(lodestar, results):
    """Of one seed's runs."""
    found = [r for r in results.values() if r]
    brightest = max((r["brightness"] for r in found), default=0)
    for result in found:
        result["missed"] = result["brightness"] < 0.9 * brightest and result["spp"] >= 64
    best = min((r for r in found if not r["missed"]), key=lambda r: r["error"], default=None)
    for result in found:
        if result["missed"]:
            done = subprocess.run([lodestar, "diff", str(result["image"]), str(best["image"]), "--json"],
                                  capture_output=True, text=True, check=True)
            result["error"] = max(result["error"], json.loads(done.stdout)["relmse_trimmed"])


def measure(arguments, scene, methods):
    """Of each method its runs, one a seed; without those that were refused."""
    folder = pathlib.Path(arguments.output) / pathlib.Path(scene).stem
    runs = {m: [] for m in methods}
    with concurrent.futures.ThreadPoolExecutor(arguments.at_once) as pool:
        for seed in range(arguments.seeds):
            # By turns from either end: cores are not alike.
            order = methods[::-1] if seed % 2 else methods
            started = {m: pool.submit(run, arguments, scene, m, seed, folder / f"{m}-{seed}") for m in order}
            results = {m: r.result() for m, r in started.items()}
            measure_what_missed_light(arguments.lodestar, results)
            for method, result in results.items():
                runs[method].append(result)
    return {m: r for m, r in runs.items() if all(r)}


def row(name, runs, by_time, forced):
    def mean(method, what):
        return statistics.fmean(r[what] for r in runs[method])

    def costs(method):
        return [max(1e-30, r["error"] * (r["seconds"] if by_time else 1)) for r in runs[method]]

    def cell(method):
        if method not in runs:
            return "refused"
        return f"{mean(method, 'error'):.3g}{'*' if any(r['missed'] for r in runs[method]) else ''} ({mean(method, 'spp'):.0f})"

    best = min((m for m in forced if m in runs), key=lambda m: statistics.fmean(costs(m)))
    share, choice = "-", "-"
    if "auto" in runs:
        logs = [math.log(b / a) for a, b in zip(costs("auto"), costs(best))]
        share = f"{math.exp(statistics.fmean(logs)):.2f}"
        if len(logs) > 1:
            share += f" +- {100 * statistics.stdev(logs) / math.sqrt(len(logs)):.0f} %"
        choice = "; ".join(sorted({r["choice"] for r in runs["auto"]}))
    return [name] + [cell(m) for m in forced + ["auto"]] + [best, share, choice]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("budget", help="time (20s, 5m) or samples per pixel")
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--at-once", type=int, default=1, help="methods that run side by side [%(default)s]")
    parser.add_argument("--resolution", help="WxH [each scene's own]")
    parser.add_argument("--methods", default=",".join(FORCED), help="the forced ones [%(default)s]")
    parser.add_argument("--output", default="out/auto-table", help="folder for what compare writes")
    parser.add_argument("--lodestar", default=str(ROOT / "build/release/bin/lodestar"))
    arguments = parser.parse_args()
    # A piece NAME=VALUE is an option of the method before it, as in `lodestar compare --methods`.
    forced = re.split(r",(?![^,:]*=)", arguments.methods)
    print("| scene | " + " | ".join(forced + ["auto"]) + " | best forced | auto to best | auto chose |")
    print("| --- |" + " ---: |" * (len(forced) + 1) + " --- | ---: | --- |", flush=True)
    for scene in arguments.scenes:
        name = pathlib.Path(scene).stem
        runs = measure(arguments, scene, forced + ["auto"])
        if not any(m in runs for m in forced):
            print(f"| {name} | refused |", flush=True)
            continue
        print("| " + " | ".join(row(name, runs, arguments.budget.endswith(("s", "m")), forced)) + " |", flush=True)


if __name__ == "__main__":
    main()
