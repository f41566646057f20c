"""A figure drawn in more ways than one: the reader chooses, paper shows them all."""

from __future__ import annotations

import base64
import hashlib
import html
import io
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

_DPI = 150  # as of other figures


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

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        """Show the page's HTML, or the first figure where there is none."""
        pictures = {label: _draw(figure) for label, figure in self.figures.items()}
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
            pictures = {label: _draw(figure) for label, figure in self.figures.items()}
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


def _draw(figure: Figure) -> str:
    """Draw a figure as PNG (base 64)."""
    file = io.BytesIO()
    look: Any = {"dpi": _DPI, "bbox_inches": "tight"}
    figure.savefig(file, format="png", metadata={"Software": None}, **look)
    return base64.b64encode(file.getvalue()).decode()
