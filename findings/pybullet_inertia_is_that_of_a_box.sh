#!/usr/bin/env bash
# PyBullet 3.2.7: loadURDF ignores a link's <inertia> unless it is told to use it, and takes
# the inertia of the box around the link's shape, not that of the shape. PyBullet's guide says
# that it is computed from the shape's volume; that it is a box is said in the source alone.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv env
env/bin/pip install --quiet --disable-pip-version-check pybullet==3.2.7 numpy==2.4.6
cat >rod.urdf <<'URDF'
<robot name="rod">
  <link name="base"/>
  <link name="rod">
    <inertial>
      <mass value="1"/>
      <inertia ixx="0.026625" iyy="0.026625" izz="0.00475" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <collision><geometry><capsule radius="0.1" length="0.4"/></geometry></collision>
  </link>
  <joint name="axle" type="continuous">
    <parent link="base"/><child link="rod"/><axis xyz="1 0 0"/>
  </joint>
</robot>
URDF
cat >try.py <<'PY'
import pybullet as p

p.connect(p.DIRECT)


def inertia(flags):
    """Return the inertia across the rod: as PyBullet tells it, and as a torque finds it."""
    body = p.loadURDF("rod.urdf", useFixedBase=True, flags=flags)
    told = p.getDynamicsInfo(body, 0)[2][0]
    p.changeDynamics(body, 0, linearDamping=0, angularDamping=0, jointDamping=0)
    p.setJointMotorControl2(body, 0, p.VELOCITY_CONTROL, force=0)
    p.setJointMotorControl2(body, 0, p.TORQUE_CONTROL, force=1.0)
    p.stepSimulation()
    return told, 1 / (240 * p.getJointState(body, 0)[1])


asked, found = inertia(p.URDF_USE_INERTIA_FROM_FILE), inertia(0)
box = (0.2**2 + 0.6**2) / 12  # 1 kg, 0.2 m by 0.2 m by 0.6 m
print(f"\nin the file: {asked[0]:.4f}; by default: {found[0]:.4f}; of the box: {box:.4f} kg m²")
assert max(abs(value - 0.026625) for value in asked) < 1e-6
assert max(abs(value - box) for value in found) < 1e-6, "it is not the box's any more"
PY
env/bin/python try.py 2>errors | tail -n 1 || { tail -n 1 errors >&2; exit 1; }
