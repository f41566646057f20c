"""The rules by which worlds are drawn. None looks at what a search finds.

Of a seed, world number k of a family draws from ``default_rng([seed, k])``; all drawn
numbers are rounded, to 0.1 mm, a gram and 0.01 degree, so that files can be read.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from tqdm import tqdm

from msc._checks import check_whole
from msc.robot import (
    Circle,
    CostWeights,
    Physics,
    TaskRange,
    Workspace,
    format_world,
    home_pose,
    random_circles,
    read_world,
)
from msc.study import locate_cut
from msc.worlds._variants import VARIANTS, draw_variants
from press import replace_file

CONTACT_PRICE = 0.01  # 1/(N s); a newton-second costs as much as one centimetre missed
_RADII = 0.30, 0.45  # m; of the annulus, whose rim is the circle of the other worlds
_SWING = 0.08  # m; up and down, of the obstacle that moves
_TURN = 10.0  # degrees, either way, of the home pose


@dataclass(frozen=True)
class Family:
    """Worlds drawn by one rule.

    Attributes
    ----------
    name : str
        With a number behind it, a world's name.
    count : int
        How many there are; with 24 layouts.
    n_train, n_test : int
        Tasks of each.
    rule : str
        How they are drawn.
    """

    name: str
    count: int
    n_train: int
    n_test: int
    rule: str


FAMILIES = {
    family.name: family
    for family in (
        Family(
            "layout",
            24,
            72,
            60,
            "1 to 5 round obstacles, centres 0.55 to 0.80 m from the base, radii 0.04 "
            "to 0.07 m, 3 cm clear of the arm at home and of each other; the arm, its "
            "home and the goals of the book",
        ),
        Family(
            "arm",
            6,
            72,
            60,
            "no obstacles; links of 0.25 to 0.45 m, scaled to 1 m in all, of 0.4 to "
            "1.2 kg; home bent to a reach of 0.78 to 0.92 m, towards 35 to 55 degrees "
            "from an axis in one of the four quadrants; the cut measured",
        ),
        Family(
            "annulus",
            6,
            300,
            100,
            "layouts 1 to 6, goals 0.30 to 0.45 m from the base",
        ),
        Family(
            "priced",
            12,
            72,
            60,
            "layouts 1, 3, 5, …, with a price on contact: a newton-second costs as "
            "much as one centimetre missed",
        ),
        Family("mujoco", 2, 72, 60, "layouts 1 and 2, in the other engine"),
        Family(
            "height",
            1,
            300,
            100,
            "the first layout whose first obstacle can move 8 cm up and down, within "
            "the rules; goals as in the annulus",
        ),
        Family(
            "turn",
            1,
            300,
            100,
            "the first layout that stays clear of the arm when its home is turned by "
            "10 degrees either way; goals as in the annulus",
        ),
        Family(
            "variant",
            2 * len(VARIANTS) - 1,
            24,
            36,
            "the headline worlds, one choice of ours changed",
        ),
    )
}


def family_of(name: str) -> Family:
    """Tell which family a world belongs to.

    Parameters
    ----------
    name : str
        The world's name.

    Returns
    -------
    Family
        Its family.

    Raises
    ------
    ValueError
        If there is none.

    Examples
    --------
    >>> family_of("layout07").n_train
    72
    """
    base, _, variant = name.partition("-")
    if base in ("free", "obstacles") and variant in VARIANTS:
        return FAMILIES["variant"]
    found = FAMILIES.get(name.rstrip("0123456789"))
    if found is None or not name[-1:].isdigit():
        raise ValueError(
            f"world={name!r} is of no family; wanted {', '.join(FAMILIES)}"
        )
    return found


def draw_worlds(seed: int, count: int = 24) -> Iterator[Workspace]:
    """Draw the worlds of all families.

    Parameters
    ----------
    seed : int
        Seed of all draws.
    count : int, default=24
        How many layouts; of the other families as many as go with them.

    Yields
    ------
    Workspace
        One world after the other; those without obstacles with a cut at 0 degrees,
        which is to be measured.

    Examples
    --------
    >>> [world.name for world in draw_worlds(0, 2)][:3]
    ['layout01', 'layout02', 'priced01']
    """
    layouts = [
        Workspace(name=f"layout{k:02}", circles=_draw_circles(seed, k))
        for k in range(1, count + 1)
    ]
    yield from layouts
    for k, world in enumerate(layouts, start=1):
        if k % 2:
            priced = CostWeights(contact=CONTACT_PRICE)
            yield replace(world, name=f"priced{k:02}", cost=priced)
    for k in range(1, FAMILIES["arm"].count * count // 24 + 1):
        yield _draw_arm(seed, k)
    rims = TaskRange("radius_m", *_RADII)
    for k, world in enumerate(layouts[: FAMILIES["annulus"].count], start=1):
        yield replace(world, name=f"annulus{k}", further=(rims,))
    more = {
        "height": TaskRange("height_m", -_SWING, _SWING),
        "turn": TaskRange("turn_deg", -_TURN, _TURN),
    }
    for name, other in more.items():
        for world in layouts:
            try:
                yield replace(world, name=f"{name}1", further=(rims, other))
                break
            except ValueError:  # an obstacle in the way
                continue
    other_engine = Physics(engine="mujoco")
    for k, world in enumerate(layouts[: FAMILIES["mujoco"].count], start=1):
        yield replace(world, name=f"mujoco{k:02}", physics=other_engine)
    yield from draw_variants()


def _draw_circles(seed: int, k: int) -> tuple[Circle, ...]:
    """Draw a layout of 1 to 5 obstacles."""
    circles = random_circles([seed, k], 1, 5)
    return tuple(Circle(*(round(number, 4) for number in one)) for one in circles)


def _draw_arm(seed: int, k: int) -> Workspace:
    """Draw links, masses and home of an arm without obstacles."""
    rng = np.random.default_rng([seed, k])
    lengths = rng.uniform(0.25, 0.45, 3)
    first, second = (lengths[:2] / lengths.sum()).round(3).tolist()
    links = first, second, round(1 - first - second, 3)
    masses = tuple(rng.uniform(0.4, 1.2, 3).round(3).tolist())
    heading = 90 * int(rng.integers(4)) + rng.uniform(35, 55)
    pose = home_pose(links, rng.uniform(0.78, 0.92), math.radians(heading))
    home = np.deg2rad(np.rad2deg(pose).round(2))
    return Workspace(
        name=f"arm{k}",
        link_lengths=links,
        link_masses=(masses[0], masses[1], masses[2]),
        home=tuple(home.tolist()),
        cut_deg=0.0,
    )


def make_worlds(
    folder: Path, *, seed: int, count: int = 24, progress: bool = False
) -> list[str]:
    """Draw all worlds and write their files.

    Parameters
    ----------
    folder : Path
        Where to.
    seed : int
        Seed of all draws.
    count : int, default=24
        How many layouts, see `draw_worlds`.
    progress : bool, default=False
        Whether to show a progress bar on standard error: cuts take half a minute each.

    Returns
    -------
    list of str
        The worlds, in the order in which they are searched.

    Raises
    ------
    ValueError
        If there is a file of another world of that name.
    """
    check_whole("count", count, 1, 99)
    check_whole("seed", seed, 0)
    drawn = list(draw_worlds(seed, count))
    for world in tqdm(drawn, desc="worlds", unit="world", disable=not progress):
        family, path = family_of(world.name), folder / f"{world.name}.toml"
        told = f"Of `msc worlds make --seed {seed} --count {count}`: {family.rule}."
        comment = textwrap.fill(told, 86)
        if family.name == "variant":
            comment = f"{comment}\n{VARIANTS[world.name.partition('-')[2]][0]}"
        if _needs_cut(world):  # its cut is to be measured, unless it has been
            cut = read_world(path).cut_deg if path.is_file() else _measure_cut(world)
            world = replace(world, cut_deg=cut)  # noqa: PLW2901
        text = format_world(world, comment)
        if path.is_file() and path.read_text("utf-8") != text:
            raise ValueError(f"{path} is another world; wanted another folder")
        replace_file(path, text)
    return [world.name for world in drawn]


def _needs_cut(world: Workspace) -> bool:
    """Whether the home pose is another, and with it where both ways cost the same."""
    return world.home != Workspace.home


def _measure_cut(world: Workspace) -> float:
    """Measure where reaching round either side of the base costs the same."""
    return float(locate_cut(world)["cut_deg"])
