"""What the end-to-end tests share: running the program, small volumes and scenes, and reading EXR headers.

Standard library only. Each test file is run with the program's path as its argument.
"""
import json
import math
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

PROGRAM = str(Path(sys.argv.pop(1)).resolve()) if len(sys.argv) > 1 else "lumisweep"


def run(*arguments, cwd=None, **options):
    """The finished process, with text output; never from a terminal."""
    return subprocess.run([PROGRAM, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, timeout=120,
                          stdin=subprocess.DEVNULL, **options)


def write_volume(path, size=24):
    """A soft ball with a hole, as 16-bit NRRD in Hounsfield-like units."""
    voxels = []
    middle = (size - 1) / 2
    for k in range(size):
        for j in range(size):
            for i in range(size):
                r = math.dist((i, j, k), (middle, middle, middle)) / (size / 2)
                voxels.append(int(1000 * max(0.0, 1.0 - r) if r > 0.3 else -200))
    header = (f"NRRD0004\ntype: int16\ndimension: 3\nspace: left-posterior-superior\nsizes: {size} {size} {size}\n"
              "space directions: (2,0,0) (0,2,0) (0,0,3)\nspace origin: (-20,-20,-30)\nendian: little\nencoding: raw\n\n")
    Path(path).write_bytes(header.encode() + struct.pack(f"<{len(voxels)}h", *voxels))


SCENE = {
    "version": 1,
    "volume": {"file": "ball.nrrd"},
    "transfer_function": {"points": [{"value": 100, "extinction": 0.0, "albedo": [0.9, 0.7, 0.6]},
                                     {"value": 400, "extinction": 0.4, "albedo": [0.95, 0.9, 0.85]}]},
    "image": {"width": 40, "height": 30},
    "render": {"samples": 4},
}


def read_exr(path):
    """(attributes, bytes of the pixel chunks). The offset table between them depends on the header's length and is left out."""
    data = Path(path).read_bytes()
    assert data[:4] == b"\x76\x2f\x31\x01", "not an EXR file"
    at, attributes = 8, {}
    while data[at]:
        name_end = data.index(b"\0", at)
        type_end = data.index(b"\0", name_end + 1)
        size, = struct.unpack_from("<i", data, type_end + 1)
        kind, value = data[name_end + 1:type_end].decode(), data[type_end + 5:type_end + 5 + size]
        numbers = {"float": "<f", "double": "<d", "int": "<i", "m44f": "<16f", "m44d": "<16d"}
        if kind == "string":
            value = value.decode()
        elif kind in numbers:
            value = struct.unpack(numbers[kind], value)
            value = value[0] if len(value) == 1 else value
        attributes[data[at:name_end].decode()] = value
        at = type_end + 5 + size
    first_chunk, = struct.unpack_from("<Q", data, at + 1)
    return attributes, data[first_chunk:]


class ProgramTest(unittest.TestCase):
    """Gives each test a folder with ball.nrrd and scene.json."""

    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = Path(holder.name)
        write_volume(self.folder / "ball.nrrd")
        self.write_scene(SCENE)

    def write_scene(self, scene, name="scene.json"):
        (self.folder / name).write_text(scene if isinstance(scene, str) else json.dumps(scene))

    def expect_failure(self, code, text, *arguments):
        process = run(*arguments, cwd=self.folder)
        self.assertEqual(process.returncode, code, process.stderr)
        self.assertIn(text, process.stderr)
        self.assertEqual(process.stdout, "")
        self.assertEqual(len(process.stderr.splitlines()), 1, process.stderr)
        return process

    def expect_success(self, *arguments):
        process = run(*arguments, cwd=self.folder)
        self.assertEqual(process.returncode, 0, process.stderr)
        return process
