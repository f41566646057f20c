"""What the chapters measure: one experiment, its methods, their errors, compared."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import Any

import pandas as pd
from numpy.typing import ArrayLike

from msc.estimates import Estimate, compare
from msc.learn import SMCE
from msc.study._execution import summarise_execution
from msc.study._methods import COMMON, N_CHARTS
from msc.study._trial import TEST_SUBSETS, Trial

N_RESAMPLES = {"quick": 1_000, "full": 20_000}  # bootstrap resamples


class Experiment(Trial):
    """A trial on evenly spaced tasks, its errors summarised and compared.

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
        Which of `msc.study.METHODS`; by default not those with other kernels.
    profile : {"quick", "full"}, default="quick"
        How many bootstrap resamples an interval rests on.
    seed : int, default=0
        Seed of the clustering and the resampling.

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
        profile: str = "quick",
        seed: int = 0,
    ) -> None:
        if profile not in N_RESAMPLES:
            raise ValueError(f"profile={profile!r}; wanted 'quick' or 'full'")
        if (n_samples is None) == (chosen is None):
            raise ValueError(
                f"n_samples={n_samples!r}, chosen={chosen!r}; wanted one of the two"
            )
        training: Any = n_samples if chosen is None else chosen
        super().__init__(name, training, n_charts=n_charts, names=names, seed=seed)
        self.n_resamples = N_RESAMPLES[profile]

    @cached_property
    def elbow(self) -> int:
        """Number of charts that the elbow picks on the training policies."""
        charts = SMCE(random_state=self.seed).fit(self.policies[self.chosen])
        return int(charts.n_clusters_)

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
            See `msc.study.summarise_execution`.
        """
        return summarise_execution(self.executed)

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
        return self._compare(f"MSE, {subset}", errors, baseline)

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
        return self._compare(names[column], errors, baseline)

    def _compare(self, measure: str, errors: pd.DataFrame, baseline: str) -> Estimate:
        return compare(
            measure,
            errors,
            "charts",
            baseline,
            n_resamples=self.n_resamples,
            seed=self.seed,
        )
