"""Tables of policies and results on disk, and the jumps in them."""

from typing import TYPE_CHECKING

from press._lazy import face

if TYPE_CHECKING:
    from msc.data._jumps import find_jumps, step_sizes
    from msc.data._results import (
        describe_origin,
        load_results,
        read_result,
    )
    from msc.data._tables import (
        WEIGHTS,
        Dataset,
        find_data,
        load_dataset,
        read_package,
        save_table,
    )
    from msc.data._toys import make_two_arcs

__all__, __getattr__, __dir__ = face(__name__, __file__)
