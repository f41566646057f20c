"""What a method may be told when it is built."""

from __future__ import annotations

from dataclasses import dataclass, field

from msc.robot import Workspace

N_CHARTS = 4  # as the paper has in both workspaces


@dataclass(frozen=True)
class Setting:
    """What a method may be told.

    Attributes
    ----------
    name : str
        What it is called.
    n_charts : int or None, default=4
        Charts that SMCE is asked for; None leaves it to the elbow. k-means, which has
        none, is then asked for four.
    seed : int, default=0
        Seed of the clustering, and of whatever else draws.
    workspace : Workspace, optional
        Where the goals of tasks are; by default ``Workspace.free()``.
    """

    name: str
    n_charts: int | None = N_CHARTS
    seed: int = 0
    workspace: Workspace = field(default_factory=Workspace.free)
