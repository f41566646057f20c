"""Rivals of the paper's method that need code of their own, a file each.

They follow scikit-learn's conventions as `msc.learn` does, and may take the `cost` of
each policy besides. `msc.study.METHODS` lists all that are compared.

The paper's section V
    `CrKR`; `isomap_skill` on the charts of `NeighbourComponents`; `MovementMixture`;
    `InvertedSweep`; `StoppedMovement`, which plans movements and predicts no policies
Knowing how movements end
    `GoalProjected`; `ConditionedProMP`
What one would try today
    `todays_methods`, among them `ChangePointProcess`
With rollouts of their own, which they count: `n_rollouts_`
    `PractisedCrKR`; `PractisedMixture`; `MultiTaskSearch`; `ContextualSearch`;
    `TriedSkill`, which executes to predict; and, as the start of a search,
    `MappedMovement`
How hyper-parameters are chosen
    `tune`, by `RANGES`, `N_TRIALS` and `N_FOLDS`; of those with rollouts
    `ChosenByTrial`, by `SETTINGS` and `N_CHECKS`, with the budgets `PRACTICE` and
    `SEARCH`: `practising_method`
"""

from typing import TYPE_CHECKING

from press import face

if TYPE_CHECKING:
    from msc.study.rivals._by_trial import (
        N_CHECKS,
        PRACTICE,
        SEARCH,
        SETTINGS,
        ChosenByTrial,
        practising_method,
    )
    from msc.study.rivals._changepoints import ChangePointProcess
    from msc.study.rivals._components import NeighbourComponents, isomap_skill
    from msc.study.rivals._constant import zero_policy
    from msc.study.rivals._contextual import ContextualSearch
    from msc.study.rivals._crkr import CrKR
    from msc.study.rivals._crkr_practice import PractisedCrKR
    from msc.study.rivals._interpolation import Interpolation
    from msc.study.rivals._mapping import MappedMovement
    from msc.study.rivals._mixture import MovementMixture
    from msc.study.rivals._mixture_practice import PractisedMixture
    from msc.study.rivals._multitask import MultiTaskSearch
    from msc.study.rivals._option import StoppedMovement
    from msc.study.rivals._projection import GoalProjected
    from msc.study.rivals._promp import ConditionedProMP
    from msc.study.rivals._sweep import InvertedSweep
    from msc.study.rivals._today import todays_method, todays_methods
    from msc.study.rivals._trial_gate import TriedSkill
    from msc.study.rivals._tuning import N_FOLDS, N_TRIALS, RANGES, tune

__all__, __getattr__, __dir__ = face(__name__, __file__)
