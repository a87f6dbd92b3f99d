"""What the examples share: their few options, and fetched data or one line that says how to get it."""
import argparse
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def arguments(script, doc, width, samples, small=(48, 2)):
    """output, width and samples; `width` and `samples` make a good picture in less than a minute, `small` a quick bad one."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=ROOT / "out" / f"{Path(script).stem}.png", metavar="FILE.png")
    parser.add_argument("--width", type=int, default=width, help=f"pixels; {width} when absent")
    parser.add_argument("--samples", type=int, default=samples, help=f"a pixel; {samples} when absent")
    parser.add_argument("--small", action="store_true", help="tiny and noisy, in a second or two: does it run?")
    options = parser.parse_args()
    if options.small:
        options.width, options.samples = small
    options.output.parent.mkdir(parents=True, exist_ok=True)
    return options


def data(name):
    """The path of a fetched file; ends the program in one line where it is absent."""
    path = ROOT / "data" / name
    if not path.is_file():
        sys.exit(f"{Path(sys.argv[0]).name}: no data/{name} (run scripts/fetch_data {path.name.split('.')[0]})")
    return path
