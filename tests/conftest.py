"""What holds for all tests.

Hypothesis tries the same examples everywhere: what passes once passes again. Ctrl-C is
not ignored, as it is in what a shell starts in the background: programs that the tests
start would ignore it as well.
"""

import signal

from hypothesis import settings

settings.register_profile("same", derandomize=True)
settings.load_profile("same")
signal.signal(signal.SIGINT, signal.default_int_handler)
