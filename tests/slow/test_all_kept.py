"""What is committed of the methods: all of it summarised, each tier fitted again."""

import json

import pytest
from test_kept import KEPT, TIERS, WORLDS, at_root, fit_again  # noqa: F401

from msc.study import format_study, run_study


@pytest.mark.parametrize("world", WORLDS)
def test_studies_are_summaries_of_what_is_kept_of_all_methods(world):
    study = run_study(world, KEPT, names=[], profile="full")
    committed = (KEPT / f"study_{world}.json").read_text("utf-8")
    assert json.loads(format_study(study)) == json.loads(committed)


@pytest.mark.parametrize("world", WORLDS)
@pytest.mark.parametrize("tier", TIERS)
def test_one_training_set_of_each_tier_is_fitted_and_tested_again(world, tier):
    fit_again(world, tier)
