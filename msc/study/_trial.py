"""One training set: the methods fitted to it, what they predict, what that does."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from msc.data import find_jumps, load_dataset
from msc.robot import Workspace
from msc.study._execution import execute_policies
from msc.study._methods import METHODS, N_CHARTS, fit_methods
from msc.study._sampling import take_evenly

TEST_SUBSETS = ("gate learned", "chart known", "away from jumps", "beside jumps")
_SIDE = 1e-9  # rad; a test task is predicted from so far before and behind it
_OTHER = 1e-3  # of a weight; predictions so far apart are two


class Trial:
    """One world, one training set, the methods, tested on tasks off the grid.

    A test task may lie half-way between two training tasks, and which is nearest is
    then for rounding to say. So every test task is predicted twice, from just before it
    and from just behind it, and each prediction counts half.

    Parameters
    ----------
    name : {"free", "obstacles"}
        The workspace and its data.
    chosen : array_like of int, or int
        Indices of the grid tasks to train on; or how many, evenly spaced.
    n_charts : int or None, default=4
        Charts, as the paper's figures have them; None leaves it to the elbow.
    names : iterable of str, default=METHODS
        Which methods.
    seed : int, default=0
        Seed of the clustering.

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
        chosen: ArrayLike | int,
        *,
        n_charts: int | None = N_CHARTS,
        names: Iterable[str] = METHODS,
        seed: int = 0,
    ) -> None:
        self.workspace = Workspace.named(name)
        self.n_charts, self.names, self.seed = n_charts, tuple(names), seed
        self.tasks, self.policies, self.table = load_dataset(name)
        test = load_dataset(f"{name}_test")
        self.test_tasks, self.test_policies, self.test_table = test
        self.jumps = find_jumps(self.tasks, self.policies)
        if np.ndim(chosen) == 0:
            chosen = take_evenly(self.tasks, chosen)  # type: ignore[arg-type]
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
    def methods(self) -> dict[str, Any]:
        """The fitted methods: ours, the single regressions, those to be beaten."""
        return fit_methods(
            self.tasks[self.chosen],
            self.policies[self.chosen],
            self.table["cost"].to_numpy()[self.chosen],
            n_charts=self.n_charts,
            seed=self.seed,
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
        nearest = np.linalg.norm(
            self.test_policies[:, None] - self.policies[self.chosen], axis=2
        ).argmin(axis=1)
        return np.asarray(self.methods["charts"].charts_[nearest])

    @cached_property
    def away_from_jumps(self) -> NDArray[np.bool_]:
        """Test tasks farther from every jump than training tasks lie apart, on average.

        The same tasks whichever set of a size is drawn. Where sets are drawn at random,
        some training tasks lie farther apart, with a jump and an "away" task between.
        """
        step = 2 * np.pi / self.n_samples
        places = (self.tasks[self.jumps] + self.tasks[self.jumps + 1]) / 2
        gaps = np.abs(self.test_tasks - places.reshape(1, -1))
        return np.asarray((gaps > step + _SIDE).all(axis=1))

    def _from_both_sides(self, name: str, **known: Any) -> NDArray[np.float64]:
        """Predict the test tasks (2, n_test_tasks, n_params)."""
        sides = [self.test_tasks - _SIDE, self.test_tasks + _SIDE]
        return np.stack([self.methods[name].predict(side, **known) for side in sides])

    @cached_property
    def _predictions(self) -> dict[str, NDArray[np.float64]]:
        return {name: self._from_both_sides(name) for name in self.methods}

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
            known = self._from_both_sides("charts", chart=self.known_charts)
            predictions["charts"] = known
        units = self.policies.var(axis=0) if standardised else 1.0
        errors = {
            name: np.mean((predicted - self.test_policies) ** 2 / units, axis=(0, 2))
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
            self._execute(*sides).assign(method=name)
            for name, sides in self._predictions.items()
        ]
        return pd.concat(tables, ignore_index=True)

    def _execute(
        self, before: NDArray[np.float64], behind: NDArray[np.float64]
    ) -> pd.DataFrame:
        """Execute predictions; of two for a task the mean, and any contact, counts."""
        done = execute_policies(self.workspace, before, self.test_table)
        other = np.abs(behind - before).max(axis=1) > _OTHER
        table = self.test_table[other]
        again = execute_policies(self.workspace, behind[other], table)
        for column in ("error_cm", "excess_cost"):
            done.loc[other, column] = (done.loc[other, column] + again[column]) / 2
        done.loc[other, "touched"] |= again["touched"]
        return done

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


class Measure(NamedTuple):
    """What is measured of every method.

    Attributes
    ----------
    key : str
        Its name in result files.
    name : str
        What it is called in a table.
    errors : callable
        Takes a trial; one row a test task, one column a method.
    unit : str
        Of what it counts; policy weights have none.
    has_ratio : bool
        Whether methods are divided by each other; a share is often zero.
    is_spread : bool
        Whether it is the standard deviation over the test tasks, not their mean.
    of : str
        What the mean squared error is taken of.
    """

    key: str
    name: str
    errors: Callable[[Trial], pd.DataFrame]
    unit: str = ""
    has_ratio: bool = True
    is_spread: bool = False
    of: str = ""

    @property
    def label(self) -> str:
        """What it is called, with its unit."""
        return f"{self.name} ({self.unit})" if self.unit else self.name

    @property
    def axis(self) -> str:
        """What an axis says."""
        return f"mean squared error\nof {self.of}" if self.of else self.label


_ERROR = partial(Trial.executed_by_method, column="error_cm")
MEASURES = {
    one.key: one
    for one in (
        *(
            Measure(
                f"mse, {subset}",
                f"MSE, {subset}",
                partial(Trial.squared_errors, subset=subset),
                of=f"policies, {subset}",
            )
            for subset in TEST_SUBSETS
        ),
        Measure(
            "standardised mse, gate learned",
            "standardised MSE, gate learned",
            partial(Trial.squared_errors, standardised=True),
            of="standardised policies, gate learned",
        ),
        Measure("error_cm", "distance at the end", _ERROR, "cm"),
        Measure(
            "excess_cost",
            "excess cost",
            partial(Trial.executed_by_method, column="excess_cost"),
        ),
        Measure(
            "under_1_cm", "under_1_cm", lambda trial: _ERROR(trial) < 1, has_ratio=False
        ),
        Measure(
            "touched",
            "touched",
            partial(Trial.executed_by_method, column="touched"),
            has_ratio=False,
        ),
        Measure(
            "error_cm spread",
            "spread of distances at the end",
            _ERROR,
            "cm",
            is_spread=True,
        ),
    )
}
