#!/usr/bin/python3
"""How fast sweeps are, beside the papers' numbers and the machine's own limits: docs/results/sweeps.md.

Runs lumisweep_bench (Google Benchmark), which generates the volumes, measures the machine, preparation, sweeps, products and
brute force in one run and takes errors against exact visibility. About ten minutes; an idle machine, please.

    studies/sweeps.py                      measures, writes docs/results/sweeps.md and keeps the numbers in out/sweeps.json
    studies/sweeps.py --from FILE.json     writes the report of an earlier run again
    studies/sweeps.py --quick              small volumes, some seconds, into out/: does it all still work?
"""
import argparse
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import sweeps_report
from benchmarks import Results, run_benchmarks
from common import ROOT, StudyError


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="small volumes, one repetition")
    parser.add_argument("--from", dest="earlier", type=Path, metavar="FILE", help="numbers of an earlier run (out/sweeps.json)")
    parser.add_argument("--program", type=Path, default=ROOT / "build" / "release" / "lumisweep_bench")
    parser.add_argument("--data", type=Path, default=ROOT / "data", help="folder with ch2better.nii.gz; left out where absent")
    parser.add_argument("--output", type=Path, default=None, help="the report (docs/results/sweeps.md)")
    options = parser.parse_args()
    options.output = options.output or ROOT / ("out/sweeps-quick.md" if options.quick else "docs/results/sweeps.md")
    return options


def main():
    options = parse_arguments()
    if options.earlier:
        measured = json.loads(options.earlier.read_text())
    else:
        print("Measuring" + ("" if options.quick else ", about ten minutes"), file=sys.stderr, flush=True)
        measured = run_benchmarks(options, "-^paths/")
        kept = options.output.with_suffix(".json") if options.quick else ROOT / "out" / "sweeps.json"
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_text(json.dumps(measured, indent=1))
    options.output.parent.mkdir(parents=True, exist_ok=True)
    options.output.write_text(sweeps_report.report(Results(measured)))
    print(f"Report: {options.output}")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (StudyError, OSError, KeyError, json.JSONDecodeError) as error:
        print(f"sweeps: {error!r}" if isinstance(error, KeyError) else f"sweeps: {error}", file=sys.stderr)
        sys.exit(1)
    except KeyboardInterrupt:
        sys.exit(130)
