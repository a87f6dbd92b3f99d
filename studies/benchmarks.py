"""Running lumisweep_bench and finding what it has measured."""
import json
import re
import subprocess
import time

from common import StudyError, commit, cores, load, need_program, processor

TIME_UNITS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}
GOOGLE_BENCHMARK_PARTS = ("iterations", "repeats", "min_time", "process_time", "real_time", "manual_time")


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


def run_benchmarks(options, name_filter):
    """The benchmarks whose names match (or do not, after a minus), as Google Benchmark reports them, and where they ran."""
    program = need_program(options.program)
    arguments = [program, "--benchmark_format=json", f"--benchmark_filter={name_filter}", *(["--quick"] if options.quick else []),
                 "--data", options.data]
    study = {"processor": processor(), "cores": cores(), "commit": commit(), "date": time.strftime("%Y-%m-%d"),
             "load_before": load(), "quick": options.quick}
    start = time.monotonic()
    run = subprocess.run([*map(str, arguments)], stdout=subprocess.PIPE, text=True)
    if run.returncode != 0:
        raise StudyError(f"{program.name} failed ({run.returncode})")
    study.update(load_after=load(), minutes=(time.monotonic() - start) / 60)
    return {**json.loads(run.stdout), "study": study}
