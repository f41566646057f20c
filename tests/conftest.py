"""What holds for all tests.

Hypothesis tries the same examples everywhere: what passes once passes again. Ctrl-C is
not ignored, as it is in what a shell starts in the background: programs that the tests
start would ignore it as well. What takes longest comes first, so that no process waits
for another at the end. And jsonschema imports a grammar of internationalised addresses
if it finds one, which takes seconds; no notebook needs it.
"""

import signal
import sys

from hypothesis import settings

LONGEST = (
    "test_study",
    "test_skill",
    "test_book",
    "test_legible",
    "test_fit",
    "test_cluster",
)

settings.register_profile("same", derandomize=True)
settings.load_profile("same")
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.modules["rfc3987_syntax"] = None


def pytest_collection_modifyitems(items):
    """Put the longest files before the others."""
    items.sort(key=lambda item: item.path.stem not in LONGEST)
