"""Dynamic Movement Primitives (Eqs. 5-8): a policy -> a path of the end effector.

In the paper's letters, per dimension (dots restored):

    κ v̇ = K (g - x) - Q v + (g - x₀) f(s)      Eq. 5
    κ ẋ = v                                     Eq. 6
    f(s) = Σ wᵢ ψᵢ(s) / Σ ψᵢ(s),  κ ṡ = -α s    Eq. 7
    ψᵢ(s) = exp(-hᵢ (s - cᵢ)²)                  Eq. 8

The equations are linear in the weights, so x(t) = x₀ + (g - x₀) (a(t) + B(t) w): the
response ``a`` of the spring and the responses ``B`` of the basis functions are
integrated once, and every path after that is one matrix product.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc._checks import LARGEST, check_number, check_whole, to_floats

_BOUNDS = {
    "spring": (1e-2, 1e4),
    "damping": (1e-2, 1e3),
    "time_scale": (0.05, 100.0),
    "alpha": (1e-3, 100.0),
}
_N_BASIS = (2, 100)
_LAST = 20.0  # times the time scale

_Array = NDArray[np.float64]


@dataclass(frozen=True)
class DMP:
    """A planar Dynamic Movement Primitive.

    Parameters
    ----------
    spring : float, default=16.0
        Spring constant K (1/s² at unit `time_scale`), from 0.01 to 10,000. Slow on
        purpose: about a tenth of the way is left after one second unless the policy
        supplies it.
    damping : float, optional
        Damping Q, from 0.01 to 1000. By default critical, ``2 * sqrt(spring)``.
    time_scale : float, default=1.0
        Factor κ by which the movement is slowed down, from 0.05 to 100.
    alpha : float, default=log(100)
        Decay α of the phase, which falls from 1 to 1/100 in one second; from 0.001 to
        100.
    n_basis : int, default=3
        Basis functions per dimension, evenly spaced in time; from 2 to 100.
    gated : bool, default=False
        Multiply f by the phase s, as is usual but not as Eq. 7 is printed. Without it
        f does not vanish at the end, and the weights move the end point.

    Raises
    ------
    ValueError
        If a constant is beyond its bounds.

    Notes
    -----
    Within the bounds, and up to 20 time scales, the equations are integrated within a
    few seconds; beyond them it may take hours.

    Examples
    --------
    >>> path = DMP().path(np.zeros(6), start=[0, 0], goal=[1, 2], times=[0.0, 1.0, 9.0])
    >>> path.round(3)
    array([[0.   , 0.   ],
           [0.908, 1.817],
           [1.   , 2.   ]])
    """

    spring: float = 16.0
    damping: float | None = None
    time_scale: float = 1.0
    alpha: float = math.log(100)
    n_basis: int = 3
    gated: bool = False

    def __post_init__(self) -> None:
        """Refuse constants for which the equations make no movement."""
        for name, bounds in _BOUNDS.items():
            value = getattr(self, name)
            if value is not None or name != "damping":
                check_number(name, value, *bounds)
        check_whole("n_basis", self.n_basis, *_N_BASIS)
        if not isinstance(self.gated, bool | np.bool_):
            raise ValueError(f"gated={self.gated!r}; wanted True or False")

    @property
    def n_params(self) -> int:
        """Length of a policy: the weights of both dimensions."""
        return 2 * self.n_basis

    def path(
        self, policy: ArrayLike, start: ArrayLike, goal: ArrayLike, times: ArrayLike
    ) -> NDArray[np.float64]:
        """Trace the movement that a policy describes.

        Parameters
        ----------
        policy : array_like of shape (n_params,) or (n_policies, n_params)
            Weights of Eq. 7, those of x before those of y.
        start, goal : array_like of shape (2,) or (n_policies, 2)
            Where the movement starts and where the spring pulls (m).
        times : array_like of shape (n_times,)
            Ascending times from the start (s), none past 20 times `time_scale`.

        Returns
        -------
        ndarray of shape (n_times, 2) or (n_policies, n_times, 2)
            Positions (m).

        Raises
        ------
        ValueError
            If the policy has another length, an argument is not finite, too large or
            not shaped as wanted, or the equations cannot be integrated with these
            constants.
        """
        weights = check_policies(policy, self.n_params)
        moments = to_floats("times", times)
        if moments.ndim != 1:
            raise ValueError(f"times has shape {moments.shape}; wanted (n_times,)")
        for name, point in (("start", start), ("goal", goal)):
            place = to_floats(name, point)
            if place.shape[-1:] != (2,) or not (np.abs(place) <= LARGEST).all():
                raise ValueError(
                    f"{name}={point!r}; wanted finite x and y, at most {LARGEST:g} m"
                )
            few = weights.ndim > 1 and place.ndim > 1 and len(place) > 1
            if place.ndim > 2 or (few and len(place) != len(weights)):
                raise ValueError(
                    f"{name} has shape {place.shape}; wanted (2,), or a place for each "
                    f"policy: policy has shape {weights.shape}"
                )
        pull, basis = _responses(self, tuple(moments.tolist()))
        weights = weights.reshape(*weights.shape[:-1], 2, self.n_basis)
        shape = pull[:, None] + np.einsum("tb,...db->...td", basis, weights)
        start = to_floats("start", start)[..., None, :]
        goal = to_floats("goal", goal)[..., None, :]
        return np.asarray(start + (goal - start) * shape)

    def forcing_basis(self, phase: ArrayLike) -> NDArray[np.float64]:
        """Evaluate the normalised basis functions.

        Parameters
        ----------
        phase : array_like of shape (n_times,)
            The phase s.

        Returns
        -------
        ndarray of shape (n_times, n_basis)
            Shares ψᵢ / Σ ψ, times s if gated.

        Raises
        ------
        ValueError
            If a phase is not finite or beyond a thousand million, they have another
            shape, or all basis functions are zero at one.
        """
        phases = to_floats("phase", phase)
        if phases.ndim != 1 or not (np.abs(phases) <= LARGEST).all():
            raise ValueError(
                f"phase={phase!r}; wanted finite numbers of shape (n_times,), at most "
                f"{LARGEST:g}"
            )
        s = phases[:, None]
        c = np.exp(-self.alpha * np.arange(self.n_basis) / (self.n_basis - 1))
        h = 1 / np.diff(c) ** 2
        psi = np.exp(-np.append(h, h[-1]) * (s - c) ** 2)  # Eq. 8
        if not psi.sum(axis=1).all():
            raise ValueError(f"{self}: at some phase all basis functions are zero")
        f = psi / psi.sum(axis=1, keepdims=True)  # Eq. 7
        return np.asarray(f * s if self.gated else f)


def check_policies(
    policy: ArrayLike, n_params: int, *, single: bool = False
) -> NDArray[np.float64]:
    """Return the policy or policies as floats, or say what is wrong with them.

    Parameters
    ----------
    policy : array_like of shape (n_params,) or (n_policies, n_params)
        What was given.
    n_params : int
        The length that is wanted.
    single : bool, default=False
        Whether it has to be one policy.

    Returns
    -------
    ndarray
        The same numbers.

    Raises
    ------
    ValueError
        If the shape is another, or a number is not real or beyond a thousand million,
        where floats no longer tell a path's micrometres.

    Examples
    --------
    >>> check_policies([0, 1], n_params=6)
    Traceback (most recent call last):
    ...
    ValueError: policy has shape (2,); wanted (6,) or (n_policies, 6)
    """
    policies = np.asarray(to_floats("policy", policy), order="C")  # to the last bit
    several = "" if single else f" or (n_policies, {n_params})"
    dimensions = (1,) if single else (1, 2)
    if policies.ndim not in dimensions or policies.shape[-1] != n_params:
        raise ValueError(
            f"policy has shape {policies.shape}; wanted ({n_params},){several}"
        )
    if not np.isfinite(policies).all():
        raise ValueError("policy has NaN or infinite weights; wanted finite numbers")
    largest = np.abs(policies).max(initial=0.0)
    if largest > LARGEST:
        raise ValueError(
            f"policy has a weight of magnitude {largest:g}; wanted at most {LARGEST:g}"
        )
    return policies


@lru_cache(maxsize=32)
def _responses(dmp: DMP, times: tuple[float, ...]) -> tuple[_Array, _Array]:
    """Integrate the spring's response (n_times,) and the basis' (n_times, n_basis)."""
    from scipy.integrate import solve_ivp  # noqa: PLC0415

    ascending = times and times[0] >= 0 and all(np.diff(times) > 0)
    if not ascending or not math.isfinite(times[-1]):
        raise ValueError("times: wanted ascending times, none before 0")
    if times[-1] > _LAST * dmp.time_scale:
        raise ValueError(
            f"times: the last is {times[-1]:g} s; wanted at most {_LAST:g} times the "
            f"time_scale, {_LAST * dmp.time_scale:g} s"
        )
    damping = 2 * math.sqrt(dmp.spring) if dmp.damping is None else dmp.damping
    n = 1 + dmp.n_basis

    def rates(time: float, state: _Array) -> _Array:
        x, v = state[:n], state[n:]
        s = math.exp(-dmp.alpha * time / dmp.time_scale)
        force = np.append(dmp.spring, dmp.forcing_basis([s])[0])
        dv = force - dmp.spring * x - damping * v  # Eq. 5, one row per response
        return np.concatenate([v, dv]) / dmp.time_scale  # Eq. 6

    span, exactly = (0.0, max(times[-1], 1e-9)), {"rtol": 1e-10, "atol": 1e-12}
    solution = solve_ivp(rates, span, np.zeros(2 * n), "DOP853", times, **exactly)
    if not (solution.success and np.isfinite(solution.y).all()):
        raise ValueError(f"{dmp}: cannot be integrated: {solution.message}")
    x = solution.y[:n].T
    x.setflags(write=False)  # kept for all that ask
    return x[:, 0], x[:, 1:]
