"""Hypothesis tries the same examples everywhere: what passes once passes again."""

from hypothesis import settings

settings.register_profile("same", derandomize=True)
settings.load_profile("same")
