"""scikit-learn's checks, for estimators of which some need not hold."""

import pytest

REFUSED = dict.fromkeys(
    (
        "check_all_zero_sample_weights_error",
        "check_sample_weight_equivalence_on_dense_data",
        "check_sample_weights_list",
        "check_sample_weights_not_an_array",
        "check_sample_weights_not_overwritten",
        "check_sample_weights_pandas_series",
        "check_sample_weights_shape",
    ),
    "what learns here takes no weights, which is told",
)


def hold(check, estimator, failing):
    """Run a check; one that need not hold has to fail.

    If it were marked so, pytest would parse the sources of all that led to the failure.
    """
    if check.func.__name__ not in failing:
        check(estimator)
        return
    with pytest.raises((AssertionError, TypeError, ValueError)):
        check(estimator)
