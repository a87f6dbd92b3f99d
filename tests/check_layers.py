#!/usr/bin/env python3
"""Checks how the sources depend on each other, and what the instruction-set files leave to the linker.

    check_layers.py includes            folders include downward only; SIMD headers and ITK only where they belong
    check_layers.py symbols BUILD_DIR   no generic function is compiled out of line with AVX flags

The second matters because an inline function that is emitted by several object files is kept once, from any of them: a generic
one taken from an AVX-512 object would crash machines without it.
"""
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "src" / "lumisweep"

# Folder: the folders that it may include from, besides itself. As in src/lumisweep/CMakeLists.txt.
DIRECT = {
    "base": [],
    "math": ["base"],
    "volume": ["math"],
    "volume/io": ["volume"],
    "image": ["math"],
    "light": ["image"],
    "visibility": ["volume"],
    "sampling": ["visibility", "light"],
    "render": ["sampling"],
    "backends/cpu": ["render"],
    "backends/cuda": ["render"],
    "backends": ["backends/cpu", "backends/cuda"],
    "scene": ["backends", "volume/io"],
}
INTRINSICS = re.compile(r"(?:[a-z]*mmintrin|immintrin|x86intrin|x86gprintrin)\.h|arm_neon\.h")
INTRINSICS_HOME = re.compile(r"lanes_\w+\.h|\w+_(?:avx2|avx512)\.cpp")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def allowed(folder):
    reached = {folder}
    for below in DIRECT[folder]:
        reached |= allowed(below)
    return reached


def folder_of(path):
    """The layer that holds a path relative to src/lumisweep; the longest name wins (volume/io before volume)."""
    parents = [parent.as_posix() for parent in Path(path).parents]
    return next((parent for parent in parents if parent in DIRECT), None)


def check_file(path):
    relative = path.relative_to(SOURCE)
    if relative.as_posix() == "lumisweep.h":
        return  # the public API in one header: above every layer
    folder = folder_of(relative)
    if folder is None:
        yield f"{relative}: belongs to no layer; add its folder to tests/check_layers.py and src/lumisweep/CMakeLists.txt"
        return
    may_use = allowed(folder)
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        bracket, target = match.groups()
        where = f"src/lumisweep/{relative}:{number}"
        if target.startswith("lumisweep/"):
            below = folder_of(target.removeprefix("lumisweep/"))
            if below not in may_use:
                yield f"{where}: {folder} must not include {target} (it may use {', '.join(sorted(may_use))})"
            elif not (SOURCE.parent / target).is_file():
                yield f"{where}: no such header: {target}"
        elif bracket == '"':
            yield f'{where}: write the whole path: #include "lumisweep/{folder}/{target}"'
        elif INTRINSICS.fullmatch(target) and not INTRINSICS_HOME.fullmatch(path.name):
            yield f"{where}: {target} belongs in lanes_*.h and *_avx2.cpp, *_avx512.cpp only"
        elif target.startswith(("itk", "vnl", "gdcm")) and folder != "volume/io":
            yield f"{where}: {target}: ITK stays inside volume/io"


def check_includes():
    files = sorted(path for path in SOURCE.rglob("*") if path.suffix in (".h", ".cpp", ".inl"))
    if not files:
        yield f"no sources under {SOURCE}"
    for path in files:
        yield from check_file(path)


def check_symbols(build):
    objects = sorted(path for name in ("avx2", "avx512") for folder in ("src", "bench")
                     for path in Path(build, folder).glob(f"**/*_{name}.cpp.o"))
    if not objects:
        yield f"no instruction-set objects under {build}"
    for path in objects:
        lane = "Avx512" if path.name.endswith("_avx512.cpp.o") else "Avx2"
        listing = subprocess.run(["nm", "--demangle", "--defined-only", str(path)], check=True, capture_output=True, text=True)
        for line in listing.stdout.splitlines():
            _, kind, symbol = line.split(maxsplit=2)
            # W: a weak function. Weak data (V, u) holds no instructions.
            if kind == "W" and lane not in symbol:
                yield f"{path.name}: emits the generic function {symbol}; keep it inline, or give it a {lane} type"


def main(arguments):
    if arguments == ["includes"]:
        problems = list(check_includes())
    elif len(arguments) == 2 and arguments[0] == "symbols":
        problems = list(check_symbols(arguments[1]))
    else:
        print(__doc__, file=sys.stderr)
        return 2
    for problem in problems:
        print(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
