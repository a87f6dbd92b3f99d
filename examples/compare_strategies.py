#!/usr/bin/python3
"""How much noise each way of choosing directions leaves, on a CT head and a stent under a morning sun.

A film knows its own variance, so no reference is needed. With independent samples variance falls as one over their number, so
variance × time is what a strategy costs for the same noise. Data: scripts/fetch_data ct_head stent sunrise

    examples/compare_strategies.py [--width N] [--samples N] [--small]
"""
import time

import lumisweep as ls
from gallery import ROOT, arguments, data

STRATEGIES = ("environment", "uniform", "visibility", "combined", "two-step", "auto")

options = arguments(__file__, __doc__, width=128, samples=128, small=(32, 16))
light = data("environments/sunrise.exr")

print(f"{'times less variance than environment sampling':48}{'equal samples':>14}{'equal time':>14}")
for scene in ("ct_head", "stent"):
    data(f"{scene}.nrrd")
    session = ls.Session.load(ROOT / "scenes" / f"{scene}.json", overrides={
        "environment.file": light, "image": {"width": options.width, "height": options.width, "show_environment": False}})
    costs = {}
    for strategy in STRATEGIES:
        session.render_settings = ls.RenderSettings(strategy=strategy, seed=1)
        session.prepare()  # sweeps, where the strategy needs them, are not part of the time
        begin = time.process_time()
        session.render(samples=options.samples)
        variance = session.noise ** 2
        costs[strategy] = variance, variance * (time.process_time() - begin)
        gains = [base / cost for base, cost in zip(costs["environment"], costs[strategy])]
        print(f"{scene + ', ' + strategy:48}" + "".join(f"{gain:13.3g}×" for gain in gains))
