#!/usr/bin/env bash
# scikit-learn 1.9.1: SpectralClustering, asked for more clusters than there are distinct
# rows, gives equal rows different labels, without a warning; KMeans does not, and warns.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv env
env/bin/pip install --quiet --disable-pip-version-check scikit-learn==1.9.1 numpy==2.4.6 scipy==1.17.1
cat >try.py <<'PY'
import warnings

import numpy as np
from sklearn.cluster import KMeans, SpectralClustering

X = np.repeat([[0.0], [1.0], [2.0]], 4, axis=0)  # three distinct rows
labels = []
with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("always")
    for seed in range(6):
        found = SpectralClustering(5, random_state=seed).fit_predict(X)
        labels.append(sum(len(set(found[i : i + 4])) for i in (0, 4, 8)))
print(f"labels among three groups of equal rows, by seed: {labels}; warnings: {len(told)}")
with warnings.catch_warnings(record=True) as told_by_k_means:
    warnings.simplefilter("always")
    k_means = KMeans(5, n_init=1, random_state=0).fit(X)
print(f"KMeans: {len(set(k_means.labels_))} labels; warnings: {len(told_by_k_means)}")
assert max(labels) > 3, "equal rows share a label now"
assert not told, "a warning tells of it now"
assert len(set(k_means.labels_)) == 3
assert told_by_k_means
PY
env/bin/python try.py
