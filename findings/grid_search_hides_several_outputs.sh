#!/usr/bin/env bash
# scikit-learn 1.9.1: the tags of GridSearchCV say one output, whatever it searches for;
# fitted around a Ridge it predicts three at once. A Pipeline hands the Ridge's tag on.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv env
env/bin/pip install --quiet --disable-pip-version-check scikit-learn==1.9.1 \
    scipy==1.17.1 numpy==2.4.6
cat >try.py <<'PY'
import numpy as np
from sklearn.linear_model import Ridge
from sklearn.model_selection import GridSearchCV
from sklearn.pipeline import make_pipeline
from sklearn.utils import get_tags


def says_several(estimator):
    return get_tags(estimator).target_tags.multi_output


rng = np.random.default_rng(0)
X, y = rng.normal(size=(20, 2)), rng.normal(size=(20, 3))
search = GridSearchCV(Ridge(), {"alpha": [0.1, 1.0]})
shape = search.fit(X, y).predict(X).shape
told = [says_several(one) for one in (Ridge(), make_pipeline(Ridge()), search)]
print(f"several outputs, say Ridge, Pipeline and GridSearchCV: {told}; it gave {shape}")
assert told == [True, True, False], "the tags say something else now"
assert shape == (20, 3), "the search has no longer three outputs"
PY
env/bin/python try.py
