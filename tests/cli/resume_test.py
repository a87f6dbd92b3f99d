"""kill -9 at any moment, then --resume: equal to the uninterrupted image to the bit."""
import random
import subprocess
import time
import unittest

from program import PROGRAM, ProgramTest, read_exr, run

SAMPLES = "200"
SIZE = ("--width", "160", "--height", "120", "--samples", SAMPLES)


class Resume(ProgramTest):
    def start(self, *arguments):
        process = subprocess.Popen([PROGRAM, "render", "scene.json", *SIZE, *arguments], cwd=self.folder, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def test_killed_and_resumed_equals_uninterrupted(self):
        self.expect_success("render", "scene.json", *SIZE, "-o", "whole.exr")
        whole = read_exr(self.folder / "whole.exr")[1]
        checkpoint = self.folder / "c.ckpt"
        chance = random.Random(1)
        resume = []
        kills = 0
        for _ in range(4):
            process = self.start("-o", "killed.exr", "--checkpoint", "c.ckpt", *resume)
            seen = checkpoint.stat().st_mtime_ns if checkpoint.exists() else None
            while process.poll() is None and (not checkpoint.exists() or checkpoint.stat().st_mtime_ns == seen):
                time.sleep(0.002)
            time.sleep(chance.uniform(0.0, 0.15))
            if process.poll() is None:
                kills += 1
            process.kill()
            process.wait()
            resume = ["--resume", "c.ckpt"]
        self.assertGreater(kills, 0, "too fast to be killed")
        process = self.expect_success("render", "scene.json", *SIZE, "-o", "resumed.exr", "--resume", "c.ckpt")
        self.assertIn("resuming from", process.stderr)
        header, resumed = read_exr(self.folder / "resumed.exr")
        self.assertEqual(header["samplesPerPixel"], int(SAMPLES))
        self.assertEqual(resumed, whole)

    def test_more_samples_later(self):
        small = ("--width", "20", "--height", "20", "-o", "o.exr")
        self.expect_success("render", "scene.json", *small, "--samples", "12")
        at_once = read_exr(self.folder / "o.exr")[1]
        self.expect_success("render", "scene.json", *small, "--samples", "5", "--checkpoint", "c.ckpt")
        self.expect_success("render", "scene.json", *small, "--samples", "12", "--resume", "c.ckpt", "--checkpoint", "c.ckpt")
        self.assertEqual(read_exr(self.folder / "o.exr")[1], at_once)
        process = self.expect_success("render", "scene.json", *small, "--samples", "3", "--resume", "c.ckpt")
        self.assertIn("has 12 samples a pixel already", process.stderr)

    def test_a_checkpoint_that_cannot_be_written_costs_no_image(self):
        (self.folder / "c.ckpt.partial").mkdir()  # where it is written first
        process = run("render", "scene.json", "--width", "20", "--height", "20", "--samples", "3", "-q", "-o", "kept.exr",
                      "--checkpoint", "c.ckpt", cwd=self.folder)
        self.assertEqual(process.returncode, 1)
        self.assertIn("cannot write the checkpoint", process.stderr.splitlines()[-1])
        self.assertEqual(read_exr(self.folder / "kept.exr")[0]["samplesPerPixel"], 3)

    def test_refuses_what_does_not_belong(self):
        small = ("--width", "20", "--height", "20", "--samples", "2", "-o", "o.exr", "-q")
        self.expect_success("render", "scene.json", *small, "--checkpoint", "c.ckpt")
        self.expect_failure(1, "another seed (0, not 4)", "render", "scene.json", *small, "--seed", "4", "--resume", "c.ckpt")
        self.expect_failure(1, "another shadow_rays (3, not 5)", "render", "scene.json", *small, "--set", "render.shadow_rays=5", "--resume",
                            "c.ckpt")
        self.expect_failure(1, "another random_numbers (stratified, not independent)", "render", "scene.json", *small, "--set",
                            "render.random_numbers=independent", "--resume", "c.ckpt")
        self.expect_failure(1, "another camera", "render", "scene.json", *small, "--set", "camera.vertical_fov_deg=20", "--resume", "c.ckpt")
        self.expect_failure(1, "another environment", "render", "scene.json", *small, "--set", "environment.scale=2", "--resume", "c.ckpt")
        whole = (self.folder / "c.ckpt").read_bytes()
        (self.folder / "short.ckpt").write_bytes(whole[:-100])
        self.expect_failure(1, "cut short", "render", "scene.json", *small, "--resume", "short.ckpt")
        (self.folder / "bad.ckpt").write_bytes(whole[:-100] + b"\x55" + whole[-99:])
        self.expect_failure(1, "checksum", "render", "scene.json", *small, "--resume", "bad.ckpt")
        self.expect_failure(1, "not a checkpoint", "render", "scene.json", *small, "--resume", "ball.nrrd")


if __name__ == "__main__":
    unittest.main()
