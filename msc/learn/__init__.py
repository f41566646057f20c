"""Tasks and policies -> charts -> a skill; knows no robot.

`SMCE` finds the charts of the manifold on which policies lie: every point is written as
an affine combination of its neighbours (`reconstruct`), points that reconstruct each
other are joined in a graph, and the graph is cut into charts. `ParameterizedSkill`
regresses on each chart by itself and asks a *gate* which chart a task is on. Both
follow scikit-learn's conventions, and take any arrays:

    ===================  ==========================================================
    ``X``, in a skill    tasks: (n_tasks, n_task_params), in radians
    ``y``, in a skill    policies: (n_tasks, n_params)
    ``X``, in SMCE       points: (n_samples, n_features), a skill's policies
    ``coef_``            row i reconstructs point i: c of Eq. 3
    ``labels_``          chart of each point, from 0 on
    ``elbow_curve_``     from which the number of charts is read, see `elbow`
    ===================  ==========================================================
"""

from typing import TYPE_CHECKING

from press import face

if TYPE_CHECKING:
    from msc.learn._copies import find_copies
    from msc.learn._elbow import SELECTION_CRITERIA, elbow, knee
    from msc.learn._gaussian import gaussian_process
    from msc.learn._reconstruction import reconstruct
    from msc.learn._skill import GATES, ParameterizedSkill, seeded_clone
    from msc.learn._smce import SMCE
    from msc.learn._spectral import cluster_graph, within_cluster_ss
    from msc.learn._weights import validate_weights

__all__, __getattr__, __dir__ = face(__name__, __file__)
