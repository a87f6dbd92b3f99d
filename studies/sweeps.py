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
import re
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import sweeps_report
from common import ROOT, StudyError, commit, cores, load, need_program, processor

TIME_UNITS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}
GOOGLE_BENCHMARK_PARTS = ("iterations", "repeats", "min_time", "process_time", "real_time")


class Results:
    """The repetitions of every benchmark, found by what its name says."""

    def __init__(self, measured):
        self.context = measured["context"]
        self.study = measured["study"]
        self.failed = {}
        self.runs = {}
        for run in measured["benchmarks"]:
            if run.get("run_type", "iteration") != "iteration":
                continue
            parts = run["run_name"].split("/")
            # "sweep/ct/rays:512/cell:4/threads:1" is ("sweep", "ct", "rays:512", …); what Google Benchmark adds is left out.
            key = tuple(part for part in parts if part.split(":")[0] not in GOOGLE_BENCHMARK_PARTS)
            if run.get("error_occurred"):
                self.failed[key] = run.get("error_message", "failed")
            else:
                self.runs.setdefault(key, []).append(run)

    def has(self, *key):
        return key in self.runs

    def best(self, *key, clock="cpu_time"):
        """The repetition that took least."""
        if key not in self.runs:
            raise StudyError(f"benchmark {'/'.join(key)} was not measured" + (f": {self.failed[key]}" if key in self.failed else ""))
        return min(self.runs[key], key=lambda run: run[clock])

    def seconds(self, *key, clock="cpu_time"):
        run = self.best(*key, clock=clock)
        return run[clock] * TIME_UNITS[run["time_unit"]]

    def rate(self, counter, *key):
        """Other load only ever slows down: the fastest repetition."""
        self.best(*key)
        return max(run[counter] for run in self.runs[key])

    def values(self, kind, subject, label):
        """What follows `label`: in the names of one kind and subject, ascending."""
        return sorted({int(match.group(1)) for key in self.runs if key[:2] == (kind, subject)
                       for match in [re.search(rf"(?:^|/){label}:(\d+)", "/".join(key))] if match})


def measure(options):
    program = need_program(options.program)
    arguments = [program, "--benchmark_format=json", *(["--quick"] if options.quick else []), "--data", options.data]
    study = {"processor": processor(), "cores": cores(), "commit": commit(), "date": time.strftime("%Y-%m-%d"),
             "load_before": load(), "quick": options.quick}
    start = time.monotonic()
    run = subprocess.run([*map(str, arguments)], stdout=subprocess.PIPE, text=True)
    if run.returncode != 0:
        raise StudyError(f"{program.name} failed ({run.returncode})")
    study.update(load_after=load(), minutes=(time.monotonic() - start) / 60)
    return {**json.loads(run.stdout), "study": study}


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
        measured = measure(options)
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
