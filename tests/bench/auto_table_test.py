#!/usr/bin/python3
"""What bench/auto_table.py makes of runs: cells, the best that was forced, auto's efficiency, pictures without light."""
import argparse
import importlib.util
import json
import pathlib
import sys
import types
import unittest
import unittest.mock

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench"))
HAS_MATPLOTLIB = importlib.util.find_spec("matplotlib") is not None
if HAS_MATPLOTLIB:
    import auto_table


def made_up(error, seconds=20.0, spp=100.0, brightness=1.0, image="a.exr", missed=False, choice=""):
    return {"error": error, "seconds": seconds, "spp": spp, "brightness": brightness, "image": pathlib.Path(image),
            "missed": missed, "choice": choice}


@unittest.skipUnless(HAS_MATPLOTLIB, "matplotlib is missing")
class Row(unittest.TestCase):
    def test_cells_and_efficiency(self):
        runs = {"path": [made_up(4, spp=250)], "sdtree": [made_up(1, missed=True)],
                "auto": [made_up(1.25, choice="sdtree")]}
        self.assertEqual(auto_table.row("room", runs, True, ["path", "sdtree", "focal"]),
                         ["room", "4 (250)", "1* (100)", "refused", "1.25 (100)", "sdtree", "0.80", "sdtree"])

    def test_time_counts_where_the_budget_is_time(self):
        runs = {"path": [made_up(1, seconds=10)], "sdtree": [made_up(0.8)], "auto": [made_up(0.5)]}
        self.assertEqual(auto_table.row("room", runs, True, ["path", "sdtree"])[-3:-1], ["path", "1.00"])
        self.assertEqual(auto_table.row("room", runs, False, ["path", "sdtree"])[-3:-1], ["sdtree", "1.60"])

    def test_seeds_have_a_geometric_mean_and_its_error(self):
        runs = {"path": [made_up(1), made_up(4)], "auto": [made_up(1, choice="sdtree"), made_up(1, choice="path")]}
        # Ratios of 1 and 4: their logarithms' mean is ln 2, and its standard error ln 4 / 2.
        self.assertEqual(auto_table.row("room", runs, True, ["path"]),
                         ["room", "2.5 (100)", "1 (100)", "path", "2.00 +- 69 %", "path; sdtree"])

    def test_without_auto(self):
        self.assertEqual(auto_table.row("room", {"path": [made_up(1)]}, True, ["path"])[-3:], ["path", "-", "-"])


@unittest.skipUnless(HAS_MATPLOTLIB, "matplotlib is missing")
class MissedLight(unittest.TestCase):
    def mark(self, results, against_best=0.0):
        """Marks them; the pictures that were compared."""
        said = types.SimpleNamespace(stdout=json.dumps({"relmse_trimmed": against_best}))
        with unittest.mock.patch.object(auto_table.subprocess, "run", return_value=said) as run:
            auto_table.measure_what_missed_light("lodestar", results)
        return [call.args[0][1:4] for call in run.call_args_list]

    def test_a_dark_picture_is_measured_against_the_best_of_the_others(self):
        results = {"path": made_up(0.1, brightness=0.85, image="path.exr"), "sdtree": made_up(0.5, image="sdtree.exr"),
                   "focal": made_up(0.3, brightness=0.95, image="focal.exr"), "grid": None}
        self.assertEqual(self.mark(results, against_best=0.7), [["diff", "path.exr", "focal.exr"]])
        self.assertEqual([r["missed"] for r in results.values() if r], [True, False, False])
        self.assertEqual([r["error"] for r in results.values() if r], [0.7, 0.5, 0.3])

    def test_an_error_never_falls(self):
        results = {"path": made_up(0.9, brightness=0.5), "sdtree": made_up(0.5)}
        self.mark(results, against_best=0.7)
        self.assertEqual(results["path"]["error"], 0.9)

    def test_few_samples_are_dark_by_their_noise(self):
        for spp, missed in ((63, False), (64, True)):
            results = {"path": made_up(0.1, spp=spp, brightness=0.5), "sdtree": made_up(0.5)}
            self.mark(results)
            self.assertEqual(results["path"]["missed"], missed)

    def test_nobody_rendered(self):
        self.assertEqual(self.mark({"path": None, "sdtree": None}), [])


@unittest.skipUnless(HAS_MATPLOTLIB, "matplotlib is missing")
class Measure(unittest.TestCase):
    def test_who_was_refused_is_left_out(self):
        arguments = argparse.Namespace(output="out", at_once=1, seeds=2, lodestar="lodestar")

        def run(arguments, scene, method, seed, folder):
            return None if method == "grid" and seed == 1 else made_up(1 + seed)

        with unittest.mock.patch.object(auto_table, "run", run):
            runs = auto_table.measure(arguments, "room.pbrt", ["path", "grid", "auto"])
        self.assertEqual({m: [r["error"] for r in of_method] for m, of_method in runs.items()},
                         {"path": [1, 2], "auto": [1, 2]})


if __name__ == "__main__":
    unittest.main()
