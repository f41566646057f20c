"""What the command line's modules share: options, and a check of where results go."""

import argparse
import tempfile
from pathlib import Path
from typing import TypeAlias

Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"


def add_profile(parser: argparse.ArgumentParser) -> None:
    """Add ``--profile``.

    Parameters
    ----------
    parser : ArgumentParser
        Parser of a command.
    """
    parser.add_argument("--profile", default="quick", help="quick (default) or full")


def add_seed(
    parser: argparse.ArgumentParser, seed: int = 0, what: str = "seed of every draw"
) -> None:
    """Add ``--seed``.

    Parameters
    ----------
    parser : ArgumentParser
        Parser of a command.
    seed : int, default=0
        The default.
    what : str
        Its meaning.
    """
    parser.add_argument("--seed", type=int, default=seed, help=f"{what} ({seed})")


def add_jobs(parser: argparse.ArgumentParser, what: str = "worker processes") -> None:
    """Add ``--jobs``.

    Parameters
    ----------
    parser : ArgumentParser
        Parser of a command.
    what : str
        Its meaning.
    """
    parser.add_argument("--jobs", type=int, default=2, help=f"{what} (2)")


def check_output(out: Path, suffix: str, *, jobs: int = 1, seed: int = 0) -> None:
    """Refuse, before hours of work, what would spoil its end.

    Parameters
    ----------
    out : Path
        The file to be written; its folder is made if it is missing.
    suffix : str
        How its name must end, in whatever case.
    jobs, seed : int
        Worker processes and the seed of every draw.

    Raises
    ------
    ValueError
        If an argument is not as wanted, or the file cannot be written.
    """
    if seed < 0:
        raise ValueError(f"seed={seed}; wanted 0 or more")
    if jobs < 1:
        raise ValueError(f"jobs={jobs}; wanted at least 1")
    if out.suffix.lower() != suffix.lower():
        raise ValueError(f"out={out}; wanted a name ending in {suffix}")
    if out.is_dir():
        raise ValueError(f"out={out} is a folder; wanted the name of a file")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=out.parent):
            pass
    except OSError as error:
        raise ValueError(
            f"out={out}: its folder cannot be written to: {error.strerror}"
        ) from None
