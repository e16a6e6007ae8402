"""Names as LaTeX: Greek letters and indices of parameters and coordinates."""

import re

# in LaTeX; all other coordinates are lengths
ANGLE_LETTERS = {name: rf"\{name}" for name in ("theta", "psi", "alpha", "beta", "gamma")}
ANGLE_LETTERS["phi"] = r"\varphi"
GREEK = frozenset(
    "alpha beta gamma delta epsilon zeta eta theta kappa lambda mu nu xi rho sigma tau phi psi omega "
    "Gamma Delta Theta Lambda Xi Sigma Phi Psi Omega".split()
)
NO_LETTER = re.compile(r"[\W\d_]")
LATEX = re.compile(r"[\\{}^$]")  # a character that no name has but one that is LaTeX


def symbol_of(name: str) -> str:
    r"""LaTeX of a name: mu_k is \mu_{k}, v_belt has its word as an index, heat_capacity is upright words.

    A name that is LaTeX itself stays what it is.
    """
    if LATEX.search(name):
        return name.strip("$")
    letter = NO_LETTER.split(name)[0]
    index = name.removeprefix(letter).removeprefix("_")
    if len(letter) != 1 and letter not in GREEK:
        return _upright(name)
    symbol = ANGLE_LETTERS.get(letter, letter if len(letter) == 1 else rf"\{letter}")
    if not index:
        return symbol
    return f"{symbol}_{{{index if len(index) == 1 or index.isdigit() else _upright(index)}}}"


def _upright(words: str) -> str:
    return rf"\mathrm{{{words.replace('_', ' ')}}}".replace(" ", r"\ ")
