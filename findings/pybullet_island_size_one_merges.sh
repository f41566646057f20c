#!/usr/bin/env bash
# PyBullet 3.2.7: by default, bodies that do not touch are solved apart. With
# minimumSolverIslandSize=1 a body with one contact is solved together with others, which
# then decide how many iterations it gets: a pile 100 m away changes its way. Islands are
# solved when they have more constraints than that number, and the default is 0.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv env
env/bin/pip install --quiet --disable-pip-version-check pybullet==3.2.7 numpy==2.4.6
cat >try.py <<'PY'
import pybullet as p


def way(n_far, parameters):
    """Return the places of a box thrown on a floor, with a pile of boxes far away."""
    p.connect(p.DIRECT)
    p.setGravity(0, 0, -10)
    p.setPhysicsEngineParameter(**parameters)
    box = p.createCollisionShape(p.GEOM_BOX, halfExtents=[0.1, 0.1, 0.1])
    floor = p.createCollisionShape(p.GEOM_BOX, halfExtents=[2, 2, 1])
    boxes = []
    for x, count in ((0, 1), (100, n_far)):
        p.createMultiBody(0, floor, basePosition=[x, 0, -1])
        for k in range(count):
            place = [x + 0.03 * k, 0.01 * k, 0.1 + 0.2 * k]
            boxes.append(p.createMultiBody(1, box, basePosition=place))
            p.resetBaseVelocity(boxes[-1], [1, 0.3, 0], [0.1, 0.2, 0.3])
    places = []
    for _ in range(240):
        p.stepSimulation()
        places += p.getBasePositionAndOrientation(boxes[0])[0]
    p.disconnect()
    return places


def moved(**parameters):
    """Return by how much the far pile changes the way (mm)."""
    alone, other = way(0, parameters), way(3, parameters)
    return 1000 * max(abs(a - b) for a, b in zip(alone, other))


default, zero, one = moved(), moved(minimumSolverIslandSize=0), moved(minimumSolverIslandSize=1)
exact = moved(minimumSolverIslandSize=1, solverResidualThreshold=0)
print(
    f"\nby default: {default:g} mm; size 0: {zero:g} mm; size 1: {one:.2g} mm; "
    f"size 1, all iterations: {exact:g} mm"
)
assert default == zero == exact == 0
assert one > 0, "islands of one contact are solved apart now"
PY
env/bin/python try.py 2>errors | tail -n 1 || { tail -n 1 errors >&2; exit 1; }
