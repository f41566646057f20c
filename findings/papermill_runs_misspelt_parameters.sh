#!/usr/bin/env bash
# papermill 2.7.0: a parameter that the notebook does not declare, as a misspelt one, is put
# into the run and warned about; the notebook computes with what it had, and papermill's exit
# is 0. It is meant so: the warning was added without changing what is done.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv env
env/bin/pip install --quiet --disable-pip-version-check papermill==2.7.0 ipykernel==7.4.0
cat >in.ipynb <<'IPYNB'
{"cells": [
  {"cell_type": "code", "id": "a", "metadata": {"tags": ["parameters"]}, "outputs": [],
   "execution_count": null, "source": "n_samples = 24"},
  {"cell_type": "code", "id": "b", "metadata": {}, "outputs": [],
   "execution_count": null, "source": "print(n_samples)"}],
 "metadata": {"kernelspec": {"name": "python3", "display_name": "", "language": "python"}},
 "nbformat": 4, "nbformat_minor": 5}
IPYNB
export IPYTHONDIR="$folder"
code=0
env/bin/papermill in.ipynb out.ipynb -p n_sample 48 --no-progress-bar 2>errors || code=$?
cat >try.py <<'PY'
import json
import sys
from pathlib import Path

cells = json.loads(Path("out.ipynb").read_text("utf-8"))["cells"]
injected = "".join(cells[1]["source"]).splitlines()[-1]
printed = "".join(cells[2]["outputs"][0]["text"]).strip()
warned = "unknown parameter: n_sample" in Path("errors").read_text("utf-8")
code = int(sys.argv[1])
print(f"injected: {injected}; computed with: {printed}; warned: {warned}; exit: {code}")
assert code == 0, "an unknown parameter is an error now"
assert injected == "n_sample = 48", "an unknown parameter is left out now"
assert printed == "24"
assert warned
PY
env/bin/python try.py "$code"
