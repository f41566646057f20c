#!/usr/bin/env bash
# cvxpy 1.9.3 with OSQP 1.1.3: a problem with the same data is solved three times. In between
# it was solved with other data, and the second answer is not the first: OSQP starts where it
# ended last, though nobody asked for a warm start. With warm_start=False the third is the
# first to the bit. An interior point method (Clarabel) forgets by itself.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv env
env/bin/pip install --quiet --disable-pip-version-check cvxpy==1.9.3 osqp==1.1.3 numpy==2.4.6 scipy==1.17.1
cat >try.py <<'PY'
import cvxpy as cp
import numpy as np

rng = np.random.default_rng(0)
A = rng.normal(size=(30, 20))
x, b = cp.Variable(20), cp.Parameter(30)
problem = cp.Problem(cp.Minimize(cp.sum_squares(A @ x - b) + cp.norm1(x)))
here, there = rng.normal(size=30), 50 * rng.normal(size=30)


def solve(data, solver, **options):
    """Solve the problem for these data."""
    b.value = data
    problem.solve(solver=solver, **options)
    return x.value.copy()


for solver in ("OSQP", "CLARABEL"):
    first = solve(here, solver)
    solve(there, solver)
    again = solve(here, solver)
    solve(there, solver)
    cold = solve(here, solver, warm_start=False)
    apart, kept = abs(again - first).max(), abs(cold - first).max()
    print(f"{solver}: again {apart:.0e} from the first answer; without a warm start {kept:.0e}")
    if solver == "OSQP":
        assert apart > 1e-7, "the second answer is the first one now"
        assert kept == 0, "without a warm start the answer differs now"
PY
env/bin/python try.py
