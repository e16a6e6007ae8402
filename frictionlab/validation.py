"""Checks of single arguments: each message has the name, the rule, what was given, and the cure.

The package's suggestions "did you mean" are made here too.  Components use this module, so numpy is imported
only where it is needed.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from difflib import get_close_matches
from functools import wraps
from itertools import islice
from numbers import Real
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from frictionlab.partial_results import keep_partial_result, partial_result

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np

VARIABLE_KEYWORDS = 8  # inspect.CO_VARKEYWORDS, whose module takes 14 ms to import
P = ParamSpec("P")
R = TypeVar("R")
MAX_CHARACTERS = 100  # characters of a value that a message shows
MAX_PATH = 4096  # characters of a path: no system takes longer ones
MOST_SEED = 1 << 30
MAX_ELEMENTS = 50  # elements of a value of which a message could show anything

# What arguments of other libraries are called here.
ELSEWHERE = {
    "rtol": "tolerances are the method's: write method=fl.Taylor(tol=1e-10)",
    "atol": "tolerances are the method's: write method=fl.Taylor(tol=1e-10)",
    "tol": "it is the method's: write method=fl.Taylor(tol=1e-10)",
    "t_span": "a run begins at 0: give its end as t_end",
    "y0": "initial states are given as x0",
    "max_step": "steps are the method's: write method=fl.Scipy(max_step=0.01)",
    "events": "give crossings to be recorded as sections",
    "dense_output": "a run always has it: write run(t)",
    "args": "parameters are the model's: write model.replace(mu_k=1.4)",
    "jac": "derivatives are known from the model: leave it out",
    "first_step": "the solver chooses it: leave it out",
    "min_step": "the solver chooses it: leave it out",
    "seed": "random numbers are chosen by rng: write rng=1",
    "ax": "it draws a whole figure: give figure=, or draw one panel by run.plot(ax=ax)",
    "c": "write color",
    "n_jobs": "write workers=2",
}
# What attributes of the results of other libraries are called here.
ATTRIBUTES_ELSEWHERE = {
    "y": "write run.states, a row for each time, or run['x1']",
    "x": "write run.states, a row for each time, or run['x1']",
    "sol": "write run(t)",
    "success": "see run.status",
    "message": "see run.status",
    "t_events": "write run.events.t",
    "y_events": "write run.events.state",
}


def plain_number(value: Any) -> Any:
    """The element of a zero-dimensional array; any other value as it is.

    Such arrays are what numpy and xarray give for one element or a mean.
    """
    return value.item() if getattr(value, "shape", None) == () and hasattr(value, "item") else value


def check_number(
    name: str,
    value: Any,
    *,
    integer: bool = False,
    least: float = -math.inf,
    most: float = math.inf,
    above: float = -math.inf,
    below: float = math.inf,
    cure: str = "",
) -> Any:
    """The value as a plain number, 4.0 as the integer 4 where one is asked for.

    Raises ValueError unless it is finite and within the bounds.
    """
    number = type(value) is float and math.isfinite(value)  # the quick case
    if not number:
        value = plain_number(value)
        number = _is_number(value)
    if (
        not number
        or (integer and value != int(value))
        or not (least <= value <= most and above < value < below)
    ):
        rules = ["an integer" if integer else "a finite number"]
        rules += [f"at least {least:g}"] if least > -math.inf else []
        rules += [f"above {above:g}"] if above > -math.inf else []
        rules += [f"at most {most:g}"] if most < math.inf else []
        rules += [f"below {below:g}"] if below < math.inf else []
        raise ValueError(f"{name} must be {', '.join(rules)}, got {abbreviate(value)}{_cure(cure)}")
    return int(value) if integer else value


def check_t_end(value: Any, cure: str = "give the length of the run in seconds") -> Any:
    """The end of a run, s; where a span of times is given, as scipy takes it, the message names its end."""
    if type(value) is float:
        if 0.0 < value < math.inf:  # the quick case
            return value
    elif is_sequence(value) and len(value):
        last = plain_number(value[-1])
        cure = f"a run begins at 0, write t_end={last:g}" if _is_number(last) else cure
    return check_number("t_end", value, above=0.0, cure=cure)


def _is_number(value: Any) -> bool:
    if not isinstance(value, Real) or isinstance(value, bool):
        return False
    try:
        return math.isfinite(float(value))
    except OverflowError:  # an integer such as 10**400
        return False


def check_field(settings: Any, name: str, **rules: Any) -> None:
    """Check one number of a frozen dataclass by :func:`check_number`, and store it as a plain number."""
    object.__setattr__(settings, name, check_number(name, getattr(settings, name), **rules))


def check_flag(name: str, value: Any, cure: str = "") -> bool:
    """The value as a truth value; raises for what Python only takes for one, such as the text "no"."""
    if not isinstance(value, bool):
        value = plain_number(value)
    if not isinstance(value, bool):
        cure = cure or f"write {name}=False"
        raise TypeError(f"{name} must be True or False, got {abbreviate(value)}: {cure}")
    return value


def check_text(name: str, value: Any, cure: str, most: int = 100_000) -> str:
    """The value, if it is a text of at most so many characters."""
    if not isinstance(value, str) or len(value) > most:
        rule = f"a text of at most {most} characters" if isinstance(value, str) else "a text"
        raise ValueError(f"{name} must be {rule}, got {abbreviate(value)}{_cure(cure)}")
    return value


def _cure(cure: str) -> str:
    """The end of a message: what can be done, if there is a cure of this argument's own."""
    return f": {cure}" if cure else ""


def check_mapping(name: str, value: Any, cure: str, keys: type = str) -> None:
    """Raise unless `value` is a mapping whose keys are texts, or of another class."""
    if not isinstance(value, Mapping):
        raise ValueError(f"{name} must be a mapping, got {abbreviate(value)}{_cure(cure)}")
    for key in value:
        if not isinstance(key, keys):
            kind = "names" if keys is str else f"of the class {keys.__name__}"
            raise ValueError(f"the keys of {name} must be {kind}, got {abbreviate(key)}{_cure(cure)}")


def is_sequence(value: Any) -> bool:
    """Whether it is a list, a tuple or an array: a text, a mapping, a set and one number are not."""
    if isinstance(value, (str, bytes)):
        return False
    return isinstance(value, Sequence) or (hasattr(value, "__array__") and getattr(value, "ndim", 0) > 0)


def check_sequence(name: str, value: Any, cure: str) -> tuple[Any, ...]:
    """The elements of a list, a tuple or an array."""
    if not is_sequence(value):
        raise ValueError(f"{name} must be a sequence such as a list, got {abbreviate(value)}: {cure}")
    return tuple(value)


def check_names_among(what: str, given: Any, known: Sequence[str]) -> None:
    """Raise unless it is a tuple of different names among those that are known."""
    names = check_sequence(what, given, f"write {what} = ({', '.join(map(repr, known[:1]))},)")
    for name in names:
        if name not in known or names.count(name) > 1:
            hint = did_you_mean_or_known(name, known) if isinstance(name, str) else ""
            raise ValueError(
                f"{what} must have names of coordinates, each once, got {abbreviate(name)}{hint}"
            )


def check_pair(name: str, value: Any, rule: str, cure: str) -> tuple[Any, Any]:
    """The two elements of a list or a tuple, which the `rule` names: "a parameter and its values"."""
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise ValueError(f"{name} must be {rule}, got {abbreviate(value)}: {cure}")
    return value[0], value[1]


def check_limits(name: str, value: Any, cure: str, *, positive: str = "") -> tuple[float, float]:
    """Two finite numbers in ascending order; above 0 where `positive` says why: "where log=True"."""
    rule = "two numbers in ascending order" + (f", above 0 {positive}" if positive else "")
    pair = tuple(value) if is_sequence(value) else ()
    numbers = list(map(plain_number, pair))
    if len(pair) == 2 and all(map(_is_number, numbers)):
        low, high = map(float, numbers)
        if low < high and (low > 0.0 or not positive):
            return low, high
    raise ValueError(f"{name} must be {rule}, got {abbreviate(value)}: {cure}")


def _is_file_name(text: str) -> bool:
    return 0 < len(text) <= MAX_PATH and "\0" not in text


def check_path(name: str, value: Any, suffixes: Sequence[str] = (), cure: str = "") -> Path:
    """The path of a file, with one of the suffixes where there are any; upper or lower case."""
    from pathlib import Path

    if not isinstance(value, (str, os.PathLike)) or not _is_file_name(str(value)):
        raise ValueError(
            f"{name} must be the path of a file, got {abbreviate(value)}: {cure or 'give its name as a text'}"
        )
    path = Path(value)
    if suffixes and path.suffix.lower() not in suffixes:
        raise ValueError(
            f"{name} must end in {' or '.join(suffixes)}, got {abbreviate(str(value))}: "
            f"{cure or f'write {path.stem[:MAX_CHARACTERS]}{suffixes[0]}'}"
        )
    return path


def float_array(name: str, values: Any, cure: str, *, finite: bool = False) -> np.ndarray:
    """The values as a new array of floats; raises unless they are real numbers, finite ones if so asked.

    An imaginary part, a mask, a text or None would be lost without a word, also in arrays of objects.
    """
    import numpy as np

    def refusal(rule: str) -> ValueError:
        return ValueError(f"{name} must hold {rule}, got {abbreviate(values)}{_cure(cure)}")

    if np.ma.is_masked(values):
        raise refusal("numbers without a mask")
    try:
        array = np.array(values)
        if array.dtype.kind not in "iufO":
            raise TypeError
        numbers = array if array.dtype.kind != "O" else floats_of_objects(array)
    except (TypeError, ValueError, OverflowError, RecursionError):
        raise refusal("numbers") from None
    if finite and not np.isfinite(numbers).all():
        raise refusal("finite numbers")
    return numbers.astype(float, copy=False)


def floats_of_objects(array: np.ndarray) -> np.ndarray:
    """An array of objects, numbers of any class as fractions, as floats; TypeError for a text or None."""
    import numpy as np

    for each in array.flat:
        if np.asarray(each).dtype.kind not in "iufO" or not hasattr(each, "__float__"):
            raise TypeError
    return array.astype(float)


def abbreviate(value: Any) -> str:
    """The value as a message shows it, cut if it is long: an array as a list."""
    try:
        text = repr(_beginning(value.tolist() if hasattr(value, "tolist") else value))
    except Exception:  # a repr may do anything; integers of 4300 digits have none
        text = f"a value of the class {type(value).__name__}"
    text = text if text.isprintable() else text.encode("unicode_escape").decode()
    return text if len(text) <= MAX_CHARACTERS else f"{text[:MAX_CHARACTERS]}..."


def _beginning(value: Any) -> Any:
    """The beginning of a text or a list, of which no more than that can be shown."""
    if isinstance(value, (str, bytes)):
        return value[: 2 * MAX_CHARACTERS]
    if type(value) in (list, tuple, set, frozenset) and len(value) > MAX_ELEMENTS:
        return list(islice(value, MAX_ELEMENTS))
    return value


def check_choice(name: str, value: Any, choices: Iterable[str], cure: str = "") -> None:
    """Raise unless `value` is one of `choices`; suggests the nearest, or the cure where none is near."""
    choices = tuple(choices)
    if not isinstance(value, str) or value not in choices:
        allowed = ", ".join(map(repr, choices))
        hint = did_you_mean(value, choices) or _cure(cure)
        raise ValueError(f"{name} must be one of {allowed}, got {abbreviate(value)}{hint}")


def nearest_name(name: Any, known: Iterable[str]) -> str | None:
    """The known name that was probably meant, whatever the case of its letters; None where none is near."""
    if not isinstance(name, str):
        return None
    names = list(known)
    lower = [each.lower() for each in names]
    near = get_close_matches(name[:MAX_CHARACTERS].lower(), lower, n=1)
    return names[lower.index(near[0])] if near else None


def did_you_mean(name: Any, known: Iterable[str]) -> str:
    """The end of a message that lists what is known: `: did you mean ...?`, or nothing where none is near."""
    near = nearest_name(name, known)
    return "" if near is None else f": did you mean {near!r}?"


def did_you_mean_or_known(name: Any, known: Iterable[str]) -> str:
    """The end of a message that does not list what is known: `: did you mean ...?`, or else that list."""
    names = list(known)
    listed = f": known are {', '.join(names)}" if names else ": there are none"
    return did_you_mean(name, names) or listed


def check_keywords(function: str, given: Iterable[str], known: Iterable[str]) -> None:
    """Raise TypeError for a keyword that the function does not take."""
    known = tuple(known)
    for name in given:
        if name not in known:
            raise unknown_keyword(function, name, known)


def unknown_keyword(function: str, name: str, known: Iterable[str]) -> TypeError:
    """The error for a keyword that a function does not take, with what was meant."""
    hint = f": {ELSEWHERE[name]}" if name in ELSEWHERE else did_you_mean(name, known)
    return TypeError(f"{function} takes no {abbreviate(name)}{hint}")


def explains_fields(kind: type[R]) -> type[R]:
    """Let a dataclass answer an unknown keyword with what was meant."""
    make = kind.__init__
    code = make.__code__
    known = code.co_varnames[1 : code.co_argcount + code.co_kwonlyargcount]

    @wraps(make)
    def init(self: R, *arguments: Any, **keywords: Any) -> None:
        check_keywords(kind.__name__, keywords, known)
        make(self, *arguments, **keywords)

    setattr(kind, "__init__", init)  # noqa: B010  # an assignment is a method's, to type checkers
    return kind


def seed_of(rng: Any) -> int:
    """A seed by which random numbers can be drawn again, from what users give as `rng`.

    An integer is the seed itself.  A numpy Generator draws one; None draws one that differs each time.
    """
    import numpy as np

    if rng is None or isinstance(rng, np.random.Generator):
        return int((np.random.default_rng() if rng is None else rng).integers(MOST_SEED))
    cure = "give one such as 1, a numpy Generator, or None for other numbers each time"
    return check_number("rng", rng, integer=True, least=0, most=MOST_SEED, cure=cure)


def explains_keywords(function: Callable[P, R]) -> Callable[P, R]:
    """Let a public function answer an unknown keyword with what was meant, a missing argument with its usage.

    Where ctrl-C arrives before the function has anything to keep, an earlier partial result is not taken for
    its own.
    """
    code = function.__code__
    known = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
    names = frozenset(known)
    needed = known[: code.co_argcount - len(function.__defaults__ or ())]
    takes_others = bool(code.co_flags & VARIABLE_KEYWORDS)  # which it explains itself

    @wraps(function)
    def call(*arguments: P.args, **keywords: P.kwargs) -> R:
        if not takes_others and not names.issuperset(keywords):
            check_keywords(function.__name__, keywords, known)
        for name in needed[len(arguments) :]:
            if name not in keywords:
                usage = f"{function.__name__}({', '.join(needed)})"
                raise TypeError(f"{function.__name__} needs {name} too: write {usage}")
        before = partial_result()
        try:
            return function(*arguments, **keywords)
        except KeyboardInterrupt:
            if partial_result() is before:
                keep_partial_result(None)
            raise

    return call


def check_key(what: str, key: Any, known: Iterable[str]) -> None:
    """Raise KeyError unless `key` is one of the names that a result has."""
    names = list(known)
    if not isinstance(key, str) or key not in names:
        raise KeyError(f"no {what} {abbreviate(key)}: name one of {', '.join(names) or 'none'}")


def with_article(kind: type) -> str:
    """A class in a message: "an ImpactLaw"."""
    return f"a{'n' * kind.__name__.startswith(tuple('AEIO'))} {kind.__name__}"


def unknown_parameter(owner: str, name: Any, known: Sequence[str], hint: str = "") -> TypeError:
    """The error for a parameter that does not exist, the same wherever parameters are named.

    A TypeError, as Python's for an unknown keyword, since parameters are keywords of models.
    """
    return TypeError(
        f"{owner} has no parameter {abbreviate(name)}{hint or did_you_mean_or_known(name, known)}"
    )


def with_cure(error: OSError, path: Any, cure: str) -> OSError:
    """An error of the system about a file, of the same class, with its path and what can be done."""
    if error.errno is None or type(error).__module__ != "builtins":  # of a library, such as pillow's
        return OSError(f"{path} cannot be used ({error}): {cure}")
    return type(error)(error.errno, f"{error.strerror}: {cure}", str(path))
