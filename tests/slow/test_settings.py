"""The chapters with a hundred legal settings, each run as a reader would."""

from pathlib import Path

import pytest
from settings import CHAPTERS, ONCE_DIED, draw_settings

from press._chapters import run_chapters
from press._notebook import complaints

ROOT = Path(__file__).parents[2]
SETTINGS = [*ONCE_DIED, *draw_settings(100, seed=14)]


@pytest.mark.parametrize(("name", "values"), SETTINGS)
def test_a_legal_setting_runs(name, values, tmp_path):
    [done] = run_chapters({CHAPTERS[name]: values}, root=ROOT, cache=tmp_path)
    assert not complaints(done.notebook)
