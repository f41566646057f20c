#!/usr/bin/env bash
# crepes 0.9.1: nine held-out errors are enough for a 90 % band, which ends at the largest of
# them. With confidence=0.9 the band is infinite, and a warning says that nine are too few;
# with 19 it ends at the largest error, not the second. The rank is the whole part of
# (1 - confidence) (n + 1), and 1 - 0.9 is less than 0.1 as floats go.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv env
env/bin/pip install --quiet --disable-pip-version-check crepes==0.9.1 numpy==2.4.6 \
    scikit-learn==1.8.0 # which it imports, and does not ask for
cat >try.py <<'PY'
import warnings

import numpy as np
from crepes import ConformalRegressor


def half(n, confidence):
    """Return where the band about 0 ends, for errors of 1 to n; and any warning."""
    model = ConformalRegressor().fit(np.arange(1.0, n + 1))
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        (band,) = model.predict_int(np.zeros(1), confidence=confidence)
    return band[1], bool(said)


found = {(n, c): half(n, c) for n, c in ((9, 0.9), (19, 0.9), (29, 0.9), (3, 0.75))}
for (n, confidence), (end, warned) in found.items():
    told = ", and a warning" if warned else ""
    print(f"{n} errors, 1 to {n}; confidence {confidence}: the band ends at {end}{told}")
assert found[3, 0.75] == (3.0, False)  # 1 - 0.75 is a float: 3 of 3, as it should
assert found[9, 0.9] == (np.inf, True), "nine are enough now"
assert found[19, 0.9] == (19.0, False), "the second largest of 19 now"
assert found[29, 0.9] == (28.0, False), "the third largest of 29 now"
PY
env/bin/python try.py
