"""A command-line tool of Python in a process of its own, started without detours.

`python _tool.py MODULE:FUNCTION ARGUMENT …` calls a tool that makes the book. On their
way to it libraries do what no chapter and no page needs, and what takes seconds:

- jsonschema imports a grammar of internationalised addresses, if it finds one;
- pybtex asks what is installed, all of it, at each of a hundred plugins that it seeks;
- PyYAML reads in Python what it could read in C.
"""

import functools
import sys
from importlib import metadata
from pkgutil import resolve_name

import yaml


def main() -> None:
    """Take these ways round, then be the tool."""
    sys.path[0] = ""  # the working directory's code, as with `python -m`
    sys.modules["rfc3987_syntax"] = None  # type: ignore[assignment]
    metadata.entry_points = functools.cache(metadata.entry_points)  # type: ignore[assignment]
    yaml.SafeLoader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    del sys.argv[0]  # the tool's name takes its place
    resolve_name(sys.argv[0])()


if __name__ == "__main__":
    main()
