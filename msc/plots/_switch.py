"""A figure drawn in more ways than one: the reader chooses, paper shows them all."""

from __future__ import annotations

import hashlib
import html
import io
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from msc.plots._style import encode_png

_LOOK: Any = {"dpi": 150, "bbox_inches": "tight"}  # as of other figures


@dataclass(frozen=True)
class Switch:
    """Figures of which a page shows one, and buttons that choose it; without a script.

    Parameters
    ----------
    name : str
        What the reader chooses, as "axis".
    figures : mapping of str to Figure
        By what the buttons say; the first is shown at first, and where there is no
        HTML.
    alt : str
        What any of them shows, for those who do not see it; a button's words follow.
    """

    name: str
    figures: Mapping[str, Figure]
    alt: str

    def __post_init__(self) -> None:
        """Refuse a switch that switches nothing."""
        if len(self.figures) < 2:
            raise ValueError(
                f"figures: {len(self.figures)} of them; wanted two at least"
            )

    def _draw(self) -> dict[str, str]:
        """Draw all figures (base 64)."""
        return {name: encode_png(one, **_LOOK) for name, one in self.figures.items()}

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        """Show the page's HTML, or the first figure where there is none."""
        pictures = self._draw()
        file = io.StringIO()
        first = next(iter(self.figures.values()))
        first.savefig(file, format="svg", bbox_inches="tight", metadata={"Date": None})
        return {
            "text/html": self.to_html(pictures),
            "image/png": next(iter(pictures.values())),
            "image/svg+xml": file.getvalue(),
            "text/plain": f"{self.alt} {self.name}: {', '.join(self.figures)}.",
        }

    def to_html(self, pictures: Mapping[str, str] | None = None) -> str:
        """Write a piece of HTML that needs no other file.

        Parameters
        ----------
        pictures : mapping of str to str, optional
            The figures as PNG (base 64), if they are drawn already.

        Returns
        -------
        str
            Buttons of one choice, and after all of them the pictures in their order.
        """
        if pictures is None:
            pictures = self._draw()
        together = hashlib.sha256("".join(pictures.values()).encode())
        group = f"switch-{together.hexdigest()[:8]}"
        buttons = "".join(
            f'<label><input type="radio" name="{group}"'
            f'{" checked" * (number == 0)} autocomplete="off"> '
            f"{html.escape(label)}</label>"
            for number, label in enumerate(pictures)
        )
        views = "".join(
            f'<div><p aria-hidden="true">{html.escape(f"{self.name}: {label}")}</p>'
            f'<img alt="{html.escape(f"{self.alt} {self.name}: {label}.")}" '
            f'src="data:image/png;base64,{picture}"></div>'
            for label, picture in pictures.items()
        )
        name = html.escape(self.name)
        return (
            f'<div class="msc-switch" role="group" aria-label="{name}">'
            f"<span>{name}</span>{buttons}{views}</div>"
        )
