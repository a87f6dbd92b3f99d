"""A corpus of hostile scenes: exit code 1 and one line that names the file, for each."""
import unittest

from program import ProgramTest

CORPUS = {
    "empty": (b"", "line 1, column 1"),
    "truncated": (b'{"version": 1, "volume": {"file": "ba', "line 1"),
    "trailing": (b'{"version": 1} }', "line 1, column 16"),
    "not_json": (b"NRRD0004\n", "line 1"),
    "binary": (bytes(range(256)), "line 1"),
    "utf16": ('{"version": 1}'.encode("utf-16"), "line 1"),
    "bad_utf8": (b'{"volume": {"file": "\xff\xfe"}}', "line 1"),
    "zero_byte": (b'{"version": 1}\0{}', "zero byte"),
    "deep": (b'{"a":' * 50000, "nested deeper"),
    "duplicate": (b'{"version": 1, "version": 1}', "given twice"),
    "unknown": (b'{"versoin": 1}', 'did you mean "version"'),
    "nan": (b'{"render": {"noise": NaN}}', "line 1"),
    "infinity": (b'{"render": {"noise": 1e400}}', "1e400"),
    "long_number": (b'{"render": {"samples": ' + b"9" * 5000 + b"}}", "number overflow"),
    "huge_key": (b'{"' + b"k" * 100000 + b'": 1}', "unknown key"),
    "newline_in_key": (b'{"a\\nb": 1}', "unknown key"),
    "huge_file": (b" " * ((16 << 20) + 1), "larger than 16 MiB"),
    "no_volume": (b"{}", "volume: missing"),
    "absent_volume": (b'{"volume": {"file": "absent.nrrd"}}', "absent.nrrd: no such file"),
    "scene_as_volume": (b'{"volume": {"file": "scene_as_volume.json"}}', "scene_as_volume.json"),
    "absent_environment": (b'{"volume": {"file": "ball.nrrd"}, "environment": {"file": "x.exr"}}', "x.exr: no such file"),
    "volume_as_environment": (b'{"volume": {"file": "ball.nrrd"}, "environment": {"file": "ball.nrrd"}}', "ball.nrrd"),
    "frame": (b'{"volume": {"file": "ball.nrrd", "frame": 7}}', "frame"),
    "glob": (b'{"volume": {"files": "none*.nrrd"}}', "none*.nrrd"),
    "too_large": (b'{"volume": {"file": "ball.nrrd"}, "image": {"width": 16385}}', "image.width"),
    "version": (b'{"version": 99}', "version"),
}


class HostileScenes(ProgramTest):
    def test_corpus(self):
        for name, (content, message) in CORPUS.items():
            with self.subTest(name):
                (self.folder / f"{name}.json").write_bytes(content)
                process = self.expect_failure(1, message, "render", f"{name}.json", "-o", "o.exr", "-q")
                self.assertLess(len(process.stderr), 1000)
                self.assertFalse((self.folder / "o.exr").exists())

    def test_directory_as_scene(self):
        self.expect_failure(1, "is a directory", "render", ".", "-o", "o.exr")


if __name__ == "__main__":
    unittest.main()
