#!/usr/bin/env bash
# PyBullet 3.2.7: a torque commanded twice before a step acts twice, and a joint's reset
# does not take it back.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv env
env/bin/pip install --quiet --disable-pip-version-check pybullet==3.2.7 numpy==2.4.6
cat >arm.urdf <<'URDF'
<robot name="wheel">
  <link name="base"/>
  <link name="wheel">
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="axle" type="continuous">
    <parent link="base"/><child link="wheel"/><axis xyz="0 0 1"/>
  </joint>
</robot>
URDF
cat >try.py <<'PY'
import pybullet as p

client = p.connect(p.DIRECT)
body = p.loadURDF("arm.urdf", useFixedBase=True, flags=p.URDF_USE_INERTIA_FROM_FILE)
p.changeDynamics(body, 0, linearDamping=0, angularDamping=0, jointDamping=0)
p.setJointMotorControl2(body, 0, p.VELOCITY_CONTROL, force=0)


def speed(commands, reset=False):
    p.resetJointState(body, 0, 0.0, 0.0)
    for torque in commands:
        p.setJointMotorControl2(body, 0, p.TORQUE_CONTROL, force=torque)
    if reset:
        p.resetJointState(body, 0, 0.0, 0.0)
    p.stepSimulation()
    return 240 * p.getJointState(body, 0)[1]  # torque / inertia, after 1/240 s


once, twice = speed([1.0]), speed([1.0, 1.0])
taken_back, reset = speed([1.0, 0.0]), speed([1.0], reset=True)
print(f"\n1 Nm: {once:.3f}; again: {twice:.3f}; 1, then 0: {taken_back:.3f}; reset: {reset:.3f}")
assert abs(once - 1) < 1e-6
assert abs(twice - 2) < 1e-6, "a second command replaces the first now"
assert abs(taken_back - 1) < 1e-6, "a command of zero takes back the first now"
assert abs(reset - 1) < 1e-6, "resetJointState takes the command back now"
PY
env/bin/python try.py 2>errors | tail -n 1 || { tail -n 1 errors >&2; exit 1; }
