"""Whether plain data are laid out as a type says: typed dictionaries and lists."""

from types import UnionType
from typing import get_args, get_origin, get_type_hints, is_typeddict


def departures(value, kind, place="it"):
    """List where a value departs from a type, a sentence each."""
    origin = get_origin(kind) or kind
    if is_typeddict(kind):
        return _of_fields(value, get_type_hints(kind), place)
    if origin is UnionType:
        fits = any(not departures(value, one, place) for one in get_args(kind))
        return [] if fits else [f"{place} is {value!r}; wanted {kind}"]
    if not _is_one(value, origin):
        return [f"{place} is {value!r}; wanted {kind}"]
    if origin is dict:
        _, inner = get_args(kind)
        return [
            one
            for key, part in value.items()
            for one in departures(part, inner, f"{place}[{key!r}]")
        ]
    if origin is list:
        (inner,) = get_args(kind)
        return [
            one
            for number, part in enumerate(value)
            for one in departures(part, inner, f"{place}[{number}]")
        ]
    return []


def _of_fields(value, fields, place):
    """List where a value departs from a typed dictionary: every field, and no other."""
    if not isinstance(value, dict):
        return [f"{place} is {value!r}; wanted fields"]
    found = [f"{place} lacks {name!r}" for name in fields if name not in value]
    found += [f"{place} has {name!r}" for name in value if name not in fields]
    for name, kind in fields.items():
        if name in value:
            found += departures(value[name], kind, f"{place}[{name!r}]")
    return found


def _is_one(value, kind):
    """Tell whether a value is of a plain type; a whole number is a number too."""
    if isinstance(value, bool):
        return kind is bool
    return isinstance(value, (int, float) if kind is float else kind)
