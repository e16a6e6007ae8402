"""docs/exact-and-fast.md, written by `frictionlab bench -o docs`: three pictures for students."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from frictionlab.file_writing import write_text
from frictionlab.hybrid.methods.taylor import Taylor

from . import missed_event, page_figures
from .harness import WorkPrecisionRow
from .single_costs import NonlinearityCost

TEXT = """\
# Exact and fast, in three pictures

Written by `frictionlab bench -o docs`, like [performance.md](performance.md), which has all the numbers. For
students who have solved an equation of motion on a computer before, say by Runge-Kutta.

The model is a slider that is pressed onto a moving belt. It can stick to the belt, slip on it, or lift off. A
change from one of these *modes* to another is an *event*. In each mode certain quantities stay positive, such
as the height of a flying slider over the belt; they are called *guards*, and an event is where a guard comes
to zero.

## 1. Error against cost

![Error against wall time of three methods](images/{cost})

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

![Wall time of the eight scenes with and without nonlinearities](images/{bars})

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
step early. Beside that the cubic term hardly shows, though it is a fifth of the tape. So a longer tape does
not always mean a longer time: the time is that of a step, operations and guards together, times the number
of steps.

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

PAGE, IMAGES = "exact-and-fast.md", "images"
COST_PICTURE, MISSED_PICTURE, SWITCHES_PICTURE = (
    "error-against-cost.png",
    "missed-event.png",
    "cost-of-switches.png",
)


def write_exact_and_fast(
    folder: Path, rows: Sequence[WorkPrecisionRow], switched: Sequence[NonlinearityCost]
) -> Path:
    """Write the page and its pictures, from the rows of scene B and of the switches."""
    images = folder / IMAGES
    images.mkdir(parents=True, exist_ok=True)
    found = missed_event.missed_event()
    pictures = {
        COST_PICTURE: page_figures.cost(rows),
        MISSED_PICTURE: page_figures.draw_missed_event(found),
        SWITCHES_PICTURE: page_figures.draw_nonlinearity_costs(switched),
    }
    for name, picture in pictures.items():
        picture.savefig(images / name, dpi=110)
    return write_text(folder / PAGE, _text(rows, found))


def _text(rows: Sequence[WorkPrecisionRow], found: missed_event.MissedEvent) -> str:
    hop = np.abs(missed_event.TIMES_NEAR_LANDING - 0.5 * found.hop) < 0.5 * found.hop
    return TEXT.format(
        cost=COST_PICTURE,
        missed=MISSED_PICTURE,
        bars=SWITCHES_PICTURE,
        events=next(row.events for row in rows if row.scene == page_figures.PICTURE_SCENE),
        low=Taylor(tol=1e-6).degree,
        high=Taylor().degree,
        height=1e6 * found.results[-1].height[hop].max(),
        hop=1e3 * found.hop,
        table=missed_event.missed_event_table(found),
    )
