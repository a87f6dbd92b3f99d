"""Exit codes, one-line errors, clean standard output, and what is refused before any work."""
import json
import os
import unittest
from unittest import mock

from program import ProgramTest, run


class Usage(ProgramTest):
    def test_help_and_version(self):
        self.assertTrue(run("--version").stdout.startswith("lumisweep "))
        for arguments in (["--help"], ["render", "--help"], ["compare", "--help"], ["info", "--help"], ["sweep", "--help"]):
            process = run(*arguments)
            self.assertEqual(process.returncode, 0)
            self.assertIn("Usage:", process.stdout)
            self.assertEqual(process.stderr, "")
        options = run("render", "--help").stdout
        for option in ("--volume", "--transfer-function", "--environment", "--strategy", "--samples", "--time", "--noise", "--seed",
                       "--width", "--height", "--threads", "--device", "--set", "--stats", "--resume", "--checkpoint", "--isa"):
            self.assertIn(option, options)

    def test_wrong_usage_is_2(self):
        for arguments in ([], ["rendr"], ["render"], ["render", "scene.json", "--nonsense"], ["render", "scene.json", "--samples", "0"],
                          ["render", "scene.json", "--samples", "many"], ["render", "scene.json", "--strategy", "best"],
                          ["render", "scene.json", "--samples", "4", "--time", "2"], ["render", "scene.json", "--time", "-1"],
                          ["render", "scene.json", "--noise", "0.1", "--samples", "3"], ["render", "scene.json", "--noise", "nan"],
                          ["render", "scene.json", "--time", "inf"], ["render", "scene.json", "--width", "0"],
                          ["render", "scene.json", "--threads", "0"], ["render", "scene.json", "--seed", "-1"], ["render", "scene.json", "--device", "abacus"],
                          ["render", "scene.json", "-o", "out.jpg"], ["render", "scene.json", "--set", "samples"],
                          ["compare", "one.exr"], ["info"]):
            self.expect_failure(2, "lumisweep: ", *arguments)

    def test_unknown_command_is_named(self):
        self.expect_failure(2, "rendr: unknown command", "rendr", "scene.json")

    def test_refusals_are_1_and_come_first(self):
        before = set(os.listdir(self.folder))
        self.expect_failure(1, "missing.json: no such file", "render", "missing.json", "-o", "o.exr")
        self.expect_failure(1, "nowhere.nrrd: no such file", "render", "--volume", "nowhere.nrrd", "-o", "o.exr")
        self.expect_failure(1, "map.exr: no such file", "render", "scene.json", "--environment", "map.exr", "-o", "o.exr")
        self.expect_failure(1, "neither a file nor a preset", "render", "scene.json", "--transfer-function", "bone", "-o", "o.exr")
        self.expect_failure(1, "the folder no/such does not exist", "render", "scene.json", "-o", "no/such/o.exr")
        self.expect_failure(1, "no such checkpoint", "render", "scene.json", "-o", "o.exr", "--resume", "none.ckpt")
        with mock.patch.dict(os.environ, CUDA_VISIBLE_DEVICES=""):  # whatever the machine has
            self.expect_failure(1, "device cuda: ", "render", "scene.json", "-o", "o.exr", "--device", "cuda")
        self.expect_failure(1, "visibility.cel: unknown key", "render", "scene.json", "-o", "o.exr", "--set", "visibility.cel=8")
        self.expect_failure(1, "none.exr", "compare", "none.exr", "none.exr")
        self.expect_failure(1, "nothing.nii", "info", "nothing.nii")
        self.assertEqual(set(os.listdir(self.folder)), before)

    def test_results_alone_on_standard_output(self):
        self.assertEqual(self.expect_success("render", "scene.json", "-o", "a.exr").stdout, "")
        comparison = json.loads(self.expect_success("compare", "a.exr", "a.exr", "--json").stdout)
        self.assertEqual(comparison["mse"], 0.0)
        self.assertIsNone(comparison["psnr"])
        self.assertGreater(comparison["mean_image"], 0.0)
        self.assertIn("relmse", self.expect_success("compare", "a.exr", "a.exr").stdout)

    def test_info(self):
        volume = json.loads(self.expect_success("info", "ball.nrrd", "--json").stdout)
        self.assertEqual(volume["size"], [24, 24, 24])
        self.assertEqual(volume["spacing"], [2.0, 2.0, 3.0])
        self.assertEqual(volume["orientation"], "LPS")
        self.assertEqual(volume["min"], -200)
        self.assertEqual(sum(volume["histogram"]["counts"]), 24 ** 3)
        scene = json.loads(self.expect_success("info", "scene.json", "--json").stdout)
        self.assertEqual(scene["scene"]["render"]["samples"], 4)
        self.expect_success("render", "scene.json", "-o", "light.exr", "--samples", "2")
        light = json.loads(self.expect_success("info", "light.exr", "--json").stdout)
        self.assertEqual(light["size"], [40, 30])
        for name in ("ball.nrrd", "scene.json", "light.exr"):
            self.assertGreater(len(self.expect_success("info", name).stdout.splitlines()), 5)

    def test_sweep(self):
        found = json.loads(self.expect_success("sweep", "scene.json", "--json", "--check", "50").stdout)
        self.assertEqual(found["cells"], [6, 6, 6])
        self.assertEqual(found["directions"], 64)
        self.assertEqual(found["check"]["positions"], 50)
        self.assertLess(found["check"]["rms"], 0.2)  # filtered: meant to be near the average, not the exact
        for stage in ("load", "classify", "sweep", "product"):
            self.assertGreaterEqual(found["seconds"][stage], 0.0)
        for part in ("layouts", "march", "lookup", "filter"):
            self.assertGreater(found["processor_seconds"][part], 0.0)
        self.assertGreater(found["voxel_steps_per_second"], 0.0)
        self.assertEqual(found["rays_chosen"], "auto")
        self.assertGreater(found["memory_bytes"]["visibility"], 0)
        unfiltered = json.loads(self.expect_success("sweep", "scene.json", "--json", "--check", "50", "--set", "visibility.filter=none",
                                                    "--set", "visibility.rays=512").stdout)
        self.assertEqual(unfiltered["rays_chosen"], "given")
        self.assertLess(unfiltered["check"]["rms"], 0.02)
        self.assertIn("march", self.expect_success("sweep", "scene.json").stdout)


if __name__ == "__main__":
    unittest.main()
