"""docs/performance.md, written by `frictionlab bench -o docs`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from frictionlab.file_writing import write_text

from . import harness, page_figures
from .harness import WorkPrecisionRow, scenes
from .many_runs import EQUILIBRIUM_SHARE

PAGE, PICTURE = "performance.md", Path("images", "performance.png")

HEAD = """\
# Performance

Written by `frictionlab bench -o docs`. Absolute times belong to the machine; the columns "x" are ratios
of one run, which is what to compare; [exact-and-fast.md](exact-and-fast.md) explains it in three
pictures. Times are medians of interleaved runs on one core, the caches warm; those of more
than {slow:g} s are measured once. What the tools compile is compiled before. `frictionlab bench --quick`
takes a fraction of the time. Load average of the machine when it began and when the scenes were done, of
which one is this command's own work: {loads}.

## Run time against error

![Error against wall time]({picture})

Down and to the left is better. Every method runs the same automaton with the same resets; other tools
integrate and find the events themselves, with right-hand sides compiled for the scene; scipy's implicit
methods are given the exact Jacobian. Steps are the tool's own that were accepted. "Missed" are the events
too few, where their number does not depend on when chatter is cut off. "Interpreted" is the same method
without native code: the same result to the last bit. All need a direction for every event, and some
have zeros within 1e-12 s of the start of a mode passed over, or they find for ever the zero they have just
left. diffrax is given the smallest of the guards as one event: of several within a step it takes the first
in its list, not in time; the state at an event is its interpolation. "Model made smooth" has tanh for the
sign of friction and a contact that springs back instead of impacts: it is another model, and its error is
of the size of the motion. References: mpmath with 40 digits for A, B and C
(`tests/reference/slider_mpmath.py`, which shares no code with the package); for D the solver itself with
another order and the limit of chatter taken at 1e-9 s; closed forms for the others.
"""

SWITCHES = """\

## What each nonlinearity costs

Scene B with nonlinearities left out. Guards, products (squares and quotients included) and operations are
summed over the modes of the tape; what a scene lacks is not there. Times are with native code for every mode.
The first call is that of a fresh process with warm caches: model, equations, kernels from the cache, one
simulated second. The last row is the import before it.

"""

NATIVE = """\

What comes before that, once on a machine: native code of a mode, written and compiled by LLVM in the
background. Later processes load it from the cache.

"""

MANY = """\

## Many runs at once

`fl.ensemble`: runs of one structure whose mode is the same take their steps side by side, four in the lanes
of one vector, on one core; every run is what it would be alone, to the last bit. Values of mu_k from 2 to 2.5
(C, 1 s) and from 0.2 to 1 (B, 20 s), from rest. It pays where no events come between: with stick and
separation the runs are seldom in one mode for long, and threads do better. Where one of few runs takes
many more steps than the others, as of eight of B, sliding only, it ends alone.

"""

SWEEP = """\

## Fig. 9's sweep

60 values of mu_k, from rest and from near the equilibrium, 300 s each, scene B otherwise. A fixed step
runs one value in ten and is scaled up. Two workers are two threads: the kernels hold no GIL.

"""

STABILITY = """\

## Linear stability

Equilibrium and eigenvalues of the slider for 10,000 values of mu_k, the modes tracked by their vectors,
against a loop of `fl.eigenvalues`; and the whole search for changes of stability. numpy solves the
eigenvalue problems.

"""

MULTIPLIERS = """\

## Floquet multipliers

Of the slider's cycle at mu_k = 1.4, from the orbit that is known: the tangent tape runs one period and
carries all directions along it; central differences run two periods for each state. One multiplier is 1 and
one is 0 exactly, as the cycle sticks; the largest other is compared with differences of two steps,
extrapolated.

"""

BASINS = """\

## Basins of attraction

Share of random initial states of the bistable oscillator (belt at 1.5) that comes to rest; {share} is known
independently. The exact runs end as soon as they are on an attractor. Those of the model made smooth,
tanh(v_r/width) for the sign of friction, all last 300 s, by scipy's LSODA with a compiled right-hand side and
a relative tolerance of 1e-6. One worker; the column "x" is of this run.

"""

EXPLORER = """\

## A step of an explorer's slider

`fl.explore` with four panels (response, phase plane, forces, spectrum), 20 s simulated: from the new value of
a slider to the bytes of four new pictures. A browser adds the way there and back. The sliders in sight are
moved step by step, once before without being timed. The worst steps are those where limits of axes change, so
that these are drawn anew. The explorer's default method has a tolerance of 1e-7, and under Eq. (13) it
replaces flights below 0.4 ms by their limit.

"""

PAGES = """\

## A slider of an exported page

`fl.export_page`, in a Chromium without a graphics card, 1280 pixels wide: a new value of mu_k in every frame,
the whole run computed and drawn. A screen shows a picture every 16.7 ms. A run is cut at 40 ms while the
slider moves, and plots are drawn in turns where all of them would take longer than a frame.

"""

TAIL = """\

## How it is fast

* A mode gets machine code of its own once it has been run for long: a tenth of a second in the
  background, once on a machine and for all tolerances. It gives what the interpreter gives to the last bit
  ([architecture.md](architecture.md)).
* The whole loop of steps, roots, resets and mode choice is one kernel that allocates nothing and counts
  no references.
* A scene without any nonlinearity goes on by one affine map, computed once: a step is a product with a
  matrix.
* Chatter is replaced by its limit, a mode of its own.
* Neither parameter values nor toggles nor laws compile the kernels; those take half a minute, once on a
  machine.
* The tolerance barely matters for the cost: the order follows it.
"""


def load_average() -> str:
    """Load average of the last minute, where the system knows it."""
    return f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"


def write_performance(
    folder: Path, rows: Sequence[WorkPrecisionRow], tables: Sequence[str], loads: Sequence[str]
) -> Path:
    """Write the page and its picture; `tables` come in the order of their heads above."""
    (folder / PICTURE.parent).mkdir(parents=True, exist_ok=True)
    page_figures.draw_work_precision(rows).savefig(folder / PICTURE, dpi=110)
    text = HEAD.format(slow=harness.SINGLE_RUN_ABOVE, picture=PICTURE.as_posix(), loads=", ".join(loads))
    for name, scene in scenes().items():
        table = harness.work_precision_table([row for row in rows if row.scene == name])
        text += f"\n### {name}: {scene.text}, {scene.t_end:.5g} s\n\n{table}\n"
    heads = (
        SWITCHES,
        NATIVE,
        MANY,
        SWEEP,
        STABILITY,
        MULTIPLIERS,
        BASINS.format(share=EQUILIBRIUM_SHARE),
        EXPLORER,
        PAGES,
    )
    for head, table in zip(heads, tables, strict=True):
        text += f"{head}{table}\n"
    return write_text(folder / PAGE, text + TAIL)
