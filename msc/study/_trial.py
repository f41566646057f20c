"""One training set: the methods fitted to it, what they predict, what that does."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from msc.data import Dataset, find_jumps, load_dataset
from msc.estimates import Estimate, compare
from msc.learn import SMCE
from msc.robot import Workspace
from msc.study._measure import (
    SIDE,
    execute_both,
    known_charts,
    predict_from_both_sides,
    squared_error,
)
from msc.study._methods import COMMON, fit_methods
from msc.study._sampling import TEST_SUBSETS, take_evenly
from msc.study._setting import N_CHARTS


class Experiment:
    """One world, one training set, the methods, tested on tasks off the grid.

    A test task may lie half-way between two training tasks, and which is nearest is
    then for rounding to say. So every test task is predicted twice, from just before it
    and from just behind it, and each prediction counts half.

    Parameters
    ----------
    name : {"free", "obstacles"}
        The workspace and its data.
    n_samples : int, optional
        Training tasks, evenly spaced over the circle; or else `chosen`.
    chosen : array_like of int, optional
        Indices of the grid tasks to train on.
    n_charts : int or None, default=4
        Charts, as the paper's figures have them; None leaves it to the elbow.
    names : iterable of str, default=COMMON
        Which of `msc.study.METHODS`; by default those tried on all training sets.
    seed : int, default=0
        Seed of the clustering.
    datasets : (Dataset, Dataset), optional
        Grid and test tasks, if they are loaded already.

    Attributes
    ----------
    tasks, policies, table : ndarray, ndarray, DataFrame
        All grid tasks (rad), shape (n_grid, 1), their policies, shape (n_grid,
        n_params), and what else is known of them.
    chosen : ndarray of shape (n_samples,)
        Indices of those trained on, ascending.
    test_tasks, test_policies, test_table : ndarray, ndarray, DataFrame
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
        n_samples: int | None = None,
        chosen: ArrayLike | None = None,
        n_charts: int | None = N_CHARTS,
        names: Iterable[str] = COMMON,
        seed: int = 0,
        datasets: tuple[Dataset, Dataset] | None = None,
    ) -> None:
        if (n_samples is None) == (chosen is None):
            raise ValueError(
                f"n_samples={n_samples!r}, chosen={chosen!r}; wanted one of the two"
            )
        self.workspace = Workspace.named(name)
        self.n_charts, self.names, self.seed = n_charts, tuple(names), seed
        grid, test = datasets or (load_dataset(name), load_dataset(f"{name}_test"))
        self.tasks, self.policies, self.table = grid
        self.test_tasks, self.test_policies, self.test_table = test
        self.jumps = find_jumps(self.tasks, self.policies)
        if n_samples is not None:
            chosen = take_evenly(self.tasks, n_samples)
        indices, last = np.sort(np.asarray(chosen)).tolist(), len(self.tasks) - 1
        if len(set(indices)) < len(indices) or not set(indices) <= {*range(last + 1)}:
            raise ValueError(
                f"chosen={indices}; wanted different whole numbers from 0 to {last}"
            )
        self.chosen = np.array(indices, dtype=np.intp)

    @property
    def n_samples(self) -> int:
        """Number of training tasks."""
        return len(self.chosen)

    @cached_property
    def elbow(self) -> int:
        """Number of charts that the elbow picks on the training policies."""
        charts = SMCE(random_state=self.seed).fit(self.policies[self.chosen])
        return int(charts.n_clusters_)

    @cached_property
    def methods(self) -> dict[str, Any]:
        """The fitted methods: ours, the single regressions, those to be beaten."""
        return fit_methods(
            self.tasks[self.chosen],
            self.policies[self.chosen],
            self.table["cost"].to_numpy()[self.chosen],
            n_charts=self.n_charts,
            seed=self.seed,
            workspace=self.workspace,
            names=self.names,
        )

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

        Only the subset "chart known" may look at a test task's policy.
        """
        trained = self.policies[self.chosen]
        return known_charts(self.methods["charts"], trained, self.test_policies)

    @cached_property
    def away_from_jumps(self) -> NDArray[np.bool_]:
        """Test tasks farther from every jump than training tasks lie apart, on average.

        The same tasks whichever set of a size is drawn. Where sets are drawn at random,
        some training tasks lie farther apart, with a jump and an "away" task between.
        """
        return away_from_jumps(self.tasks, self.jumps, self.test_tasks, self.n_samples)

    @cached_property
    def _predictions(self) -> dict[str, NDArray[np.float64]]:
        return {
            name: predict_from_both_sides(method, self.test_tasks)
            for name, method in self.methods.items()
        }

    def squared_errors(
        self, subset: str = "gate learned", *, standardised: bool = False
    ) -> pd.DataFrame:
        """Compare predicted with searched policies, one row a test task.

        Parameters
        ----------
        subset : {"gate learned", "chart known", "away from jumps", "beside jumps"}
            Which chart a test task belongs to, and which test tasks count.
        standardised : bool, default=False
            Whether each dimension is divided by its variance over the grid first.

        Returns
        -------
        DataFrame
            Squared errors, averaged over the six dimensions, one column a method.

        Raises
        ------
        ValueError
            If the subset is another.
        """
        if subset not in TEST_SUBSETS:
            raise ValueError(f"subset={subset!r}; wanted one of {TEST_SUBSETS}")
        predictions = dict(self._predictions)
        if subset == "chart known" and "charts" in predictions:
            predictions["charts"] = predict_from_both_sides(
                self.methods["charts"], self.test_tasks, chart=self.known_charts
            )
        units = self.policies.var(axis=0) if standardised else 1.0
        errors = {
            name: squared_error(predicted, self.test_policies, units)
            for name, predicted in predictions.items()
        }
        table = pd.DataFrame(errors, index=self.test_table["task_deg"])
        if subset == "away from jumps":
            return table[self.away_from_jumps]
        return table[~self.away_from_jumps] if subset == "beside jumps" else table

    @cached_property
    def executed(self) -> pd.DataFrame:
        """What happens when predicted policies are run: one row a task and method."""
        tables = [
            execute_both(self.workspace, both, self.test_table).assign(method=name)
            for name, both in self._predictions.items()
        ]
        return pd.concat(tables, ignore_index=True)

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
        """Average the squared errors, one row a method, one column a test subset.

        Returns
        -------
        DataFrame
            Mean squared errors; "chart known" differs for the charts alone. A subset
            that has no test task, as beside jumps where there are none, is left out.
        """
        means = {subset: self.squared_errors(subset).mean() for subset in TEST_SUBSETS}
        return pd.DataFrame(means).loc[list(self.methods)].dropna(axis="columns")

    def executed_summary(self) -> pd.DataFrame:
        """Summarise what execution costs, one row a method.

        Returns
        -------
        DataFrame
            Excess cost (mean, median), centimetres (mean, standard deviation, median,
            95th percentile), the share of tasks missed by less than 1 cm, and that
            which met an obstacle.
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
                "error (cm), 95 %": error.quantile(0.95),
                "share under 1 cm": error.agg(lambda cm: float((cm < 1).mean())),
                "share that touched": groups["touched"].mean(),
            }
        )

    def compare_mse(
        self, subset: str = "gate learned", baseline: str = "single regression"
    ) -> Estimate:
        """Compare the charts' mean squared error with a baseline's.

        Parameters
        ----------
        subset : str, default="gate learned"
            See `squared_errors`.
        baseline : str, default="single regression"
            A method.

        Returns
        -------
        Estimate
            The ratio and its interval.
        """
        errors = self.squared_errors(subset)
        return compare(f"MSE, {subset}", errors, "charts", baseline)

    def compare_executed(
        self, column: str, baseline: str = "single regression"
    ) -> Estimate:
        """Compare what the charts' policies do when executed with a baseline's.

        Parameters
        ----------
        column : {"error_cm", "excess_cost"}
            See `executed`.
        baseline : str, default="single regression"
            A method.

        Returns
        -------
        Estimate
            The ratio and its interval.
        """
        names = {"error_cm": "execution error", "excess_cost": "excess cost"}
        errors = self.executed_by_method(column)
        return compare(names[column], errors, "charts", baseline)


def away_from_jumps(
    tasks: NDArray[np.float64],
    jumps: NDArray[np.intp],
    test_tasks: NDArray[np.float64],
    n_samples: int,
) -> NDArray[np.bool_]:
    """Tell which test tasks are farther from every jump than n samples lie apart."""
    places = (tasks[jumps] + tasks[jumps + 1]) / 2
    gaps = np.abs(test_tasks - places.reshape(1, -1))
    return np.asarray((gaps > 2 * np.pi / n_samples + SIDE).all(axis=1))
