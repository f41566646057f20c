"""Pictures by casting rays at a round table and at what stands and lies on it.

Two shapes suffice, upright cylinders and lying rods, and where a ray meets one is a
formula: no meshes, no graphics card, and the same bytes every time. Each pixel averages
nine rays, so edges are smooth. Lengths are in metres; z points up from the table.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

TABLE_RADIUS, TABLE_THICKNESS = 0.90, 0.05
TABLE_COLOUR, EDGE_COLOUR = (0.93, 0.93, 0.92), (0.42, 0.42, 0.42)
SIDE = 3  # rays per pixel, in each direction

_EYE, _AT, _SPREAD = np.array([0.0, -1.9, 3.0]), np.array([0.0, -0.10, 0.0]), 0.266
_LIGHT = np.array([-0.42, 0.34, 0.84])  # towards it; of length 1
_SLANT = -_LIGHT[:2] / _LIGHT[2]  # where a shadow falls, per height
_ROUNDING = 0.005  # of the upper edge of cylinders

Span = tuple[float, float]
Colour = tuple[float, float, float]
_Array = NDArray[np.float32]
_Window = tuple[slice, slice]


class Canvas:
    """What the rays of one tilted view see so far; at first, an empty table.

    Colours are tuples of red, green and blue, from 0 to 1.

    Parameters
    ----------
    size : int
        Width and height of the picture (pixels).

    Examples
    --------
    >>> canvas = Canvas(60)
    >>> canvas.cylinder((0, 0), 0.3, (0, 0.1), colour=(0.1, 0.1, 0.8))
    >>> canvas.develop().getpixel((30, 27))
    (38, 38, 213)
    """

    def __init__(self, size: int) -> None:
        n_rays = SIDE * size
        ahead = (_AT - _EYE) / np.linalg.norm(_AT - _EYE)
        right = np.array([1.0, 0.0, 0.0])
        self._axes = np.stack([right, np.cross(right, ahead), ahead])
        across = np.arange(1 - n_rays, n_rays, 2, dtype=np.float32) * _SPREAD / n_rays
        u, v = np.meshgrid(across, -across)
        axes = self._axes.astype(np.float32)[..., None, None]
        self._rays = u * axes[0] + v * axes[1] + axes[2]
        self._rays /= np.linalg.norm(self._rays, axis=0)
        self._floor = self._places(0.0)
        self._bare = np.hypot(*self._floor) < TABLE_RADIUS
        self._depth = np.full((n_rays, n_rays), np.inf, np.float32)
        self._colour = np.ones((n_rays, n_rays, 3), np.float32)
        below = np.hypot(*self._places(-TABLE_THICKNESS)) < TABLE_RADIUS
        self._colour[below] = EDGE_COLOUR
        self._colour[self._bare] = TABLE_COLOUR

    def copy(self) -> Canvas:
        """Return a canvas to draw more on, while this one stays as it is."""
        other = copy.copy(self)
        other._colour, other._depth = self._colour.copy(), self._depth.copy()
        return other

    def develop(self) -> Image.Image:
        """Average the rays of each pixel: the picture."""
        size = len(self._depth) // SIDE
        rows = self._colour.reshape(size, SIDE, -1).sum(axis=1)
        pixels = rows.reshape(size, size, SIDE, 3).sum(axis=2) * (255 / SIDE**2)
        return Image.fromarray(pixels.clip(0, 255).round().astype(np.uint8))

    def line(self, points: ArrayLike, width: float, colour: Colour) -> None:
        """Paint a line (m) on the table, as a filter: shadows stay on it."""
        covered = np.zeros_like(self._bare)
        for start, end in pairwise(np.asarray(points, dtype=float)):
            window = self._window([start, end], (0.0,), width)
            covered[window] |= _gap(self._floor[:, *window], start, end)[0] < width / 2
        self._colour[covered & self._bare] *= np.divide(colour, TABLE_COLOUR)

    def shadow(
        self, start: ArrayLike, end: ArrayLike, radius: float, heights: Span
    ) -> None:
        """Darken the table below a body, the more softly the higher it is (m)."""
        first = np.add(start, heights[0] * _SLANT)
        last = np.add(end, heights[1] * _SLANT)
        window = self._window([first, last], (0.0,), radius + 0.05)
        gap, along = _gap(self._floor[:, *window], first, last)
        blur = 0.004 + 0.3 * (heights[0] + along * (heights[1] - heights[0]))
        inside = np.clip(0.5 - (gap - radius) / (2 * blur), 0, 1)
        light = 1 - 0.45 * inside * inside * (3 - 2 * inside)
        self._colour[window] *= np.where(self._bare[window], light, 1)[..., None]

    def cylinder(
        self, centre: ArrayLike, radius: float, heights: Span, colour: Colour
    ) -> None:
        """Draw an upright cylinder between two heights (m)."""
        x, y = np.asarray(centre, dtype=float).tolist()
        window = self._window([[x, y]], heights, radius)
        dx, dy, dz = self._rays[:, *window]
        ox, oy, oz = (_EYE - (x, y, 0.0)).tolist()
        top = (heights[1] - oz) / dz
        rim = radius - np.hypot(ox + top * dx, oy + top * dy)
        a, b = dx * dx + dy * dy, ox * dx + oy * dy
        root = b * b - a * (ox * ox + oy * oy - radius * radius)
        side = (-b - np.sqrt(root.clip(min=0))) / a
        z = oz + side * dz
        beside = (root > 0) & (heights[0] < z) & (z < heights[1])
        far = np.where(rim > 0, top, side)
        lean = np.where(rim > 0, 0.7 * (1 - rim / _ROUNDING).clip(min=0), 1) / radius
        out = lean * (ox + far * dx), lean * (oy + far * dy)
        normal = np.stack([*out, (rim > 0).astype(np.float32)])
        self._cover(window, far, (rim > 0) | beside, normal, colour)

    def rod(
        self,
        start: ArrayLike,
        end: ArrayLike,
        radius: float,
        height: float,
        colour: Colour,
    ) -> None:
        """Draw a lying rod, open at its ends: a cylinder is to hide them."""
        along = np.subtract(end, start)
        length = float(np.hypot(*along))
        cos, sin = (along / length).tolist()
        window = self._window([start, end], (height,), 2 * radius)
        dx, dy, dz = self._rays[:, *window]
        ox, oy, oz = (_EYE - (*np.asarray(start), height)).tolist()
        d, o = cos * dy - sin * dx, cos * oy - sin * ox  # across the rod
        a, b = d * d + dz * dz, d * o + dz * oz
        root = b * b - a * (o * o + oz * oz - radius * radius)
        far = (-b - np.sqrt(root.clip(min=0))) / a
        place = cos * (ox + far * dx) + sin * (oy + far * dy)
        hit = (root > 0) & (place > 0) & (place < length)
        normal = np.stack([-sin * (o + far * d), cos * (o + far * d), oz + far * dz])
        self._cover(window, far, hit, normal, colour)

    def _cover(
        self,
        window: _Window,
        far: _Array,
        hit: NDArray[np.bool_],
        normal: _Array,
        colour: Colour,
    ) -> None:
        """Put a lit surface in front of what is farther away."""
        near = hit & (far < self._depth[window])
        self._depth[window][near] = far[near]
        normal = normal[:, near]
        normal /= np.linalg.norm(normal, axis=0)
        half = _LIGHT[:, None] - self._rays[:, *window][:, near]
        half /= np.linalg.norm(half, axis=0)
        facing = np.einsum("i,ij->j", _LIGHT, normal).clip(min=0)
        gloss = np.einsum("ij,ij->j", half, normal).clip(min=0) ** 30
        lit = 0.42 + 0.14 * normal[2] + 0.50 * facing
        shine = 0.16 * gloss[:, None]
        self._colour[window][near] = lit[:, None] * np.array(colour) + shine

    def _places(self, height: float) -> _Array:
        """Return where the rays pass a height, of shape (2, n_rays, n_rays)."""
        x, y, z = _EYE.tolist()
        far = (height - z) / self._rays[2]
        return np.stack([x + far * self._rays[0], y + far * self._rays[1]])

    def _window(
        self, points: Sequence[ArrayLike], heights: Sequence[float], margin: float
    ) -> _Window:
        """Return the part of the picture that holds points and what is near them."""
        corners = [(*point, h) for point in np.array(points) for h in heights]
        seen = self._axes @ (np.array(corners) - _EYE).T
        scale = len(self._depth) / 2 / _SPREAD
        places = seen[:2] / seen[2] * [[scale], [-scale]] + len(self._depth) / 2
        wide = scale * margin / (seen[2].min() - margin) + 1
        low = (places.min(axis=1) - wide).clip(min=0).astype(int)
        high = (places.max(axis=1) + wide).clip(min=0).astype(int)
        return slice(low[1], high[1]), slice(low[0], high[0])


def _gap(places: _Array, start: ArrayLike, end: ArrayLike) -> tuple[_Array, _Array]:
    """Measure how far places are from a line, and how far along it the nearest is."""
    (x0, y0), (dx, dy) = np.array([start, np.subtract(end, start)]).tolist()
    x, y = places[0] - x0, places[1] - y0
    along = ((x * dx + y * dy) / (dx * dx + dy * dy or 1.0)).clip(0, 1)
    return np.hypot(x - along * dx, y - along * dy), along
