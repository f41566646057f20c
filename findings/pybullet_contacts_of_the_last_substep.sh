#!/usr/bin/env bash
# PyBullet 3.2.7: with numSubSteps, getContactPoints after a step knows of the last sub-step
# alone; a ball that bounces in an earlier one has touched nothing, whatever turned it round.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv env
env/bin/pip install --quiet --disable-pip-version-check pybullet==3.2.7 numpy==2.4.6
cat >try.py <<'PY'
import pybullet as bullet

RATE, N_STEPS, GRAVITY = 60, 60, 9.81


def drop(substeps):
    """Drop an elastic ball of 1 kg for a second; count bounces, and what is told of them."""
    here = {"physicsClientId": bullet.connect(bullet.DIRECT)}
    bullet.setTimeStep(1 / RATE, **here)
    bullet.setPhysicsEngineParameter(
        numSubSteps=substeps, restitutionVelocityThreshold=0.01, **here
    )
    bullet.setGravity(0, 0, -GRAVITY, **here)
    shapes = (bullet.GEOM_PLANE, {}), (bullet.GEOM_SPHERE, {"radius": 0.05})
    ground, ball = (
        bullet.createMultiBody(
            mass,
            bullet.createCollisionShape(kind, **size, **here),
            basePosition=[0, 0, height],
            **here,
        )
        for mass, height, (kind, size) in zip((0, 1), (0, 0.5), shapes)
    )
    for body in (ground, ball):
        free = {"linearDamping": 0.0, "angularDamping": 0.0}
        bullet.changeDynamics(body, -1, restitution=1.0, **free, **here)
    bounces, steps_with_contact, told, speed = 0, 0, 0.0, 0.0
    for _ in range(N_STEPS):
        bullet.stepSimulation(**here)
        force = sum(one[9] for one in bullet.getContactPoints(ball, ground, **here))
        steps_with_contact += force > 0
        told += force / RATE
        before, speed = speed, bullet.getBaseVelocity(ball, **here)[0][2]
        bounces += speed > before + 1
    gained = speed + GRAVITY * N_STEPS / RATE  # m/s of 1 kg: the impulse of all bounces
    bullet.disconnect(here["physicsClientId"])
    return bounces, steps_with_contact, round(told, 1), round(gained, 1)


found = {substeps: drop(substeps) for substeps in (1, 2, 4, 8)}
for substeps, (bounces, steps, told, gained) in found.items():
    print(f"sub-steps {substeps}: {bounces} bounces, {steps} steps with contact; ", end="")
    print(f"impulse {gained} N s, told of {told}")
bounces, steps, told, gained = found[1]
assert bounces == steps == 2
assert abs(told - gained) < 0.1
seen = [steps for bounces, steps, *_ in list(found.values())[1:]]
assert all(found[n][0] == 2 for n in found)
assert min(seen) == 0, "contacts of earlier sub-steps are told now"
PY
env/bin/python try.py
