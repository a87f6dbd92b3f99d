"""_core.pyi says what the module has: names by mypy's own test, arguments by docstrings, types by a program that mypy checks."""
import ast
import importlib.util
import tempfile
import unittest
from pathlib import Path

import lumisweep as ls
from support import run_python

PROGRAM = """
import numpy as np
import lumisweep as ls

volume = ls.Volume(np.zeros((4, 4, 4), np.uint8), spacing=(1.0, 1.0, 2.0))
session = ls.Session(volume, render_settings=ls.RenderSettings(strategy="two-step"))
image: ls.Image = session.render(samples=1, progress=lambda samples, seconds: print(samples))
reveal_type(image.radiance)
session.render_settings = ls.RenderSettings(strategy="two step")
"""


@unittest.skipUnless(importlib.util.find_spec("mypy"), "mypy is not installed")
class Mypy(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = Path(holder.name)

    def test_names(self):
        # pybind11's classes have a metaclass of its own, and those without a constructor an __init__ that refuses.
        bound = {name: value for name, value in vars(ls).items() if isinstance(value, type) and type(value) is not type}
        refusing = [name for name, value in bound.items() if "(self: " not in str(value.__init__.__doc__)]
        allowed = [*bound, *(fr"{name}\.__init__" for name in refusing)]
        (self.folder / "allowed").write_text("\n".join(fr"lumisweep\.(_core\.)?{name}" for name in allowed))
        process = run_python("-m", "mypy.stubtest", "--allowlist", "allowed", "lumisweep", cwd=self.folder)
        self.assertEqual(process.returncode, 0, process.stdout + process.stderr)

    def test_programs_are_checked(self):
        program = self.folder / "program.py"
        program.write_text(PROGRAM)
        process = run_python("-m", "mypy", "--strict", program, cwd=self.folder)
        *others, revealed, mistake, found = process.stdout.splitlines()
        self.assertEqual(others, [])
        self.assertIn("float", revealed)
        self.assertIn("two step", mistake)
        self.assertIn("Found 1 error", found)


def documented(docstring):
    """(name, whether it may be left out) of the arguments in pybind11's first line."""
    text = docstring.splitlines()[0].partition("(")[2].rpartition(") -> ")[0]
    parts, depth = [""], 0
    for character in text:
        depth += (character in "([{") - (character in ")]}")
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    names = [(part.partition(":")[0].strip(), " = " in part) for part in parts if part]
    return [("**" if name.startswith("**") else name, optional) for name, optional in names]


def declared(function):
    """Likewise, of a function in _core.pyi."""
    arguments = function.args
    optional = [False] * (len(arguments.args) - len(arguments.defaults)) + [True] * len(arguments.defaults)
    names = [(argument.arg, can) for argument, can in zip(arguments.args, optional)]
    if arguments.kwonlyargs:
        names += [("*", False), *((argument.arg, value is not None) for argument, value in
                                  zip(arguments.kwonlyargs, arguments.kw_defaults))]
    return names + [("**", False)] * (arguments.kwarg is not None)


class Arguments(unittest.TestCase):
    def test_declarations_and_docstrings_agree(self):
        module = ast.parse(Path(ls.__file__).with_name("_core.pyi").read_text())
        classes = [node for node in module.body if isinstance(node, ast.ClassDef)]
        count = 0
        for owner, place in [(ls, module), *((getattr(ls, node.name), node) for node in classes)]:
            for function in place.body:
                if not isinstance(function, ast.FunctionDef) or isinstance(getattr(owner, function.name), property):
                    continue
                if function.name.startswith("__") and function.name not in ("__init__", "__call__"):
                    continue  # operators' arguments have no names
                with self.subTest(f"{owner.__name__}.{function.name}"):
                    self.assertEqual(declared(function), documented(getattr(owner, function.name).__doc__))
                    count += 1
        self.assertGreater(count, 40)

    def test_everything_is_documented(self):
        self.assertTrue(ls.__doc__)
        self.assertRegex(ls.__version__, r"^\d+\.\d+")
        for name, value in vars(ls).items():
            if not name.startswith("_"):
                self.assertTrue(value.__doc__, name)


if __name__ == "__main__":
    unittest.main()
