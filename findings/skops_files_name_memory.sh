#!/usr/bin/env bash
# skops 0.16.0: files of equal models differ: parts and members are named after addresses
# in memory. Pickles of them are the same.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv env
env/bin/pip install --quiet --disable-pip-version-check skops==0.16.0 \
    scikit-learn==1.9.1 scipy==1.17.1 numpy==2.4.6
cat >try.py <<'PY'
import io
import pickle
import zipfile

import numpy as np
import skops.io
from sklearn.linear_model import LinearRegression

X = np.arange(6.0)[:, None]
models = [LinearRegression().fit(X, X[:, 0]) for _ in range(2)]


def members(content):
    return zipfile.ZipFile(io.BytesIO(content)).namelist()


files = [skops.io.dumps(model) for model in models]
pickles = {pickle.dumps(model) for model in models}
first, second = map(members, files)
print(f"equal models: {len(pickles)} pickle, {len({*files})} skops files", end="; ")
print(f"members of one: {first[0]}, of the other: {second[0]}")
assert len(pickles) == 1, "pickles differ, too"
assert files[0] != files[1], "the files have the same bytes now"
assert first != second, "members have the same names now"
PY
env/bin/python try.py
