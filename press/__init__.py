"""Notebooks -> the book: executed, rendered, packed. Imports nothing of `msc`."""

from typing import TYPE_CHECKING

from press._lazy import face

if TYPE_CHECKING:
    from press._chapters import BookError
    from press._checks import expect
    from press._files import (
        checksum,
        locked,
        replace_file,
        replace_files,
        write_json,
    )
    from press._markdown import label, paragraph, plain
    from press._options import (
        Commands,
        add_jobs,
        add_profile,
        add_seed,
        check_output,
    )
    from press._parameters import check_parameters
    from press.cli import COMMANDS

__all__, __getattr__, __dir__ = face(__name__, __file__)
