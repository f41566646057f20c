"""The movements of a table's policies, and how far those of neighbours are apart."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from msc.data import find_jumps, load_dataset
from msc.robot import Arm, Circle, Workspace, clearance, forward_kinematics
from msc.search import cost
from msc.study import take_evenly

CONTACT = 0.001  # m; an arm that came this close to an obstacle touched it


class Movements:
    """What the arm does for each task of a table.

    Parameters
    ----------
    name : {"free", "obstacles"}
        The workspace and its table.

    Attributes
    ----------
    workspace : Workspace
        Where the movements take place.
    degrees : ndarray of shape (n_tasks,)
        Task angles, ascending (degrees).
    rollouts : list of Rollout
        What the policy of each task does.
    jumps : ndarray of int
        Indices of tasks after which the policies jump, the circle cut open.

    Examples
    --------
    >>> free = Movements("free")
    >>> len(free.rollouts) == len(free.degrees) == len(free.gaps)
    True
    """

    def __init__(self, name: str) -> None:
        self.workspace = Workspace.named(name)
        self._tasks, policies, table = load_dataset(name)
        self.degrees = table["task_deg"].to_numpy()
        self.jumps = find_jumps(self._tasks, policies)
        with Arm(self.workspace) as arm:
            self.rollouts = arm.execute_many(policies, self.degrees.tolist())

    @cached_property
    def places(self) -> NDArray[np.float64]:
        """Base, joints and end effector (m), of shape (n_tasks, n_steps + 1, 4, 2)."""
        joints = np.array([rollout.joints for rollout in self.rollouts])
        return forward_kinematics(joints, self.workspace.link_lengths)

    @property
    def gaps(self) -> NDArray[np.float64]:
        """How far each movement is from the next task's (m), of shape (n_tasks,).

        The farthest that any joint, or the end effector, is from where it is in the
        other movement at the same time. The last task's next is the first.
        """
        apart = np.roll(self.places, -1, axis=0) - self.places
        return np.asarray(np.linalg.norm(apart, axis=-1).max(axis=(1, 2)))

    @property
    def breaks(self) -> list[tuple[int, int]]:
        """Indices of the tasks on both sides of each jump and, last, of the cut."""
        last = len(self.degrees) - 1
        return [(int(k), int(k) + 1) for k in self.jumps] + [(last, 0)]

    @property
    def unbroken(self) -> NDArray[np.float64]:
        """The `gaps` elsewhere (m): without those of the jumps and of the cut."""
        return np.delete(self.gaps, [*self.jumps, len(self.degrees) - 1])

    @property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lower and upper bounds of all that moves or stands here, x and y (m)."""
        low, high = [self.places.min(axis=(0, 1, 2))], [self.places.max(axis=(0, 1, 2))]
        for x, y, radius in self.workspace.circles:
            low.append(np.array([x - radius, y - radius]))
            high.append(np.array([x + radius, y + radius]))
        return np.min(low, axis=0) - 0.03, np.max(high, axis=0) + 0.03

    def evenly(self, n_tasks: int) -> list[int]:
        """Pick tasks evenly spaced over the circle.

        Parameters
        ----------
        n_tasks : int
            How many.

        Returns
        -------
        list of int
            Their indices.

        Raises
        ------
        ValueError
            If there are fewer.
        """
        return [int(index) for index in take_evenly(self._tasks, n_tasks)]

    def touched(self, index: int) -> list[Circle]:
        """Find the obstacles that the arm touched.

        Parameters
        ----------
        index : int
            Which task.

        Returns
        -------
        list of Circle
            The obstacles.
        """
        return [
            circle
            for circle in self.workspace.circles
            if self.rollouts[index].touched
            and clearance(self.places[index], circle).min() < circle.radius + CONTACT
        ]

    def compare(self) -> pd.DataFrame:
        """Compare the movements on both sides of each jump and, last, of the cut.

        Returns
        -------
        DataFrame
            One row a break: the largest distance between the two movements (cm), see
            `gaps`; the cost before and after; whether the arm touched an obstacle; and
            the larger of the distances that were left to the goals (cm).
        """
        rows = {}
        for pair in self.breaks:
            before, after = (self.rollouts[index] for index in pair)
            rows[" | ".join(f"{self.degrees[index]:g}°" for index in pair)] = {
                "apart (cm)": 100 * self.gaps[pair[0]],
                "cost before": cost(before),
                "cost after": cost(after),
                "touched before": before.touched,
                "touched after": after.touched,
                "missed by (cm)": 100 * max(before.error, after.error),
            }
        return pd.DataFrame.from_dict(rows, orient="index").rename_axis("tasks")
