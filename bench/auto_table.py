#!/usr/bin/python3
"""How close `auto` comes to the best method that could have been forced, scene by scene.

    bench/auto_table.py 20s scenes/*.pbrt ../shared/scenes/*/*.pbrt
    bench/auto_table.py 60s --seeds 3 --output out/auto-60 scenes/corridor.pbrt

Runs `lodestar compare` for each scene and method, and prints a Markdown table: estimated trimmed relMSE of each method,
the best that was forced, auto's efficiency over its (1 / (error * seconds); the goals are 0.85 at 20 s, 0.93 at 60 s
and 0.97 at 300 s), and what auto chose. A budget without a unit is samples per pixel: then efficiency leaves time out
and the table means little beyond the choice.

An error estimated from variances is too small where a method has not met the light at all. A picture that is darker than
another method's (mean of its PNG below nine tenths) is therefore marked * and measured against the best of the others.
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys

import matplotlib.image

FORCED = ["path", "sdtree", "focal", "grid"]
ROOT = pathlib.Path(__file__).resolve().parent.parent


def run(arguments, scene, method, folder):
    """The method's part of compare.json, or None where it was refused."""
    budget = ["--time" if arguments.budget.endswith(("s", "m")) else "--spp", arguments.budget]
    command = [arguments.lodestar, "compare", scene, "--methods", method, "--seeds", str(arguments.seeds), "--filter", "box",
               "--quiet", "--output", str(folder)] + budget
    if arguments.resolution:
        command += ["--resolution", arguments.resolution]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        print(f"{scene}, {method}: {done.stderr.strip()}", file=sys.stderr)
        return None
    measured = json.loads((folder / "compare.json").read_text())["methods"][0]
    picture = folder / measured["runs"][0]["picture"]
    return {"error": measured["relmse_estimated"]["mean"], "seconds": measured["seconds"]["mean"],
            "spp": measured["spp"]["mean"], "brightness": float(matplotlib.image.imread(picture)[..., :3].mean()),
            "image": picture.with_suffix(".exr"), "missed": False,
            "choice": "; ".join(sorted({r.get("choice", "").split(";")[0].split(":")[0] for r in measured["runs"]}))}


def measure_what_missed_light(lodestar, results):
    found = {m: r for m, r in results.items() if r}
    brightest = max(r["brightness"] for r in found.values())
    for result in found.values():
        result["missed"] = result["brightness"] < 0.9 * brightest
    best = min((r for r in found.values() if not r["missed"]), key=lambda r: r["error"])
    for result in found.values():
        if result["missed"]:
            done = subprocess.run([lodestar, "diff", str(result["image"]), str(best["image"]), "--json"],
                                  capture_output=True, text=True, check=True)
            result["error"] = max(result["error"], json.loads(done.stdout)["relmse_trimmed"])


def row(name, results, by_time, methods):
    def efficiency(result):
        return 1 / max(1e-30, result["error"] * (result["seconds"] if by_time else 1))

    def cell(result):
        if not result:
            return "refused"
        return f"{result['error']:.3g}{'*' if result['missed'] else ''} ({result['spp']:.0f})"

    forced = {m: results[m] for m in methods if results.get(m)}
    best = max(forced, key=lambda m: efficiency(forced[m]))
    auto = results["auto"]
    share = f"{efficiency(auto) / efficiency(forced[best]):.2f}" if auto else "-"
    return [name] + [cell(results.get(m)) for m in methods + ["auto"]] + [best, share, auto["choice"] if auto else "-"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("budget", help="time (20s, 5m) or samples per pixel")
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--seeds", type=int, default=1)
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
        results = {m: run(arguments, scene, m, pathlib.Path(arguments.output) / name / m) for m in forced + ["auto"]}
        if not any(results.get(m) for m in forced):
            print(f"| {name} | refused |", flush=True)
            continue
        measure_what_missed_light(arguments.lodestar, results)
        print("| " + " | ".join(row(name, results, arguments.budget.endswith(("s", "m")), forced)) + " |", flush=True)


if __name__ == "__main__":
    main()
