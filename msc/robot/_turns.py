"""What worlds of either engine promise: one rollout after another, until closed.

Threads would gain nothing by stepping worlds side by side: PyBullet keeps Python's
global lock while it computes, and with either engine most of the time goes into the
Python around steps of some microseconds. So they take turns, a batch of policies each.
"""

from __future__ import annotations

import os
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from msc.robot._control import ControllerGains
from msc.robot._workspace import Workspace

_Array = NDArray[np.float64]

TURN = threading.RLock()  # a fork waits for it, so that no copy is in mid-rollout
os.register_at_fork(
    before=TURN.acquire, after_in_parent=TURN.release, after_in_child=TURN.release
)


class World(ABC):
    """Copies of a workspace's arm and its obstacles; `client_id` is -1 once closed."""

    client_id: int
    _free: Callable[[], object]

    def __init__(
        self, workspace: Workspace, controller: ControllerGains, n_arms: int
    ) -> None:
        self.workspace, self.controller, self.n_arms = workspace, controller, n_arms
        self._busy = False

    def close(self) -> None:
        """Free the world, after what another thread has it do."""
        with TURN:
            self._refuse_if_busy()
            self.client_id = -1
            self._free()

    def track(
        self, plan: _Array, homes: _Array, circles: _Array
    ) -> tuple[_Array, _Array]:
        """Follow planned joint angles by PID torques in the physics world.

        Parameters
        ----------
        plan : ndarray of shape (n_policies, n_steps + 1, 3)
            Joint angles (rad).
        homes : ndarray of shape (n_policies, 3)
            Joint angles at the start (rad).
        circles : ndarray of shape (n_policies, n_circles, 3)
            Where the obstacles are (m).

        Returns
        -------
        joints : ndarray of shape (n_policies, n_steps + 1, 3)
            Joint angles that came about (rad).
        impulse : ndarray of shape (n_policies,)
            Of all contacts (N s).
        """
        with TURN:
            self._refuse_if_busy()
            if self.client_id < 0:
                raise RuntimeError("the arm is closed; wanted an open one")
            self._busy = True
            try:
                return self._track(plan, homes, circles)
            finally:
                self._busy = False

    def _refuse_if_busy(self) -> None:
        """Refuse a call from within a rollout: locks do not keep a thread from it."""
        if self._busy:
            raise RuntimeError(
                "the arm is in the middle of a rollout; wanted calls one after another"
            )

    @abstractmethod
    def _track(
        self, plan: _Array, homes: _Array, circles: _Array
    ) -> tuple[_Array, _Array]:
        """Follow planned joint angles, see `track`."""
