#!/usr/bin/env bash
# scikit-learn 1.9.1: KMeans computes with every core also on a handful of points, where
# threads gain nothing and often cost.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv env
env/bin/pip install --quiet --disable-pip-version-check scikit-learn==1.9.1 numpy==2.4.6
cat >try.py <<'PY'
from statistics import median
from time import perf_counter

import numpy as np
from sklearn.cluster import KMeans
from threadpoolctl import threadpool_limits

points = np.random.default_rng(0).normal(size=(60, 6))


def seconds(n_threads):
    with threadpool_limits(n_threads, user_api="openmp"):
        start = perf_counter()
        KMeans(4, n_init=20, random_state=0).fit(points)
        return perf_counter() - start


seconds(None)
ratio = median(seconds(None) / seconds(1) for _ in range(40))
print(f"\n60 points: all threads take {ratio:.2f} times as long as one")
assert ratio > 0.9, "threads gain something now"
PY
env/bin/python try.py 2>errors | tail -n 1 || { tail -n 1 errors >&2; exit 1; }
