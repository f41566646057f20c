"""A mixture of movement primitives whose gate has practised."""

from __future__ import annotations

from numbers import Integral, Real
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import log_softmax, softmax
from sklearn.utils._param_validation import Interval

from msc._checks import RANDOM_STATE, RandomState, seed_of, validate_points
from msc.robot import DMP, Workspace
from msc.study.rivals._mixture import MovementMixture
from msc.study.rivals._trials import N_TOGETHER, Execute, Span, Trials, draw_tasks

Array = NDArray[np.float64]


class PractisedMixture(MovementMixture):
    """Have trials say how much of each stored movement a task gets.

    After Mülling, Kober, Kroemer and Peters: `MovementMixture`, practised.

    Parameters
    ----------
    workspace : Workspace, optional
        Where to execute; by default ``Workspace.free()``.
    execute : callable, optional
        Executes in its place: policies of shape (n, n_params) and tasks of shape (n,
        n_task_params) give n costs.
    width : float, default=0.3
        Width, > 0, of the gate before practice, in the unit of tasks (rad).
    n_rollouts : int, default=500
        Trials.
    n_together : int, default=9
        Trials that are executed before they are learned from.
    concentration : float, default=10.0
        How near, > 0, the shares of a trial are to the gate's. With very few a trial is
        of one movement, drawn by the gate; with very many of the gate's own mixture.
    temperature : float, default=None
        Cost, > 0, that divides a trial's reward by e. None: the median of the costs of
        all trials so far.
    strength : float, default=0.1
        How strongly, > 0, the gate is held to what it was before practice.
    span : tuple of (float, float), default=None
        Bounds of the tasks that are practised, drawn uniformly (rad), or two rows of
        them, a column each. None: from the least training task to the greatest.
    dmp : DMP, optional
        What a policy means; by default the workspace's.
    random_state : int, RandomState instance, Generator or None, default=None
        Draws tasks and shares.

    Attributes
    ----------
    primitives_, gate_weights_, n_features_in_
        As of `MovementMixture`.
    n_rollouts_ : int
        Rollouts spent on practice, not counting searches of the training set.

    Notes
    -----
    In trial t, on a task x_t, shares h_t are drawn from a Dirichlet distribution about
    those of the gate; the mixture of the stored movements with these shares is
    executed; its reward is r_t = exp(-cost_t / temperature). The gate is then regressed
    on the shares, weighted by rewards: its weights v maximise::

        sum_t r_t sum_i h_ti log g_i(x_t) - strength / 2 |v - v before practice|^2

    which is convex: multinomial logistic regression, to shares instead of classes. As
    the mean of the shares drawn is the gate's, rewards that are all alike move it
    nowhere in the mean. Movements that fail lose their tasks to neighbours, and where
    mixtures fail the gate gets steeper, so far as exponentials of linear functions can.

    Adapted: [1]_ keeps the scheme (trial, reward, reward-weighted regression of the
    gate's weights), but regresses each movement's weight by itself, where ours is the
    likelihood of all shares, and it explores by how balls happen to come, where a
    simulated arm has to vary the mixture. Left out: adding and dropping movements.

    References
    ----------
    .. [1] K. Mülling, J. Kober, O. Kroemer and J. Peters, "Learning to select and
       generalize striking movements in robot table tennis", The International Journal
       of Robotics Research 32, 2013.
    .. [2] J. Peters and S. Schaal, "Reinforcement learning by reward-weighted
       regression for operational space control", ICML 2007.

    Examples
    --------
    >>> import numpy as np
    >>> from msc.study.rivals import PractisedMixture
    >>> def execute(policies, X):
    ...     return (policies[:, 0] - 1.0) ** 2  # of the two, the second is always right
    >>> mixture = PractisedMixture(execute=execute, n_rollouts=90, random_state=0)
    >>> mixture = mixture.fit([[0.0], [1.0]], [[0.0], [1.0]])
    >>> bool(mixture.gate([[0.5]])[0, 1] > 0.6), mixture.n_rollouts_
    (True, 90)
    """

    _parameter_constraints: ClassVar[dict[str, list[Any]]] = {
        **MovementMixture._parameter_constraints,
        "n_rollouts": [Interval(Integral, 0, None, closed="left")],
        "n_together": [Interval(Integral, 1, None, closed="left")],
        "concentration": [Interval(Real, 0, None, closed="neither")],
        "temperature": [Interval(Real, 0, None, closed="neither"), None],
        "strength": [Interval(Real, 0, None, closed="neither")],
        "random_state": RANDOM_STATE,
    }

    def __init__(
        self,
        workspace: Workspace | None = None,
        *,
        execute: Execute | None = None,
        width: float = 0.3,
        n_rollouts: int = 500,
        n_together: int = N_TOGETHER,
        concentration: float = 10.0,
        temperature: float | None = None,
        strength: float = 0.1,
        span: Span | None = None,
        dmp: DMP | None = None,
        random_state: RandomState = None,
    ) -> None:
        super().__init__(width)
        self.workspace = workspace
        self.execute = execute
        self.n_rollouts = n_rollouts
        self.n_together = n_together
        self.concentration = concentration
        self.temperature = temperature
        self.strength = strength
        self.span = span
        self.dmp = dmp
        self.random_state = random_state

    def fit(self, X: Any, y: Any) -> Self:
        """Store the movements, and practise.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks.
        y : array-like of shape (n_tasks, n_params) or (n_tasks,)
            Policies.

        Returns
        -------
        PractisedMixture
            The fitted mixture.
        """
        super().fit(X, y)
        X = validate_points(self, X, reset=False)
        trials = Trials(self.workspace, self.execute, self.dmp)
        rng = np.random.default_rng(seed_of(self.random_state))
        movements = self.primitives_.reshape(len(X), -1)
        before, tasks = self.gate_weights_, X[:0]
        shares, costs = np.empty((0, len(X))), np.empty(0)
        while left := self.n_rollouts - trials.n_rollouts:
            new = draw_tasks(rng, min(left, self.n_together), X, self.span)
            drawn = draw_shares(rng, self.gate(new), self.concentration)
            paid = trials(drawn @ movements, new)
            tasks, shares = np.vstack([tasks, new]), np.vstack([shares, drawn])
            costs = np.append(costs, paid)
            fall = self.temperature or np.median(costs) or 1.0
            self.gate_weights_ = regress_gate(
                np.column_stack([np.ones(len(tasks)), tasks - self._centre]),
                shares,
                np.exp(-costs / fall),
                before,
                self.strength,
            )
        self.n_rollouts_ = trials.n_rollouts
        return self


def draw_shares(rng: np.random.Generator, shares: Array, concentration: float) -> Array:
    """Draw shares from Dirichlet distributions whose means are given, row by row."""
    # Gamma variates over their sum, in logarithms: of few counts they are too small.
    counts = np.maximum(concentration * shares, 1e-300)
    logs = np.log(rng.standard_gamma(counts + 1))
    logs -= rng.standard_exponential(counts.shape) / counts
    return np.asarray(softmax(logs, axis=1))


def regress_gate(
    seen: Array,
    shares: Array,
    rewards: Array,
    before: Array,
    strength: float,
) -> Array:
    """Return the likeliest weights of a gate, trials weighted by rewards."""

    def objective(flat: Array) -> tuple[float, Array]:
        weights = flat.reshape(before.shape)
        logs = log_softmax(seen @ weights.T, axis=1)
        moved = weights - before
        value = -(rewards[:, None] * shares * logs).sum()
        slope = (rewards[:, None] * (np.exp(logs) - shares)).T @ seen
        penalty = 0.5 * strength * (moved**2).sum()
        return float(value + penalty), (slope + strength * moved).ravel()

    options = {"maxiter": 1000, "ftol": 1e-13, "gtol": 1e-8}
    found = minimize(
        objective, before.ravel(), jac=True, method="L-BFGS-B", options=options
    )
    return np.asarray(found.x.reshape(before.shape))
