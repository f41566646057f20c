"""What the chapters measure: one experiment, its methods, their errors, compared."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from sklearn.dummy import DummyRegressor
from sklearn.neighbors import KNeighborsRegressor

from msc.arm import Arm
from msc.comparison import Comparison, compare
from msc.dataset import take_evenly
from msc.jumps import find_jumps
from msc.search import cost
from msc.skill import ParameterizedSkill
from msc.smce import SMCE
from msc.tables import load_dataset
from msc.workspace import Workspace

PROFILES = {"quick": 1_000, "full": 20_000}  # bootstrap resamples
READINGS = ("gate learned", "chart known", "away from jumps")


class Experiment:
    """One world, one training set, all methods, tested on tasks off the grid.

    Parameters
    ----------
    name : {"free", "obstacles"}
        The workspace and its data.
    n_samples : int
        Training tasks, evenly spaced over the circle.
    n_charts : int or None, default=4
        Charts, as the paper's figures have them; None leaves it to the elbow.
    profile : {"quick", "full"}, default="quick"
        How many bootstrap resamples an interval rests on.
    seed : int, default=0
        Seed of the clustering and the resampling.

    Attributes
    ----------
    tasks, policies : ndarray of shape (n_grid, 1) and (n_grid, n_params)
        All grid tasks (rad) and their policies.
    chosen : ndarray of shape (n_samples,)
        Indices of those trained on.
    test_tasks, test_policies : ndarray
        The tasks tested on, never trained on.
    jumps : ndarray of int
        Where the policies jump from one grid task to the next.

    Raises
    ------
    ValueError
        If an argument is not as wanted.
    """

    def __init__(
        self,
        name: str,
        *,
        n_samples: int,
        n_charts: int | None = 4,
        profile: str = "quick",
        seed: int = 0,
    ) -> None:
        if profile not in PROFILES:
            raise ValueError(f"profile={profile!r}; wanted 'quick' or 'full'")
        self.workspace = Workspace.named(name)
        self.n_charts, self.seed = n_charts, seed
        self.n_resamples = PROFILES[profile]
        self.tasks, self.policies, self.table = load_dataset(name)
        test = load_dataset(f"{name}_test")
        self.test_tasks, self.test_policies, self.test_table = test
        self.chosen = take_evenly(self.tasks, n_samples)
        self.jumps = find_jumps(self.tasks, self.policies)

    @property
    def n_samples(self) -> int:
        """Number of training tasks."""
        return len(self.chosen)

    @cached_property
    def methods(self) -> dict[str, Any]:
        """The fitted methods: ours, the single regression, and those to be beaten."""
        charts = SMCE(self.n_charts, random_state=self.seed)
        unfitted = {
            "charts": ParameterizedSkill(charts, random_state=self.seed),
            "single regression": ParameterizedSkill(None, random_state=self.seed),
            "nearest neighbour": KNeighborsRegressor(1),
            "mean policy": DummyRegressor(),
            "zero policy": DummyRegressor(
                strategy="constant", constant=np.zeros(self.policies.shape[1])
            ),
        }
        X, y = self.tasks[self.chosen], self.policies[self.chosen]
        return {name: method.fit(X, y) for name, method in unfitted.items()}

    @cached_property
    def elbow(self) -> int:
        """Number of charts that the elbow picks on the training policies."""
        charts = SMCE(random_state=self.seed).fit(self.policies[self.chosen])
        return int(charts.n_clusters_)

    def predict(self, name: str, tasks: ArrayLike) -> NDArray[np.float64]:
        """Predict policies.

        Parameters
        ----------
        name : str
            A method.
        tasks : array_like of shape (n_tasks, 1)
            Tasks (rad).

        Returns
        -------
        ndarray of shape (n_tasks, n_params)
            Policies.
        """
        return np.asarray(self.methods[name].predict(np.asarray(tasks)))

    @cached_property
    def known_charts(self) -> NDArray[np.intp]:
        """Charts of the test tasks by their own policies: that of the nearest policy.

        Only the reading "chart known" may look at a test task's policy.
        """
        nearest = np.linalg.norm(
            self.test_policies[:, None] - self.policies[self.chosen], axis=2
        ).argmin(axis=1)
        return np.asarray(self.methods["charts"].charts_[nearest])

    @cached_property
    def away_from_jumps(self) -> NDArray[np.bool_]:
        """Test tasks farther from every jump than the training tasks lie apart."""
        step = 2 * np.pi / self.n_samples
        places = (self.tasks[self.jumps] + self.tasks[self.jumps + 1]) / 2
        gaps = np.abs(self.test_tasks - places.reshape(1, -1))
        return np.asarray((gaps > step).all(axis=1))

    def squared_errors(self, reading: str = "gate learned") -> pd.DataFrame:
        """Compare predicted with searched policies, one row a test task.

        Parameters
        ----------
        reading : {"gate learned", "chart known", "away from jumps"}
            Which chart a test task belongs to, and which test tasks count.

        Returns
        -------
        DataFrame
            Squared errors, averaged over the six dimensions, one column a method.

        Raises
        ------
        ValueError
            If the reading is another.
        """
        if reading not in READINGS:
            raise ValueError(f"reading={reading!r}; wanted one of {READINGS}")
        errors = {}
        for name, method in self.methods.items():
            if reading == "chart known" and name == "charts":
                predicted = method.predict(self.test_tasks, chart=self.known_charts)
            else:
                predicted = method.predict(self.test_tasks)
            errors[name] = np.mean((predicted - self.test_policies) ** 2, axis=1)
        table = pd.DataFrame(errors, index=self.test_table["task_deg"])
        return table[self.away_from_jumps] if reading == READINGS[2] else table

    @cached_property
    def executed(self) -> pd.DataFrame:
        """What happens when predicted policies are run: one row a task and method."""
        angles = self.test_table["task_deg"].tolist()
        rows = []
        with Arm(self.workspace) as arm:
            for name in self.methods:
                policies = self.predict(name, self.test_tasks)
                for angle, searched, rollout in zip(
                    angles,
                    self.test_table["cost"],
                    arm.execute_many(policies, angles),
                    strict=True,
                ):
                    rows.append(
                        {
                            "method": name,
                            "task_deg": angle,
                            "error_cm": 100 * rollout.error,
                            "excess_cost": cost(rollout) - searched,
                            "touched": rollout.touched,
                        }
                    )
        return pd.DataFrame(rows)

    def executed_by_method(self, column: str) -> pd.DataFrame:
        """Spread a column of `executed`: one row a test task, one column a method.

        Parameters
        ----------
        column : {"error_cm", "excess_cost", "touched"}
            Which.

        Returns
        -------
        DataFrame
            The column, for `compare`.
        """
        wide = self.executed.pivot_table(
            index="task_deg", columns="method", values=column, sort=False
        )
        return wide[list(self.methods)]

    def mse_summary(self) -> pd.DataFrame:
        """Average the squared errors, one row a method, one column a reading.

        Returns
        -------
        DataFrame
            Mean squared errors; "chart known" differs for the charts alone.
        """
        means = {reading: self.squared_errors(reading).mean() for reading in READINGS}
        return pd.DataFrame(means).loc[list(self.methods)]

    def executed_summary(self) -> pd.DataFrame:
        """Summarise what execution costs, one row a method.

        Returns
        -------
        DataFrame
            Excess cost (mean, median), centimetres (mean, standard deviation, median),
            the share of tasks missed by less than 1 cm, and that which met an obstacle.
        """
        groups = self.executed.groupby("method", sort=False)
        error, excess = groups["error_cm"], groups["excess_cost"]
        return pd.DataFrame(
            {
                "excess cost, mean": excess.mean(),
                "excess cost, median": excess.median(),
                "error (cm), mean": error.mean(),
                "error (cm), std": error.std(),
                "error (cm), median": error.median(),
                "share under 1 cm": error.agg(lambda cm: float((cm < 1).mean())),
                "share that touched": groups["touched"].mean(),
            }
        )

    def compare_mse(
        self, reading: str = "gate learned", baseline: str = "single regression"
    ) -> Comparison:
        """Compare the charts' mean squared error with a baseline's.

        Parameters
        ----------
        reading : str, default="gate learned"
            See `squared_errors`.
        baseline : str, default="single regression"
            A method.

        Returns
        -------
        Comparison
            The ratio and its interval.
        """
        errors = self.squared_errors(reading)
        return self._compare(f"MSE, {reading}", errors, baseline)

    def compare_executed(
        self, column: str, baseline: str = "single regression"
    ) -> Comparison:
        """Compare what the charts' policies do when executed with a baseline's.

        Parameters
        ----------
        column : {"error_cm", "excess_cost"}
            See `executed`.
        baseline : str, default="single regression"
            A method.

        Returns
        -------
        Comparison
            The ratio and its interval.
        """
        names = {"error_cm": "execution error", "excess_cost": "excess cost"}
        errors = self.executed_by_method(column)
        return self._compare(names[column], errors, baseline)

    def _compare(self, measure: str, errors: pd.DataFrame, baseline: str) -> Comparison:
        return compare(
            measure,
            errors,
            "charts",
            baseline,
            n_resamples=self.n_resamples,
            seed=self.seed,
        )
