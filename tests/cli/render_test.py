"""Rendering: strategies, stop criteria, overrides, headers and statistics, the same image for any number of threads."""
import json
import os
import signal
import subprocess
import time
import unittest

from program import PROGRAM, ProgramTest, SCENE, read_exr


class Render(ProgramTest):
    def pixels(self, *arguments):
        self.expect_success("render", "scene.json", "-o", "out.exr", *arguments)
        return read_exr(self.folder / "out.exr")[1]

    def compare(self, a, b):
        return json.loads(self.expect_success("compare", a, b, "--json").stdout)

    def test_every_strategy_has_the_same_mean(self):
        # A sun so wide that uniform directions find it, too.
        sky = "environment.sky.sun_angular_diameter_deg=90"
        for strategy in ("uniform", "environment", "visibility", "combined", "two-step", "auto"):
            self.expect_success("render", "scene.json", "-o", f"{strategy}.exr", "--strategy", strategy, "--samples", "64",
                                "--set", sky)
            self.assertEqual(read_exr(self.folder / f"{strategy}.exr")[0]["strategy"], strategy)
            difference = self.compare(f"{strategy}.exr", "uniform.exr")
            self.assertAlmostEqual(difference["mean_image"] / difference["mean_reference"], 1.0, delta=0.01)

    def test_threads_do_not_change_a_bit(self):
        one = self.pixels("--threads", "1")
        self.assertEqual(self.pixels("--threads", "2"), one)
        self.assertEqual(self.pixels("--threads", "7"), one)
        self.assertNotEqual(self.pixels("--seed", "1"), one)

    def test_outputs_and_header(self):
        self.expect_success("render", "scene.json", "-o", "a.exr", "-o", "b.PNG", "--samples", "3", "--seed", "9", "--width", "50",
                            "--height", "20", "--stats", "stats.json")
        self.assertEqual((self.folder / "b.PNG").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        header, _ = read_exr(self.folder / "a.exr")
        self.assertEqual(header["samplesPerPixel"], 3)
        self.assertEqual(header["seed"], 9)
        self.assertGreater(header["renderSeconds"], 0)
        self.assertEqual(header["scene"], (self.folder / "scene.json").read_text())
        self.assertEqual(json.loads(header["sceneInFull"])["image"]["width"], 50)
        self.assertEqual(len(header["worldToCamera"]), 16)
        self.assertEqual(header["worldToCamera"][3::4], (0.0, 0.0, 0.0, 1.0))  # row vectors: translation in the last row
        self.assertIn("lumisweep", header["programVersion"])
        for layer in (b"A\0", b"Variance.R\0", b"albedo.G\0", b"normal.Z\0", b"depth.Z\0"):
            self.assertIn(layer, header["channels"])
        stats = json.loads((self.folder / "stats.json").read_text())
        self.assertEqual(stats["paths"], 50 * 20 * 3)
        self.assertEqual(stats["samples_per_pixel"], 3)
        self.assertEqual(stats["device"], "cpu")
        for key in ("load", "classify", "majorants", "sweep", "joint", "render"):
            self.assertGreaterEqual(stats["seconds"][key], 0.0)
        for key in ("volume", "visibility", "environment", "peak_rss"):
            self.assertGreater(stats["memory_bytes"][key], 0)
        self.assertEqual(stats["strategy"], "auto")
        self.assertEqual(stats["random_numbers"], "stratified")
        self.assertEqual(stats["shadow_rays"]["per_camera_ray"], 3)
        self.assertGreater(stats["shadow_rays"]["traced"], 0)
        self.assertLessEqual(stats["shadow_rays"]["traced"], 3 * stats["paths"])
        self.assertGreater(stats["steps"]["camera"], 0)
        self.assertGreater(stats["noise"], 0.0)

    def test_random_numbers_and_shadow_rays(self):
        def stats(*arguments):
            self.expect_success("render", "scene.json", "-o", "out.exr", "--stats", "stats.json", *arguments)
            return json.loads((self.folder / "stats.json").read_text())

        papers = stats("--strategy", "two-step")
        self.assertEqual((papers["random_numbers"], papers["shadow_rays"]["per_camera_ray"]), ("independent", 1))
        self.assertLessEqual(papers["shadow_rays"]["traced"], papers["paths"])
        ours = stats("--strategy", "two-step", "--set", "render.random_numbers=stratified", "--set", "render.shadow_rays=3")
        self.assertEqual((ours["random_numbers"], ours["shadow_rays"]["per_camera_ray"]), ("stratified", 3))
        # Automatic is two-step's density with these settings.
        pixels = read_exr(self.folder / "out.exr")[1]
        self.assertEqual(self.pixels(), pixels)
        self.assertNotEqual(self.pixels("--set", "render.shadow_rays=5"), pixels)
        self.assertNotEqual(self.pixels("--set", "render.random_numbers=independent"), pixels)
        self.expect_failure(1, "render.shadow_rays: 65 is out of range (give a whole number from 1 to 64)", "render", "scene.json", "-o",
                            "out.exr", "--set", "render.shadow_rays=65")

    def test_volume_alone(self):
        process = self.expect_success("render", "--volume", "ball.nrrd", "--samples", "1", "--width", "16", "--height", "16")
        self.assertIn("no preset named: took ", process.stderr)
        self.assertIn("ball-render.exr", process.stderr)
        self.assertTrue((self.folder / "ball-render.exr").exists())
        self.assertEqual(process.stdout, "")

    def test_transfer_function_from_file_and_preset(self):
        (self.folder / "tf.json").write_text('{"points": [{"value": 0, "extinction": 1}] // all of it\n}')
        plain = self.pixels()
        self.assertNotEqual(self.pixels("--transfer-function", "tf.json"), plain)
        self.assertEqual(self.pixels("--preset", "ct-bone"), self.pixels("--set", "transfer_function.preset=ct-bone"))

    def test_set(self):
        self.assertEqual(self.pixels("--set", "render.seed=5"), self.pixels("--seed", "5"))
        self.write_scene({**SCENE, "image": {"width": 12, "height": 10}}, "small.json")
        self.expect_success("render", "small.json", "-o", "small.exr")
        self.assertEqual(self.pixels("--set", "image.width=12", "--set", 'image={"width": 12, "height": 10}'),
                         read_exr(self.folder / "small.exr")[1])

    def test_paths_are_relative_to_the_scene(self):
        (self.folder / "below").mkdir()
        self.write_scene({**SCENE, "volume": {"file": "../ball.nrrd"}}, "below/scene.json")
        self.expect_success("render", "below/scene.json", "-o", "b.exr")
        self.assertEqual(read_exr(self.folder / "b.exr")[1], self.pixels())

    def test_time(self):
        self.expect_success("render", "scene.json", "-o", "t.exr", "--time", "1.5", "--stats", "s.json")
        stats = json.loads((self.folder / "s.json").read_text())
        self.assertGreater(stats["samples_per_pixel"], 1)
        self.assertGreater(stats["seconds"]["render"], 1.0)
        self.assertLess(stats["seconds"]["render"], 2.5)

    def test_noise(self):
        self.expect_success("render", "scene.json", "-o", "n.exr", "--noise", "0.03", "--stats", "s.json")
        stats = json.loads((self.folder / "s.json").read_text())
        self.assertGreaterEqual(stats["samples_per_pixel"], 16)
        self.assertLessEqual(stats["noise"], 0.03)

    def test_noise_of_a_black_image_ends(self):
        process = self.expect_success("render", "scene.json", "-o", "n.exr", "--noise", "0.01", "--set", "environment.radiance=[0,0,0]")
        self.assertIn("black", process.stderr)

    def test_interrupt_still_writes(self):
        for interruption in (signal.SIGINT, signal.SIGTERM):
            process = subprocess.Popen([PROGRAM, "render", "scene.json", "-o", "i.exr", "--samples", "100000000"], cwd=self.folder,
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            self.addCleanup(process.kill)
            for line in process.stderr:
                if "rendering on" in line:
                    break
            time.sleep(1.0)
            process.send_signal(interruption)
            _, errors = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 0, errors)
            self.assertIn("interrupted", errors)
            self.assertGreater(read_exr(self.folder / "i.exr")[0]["samplesPerPixel"], 0)
            os.remove(self.folder / "i.exr")


if __name__ == "__main__":
    unittest.main()
