#!/usr/bin/env bash
# scikit-learn 1.9.1: in GaussianProcessRegressor, alpha is the variance of the noise of the
# targets, and normalize_y only makes it easier to choose a kernel. With normalize_y=True,
# alpha is added after targets are divided by their deviation, and is not divided: the same
# data and the same noise in other units give another prediction. The page does not say so.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv env
env/bin/pip install --quiet --disable-pip-version-check scikit-learn==1.9.1 numpy==2.4.6 scipy==1.17.1
cat >try.py <<'PY'
import numpy as np
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF

X = np.linspace(0, 1, 20)[:, np.newaxis]
metres = np.sin(6 * X[:, 0]) + np.random.default_rng(0).normal(0, 0.1, 20)


def predict(per_metre, alpha):
    """Learn the same curve in another unit; return predictions in metres."""
    model = GaussianProcessRegressor(
        RBF(0.2), alpha=alpha, optimizer=None, normalize_y=True
    )
    return model.fit(X, per_metre * metres).predict(X) / per_metre


in_metres = predict(1, 0.1**2)
for unit, per_metre in {"centimetres": 100, "millimetres": 1000}.items():
    apart = abs(predict(per_metre, (0.1 * per_metre) ** 2) - in_metres).max()
    print(f"in {unit}, alpha the noise's variance there: {100 * apart:.1f} cm from metres")
    assert apart > 0.5, "predictions do not depend on the unit any more"
same = abs(predict(1000, 0.1**2) - in_metres).max()
print(f"in millimetres, alpha as in metres: {100 * same:.1g} cm from metres")
assert same < 1e-9, "alpha has a unit now"
PY
env/bin/python try.py
