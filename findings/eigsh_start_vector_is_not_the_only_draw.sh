#!/usr/bin/env bash
# SciPy 1.17.1: eigsh with a start vector v0 gives other eigenvectors from call to call
# where ARPACK runs out of directions and draws new ones; only `rng` settles them.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv env
env/bin/pip install --quiet --disable-pip-version-check scipy==1.17.1 numpy==2.4.6
cat >try.py <<'PY'
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import eigsh

pair = np.array([[1.0, -1.0], [-1.0, 1.0]])  # the Laplacian of two joined points
laplacian = sp.block_diag([pair] * 300).tocsc()
start = np.random.default_rng(0).standard_normal(600)


def vectors(**options):
    return eigsh(laplacian, 6, sigma=-1e-3, v0=start, **options)[1]


apart = abs(vectors() - vectors()).max()
settled = (vectors(rng=0) == vectors(rng=0)).all()
print(f"300 pairs of points, the same v0 twice: vectors {apart:.1g} apart", end="; ")
print(f"with rng=0 {'the same' if settled else 'others'}")
assert apart > 0.01, "v0 alone settles the vectors now"
assert settled, "rng does not settle the vectors now"
PY
env/bin/python try.py
