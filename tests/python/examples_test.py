"""The gallery: every example runs, small, and leaves its picture; without its data it says in one line what to fetch."""
import importlib.util
import os
import re
import shutil
import tempfile
import unittest
from pathlib import Path

import numpy as np

import lumisweep as ls
from support import ROOT, run_python

EXAMPLES = ROOT / "examples"


def run(script, *arguments):
    return run_python(script, *arguments, env={**os.environ, "MPLBACKEND": "Agg"})


class Gallery(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = Path(holder.name)

    def picture(self, name):
        """What the example prints; its picture is a PNG of more than one colour."""
        text = (EXAMPLES / f"{name}.py").read_text()
        for file in re.findall(r'data\("([^"]+)"\)', text):
            if not (ROOT / "data" / file).is_file():
                self.skipTest(f"no data/{file}")
        if "matplotlib" in text and importlib.util.find_spec("matplotlib") is None:
            self.skipTest("matplotlib is not installed")
        output = self.folder / f"{name}.png"
        process = run(EXAMPLES / f"{name}.py", "--small", "--output", output)
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertEqual(process.stderr, "")
        content = output.read_bytes()
        self.assertEqual(content[:8], b"\x89PNG\r\n\x1a\n")
        self.assertGreater(len(content), 2000)
        return process.stdout

    def test_ct_head(self):
        self.assertIn("relative error", self.picture("ct_head"))
        self.assertEqual(ls.read_exr(self.folder / "ct_head.exr").width, 48)

    def test_stent(self):
        printed = self.picture("stent")
        self.assertIn("reads the array itself: True", printed)
        # A new light does not sweep, changed voxels do.
        swept = [float(seconds) for seconds in re.findall(r"swept for ([\d.]+) s", printed)]
        self.assertEqual(len(swept), 3)
        self.assertEqual(swept[1], 0.0)

    def test_mr(self):
        self.assertIn("shared with NumPy: True", self.picture("mr"))

    def test_smoke(self):
        self.assertIn("first sample after", self.picture("smoke"))

    def test_inspect_pdf(self):
        found = re.findall(r": ([\d.]+) ± ([\d.]+)", self.picture("inspect_pdf"))
        means = [(float(mean), float(error)) for mean, error in found]
        self.assertEqual(len(means), 5)
        for mean, error in means:
            self.assertLess(abs(mean - means[-1][0]), 5 * np.hypot(error, means[-1][1]) + 0.02)


class Strategies(unittest.TestCase):
    def test_compare_strategies(self):
        for file in ("ct_head.nrrd", "stent.nrrd", "environments/sunrise.exr"):
            if not (ROOT / "data" / file).is_file():
                self.skipTest(f"no data/{file}")
        process = run(EXAMPLES / "compare_strategies.py", "--small")
        self.assertEqual(process.returncode, 0, process.stderr)
        gains = dict(re.findall(r"^(\S+, \S+) +([\d.e-]+)×", process.stdout, re.MULTILINE))
        self.assertEqual(len(gains), 12, process.stdout)
        self.assertEqual(float(gains["stent, environment"]), 1.0)
        self.assertGreater(float(gains["ct_head, auto"]), 1.0)


class WithoutData(unittest.TestCase):
    def test_one_line_says_what_to_fetch(self):
        with tempfile.TemporaryDirectory() as folder:
            shutil.copytree(EXAMPLES, Path(folder) / "examples")
            for name, fetch in (("ct_head", "ct_head"), ("stent", "stent"), ("mr", "ch2better"), ("inspect_pdf", "ct_head")):
                with self.subTest(name):
                    process = run(Path(folder) / "examples" / f"{name}.py", "--small")
                    self.assertEqual(process.returncode, 1)
                    self.assertEqual(len(process.stderr.splitlines()), 1, process.stderr)
                    self.assertIn(f"scripts/fetch_data {fetch}", process.stderr)


if __name__ == "__main__":
    unittest.main()
