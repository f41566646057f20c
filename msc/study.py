"""Every method, at many sample sizes, drawn in three ways, many times over.

A study of one workspace is a dictionary, written to `data/results/study_<world>.json`.
Its layout, which claims and figures read::

    {"workspace": "free", "profile": "full", "seed": 0, "n_charts": 4,
     "provenance": {
         "command": "msc evaluate --profile full --seed 0",
         "data": {"free.csv": "sha256:…", "free_test.csv": "sha256:…"},
         "versions": {"numpy": "…", "scikit-learn": "…", "cvxpy": "…",
                      "pybullet": "…"}},
     "cells": [
         {"design": "even" | "uniform" | "nonuniform", "n_samples": 24,
          "repetitions": 15,
          "measures": {MEASURE: {METHOD: SUMMARY}},
          "ratios": [{"measure": MEASURE, "method": "charts", "baseline": METHOD,
                      "ratio": 0.5, "low": 0.4, "high": 0.7}, …]}, …],
     "sweep": [
         {"n_charts": 1, "n_samples": 24, "repetitions": 10,
          "measures": {MEASURE: {"charts": SUMMARY}}}, …]}

``SUMMARY`` is ``{"mean", "std", "median", "p95", "low", "high", "per_repetition"}``.
``MEASURE`` is one of "mse, gate learned", "mse, chart known", "mse, away from jumps",
"mse, beside jumps", "standardised mse, gate learned", "error_cm", "excess_cost",
"under_1_cm", "touched" (shares) and "error_cm spread" (standard deviation over the test
tasks). ``METHOD`` is a name of `msc.methods`: "charts", "single regression", "CrKr",
"single, Matérn", "single, periodic", "nearest neighbour", "linear interpolation",
"mean policy" and "zero policy". ``low`` and ``high`` bound 95 % bootstrap intervals.
"""
