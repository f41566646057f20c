#!/usr/bin/env bash
# PyBullet 3.2.7: a capsule slides along a cylinder, 10 nm deep all the way. Whether the two
# touch is decided by the last digit of its place; two capsules always touch. The first pair's
# distance is searched for by iteration, to about 100 nm; the second pair's has a closed form.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv env
env/bin/pip install --quiet --disable-pip-version-check pybullet==3.2.7 numpy==2.4.6
cat >try.py <<'PY'
import math

import pybullet as p

p.connect(p.DIRECT)
LYING, DEPTH = p.getQuaternionFromEuler([0, math.pi / 2, 0]), 1e-8
rod = p.createMultiBody(1, p.createCollisionShape(p.GEOM_CAPSULE, radius=0.02, height=0.4))


def distances(shape):
    """Return the rod's distance from a post at two places that touch most unlike (nm).

    The places are narrowed down to neighbouring numbers.
    """
    post = p.createMultiBody(0, p.createCollisionShape(shape, radius=0.05, height=0.2))

    def distance(place):
        p.resetBasePositionAndOrientation(rod, [place, 0.07 - DEPTH, 0], LYING)
        return p.getClosestPoints(rod, post, 0.1)[0][8]

    steps = [(k * 1e-4, (k + 1) * 1e-4) for k in range(-1000, 1000)]
    low, high = max(steps, key=lambda step: abs(distance(step[0]) - distance(step[1])))
    while math.nextafter(low, high) < high:
        middle = (low + high) / 2
        if (distance(middle) < 0) == (distance(low) < 0):
            low = middle
        else:
            high = middle
    found = 1e9 * distance(low), 1e9 * distance(high)
    p.removeBody(post)
    return sorted(found)


(deep, apart), smooth = distances(p.GEOM_CYLINDER), distances(p.GEOM_CAPSULE)
print(
    f"\nat neighbouring numbers, cylinder: {deep:.3f} and {apart:.3f} nm; "
    f"capsule: {smooth[0]:.3f} and {smooth[1]:.3f} nm"
)
assert deep < 0 < apart, "they touch at both places, or at neither, now"
assert apart - deep > 10, "the distance hardly jumps now"
assert max(abs(value + 1e9 * DEPTH) for value in smooth) < 1e-6
PY
env/bin/python try.py 2>errors | tail -n 1 || { tail -n 1 errors >&2; exit 1; }
