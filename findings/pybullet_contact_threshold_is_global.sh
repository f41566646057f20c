#!/usr/bin/env bash
# PyBullet 3.2.7: contactBreakingThreshold, set in one connection, acts in the others.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv env
env/bin/pip install --quiet --disable-pip-version-check pybullet==3.2.7 numpy==2.4.6
cat >try.py <<'PY'
import pybullet as p


def contacts():
    """Count the contacts of a sphere 10 cm above a plate, in a connection of its own."""
    client = p.connect(p.DIRECT)
    plate = p.createCollisionShape(p.GEOM_BOX, halfExtents=[1, 1, 1], physicsClientId=client)
    ball = p.createCollisionShape(p.GEOM_SPHERE, radius=0.5, physicsClientId=client)
    p.createMultiBody(0, plate, physicsClientId=client)
    p.createMultiBody(1, ball, basePosition=[0, 0, 1.6], physicsClientId=client)
    p.performCollisionDetection(physicsClientId=client)
    found = len(p.getContactPoints(physicsClientId=client))
    p.disconnect(client)
    return found


before = contacts()
other = p.connect(p.DIRECT)
p.setPhysicsEngineParameter(contactBreakingThreshold=0.2, physicsClientId=other)
p.disconnect(other)
after = contacts()
print(f"contacts before: {before}; after another connection, now closed, set it: {after}")
assert (before, after) == (0, 1), "the threshold belongs to its connection now"
PY
env/bin/python try.py 2>errors | tail -n 1 || { tail -n 1 errors >&2; exit 1; }
