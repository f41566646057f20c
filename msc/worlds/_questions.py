"""What is asked of worlds: `data/worlds/asked.yml`, written before the first search.

A question is a number a world, with one predicate and a smallest effect of interest.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import yaml

from msc.worlds._draw import family_of

ASKED = "asked.yml"
_PREDICATES = ("below", "at_least", "equals")
_FEW = 24  # training tasks of a variant


@dataclass(frozen=True)
class Question:
    """What is asked of worlds.

    Attributes
    ----------
    id : str
        Its name.
    question : str
        In words.
    families : tuple of str
        Of whose worlds it is asked.
    claims : tuple of str
        Claims of the paper that it is of; none, if it is our own.
    measure : str
        A key of `msc.study.MEASURES`; or "jumps".
    sizes : tuple of int
        Numbers of training tasks.
    method : str
        Whose error is divided,
    baselines : tuple of str
        by whose; "cost": by what the searched policies of the test tasks cost.
    predicate : {"below", "at_least", "equals"}
        Where the number must lie,
    wanted : float
        of this.
    effect : float
        Between this and `wanted` an effect is too small to be of interest.
    """

    id: str
    question: str
    families: tuple[str, ...]
    claims: tuple[str, ...]
    measure: str
    predicate: str
    wanted: float
    effect: float
    sizes: tuple[int, ...] = ()
    method: str = ""
    baselines: tuple[str, ...] = ()

    @property
    def is_of_few(self) -> bool:
        """Whether it needs no more tasks than a variant has."""
        return set(self.sizes) <= {_FEW}


def load_questions(path: Path) -> list[Question]:
    """Read what is asked.

    Parameters
    ----------
    path : Path
        `data/worlds/asked.yml`.

    Returns
    -------
    list of Question
        In the order of the file.

    Raises
    ------
    ValueError
        If a question lacks a part or has not one predicate.
    """
    return [_question(one) for one in _read(path)["questions"]]


def load_choices(path: Path) -> dict[str, list[Question]]:
    """Read what is asked again, with one choice of the learners' changed.

    Parameters
    ----------
    path : Path
        `data/worlds/asked.yml`.

    Returns
    -------
    dict from str to list of Question
        By choice, in words: the questions, with other methods in them.
    """
    told = _read(path)
    asked = [one for one in load_questions(path) if one.id in told["choices_asked"]]
    return {
        choice["choice"]: [_changed(one, choice["methods"]) for one in asked]
        for choice in told["choices"]
    }


def load_kin(path: Path) -> dict[str, str]:
    """Read which family the variants of each headline world are asked like.

    Parameters
    ----------
    path : Path
        `data/worlds/asked.yml`.

    Returns
    -------
    dict from str to str
        Families, by headline world.
    """
    return dict(_read(path)["variants"])


def is_asked(asked: Question, world: str, kin: Mapping[str, str]) -> bool:
    """Tell whether a question is asked of a world.

    Parameters
    ----------
    asked : Question
        The question.
    world : str
        The world's name.
    kin : mapping of str to str
        What `load_kin` returned.

    Returns
    -------
    bool
        Whether it is.
    """
    family = family_of(world).name
    if family != "variant":
        return family in asked.families
    return asked.is_of_few and kin[world.partition("-")[0]] in asked.families


def _read(path: Path) -> Any:
    """Read the file."""
    return yaml.safe_load(path.read_text("utf-8"))


def _changed(asked: Question, methods: Mapping[str, str]) -> Question:
    """Put other methods into a question."""
    baselines = tuple(methods.get(one, one) for one in asked.baselines)
    method = methods.get(asked.method, asked.method)
    return replace(asked, method=method, baselines=baselines)


def _question(told: Mapping[str, Any]) -> Question:
    """Read a question."""
    predicates = [name for name in _PREDICATES if name in told]
    if len(predicates) != 1 or not {"id", "question", "families"} <= told.keys():
        raise ValueError(
            f"question {told.get('id')!r}: wanted id, question, families and one of "
            f"{', '.join(_PREDICATES)}"
        )
    wanted = float(told[predicates[0]])
    return Question(
        id=told["id"],
        question=told["question"],
        families=tuple(told["families"]),
        claims=_listed(told.get("of", [])),
        measure="jumps" if "jumps" in told else told["measure"],
        predicate=predicates[0],
        wanted=wanted,
        effect=float(told.get("effect", wanted)),
        sizes=_listed(told.get("n_samples", [])),
        method=told.get("method", ""),
        baselines=_listed(told.get("baseline", [])),
    )


def _listed(value: Any) -> tuple[Any, ...]:
    return tuple(value) if isinstance(value, list) else (value,)
