"""What the commands share: a parser with errors of one line, spellings, the options of a model (`--model`,
`--set`, `--without`), checks before a run, and output, also as JSON, to streams that may be closed or full.
"""

from __future__ import annotations

import argparse
import ast
import json
import math
import os
import re
import sys
from collections.abc import Mapping, Sequence
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from frictionlab.validation import nearest_name

if TYPE_CHECKING:
    from frictionlab.models.model import ModelOrAutomaton

# Negative numbers, "-1e-3" and "-inf" included, and lists of them: argparse mistakes some for options.
NEGATIVE_NUMBER = re.compile(r"-(\d|\.\d|inf|nan)", re.IGNORECASE)
DEFAULT_MODEL = "SliderOnBelt"
EXIT_FAILED = 1  # the exit status of a command that did not do what was asked
SHOWN = {"SliderOnBelt": {"mu_k": 1.4}}  # values used unless others are given: the paper's cycle is there
OWN_FILE = re.compile(r"(?P<path>.+\.py)(?::(?P<name>.*))?")
PICTURE_FORMATS = (".png", ".pdf", ".svg", ".eps", ".jpg", ".webp")


class OneLineParser(argparse.ArgumentParser):
    """A parser whose errors are one line."""

    def error(self, message: str) -> NoReturn:
        flush_output()
        self.exit(2, f"{self.prog}: error: {' '.join(message.split())}\n")


def add_command(commands: Any, name: str, about: str, description: str, epilog: str) -> OneLineParser:
    """A command's parser, whose help keeps the lines of its texts."""
    return commands.add_parser(
        name,
        help=about,
        description=description,
        epilog=epilog,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )


def flush_output() -> None:
    """Write what standard output still holds; OSError where that fails.  There may be none (pythonw)."""
    if sys.stdout is not None:
        sys.stdout.flush()


def complain(program: str, text: str) -> None:
    """Write a line to standard error, if that can be done."""
    from frictionlab.interruption import tell

    tell(f"{program}: {text}")


def discard(stream: Any) -> None:
    """Redirect the stream to the null device, with all that it still holds."""
    handle = os.open(os.devnull, os.O_WRONLY)
    os.dup2(handle, stream.fileno())
    os.close(handle)


def discard_unwritten(stream: Any) -> None:
    """Discard what cannot be written: the interpreter would try again when it ends, and complain."""
    try:
        if stream is not None:
            stream.flush()
    except OSError:
        discard(stream)


def normalise_arguments(argv: Sequence[str]) -> list[str]:
    """The arguments with negative numbers joined to their options."""
    normalised: list[str] = []
    for word in argv:
        option = normalised[-1] if normalised else ""
        if NEGATIVE_NUMBER.match(word) and option.startswith("--") and "=" not in option:
            normalised[-1] += f"={word}"
        else:
            normalised.append(word)
    return normalised


def unknown_option_text(words: Sequence[str], parser: argparse.ArgumentParser) -> str:
    """The message for words that belong to no option, with the most similar options as suggestions."""
    word = words[0]
    if not word.startswith("-"):
        return f"unexpected argument {word!r}: values follow their option, as in --set mu_k=1.4"
    option = word.partition("=")[0]
    options = [name for action in parser._actions for name in action.option_strings]
    bare = {name.lstrip("-"): name for name in options}  # without the dashes, which all options have
    near = nearest_name(option.lstrip("-"), bare)
    parameters = "; parameters are --set mu_k=1.4" if "set" in bare else ""
    hint = f"see {parser.prog} --help{parameters}" if near is None else f"did you mean {bare[near]!r}?"
    return f"unknown option {option!r}: {hint}"


def add_sweep_options(group: Any) -> None:
    """Add `--workers` and `--resume`, for commands that run sweeps."""
    group.add_argument("--workers", type=int, metavar="N", help="threads (default: one for each processor)")
    group.add_argument(
        "--resume", metavar="FOLDER", help="keep sweeps there as they come, and go on with those found there"
    )


def check_workers(workers: int | None) -> None:
    """Raise an error unless it is None or a positive integer."""
    from frictionlab.validation import check_number

    if workers is not None:
        check_number("--workers", workers, integer=True, least=1, cure="leave it out for one each processor")


def check_files(args: argparse.Namespace) -> None:
    """Raise ValueError if the picture or the saved run could not be written after the run."""
    if args.output is not None:
        _check_picture(Path(args.output))
        check_writable(Path(args.output), "-o")
    if args.save is not None:
        path = Path(args.save)
        check_writable(path if path.suffix == ".npz" else path.with_name(path.name + ".npz"), "--save")


def _check_picture(path: Path) -> None:
    if path.suffix.lower() not in PICTURE_FORMATS:
        raise ValueError(f"-o must end in one of {', '.join(PICTURE_FORMATS)}, got {str(path)!r}: take .png")


def check_writable(path: Path, option: str) -> None:
    """Raise ValueError if a file could not be written after the run."""
    folder = path.parent
    if not folder.is_dir():
        raise ValueError(f"{option} needs an existing folder, there is no {str(folder)!r}: make it first")
    if path.is_dir():
        raise ValueError(f"{option} must be a file, {str(path)!r} is a folder: add a file name")
    if not os.access(path if path.exists() else folder, os.W_OK):
        raise ValueError(f"{option} cannot be written to {str(path)!r}: permission denied, choose another")


def add_model_options(group: Any) -> None:
    """Add `--model`, `--set` and `--without`: which model, with which values and nonlinearities."""
    text = (
        "of `frictionlab models`, with laws as in Python if you like, or a model, structure or automaton of "
        f"a file of yours, mymodels.py:Crank, which is run (default: {DEFAULT_MODEL})"
    )
    group.add_argument("--model", metavar="NAME", default=DEFAULT_MODEL, help=text)
    add_values(group)
    text = "leave nonlinearities out: cubic, nonsmooth, geometry, as far as the model has them"
    group.add_argument("--without", nargs="+", action="extend", default=[], metavar="NAME", help=text)


def add_values(group: Any) -> None:
    """Add `--set`: values of parameters, as in `--set mu_k=1.4 v=-1`."""
    text = "values of parameters, such as mu_k=1.4 v=-1; `frictionlab models NAME` lists them"
    group.add_argument(
        "--set", nargs="+", action="extend", default=[], metavar="P=X", dest="values", help=text
    )


def add_json(group: Any) -> None:
    """Add `--json`: print one JSON object instead of text."""
    group.add_argument("--json", action="store_true", help="print one JSON object, and nothing else")


def model_from_options(args: argparse.Namespace) -> Any:
    """The model with its laws and values; raises ValueError or TypeError as the model does."""
    model = model_of(args.model)
    values = SHOWN.get(args.model, {}) | values_of(args.values)
    if not args.without:
        return model.replace(**values)
    if not hasattr(model, "without"):
        kind = type(model).__name__
        raise ValueError(f"--without needs a model, {args.model!r} is of class {kind}: leave it out")
    return model.without(*args.without).replace(**values)


def values_of(words: list[str]) -> dict[str, float]:
    """Values by parameter name, from words such as mu_k=1.4; raises ValueError for other words."""
    return dict(_value_of(word) for word in words)


def _value_of(word: str) -> tuple[str, float]:
    name, equals, text = word.partition("=")
    try:
        if not (name.isidentifier() and equals):
            raise ValueError
        return name, float(text)
    except ValueError:
        rule = "--set takes a parameter, = and a number without spaces"
        raise ValueError(f"{rule}, got {word!r}: write --set mu_k=1.4") from None


def model_of(text: str) -> Any:
    """The model that a text names: `DenHartog`, `MassOnBelt(friction=Stribeck(v_s=0.1), c=0.1)`, or
    `mymodels.py:Crank`.

    Raises
    ------
    ValueError, TypeError
        For names that are no models or laws, and for values that the model refuses.
    """
    from frictionlab.models.library.catalogue import CLASSICS
    from frictionlab.validation import did_you_mean

    if own := OWN_FILE.fullmatch(text):
        return _model_of_file(Path(own["path"]), own["name"])
    name, names = text.partition("(")[0].strip().removeprefix("fl."), model_names(CLASSICS)
    if name not in names and name not in (names := model_names()):  # only now the zoo is loaded
        listed = ", ".join(names)
        hint = did_you_mean(name, names) or ": `frictionlab models` says what each is"
        raise ValueError(f"--model must be one of {listed}, got {name!r}{hint}")
    try:
        node = ast.parse(text if "(" in text else f"{text}()", mode="eval").body
    except SyntaxError:
        raise ValueError(f"--model must be a name or a call, got {text!r}: close what is open") from None
    return _component(node, text)


def _model_of_file(path: Path, name: str | None) -> Any:
    """The model, structure or automaton in a Python file, which is run: that of the name, or the only one."""
    from frictionlab.automaton import HybridAutomaton
    from frictionlab.models import Model
    from frictionlab.models.model import MovingSystem
    from frictionlab.validation import did_you_mean

    module = _run_file(path)
    found = {
        key: value
        for key, value in vars(module).items()
        if isinstance(value, (Model, MovingSystem, HybridAutomaton))
        or (isinstance(value, type) and issubclass(value, Model) and value.__module__ == module.__name__)
    }
    if not found:
        raise ValueError(f"--model needs a model, a structure or an automaton, {path} has none: write one")
    if name is None and len(found) == 1:
        (name,) = found
    if name not in found:
        cure = did_you_mean(name or "", found) or f": write {path}:{next(iter(found))}"
        names = ", ".join(found)
        raise ValueError(f"--model must be one of {names} of {path}, got {name or 'no name'}{cure}")
    chosen: Any = found[name]
    return chosen() if isinstance(chosen, type) else chosen


def _run_file(path: Path) -> Any:
    """The module that a Python file makes, which may import its neighbours."""
    if not path.is_file():
        raise ValueError(f"--model needs an existing file, there is no {str(path)!r}: mend its name")
    spec = spec_from_file_location(path.stem if path.stem not in sys.modules else f"own_{path.stem}", path)
    assert spec is not None  # it ends in .py
    assert spec.loader is not None
    module = sys.modules[spec.name] = module_from_spec(spec)  # where classes look their annotations up
    sys.path.insert(0, str(path.parent))
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        what = f"{type(error).__name__}: {error}"
        raise ValueError(f"--model needs a file that runs, {path} ends in {what}: mend it") from error
    return module


def model_names(topic: str | None = None) -> list[str]:
    """Names of the package's models, or of those of a topic, in the order of their table."""
    from frictionlab.models.library.catalogue import list_models

    return list(dict.fromkeys(row.call.partition("(")[0] for row in list_models(topic)))


def _component(node: ast.expr, text: str) -> Any:
    """The model or law that a call with keywords makes; for any other expression the value of a literal."""
    import frictionlab as fl
    from frictionlab.components.component import Component

    if not isinstance(node, ast.Call):
        return _literal(node, text)
    name = node.func.id if isinstance(node.func, ast.Name) else getattr(node.func, "attr", "")
    kind = getattr(fl, name) if name in fl.__all__ else None
    if node.args or not (isinstance(kind, type) and issubclass(kind, Component)):
        laws = "laws by their names, values as keywords"
        raise ValueError(
            f"--model takes {laws}, got {ast.unparse(node)!r}: write MassOnBelt(friction=Stribeck())"
        )
    return kind(**{str(each.arg): _component(each.value, text) for each in node.keywords})


def _literal(node: ast.expr, text: str) -> Any:
    try:
        return ast.literal_eval(node)
    except ValueError:
        rule = "--model takes numbers, texts and laws as values"
        raise ValueError(f"{rule}, got {ast.unparse(node)!r} in {text!r}: write numbers out") from None


def model_data(model: ModelOrAutomaton) -> dict[str, Any]:
    """The entries about a model in the commands' JSON."""
    from frictionlab.automaton import HybridAutomaton

    values = model.values if isinstance(model, HybridAutomaton) else model.parameters
    return {"model": type(model).__name__, "call": repr(model), "parameters": dict(values)}


def print_json(data: Mapping[str, Any]) -> None:
    """Print one JSON object on standard output; its values may be those of numpy."""
    print(json.dumps(_plain(data), indent=2, ensure_ascii=True, allow_nan=False))


def _plain(value: Any) -> Any:
    """The value in the types of JSON: objects, lists, texts, finite numbers, null for numbers not finite."""
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, Mapping):
        return {str(name): _plain(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if isinstance(value, complex):
        return {"real": _plain(value.real), "imag": _plain(value.imag)}
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int) else str(value)
