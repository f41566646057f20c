#!/usr/bin/env bash
# cma 4.5.0: seed 0 means the clock, so that two searches with it differ; and making a search
# seeds NumPy's global generator, whoever else draws from it. The text of the option says so
# (cma.CMAOptions("seed")).
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv env
env/bin/pip install --quiet --disable-pip-version-check cma==4.5.0 numpy==2.4.6
cat >try.py <<'PY'
import cma
import numpy as np


def first(**options):
    """Return the first points that a search asks for."""
    return cma.CMAEvolutionStrategy([0.0, 0.0], 1.0, {"verbose": -9, **options}).ask()


def next_draw(**options):
    """Return what NumPy's global generator, seeded, draws after a search was made."""
    np.random.seed(1)
    cma.CMAEvolutionStrategy([0.0, 0.0], 1.0, {"verbose": -9, **options})
    return np.random.random()


def own():
    """Return options by which all draws come from a generator of one's own."""
    return {"seed": np.nan, "randn": lambda *size: rng.standard_normal(size)}


equal = {seed: np.array_equal(first(seed=seed), first(seed=seed)) for seed in (0, 7)}
np.random.seed(1)
undisturbed = np.random.random()
np.random.seed(7)
of_seven = np.random.random()
print(f"two searches are equal, by seed: {equal}; ", end="")
print(f"seed 7 sets NumPy's generator: {next_draw(seed=7) == of_seven}")
assert not equal[0], "seed 0 is a seed now"
assert equal[7]
assert next_draw(seed=0) != undisturbed
assert next_draw(seed=7) == of_seven != undisturbed, "NumPy's generator is left alone now"

rng = np.random.default_rng(0)
once = first(**own())
rng = np.random.default_rng(0)
assert np.array_equal(once, first(**own()))
assert next_draw(**own()) == undisturbed
PY
env/bin/python -W ignore try.py  # of having no matplotlib
