"""What a chapter checks: its parameters first, and its claims where it makes them.

Its cell of parameters is plain assignments. The comment beside one is what it means,
and ends in the values it may take:

    n_samples = 24  # training tasks, evenly spaced (2 to 360)
    n_charts = 4  # None: the elbow picks (1 to 10, at most n_samples, or None)
    task_deg = 60.0  # the task, in degrees (any number, modulo 360)
    design = "even"  # how they are drawn ("even", "uniform" or "nonuniform")

Its type is the default's; numbers are whole if the default is and both bounds are. A
comment too long for its line goes on in one that begins with the parenthesis. All else
is made of this: what the command line refuses, what a chapter checks before it computes
anything, and the page of parameters.

With the chapter's own parameters a claim that does not hold stops the build of the
book. With others, which a reader is free to choose, it is told in words.
"""

import ast
import io
import math
import re
import reprlib
import tokenize
from collections.abc import Mapping, MutableMapping
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any, NamedTuple

_NUMBER = r"-?\d+(?:\.\d+)?"
_LITERAL = rf'"[^"]*"|{_NUMBER}|None|True|False'
_RANGE = re.compile(
    rf"(?:any number|(?P<low>{_NUMBER}) to (?P<high>{_NUMBER}))"
    rf"(?:, modulo (?P<period>{_NUMBER}))?"
    r"(?:, at most (?P<most>\w+))?(?P<none>,? or None)?"
)
_LITERALS = re.compile(_LITERAL)
_CHOICES = re.compile(rf"(?:{_LITERAL})(?:(?:, | or )(?:{_LITERAL}))+")
_NONE = ("None", "null")  # how a file of parameters may spell it
_REFUSED = object()
_NAMES = {int: "a whole number", float: "a number", bool: "True or False", str: "text"}

# How a cell tells, in words, of claims that do not hold.
WORDS = "With these parameters it does not hold that"


class Parameter(NamedTuple):
    """A parameter as a chapter declares it."""

    default: str  # as Python writes it
    meaning: str  # the comment beside it, without the values
    values: str = ""  # in the comment's last parenthesis; if empty, the type counts

    @property
    def wanted(self) -> str:
        """What values it may take, in words."""
        kind = _NAMES.get(self._kind, "anything")
        if not (found := _RANGE.fullmatch(self.values)):
            return self.values or kind
        words = f"{kind} from {found['low']} to {found['high']}"
        if not found["low"]:
            words = kind.replace("a ", "any ", 1)
        words += f", modulo {found['period']}" if found["period"] else ""
        words += f", at most {self.most}" if self.most else ""
        return words + (" or None" if found["none"] else "")

    @property
    def most(self) -> str:
        """Which other parameter bounds it; empty if none does."""
        found = _RANGE.fullmatch(self.values)
        return found["most"] or "" if found else ""

    def read(self, name: str, value: Any) -> Any:
        """Return a value as its type has it, or refuse it by name: "1e2" as 100."""
        read = self._typed(value)
        if read is not _REFUSED and read is not None:
            read = self._within(read)
        if read is _REFUSED:
            raise ValueError(f"{name}={_shown(value)}; wanted {self.wanted}")
        return read

    @property
    def _default(self) -> Any:
        """The default, if it is written out and nothing to be computed."""
        try:
            return ast.literal_eval(self.default)
        except (ValueError, SyntaxError):
            return _REFUSED

    @property
    def _kind(self) -> type:
        """Its type: the default's; whole numbers have whole bounds."""
        kind = type(self._default)
        if found := _RANGE.fullmatch(self.values):
            is_whole = kind is not float and found["low"] and "." not in self.values
            return int if is_whole else float
        return kind

    def _typed(self, value: Any) -> Any:
        """Return the value as its type has it, or that it is refused."""
        kind = self._kind
        is_none = value is None or (isinstance(value, str) and value in _NONE)
        if is_none and "None" in _LITERALS.findall(self.values):
            return None
        if kind in (int, float):
            return _number(value, kind)
        return value if kind not in _NAMES or isinstance(value, kind) else _REFUSED

    def _within(self, value: Any) -> Any:
        """Return the value if it may be taken, or that it is refused."""
        if not (found := _RANGE.fullmatch(self.values)):
            choices = [ast.literal_eval(one) for one in _LITERALS.findall(self.values)]
            return value if not choices or value in choices else _REFUSED
        if found["low"] and not float(found["low"]) <= value <= float(found["high"]):
            return _REFUSED
        if found["period"]:
            period = self._kind(found["period"])
            return value % period % period  # -1e-20 % 360 is 360
        return value


def declared(code: str) -> dict[str, Parameter]:
    r"""Return what a cell of parameters assigns, in its order; refuse another.

    >>> for name, one in declared("n = 24  # tasks (2 to 360)\nseed = 0").items():
    ...     print(name, tuple(one), one.wanted)
    n ('24', 'tasks', '2 to 360') a whole number from 2 to 360
    seed ('0', '', '') a whole number
    """
    try:
        tree = ast.parse(code, "the cell")
        tokens = [*tokenize.generate_tokens(io.StringIO(code).readline)]
    except (SyntaxError, ValueError, tokenize.TokenError) as error:
        raise ValueError(f"its cell of parameters is no Python: {error}") from error
    beside: dict[int, str] = {}  # the comment on a line, after code,
    alone: dict[int, str] = {}  # and on one of its own
    for token in tokens:
        if token.type == tokenize.COMMENT:
            line, column = token.start
            (beside if column else alone)[line] = token.string.lstrip("# ").strip()
    found = {}
    for given in ast.walk(tree):
        if isinstance(given, ast.Assign | ast.AnnAssign):
            default = ast.unparse(given.value) if given.value else ""
            end = given.end_lineno or 0
            comment, below = beside.get(end, ""), alone.get(end + 1, "")
            comment += f" {below}" if below.startswith("(") else ""
            for node in ast.walk(given):
                if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                    found[node.id] = _parameter(node.id, default, comment.strip())
    for name, one in found.items():
        if one.most and one.most not in found:
            raise ValueError(f"{name} is bounded by {one.most}, which is not declared")
    return found


def check(
    parameters: Mapping[str, Parameter], given: Mapping[str, Any]
) -> dict[str, Any]:
    r"""Return the values given, each as its type has it, or refuse one by name.

    They are held against each other, too; what is not given is the default.

    >>> cell = "n = 24  # tasks (2 to 360)\nk = 4  # parts (1 to 10, at most n)"
    >>> check(declared(cell), {"n": "1e2", "k": 5.0})
    {'n': 100, 'k': 5}
    >>> check(declared(cell), {"n": 3})
    Traceback (most recent call last):
    ValueError: k=4, n=3; wanted k at most n
    """
    for name in given:
        if name not in parameters:
            known = ", ".join(sorted(parameters)) or "none"
            raise ValueError(f"no parameter {name!r}; it declares: {known}")
    read = {name: parameters[name].read(name, value) for name, value in given.items()}
    values = {
        name: one.read(name, one._default)
        for name, one in parameters.items()
        if one.values and name not in read and one._default is not _REFUSED
    }
    values |= read
    for name, one in parameters.items():
        value, most = values.get(name), values.get(one.most)
        if value is not None and most is not None and value > most:
            both = f"{name}={value!r}, {one.most}={most!r}"
            raise ValueError(f"{both}; wanted {name} at most {one.most}")
    return read


def check_parameters(namespace: MutableMapping[str, Any]) -> None:
    """Check the parameters of a running chapter, before it computes anything.

    Its first call is ``check_parameters(globals())``. A parameter may have come from
    papermill, from the command line or from an edit of the cell. Text that is a number
    becomes one.

    Parameters
    ----------
    namespace : mapping from str to object
        The chapter's variables. IPython keeps in one of them, `In`, the cells that
        were executed; those that hold nothing but assignments, beside comments that end
        in values, declare parameters. Without IPython nothing is checked.

    Raises
    ------
    ValueError
        If a parameter cannot take its value.
    """
    known: dict[str, Parameter] = {}
    for code in filter(_declares, namespace.get("In", ())):
        known |= declared(code)
    values = {name: namespace[name] for name in known if name in namespace}
    namespace.update(check(known, values))


@dataclass(frozen=True)
class Unmet:
    """Claims that do not hold, as a chapter shows them."""

    claims: tuple[str, ...]  # each a clause after "that"

    def __repr__(self) -> str:
        """Write them down, one a line."""
        return "\n- ".join((WORDS, *self.claims))


def expect(claims: Mapping[str, bool]) -> Unmet | None:
    """Check what a chapter says.

    Parameters
    ----------
    claims : mapping from str to bool
        Whether each holds. It is a clause after "it does not hold that".

    Returns
    -------
    Unmet or None
        Those that do not hold, which a cell shows in words; None, which it does not
        show, if all do.

    Examples
    --------
    >>> expect({"two is even": True})
    >>> expect({"two is even": True, "three is even": False})
    With these parameters it does not hold that
    - three is even
    """
    failed = tuple(claim for claim, holds in claims.items() if not holds)
    return Unmet(failed) if failed else None


def resolve(word: str) -> Any:
    """Read a word of the command line as `papermill -p` does.

    >>> [resolve(word) for word in ("None", "1e2", "48", "even", "null")]
    [None, 100.0, 48, 'even', 'null']
    """
    named = {"True": True, "False": False, "None": None}
    if word in named:
        return named[word]
    for kind in (int, float):
        try:
            return kind(word)
        except ValueError:
            pass
    return word


def _parameter(name: str, default: str, comment: str) -> Parameter:
    """Part a comment into what a parameter means and the values it may take."""
    if not (found := re.fullmatch(r"(.*?)\s*\(([^()]*)\)", comment)):
        return Parameter(default, comment)
    meaning, values = found.groups()
    if not _are_values(values):
        raise ValueError(
            f"{name}: its comment ends in ({values}); wanted the values it may take, "
            'as (0 to 360), (1 to 10, at most n, or None), (any number) or ("a" or "b")'
        )
    return Parameter(default, meaning, values)


def _declares(code: str) -> bool:
    """Tell whether a cell holds assignments alone, and the values that one may take."""
    try:
        lines = ast.parse(code).body
    except (SyntaxError, ValueError):
        return False
    ends = re.findall(r"#.*\(([^()]*)\)\s*$", code, re.MULTILINE)
    return all(isinstance(line, ast.Assign | ast.AnnAssign) for line in lines) and any(
        _are_values(end) for end in ends
    )


def _are_values(text: str) -> bool:
    """Tell whether the inside of a parenthesis names values."""
    return bool(_RANGE.fullmatch(text) or _CHOICES.fullmatch(text))


def _number(value: Any, kind: type) -> Any:
    """Return a finite number as one of its kind, or that it is refused."""
    if isinstance(value, str):
        value = resolve(value)
    if isinstance(value, bool) or not isinstance(value, Real):
        return _REFUSED
    if isinstance(value, Integral):
        value = int(value)
    elif not math.isfinite(value):
        return _REFUSED
    try:
        return kind(value) if kind is float or value == int(value) else _REFUSED
    except OverflowError:
        return _REFUSED


def _shown(value: Any) -> str:
    """Show a value, shortened."""
    try:
        return reprlib.repr(value)
    except ValueError:
        return "a whole number of thousands of digits"
