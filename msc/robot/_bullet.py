"""PyBullet: copies of the arm in one physics world, driven by PID torques.

The only module that imports PyBullet. One world carries `n_arms` copies of the arm and
of its obstacles, one above the other on storeys a metre high: they are controlled and
stepped together, and never near enough for the engine to look for contacts between
them. This is what makes a rollout cost little more than its physics. Each copy is a
body, and so a solver island, of its own: a test holds it to do, bit for bit, what it
would do alone.
"""

from __future__ import annotations

import contextlib
import ctypes
import math
import os
import sys
import tempfile
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from msc.robot._control import ControllerGains, rod_inertia, steer
from msc.robot._obstacles import LINK_RADIUS
from msc.robot._turns import TURN, World
from msc.robot._workspace import Workspace

_Array = NDArray[np.float64]

_JOINTS = [0, 1, 2]
_ARM_FILTER, _OBSTACLE_FILTER = (2, 1), (1, 2)  # group, mask: arms meet obstacles only
_GROUND = 768  # m; from here to 1024 m, doubles are evenly spaced: storeys round alike
_BREAKING = 0.02  # m; PyBullet's default, which any connection sets for all of them


class BulletWorld(World):
    """A physics world of PyBullet's; it is freed when it is closed, or forgotten."""

    def __init__(
        self, workspace: Workspace, controller: ControllerGains, n_arms: int
    ) -> None:
        super().__init__(workspace, controller, n_arms)
        self._bullet = load_pybullet()
        self.client_id = self._bullet.connect(self._bullet.DIRECT)
        if self.client_id < 0:
            raise RuntimeError(
                "PyBullet takes no more than 1024 worlds in a process; wanted arms "
                "closed that are not needed any more"
            )
        free = weakref.finalize(self, _disconnect, self._bullet, self.client_id)
        free.atexit = False
        self._free = free
        self._torn = False  # left in the middle of a rollout
        self._bodies = self._load_arms()
        self._obstacles = [
            self._load_obstacle(*circle, height=_GROUND + number)
            for number in range(n_arms)
            for circle in workspace.circles
        ]

    def _track(
        self, plan: _Array, homes: _Array, circles: _Array
    ) -> tuple[_Array, _Array]:
        """Follow planned joint angles, see `track`."""
        bullet, client = self._bullet, self.client_id
        n_policies, n_rows = plan.shape[:2]
        starts = np.tile(self.workspace.home, (self.n_arms, 1))
        starts[:n_policies] = homes
        wanted = np.empty((n_rows, 3, self.n_arms))
        wanted[:] = starts.T
        wanted[..., :n_policies] = plan.transpose(1, 2, 0)
        controller = steer(self.workspace, self.controller, wanted)
        push, mode = bullet.setJointMotorControlArray, bullet.TORQUE_CONTROL
        states = np.empty((n_rows, 6 * self.n_arms))
        contacts: list[list[float]] = [[] for _ in self._bodies]
        self._reset(starts, circles)
        self._torn = True
        states[0] = self._read()
        for step in range(n_rows - 1):
            state = states[step].reshape(-1, 2, 3).transpose(1, 2, 0)
            torques = controller.torques(step, state).T.tolist()
            for body, torque in zip(self._bodies, torques, strict=True):
                push(body, _JOINTS, mode, forces=torque, physicsClientId=client)
            bullet.stepSimulation(physicsClientId=client)
            states[step + 1] = self._read()
            if self._obstacles:
                for contact in bullet.getContactPoints(physicsClientId=client):
                    contacts[self._bodies.index(contact[1])].append(contact[9])
        self._torn = False
        angles = states.reshape(n_rows, -1, 2, 3)[:, :n_policies, 0]
        impulse = np.array([math.fsum(forces) for forces in contacts[:n_policies]])
        physics = self.workspace.physics
        return angles.swapaxes(0, 1).copy(), (
            physics.substeps * physics.time_step * impulse
        )

    def _read(self) -> list[float]:
        """Return every arm's joint angles and velocities, one after the other."""
        read, client = self._bullet.getJointStates, self.client_id
        values: list[float] = []
        for body in self._bodies:
            (q1, v1, _, _), (q2, v2, _, _), (q3, v3, _, _) = read(
                body, _JOINTS, physicsClientId=client
            )
            values += (q1, q2, q3, v1, v2, v3)
        return values

    def _reset(self, starts: _Array, circles: _Array) -> None:
        """Put every arm at rest in its home pose and forget every contact."""
        bullet, here = self._bullet, {"physicsClientId": self.client_id}
        bullet.setPhysicsEngineParameter(contactBreakingThreshold=_BREAKING, **here)
        if self._torn:  # torques that moved nothing yet would add to the next ones
            bullet.stepSimulation(**here)
        for body, home in zip(self._bodies, starts.tolist(), strict=True):
            for joint, angle in zip(_JOINTS, home, strict=True):
                bullet.resetJointState(body, joint, angle, 0.0, **here)
        if self.workspace.further:
            self._move_obstacles(circles)
        for obstacle in self._obstacles:  # renews its proxy: no cached contact is left
            bullet.setCollisionFilterGroupMask(obstacle, -1, *_OBSTACLE_FILTER, **here)

    def _move_obstacles(self, circles: _Array) -> None:
        """Put the obstacles of every policy where its task has them."""
        bullet, here = self._bullet, {"physicsClientId": self.client_id}
        places = circles[..., :2].reshape(-1, 2).tolist()
        each = len(self.workspace.circles)
        for number, (x, y) in enumerate(places):
            place = [x, y, _GROUND + number // each]
            upright = [0.0, 0.0, 0.0, 1.0]
            obstacle = self._obstacles[number]
            bullet.resetBasePositionAndOrientation(obstacle, place, upright, **here)

    def _load_arms(self) -> list[int]:
        """Build the physics world with its arms."""
        bullet, here = self._bullet, {"physicsClientId": self.client_id}
        physics = self.workspace.physics
        bullet.setTimeStep(physics.time_step, **here)
        if physics.gravity:
            bullet.setGravity(0.0, -physics.gravity, 0.0, **here)
        bullet.setPhysicsEngineParameter(
            deterministicOverlappingPairs=1,
            solverResidualThreshold=0.0,
            numSubSteps=physics.substeps,
            **here,
        )
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "arm.urdf")
            file.write_text(_urdf(self.workspace), "utf-8")
            bodies: list[int] = [
                bullet.loadURDF(
                    str(file),
                    basePosition=[0.0, 0.0, _GROUND + number],
                    useFixedBase=True,
                    flags=bullet.URDF_USE_INERTIA_FROM_FILE,
                    **here,
                )
                for number in range(self.n_arms)
            ]
        free = dict.fromkeys(("linearDamping", "angularDamping", "jointDamping"), 0.0)
        for body in bodies:
            for link in (-1, *_JOINTS):
                bullet.changeDynamics(body, link, **free, **here)
                bullet.setCollisionFilterGroupMask(body, link, *_ARM_FILTER, **here)
            mode = bullet.VELOCITY_CONTROL  # motors that hold joints, by default
            bullet.setJointMotorControlArray(
                body, _JOINTS, mode, forces=[0.0] * 3, **here
            )
        return bodies

    def _load_obstacle(self, x: float, y: float, radius: float, height: float) -> int:
        """Add an immovable, frictionless post, its middle at a height."""
        # A capsule, as the links are: where two of them touch has a closed form, which
        # moves as smoothly as they do. Where a capsule touches a cylinder the engine
        # finds by iteration; its last digits decide whether a link that slides along
        # touches or not.
        bullet, here = self._bullet, {"physicsClientId": self.client_id}
        kind = bullet.GEOM_CAPSULE
        shape = bullet.createCollisionShape(kind, radius=radius, height=0.2, **here)
        place = [x, y, height]
        body: int = bullet.createMultiBody(0.0, shape, basePosition=place, **here)
        bullet.changeDynamics(body, -1, lateralFriction=0.0, **here)
        return body


def _urdf(workspace: Workspace) -> str:
    """Describe the arm; one element a line, as PyBullet's parser wants it."""
    text, offset = "", 0.0
    links = zip(workspace.link_lengths, workspace.link_masses, strict=True)
    for number, (length, mass) in enumerate(links, start=1):
        across, along = rod_inertia(length, mass), mass * LINK_RADIUS**2 / 2
        text += f"""
        <link name="link_{number}">
        <inertial><origin xyz="{length / 2} 0 0"/>
        <mass value="{mass}"/>
        <inertia ixx="{along}" iyy="{across}" izz="{across}"
        ixy="0" ixz="0" iyz="0"/></inertial>
        <collision>
        <origin xyz="{length / 2} 0 0" rpy="0 {math.pi / 2} 0"/>
        <geometry><capsule radius="{LINK_RADIUS}" length="{length}"/></geometry>
        </collision>
        </link>
        <joint name="joint_{number}" type="continuous">
        <parent link="link_{number - 1}"/>
        <child link="link_{number}"/>
        <origin xyz="{offset} 0 0"/>
        <axis xyz="0 0 1"/>
        </joint>"""
        offset = length
    return f"""<robot name="arm">
        <link name="link_0">
        <inertial><mass value="1"/>
        <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
        </link>{text}
        </robot>"""


def load_pybullet() -> Any:
    """Import PyBullet without the line it prints past Python's own streams."""
    with TURN, contextlib.nullcontext() if "pybullet" in sys.modules else _quiet():
        try:
            import pybullet  # noqa: PLC0415
        except ImportError:
            raise ValueError(
                "engine='pybullet' is not installed, and has no wheels for Python 3.12 "
                "and later; wanted it, or a world whose engine is 'mujoco'"
            ) from None
    return pybullet


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Send what C code prints nowhere; what other threads print stays."""
    library = ctypes.CDLL(None)
    library.fopen.restype = ctypes.c_void_p
    streams = [ctypes.c_void_p.in_dll(library, name) for name in ("stdout", "stderr")]
    saved = [stream.value for stream in streams]
    null = library.fopen(os.devnull.encode(), b"w")
    for stream in streams:
        stream.value = null
    try:
        yield
    finally:
        for stream, value in zip(streams, saved, strict=True):
            stream.value = value


def _disconnect(bullet: Any, client: int) -> None:
    """Free a world, if nobody else has freed it."""
    with contextlib.suppress(bullet.error):
        bullet.disconnect(client)
