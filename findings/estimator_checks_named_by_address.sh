#!/usr/bin/env bash
# scikit-learn 1.9.1 with pytest 9.2.0 and pytest-xdist 3.8.0: parametrize_with_checks
# names each test by the estimator's repr. Where a parameter is a function, that holds its
# address, other in every process, and two workers refuse to run one test at all: they
# "collected different tests". With one worker all run.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv env
env/bin/pip install --quiet --disable-pip-version-check scikit-learn==1.9.1 \
    scipy==1.17.1 numpy==2.4.6 pytest==9.2.0 pytest-xdist==3.8.0
cat >test_checks.py <<'PY'
import numpy as np
from sklearn.preprocessing import FunctionTransformer
from sklearn.utils.estimator_checks import parametrize_with_checks


def double(X):
    return 2 * np.asarray(X)


@parametrize_with_checks([FunctionTransformer(double)])
def test_transformer(estimator, check):
    check(estimator)
PY
one=$(env/bin/python -m pytest -q -p no:cacheprovider test_checks.py | tail -1)
two=$(env/bin/python -m pytest -q -p no:cacheprovider -n 2 test_checks.py || true)
name=$(env/bin/python -m pytest -q --collect-only test_checks.py | head -1)
echo "a test is called: $name"
echo "one process: $one"
echo "two workers: $(grep -o 'Different tests were collected' <<<"$two" | head -1)"
grep -q 'function.*at0x' <<<"$name" || { echo "names hold no address any more"; exit 1; }
grep -q ' passed' <<<"$one" || { echo "one process does not pass"; exit 1; }
grep -q 'Different tests were collected' <<<"$two" || { echo "two workers agree"; exit 1; }
