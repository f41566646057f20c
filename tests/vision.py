"""How colours look: in grey, and to those who see fewer of them.

Colours are linear RGB here but for their names. The matrices simulate the loss of one
kind of cone; they are the last rows, of full severity, of the table in G. M. Machado,
M. M. Oliveira, L. A. F. Fernandes, "A physiologically-based model for simulation of
color vision deficiency", IEEE Trans. Vis. Comput. Graph. 15(6), 2009.
"""

from itertools import combinations

import numpy as np
from matplotlib.colors import to_rgb

VISIONS = {
    "all cones": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}
XYZ = np.array(  # of sRGB's primaries, white D65 (IEC 61966-2-1)
    [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
)


def linear(colour):
    """Return a colour's linear RGB."""
    rgb = np.array(to_rgb(colour))
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


def luminance(colour):
    """Return what is left of a colour in grey, from 0 to 1."""
    return float(XYZ[1] @ linear(colour))


def contrast(colour, other="white"):
    """Return the contrast of two colours, from 1 to 21 (WCAG 2.2)."""
    low, high = sorted((luminance(colour), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def lab(colour, vision="all cones"):
    """Return CIELAB's lightness, red against green, yellow against blue."""
    seen = np.clip(VISIONS[vision] @ linear(colour), 0, 1)
    share = XYZ @ seen / XYZ.sum(axis=1)
    small = share <= (6 / 29) ** 3
    x, y, z = np.where(small, share * (29 / 6) ** 2 / 3 + 4 / 29, np.cbrt(share))
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def distance(colour, other, vision="all cones"):
    """Return how different two colours look; two is just noticeable (CIE 1976)."""
    return float(np.linalg.norm(lab(colour, vision) - lab(other, vision)))


def closest(colours, vision="all cones"):
    """Return the smallest distance of any two colours."""
    pairs = combinations(colours, 2)
    return min(distance(one, other, vision) for one, other in pairs)


def closest_in_grey(colours):
    """Return the smallest difference in lightness of any two colours."""
    return min(np.diff(sorted(lab(colour)[0] for colour in colours)))
