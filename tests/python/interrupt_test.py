"""Ctrl-C, other Python threads during a render, and what a progress callback may do."""
import math
import signal
import subprocess
import sys
import textwrap
import threading
import time
import unittest
from pathlib import Path

import numpy as np

import lumisweep as ls
from support import ball_session

FOLDER = str(Path(__file__).resolve().parent)

# The child says when its long call begins and, after Ctrl-C, what is left; it never ends by itself.
CHILD = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.path.insert(0, {folder!r})
import numpy as np
import lumisweep as ls
from support import ball_session
session = ball_session(64, 64, threads=1)
{before}
print("begun", flush=True)
try:
    {call}
except KeyboardInterrupt:
    print("interrupted", flush=True)
{after}
print(session.samples, session.samples == 0 or np.isfinite(session.image().radiance).all(), flush=True)
"""


class CtrlC(unittest.TestCase):
    def interrupt(self, call, before="", after=""):
        """Interrupts the call after a second; the last line that the child prints, and the seconds that it took to stop."""
        code = textwrap.dedent(CHILD).format(folder=FOLDER, before=before, call=call, after=after)
        child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(child.kill)
        self.assertEqual(child.stdout.readline(), "begun\n")
        time.sleep(1.0)
        child.send_signal(signal.SIGINT)
        start = time.perf_counter()
        line = child.stdout.readline()
        seconds = time.perf_counter() - start
        # Not communicate(): what readline() has read ahead, it does not know of.
        out, errors = child.stdout.read(), child.stderr.read()
        self.assertEqual(child.wait(timeout=60), 0, errors)
        self.assertEqual(line, "interrupted\n", errors)
        self.assertLess(seconds, 3.0)  # two would do; other work on the machine only adds
        return out.split()

    def test_render_keeps_its_passes(self):
        samples, finite = self.interrupt("session.render(samples=10**9)")
        self.assertGreater(int(samples), 0)
        self.assertEqual(finite, "True")

    def test_a_long_pass_is_given_up(self):
        before = "session.image_settings = ls.ImageSettings(width=3000, height=3000)"  # seconds a pass
        self.interrupt("session.render(samples=10**9)", before)

    def test_the_session_goes_on(self):
        after = ("samples = session.samples; again = session.render(samples=samples + 1)\n"
                 "fresh = ball_session(64, 64).render(samples=samples + 1)\n"
                 "assert np.array_equal(again.radiance, fresh.radiance)")
        self.interrupt("session.render(samples=10**9)", after=after)

    def test_prepare(self):
        before = ("session.volume = ls.Volume(np.random.default_rng(1).integers(0, 500, (256, 256, 256)).astype(np.int16))\n"
                  "session.visibility_settings = ls.VisibilitySettings(directions=32, oversampling=16)")
        self.interrupt("session.prepare()", before)


class OtherThreads(unittest.TestCase):
    def test_they_run_while_a_render_does(self):
        ticks, stop = [], threading.Event()

        def tick():
            while not stop.wait(0.005):
                ticks.append(time.perf_counter())

        other = threading.Thread(target=tick)
        session = ball_session(threads=1)
        other.start()
        try:
            start = time.perf_counter()
            session.render(time=1.0)
            end = time.perf_counter()
        finally:
            stop.set()
            other.join()
        self.assertGreater(sum(start < moment < end for moment in ticks), 40)

    def test_two_sessions_in_two_threads(self):
        images = {}

        def render(name):
            images[name] = ball_session(threads=1).render(samples=8).radiance

        threads = [threading.Thread(target=render, args=(name,)) for name in "ab"]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        np.testing.assert_array_equal(images["a"], images["b"])


class Ending(unittest.TestCase):
    """The program ends while a daemon thread renders, or in the middle of what runs at its end."""

    def run_child(self, code):
        child = subprocess.run([sys.executable, "-c", f"import sys; sys.path.insert(0, {FOLDER!r})\n" + textwrap.dedent(code)],
                               capture_output=True, text=True, timeout=60)
        self.assertEqual((child.returncode, child.stderr), (0, ""))
        return child.stdout

    def test_beside_a_daemon_thread(self):
        for call in ("session.render(samples=10**9)", "session.render(samples=10**9, progress=lambda samples, seconds: None)"):
            self.run_child(f"""
                import threading, time
                from support import ball_session
                session = ball_session(threads=1)
                threading.Thread(target=lambda: {call}, daemon=True).start()
                time.sleep(0.5)""")

    def test_rendering_at_exit(self):
        out = self.run_child("""
            import atexit
            atexit.register(lambda: print(ball_session().render(samples=2).width))
            from support import ball_session""")
        self.assertEqual(out, "40\n")


class Progress(unittest.TestCase):
    def test_what_it_is_told(self):
        calls = []
        session = ball_session()
        session.render(time=1.0, progress=lambda samples, seconds: calls.append((samples, seconds)))
        self.assertGreater(len(calls), 1)
        self.assertLessEqual(len(calls), math.ceil(calls[-1][1] * 10) + 1)
        self.assertEqual(calls, sorted(calls))
        self.assertIsInstance(calls[0][0], int)
        self.assertLessEqual(calls[-1][0], session.samples)

    def test_its_exceptions_reach_the_caller(self):
        class Enough(Exception):
            pass

        def stop(samples, seconds):
            raise Enough(samples)

        session = ball_session()
        with self.assertRaises(Enough) as caught:
            session.render(samples=10**9, progress=stop)
        self.assertEqual(caught.exception.args, (session.samples,))
        samples = session.samples
        session.render(samples=samples + 2)
        self.assertEqual(session.samples, samples + 2)

    def test_it_may_look_at_the_film(self):
        session, seen = ball_session(), []

        def look(samples, seconds):
            seen.append((samples, session.image().attributes["samplesPerPixel"]))

        session.render(samples=64, progress=look)
        self.assertTrue(seen)
        self.assertTrue(all(told == found for told, found in seen), seen)


    def test_it_may_not_change_the_session(self):
        session = ball_session()

        def change(samples, seconds):
            session.image_settings = ls.ImageSettings(width=8, height=8)

        with self.assertRaisesRegex(ls.Error, "busy"):
            session.render(samples=64, progress=change)
        self.assertEqual(session.render(samples=64).width, 40)


class BusySessions(unittest.TestCase):
    """While a render runs without the interpreter, signal handlers and other threads find the session busy."""

    def test_in_a_signal_handler(self):
        session, refused = ball_session(threads=1), []

        def handler(number, frame):
            for attempt in (session.image, session.prepare, lambda: session.samples,
                            lambda: setattr(session, "image_settings", ls.ImageSettings(width=8, height=8))):
                try:
                    attempt()
                except ls.Error as error:
                    refused.append(str(error))

        before = signal.signal(signal.SIGALRM, handler)
        self.addCleanup(signal.signal, signal.SIGALRM, before)
        signal.setitimer(signal.ITIMER_REAL, 0.3)
        session.render(time=0.8)
        self.assertEqual(len(refused), 4, refused)
        self.assertTrue(all("busy" in text for text in refused))
        self.assertEqual(session.image().width, 40)

    def test_in_another_thread(self):
        session, errors = ball_session(threads=1), []

        def meddle():
            time.sleep(0.2)
            try:
                session.render(samples=10**9)
            except ls.Error as error:
                errors.append(str(error))

        thread = threading.Thread(target=meddle)
        thread.start()
        session.render(time=0.8)
        thread.join()
        self.assertEqual(len(errors), 1)
        self.assertIn("busy", errors[0])


if __name__ == "__main__":
    unittest.main()
