"""scikit-learn's checks of weights, for estimators that refuse some."""

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
