"""A disk that is almost full."""

import resource
from contextlib import contextmanager


@contextmanager
def disk_of(n_bytes):
    """Let no file grow longer, as a full disk would; Linux says "File too large"."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (n_bytes, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
