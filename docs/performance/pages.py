"""The pages that `measure.py -o docs` writes: docs/performance.md, with all the numbers, and
docs/exact-and-fast.md, three pictures for students.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from datetime import date
from pathlib import Path
from types import MappingProxyType

import numpy as np

import page_figures
import work_precision
from beside_heyoka import TURNS
from frictionlab.file_writing import write_text
from frictionlab.hybrid.methods.taylor import Taylor
from many_runs import EQUILIBRIUM_SHARE
from processors import processor, vectors
from reference_scenes import scenes
from single_costs import NonlinearityCost
from work_precision import WorkPrecisionRow

PAGE, PICTURE = "performance.md", Path("images", "performance.png")
GROWTH_PICTURE = Path("images", "growth.png")

HEAD = """\
# Performance

How many times our time other tools take, and where ours goes. `python docs/performance/measure.py -o docs`
measures and writes this page in a clone, after `pip install -r docs/performance/requirements.txt` for the
other tools. `--part "Starting"` measures one part and leaves the others as they are; each says when and on
what it was measured. [exact-and-fast.md](exact-and-fast.md) explains it in three pictures.
"""

RATIOS = """\
The columns are scenes. In A the slider on a belt sticks, slips and lifts off for 20 s, without the moving
load; B is A with it. C slides only, for 1 s, on a stiff contact that is strongly nonlinear. D is B with
Eq. (13) as printed, by which the slider chatters, for 1 s. Coulomb is a mass on a belt that sticks and slips
a thousand times. In the linear scene all three nonlinearities are left out; it has no events.

A number is the tool's time divided by ours, for each of its tolerances, the tighter one first. Ours is
the shortest of our own runs whose error is not larger than the tool's, so that nothing is gained by being
less exact; where all of ours have a larger error, our most exact one, in brackets.

{ratios}

heyoka is given the operations of our own tape, and both ways in which it multiplies and adds. At events its
resets are Python here; ours are compiled. Times are processor times, in which other work on the machine
counts little, medians of runs in turns with warm caches; those of more than {slow:g} s are measured once.

Of our time on the linear scene Python around the kernel takes two thirds, the same for every tolerance.
C is smooth and stiff. At the same tolerance of 1e-9 we take two thirds of the time of heyoka with fast_math,
whose error is then 200 times smaller. So the table compares it with our run at 1e-12, which takes four fifths
of heyoka's time: we take 807 steps of order 28, heyoka 2,847 of order 12. For all steps these are 23,000
orders beside 34,000, but 1,100,000 products in convolutions beside 720,000. heyoka rounds products and sums
together, which we do not, as not every processor can; and it keeps no steps, of which we keep all, to give
the motion at any time. A tenth of our time is a run's fixed cost in Python. Orders from 22 to 30 take nearly
the same time at 1e-12. Multiplications and additions fill the jets' time.

Ours at each tolerance, in ms. It falls as the tolerance is loosened, but for the scatter:

{ours}
"""

WORK = """\
![Error against run time]({picture})

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
another order and the limit of chatter taken at 1e-9 s; closed forms for the others. A tool that is not
installed has a row that says so.
"""

# What the parts below the scenes say before their tables, in the sequence of the page.
PARTS: Mapping[str, str] = MappingProxyType(
    {
        "At heyoka's tolerance": """\
Our share of the time of the faster heyoka at its own tolerance, 1e-15 and then 1e-9, whatever the errors:
the median of {turns} turns in one process. A process that does not see AVX-512 stands for another processor.
That of the linear scene changes most from one measurement to the next, by up to a third:
two thirds of our time there are Python.
""",
        "Where the time goes": """\
One run at a tolerance of 1e-15. Jets are the Taylor coefficients of all steps; the floor is the time in which
one core does as many multiplications and additions in a product of matrices, which fuses the two (we do not,
as not every processor does). Each coefficient of a jet needs those before it, which keeps a single run from
that floor. An event is its location, its reset and the choice of the next mode, and what the guards cost in
all steps.
""",
        "What each nonlinearity costs": """\
Scene B with nonlinearities left out. Guards, products (squares and quotients included) and operations are
summed over the modes of the tape; what a scene lacks is not there. Times are with native code for every mode.
The first call is that of a fresh process with warm caches: model, equations, kernels from the cache, one
simulated second. The last row is the import before it.
""",
        "Native code": """\
Once on a machine: native code of a mode, written and compiled by LLVM in the background. Later processes load
it from the cache.
""",
        "Starting": """\
From the start of a process to its end, with the byte code of all modules there. The first process has an
empty cache folder: in a clone it derives the equations with sympy and keeps what it has derived, as arrays
and formulas, for later ones, which do not load sympy. A wheel carries these; its first process also compiles
machine code of modes. A law of one's own is derived in every process. numba is loaded in none. The floor
is what a process with the same libraries takes that does nothing else; "x" is a later one of a clone, in
floors.
""",
        "Many runs at once": """\
`fl.ensemble`: runs of one structure whose mode is the same take their steps side by side, in the lanes of one
vector: four, or eight where AVX-512 is. They are shared out to threads, one for each core, as the kernels
hold no GIL. Every run is what it would be alone, to the last bit. On two cores the time is that of the clock.
By itself fl.ensemble takes no more threads than have full lanes: with lanes of eight 8 runs stay on one. The
column of two cores is for workers=2.
Values of mu_k from 2 to 2.5 (C, 1 s) and from 0.2 to 1 (B, 20 s), from rest. It pays most where no events
come between, of which each run finds and handles its own. Of few runs one that takes many more steps than
others ends alone.
""",
        "Fig. 9's sweep": """\
60 values of mu_k, from rest and from near the equilibrium, 300 s each, scene B otherwise. A fixed step and
heyoka run one value in ten and are scaled up. heyoka's equations are compiled for each value before; its
batch mode holds runs of one mode only, and does not go on where their events fall apart. Two workers are two
threads: the kernels hold no GIL.
""",
        "Linear stability": """\
Equilibrium and eigenvalues of the slider for 10,000 values of mu_k, the modes tracked by their vectors,
against a loop of `fl.eigenvalues`; and the whole search for changes of stability. numpy solves the
eigenvalue problems.
""",
        "Floquet multipliers": """\
Of the slider's cycle at mu_k = 1.4, from the orbit that is known: the tangent tape runs one period and
carries all directions along it; central differences run two periods for each state. One multiplier is 1 and
one is 0 exactly, as the cycle sticks; the largest other is compared with differences of two steps,
extrapolated.
""",
        "Basins of attraction": """\
Share of random initial states of the bistable oscillator (belt at 1.5) that comes to rest; {share} is known
independently. The exact runs end as soon as they are on an attractor; all others last 300 s: RK4 and heyoka
with the same automaton, and the model made smooth, tanh(v_r/width) for the sign of friction, by scipy's LSODA
with a compiled right-hand side and a relative tolerance of 1e-6. One worker; the column "x" is of this run.
""",
        "A slider of an exported page": """\
`fl.export_page`, in a Chromium without a graphics card, 1280 pixels wide: a new value of mu_k in every frame,
the whole run computed and drawn. A screen shows a picture every 16.7 ms. A run is cut at 20 ms while the
slider moves, and axes, labels and legends are drawn only where they change.
""",
        "How it grows": """\
![Time and memory against sizes]({growth})
""",
    }
)

TAIL = """\

## How it is fast

* A mode gets machine code of its own once it has been run for long: a tenth of a second in the
  background, once on a machine and for all tolerances. It gives what the interpreter gives to the last bit
  ([machine code of modes](architecture/machine-code-of-modes.md)).
* The whole loop of steps, roots, resets and mode choice is one kernel that allocates nothing and counts
  no references.
* A scene without any nonlinearity goes on by affine maps of one to eight steps, computed once: a step is a
  product with a matrix, and few steps of a block wait for one another.
* A model keeps its automaton, an automaton its program and numbers, so that a warm run goes through some 60
  Python functions around its kernels.
* Chatter is replaced by its limit, a mode of its own.
* Neither parameter values nor toggles nor laws compile the kernels; those are compiled with the package.
* The order falls with the tolerance more slowly than the steps grow, so that a looser one takes less time.
  Without events it is higher still.
"""

STUDENTS_TEXT = """\
# Exact and fast, in three pictures

Written by `python docs/performance/measure.py -o docs`, like [performance.md](performance.md), which has all
the numbers. For students who have solved an equation of motion on a computer before, say by Runge-Kutta.

The model is a slider that is pressed onto a moving belt. It can stick to the belt, slip on it, or lift off. A
change from one of these *modes* to another is an *event*. In each mode certain quantities stay positive, such
as the height of a flying slider over the belt; they are called *guards*, and an event is where a guard comes
to zero.

## 1. Error against cost

![Error against processor time of three methods](images/{cost})

Each point is one run of the same 20 s of motion with its {events} events. To the right is more computing
time, upwards is a larger error at the end. So *down and to the left is better*. Both axes are logarithmic: a
division is a factor of ten, and a power law is a straight line.

Each method has one thing to choose: its step, or its tolerance (the error it may make in a step, `tol` and
`rtol` in the picture). Another choice moves the point along the line of the method. The slope of the line is
the *order*: the error of a method of order p falls with the p-th power of the step, and the number of steps
grows as the step falls. RK4, the classical Runge-Kutta method, has order 4. Ten times as many steps make its
error 10,000 times smaller, which is the dashed line. The points follow it only roughly, since locating the
events takes time as well, and that does not depend on the step.

The line of frictionlab is nearly upright: more digits cost next to nothing. It follows the motion by power
series in time and takes more terms of them where more digits are asked for, {low} terms at a tolerance of
1e-6 and {high} at 1e-15, so that its steps need not become short. A high order is what pays where much
accuracy is wanted.

Try it yourself. By which factor does the error fall as the step is halved?

```python
import numpy as np
import frictionlab as fl

model = fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full"))
exact = fl.simulate(model, 1.0).final_state
for step in (4e-4, 2e-4, 1e-4, 5e-5):
    run = fl.simulate(model, 1.0, method=fl.RK4(step=step))
    print(step, np.abs(run.final_state - exact).max())
```

## 2. A missed event is not a small error

![Hops of the slider, and errors of four methods around a landing](images/{missed})

The slider has been in the air and lands. By the impact law of the paper, its Eq. (13) as printed, it does not
come to rest on the belt: it leaves again at once, {height:.1f} µm high, lands, and so on (dashed, above). The
first of these hops takes {hop:.3f} ms. A method with a fixed step looks at the guards when a step is over
(dots); where one is negative, it searches that step for the event. So it finds the first landing. But the
step of 0.2 ms in which that happens ends just after the second landing. There the slider is on the belt, as
a slider in contact should be, and the method finds nothing to do: the second landing is not seen, its impact
is left out, and the slider goes on into the belt.

Below is the error of the whole state. Before the landing each method has its own small error, and the smaller
the step, the smaller it is. With the landing missed, the error grows within milliseconds to a share of the
motion itself, more than a million times what it was, and there it stays. A step ten times shorter makes the
error *before* 10,000 times smaller. It sees the first hops, too. But the hops become shorter and shorter, and
a few milliseconds later one fits between two of its looks. After that the method that was 10,000 times better
is about ten times better. Accuracy between the events does not help once an event is missed: from there on
another motion is computed, however accurately.

{table}

Where every event is located, that is, the zero of the guard is looked for *within* the step, the error stays
what the tolerance says: even the coarse 1e-6 is better in the end than the short step. Here a guard is a
polynomial in time on each step, and the zeros of a polynomial can be counted, so that none is passed over.

Try it yourself. Is there a step that sees enough? How does the error fall now as the step is halved?

```python
import numpy as np
import frictionlab as fl

model = fl.SliderOnBelt(mu_k=1.4)  # Eq. (13) as printed
exact = fl.simulate(model, 0.2)
for step in (4e-4, 2e-4, 1e-4, 5e-5, 2.5e-5):
    run = fl.simulate(model, 0.2, method=fl.RK4(step=step))
    print(step, np.abs(run.final_state - exact.final_state).max(), len(run.events), len(exact.events))
```

[step-size.md](step-size.md) shows what this does to the vibration in the end.

## 3. What each switch costs

![Processor time of the eight scenes with and without nonlinearities](images/{bars})

The model has three nonlinearities, and each can be switched off: *cubic*, a contact spring that grows stiffer
as it is compressed; *nonsmooth*, sticking and lifting off, without which the slider always slides;
*geometry*, the belt's rotation and the load that travels with the slider. That makes eight models. Each bar
is one, named by what is switched on; its length is the computing time for one second of motion.

The numbers beside a bar say how much there is to compute. The equations of motion become a list of
*operations*, sums and products, called the tape. *Products* are those operations that multiply two changing
quantities: none of them is left in a linear model. *Guards* are watched in every step. *States* are the
coordinates and velocities. All modes are counted together, though only one is at work at a time. What is
switched off is gone from the list, rather than multiplied by zero.

The most expensive switch is nonsmooth. Its guards have to be examined in each step, and each event ends a
step early. A quarter of the tape is left without it, but more than half of the time, as only one mode is at
work at a time. So a longer tape does not mean a longer time in proportion: the time is that of a step,
operations and guards together, times the number of steps.

Try it yourself. Which switch changes the number of steps, and which the time that a step takes?

```python
from timeit import repeat
import frictionlab as fl

model = fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full"))
for names in ((), ("cubic",), ("geometry",), ("nonsmooth",), ("cubic", "nonsmooth", "geometry")):
    one = model.without(*names)
    steps = fl.simulate(one, 20.0).stats["steps"]
    seconds = min(repeat(lambda: fl.simulate(one, 20.0), number=1, repeat=50))
    print(names, steps, "steps,", 1e6 * seconds / steps, "µs each")
```
"""

STUDENTS_PAGE, IMAGES = "exact-and-fast.md", "images"
COST_PICTURE, MISSED_PICTURE, SWITCHES_PICTURE = (
    "error-against-cost.png",
    "missed-event.png",
    "cost-of-switches.png",
)


def measured_on() -> str:
    """The day, the processor and how busy it is: what a part says of its numbers."""
    load = f", load {os.getloadavg()[0]:.0f}" if hasattr(os, "getloadavg") else ""
    return f"{date.today()}, {processor()} ({vectors()}), {os.cpu_count()} cores{load}"


def folded(title: str, text: str) -> str:
    """A part of the page that a click unfolds."""
    return f"<details>\n<summary>{title}</summary>\n\n{text}\n</details>\n"


def scene_parts(rows: Sequence[WorkPrecisionRow], when: str) -> dict[str, str]:
    """The ratios, and the tables of all scenes."""
    ratios, ours = work_precision.ratio_table(rows), work_precision.own_table(rows)
    text = RATIOS.format(slow=work_precision.SINGLE_RUN_ABOVE, ratios=ratios, ours=ours)
    tables = [folded("The picture, and what is compared", WORK.format(picture=PICTURE.as_posix()))]
    for name, scene in scenes().items():
        table = work_precision.work_precision_table([row for row in rows if row.scene == name])
        tables.append(folded(f"{name}: {scene.text}, {scene.t_end:.5g} s", table))
    return {
        "How many times our time": f"Measured {when}.\n\n{text}",
        "Run time against error": "\n".join(tables),
    }


def draw_scenes(folder: Path, rows: Sequence[WorkPrecisionRow]) -> None:
    """Draw error against run time into the folder of the page."""
    (folder / PICTURE.parent).mkdir(parents=True, exist_ok=True)
    page_figures.draw_work_precision(rows).savefig(folder / PICTURE, dpi=110)


def draw_switches(folder: Path, rows: Sequence[NonlinearityCost]) -> None:
    """Draw what each nonlinearity costs into the folder of the page."""
    (folder / IMAGES).mkdir(parents=True, exist_ok=True)
    page_figures.draw_nonlinearity_costs(rows).savefig(folder / IMAGES / SWITCHES_PICTURE, dpi=110)


def part(title: str, table: str, when: str) -> str:
    """A part below the scenes."""
    text = PARTS[title].format(share=EQUILIBRIUM_SHARE, growth=GROWTH_PICTURE.as_posix(), turns=TURNS)
    return folded(f"Measured {when}", f"{text}\n{table}")


def write_performance(folder: Path, parts: Mapping[str, str]) -> Path:
    """Write the page; a part that is not among `parts` stays as it is on the page."""
    page = folder / PAGE
    written = page.read_text(encoding="utf-8") if page.exists() else ""
    before = dict(each.split("\n", 1) for each in written.split("\n## ")[1:])
    text = HEAD
    for title in ("How many times our time", "Run time against error", *PARTS):
        kept = parts.get(title) or before.get(title) or "Not measured yet.\n"
        text += f"\n## {title}\n\n{kept.strip()}\n"
    return write_text(page, text + TAIL)


def write_exact_and_fast(folder: Path, rows: Sequence[WorkPrecisionRow]) -> Path:
    """Write the page and its pictures, from the rows of scene B; :func:`draw_switches` draws the third."""
    images = folder / IMAGES
    images.mkdir(parents=True, exist_ok=True)
    landing = page_figures.missed_event()
    pictures = {
        COST_PICTURE: page_figures.cost(rows),
        MISSED_PICTURE: page_figures.draw_missed_event(landing),
    }
    for name, picture in pictures.items():
        picture.savefig(images / name, dpi=110)
    return write_text(folder / STUDENTS_PAGE, _students_text(rows, landing))


def _students_text(rows: Sequence[WorkPrecisionRow], landing: page_figures.MissedEvent) -> str:
    hop = np.abs(page_figures.TIMES_NEAR_LANDING - 0.5 * landing.hop) < 0.5 * landing.hop
    return STUDENTS_TEXT.format(
        cost=COST_PICTURE,
        missed=MISSED_PICTURE,
        bars=SWITCHES_PICTURE,
        events=next(row.events for row in rows if row.scene == page_figures.PICTURE_SCENE),
        low=Taylor(tol=1e-6).degree,
        high=Taylor().degree,
        height=1e6 * landing.results[-1].height[hop].max(),
        hop=1e3 * landing.hop,
        table=page_figures.missed_event_table(landing),
    )
