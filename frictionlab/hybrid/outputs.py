"""Named outputs of a run, each by the formula of its mode.

Powers in these formulas follow the rule of the tape: a base that rounding has made negative counts as zero.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache

import numpy as np

from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.tape.formulas import Formulas, formulas_of, kept_formulas


def evaluate_outputs(
    automaton: HybridAutomaton,
    names: Iterable[str],
    states: np.ndarray,
    modes: np.ndarray,
    mode_names: Sequence[str],
) -> dict[str, np.ndarray]:
    """Values (N,) of the outputs of these names at `states` (N, n), each by the formula of its mode.

    `modes` (N,) holds indices into `mode_names`; where it is negative no mode could be entered, and the
    outputs are not numbers.
    """
    values = {name: np.full(len(states), np.nan) for name in names}
    for i in np.unique(modes[modes >= 0]):
        chosen = modes == i
        inputs = *states[chosen].T, *automaton.values.values()
        for name, column in values.items():
            column[chosen] = output_formulas(automaton, mode_names[int(i)], name).along_run(*inputs)[0]
    return values


def output_formulas(automaton: HybridAutomaton, mode: str, name: str) -> Formulas:
    """An output in a mode as a formula of the states, then the parameters."""

    def derive() -> Formulas:
        return _derived_output(automaton.mode(mode), name, automaton.states, tuple(automaton.parameters))

    return kept_formulas(automaton.derivations, f"{name} in {mode}", derive)


@lru_cache(maxsize=1024)
def _derived_output(mode: Mode, name: str, states: tuple, parameters: tuple) -> Formulas:
    return formulas_of([*states, *parameters], [mode.outputs[name]])
