"""Names of coordinates are free: what looks like HTML, TeX or Python is shown as it is."""

import re

import pytest
from matplotlib import pyplot

import frictionlab as fl
from frictionlab.models import Friction, Mechanics
from frictionlab.pages.export import FRONT_END, text_of
from tests.helpers.cases import slow_but

IMAGE = "<img src=x onerror=alert(1)>"
NAMES = [IMAGE, r"$\alpha$ & co", "x{y", "x_", "x_1", "a$b", r"\frac", "x y", "lambda"]


def named(name):
    """A mass on a belt with that name for its coordinate."""

    @fl.model
    class Odd(fl.MechanicalModel):
        k: float = fl.parameter(1.0, unit=IMAGE, symbol="k", meaning=IMAGE, range=(0.5, 2.0))
        friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.5, mu_s=1.0)

        coordinates = (name,)
        period = 6.0

        def mechanics(self, q, v):
            x, rate = getattr(q, name), getattr(v, name)
            contact = Friction(0.2 - rate, 1.0, self.friction)
            return Mechanics(kinetic=rate**2 / 2, potential=self.k * x**2 / 2, contacts=(contact,))

    return Odd()


@pytest.mark.parametrize("name", slow_but(NAMES[::2], NAMES))
def test_it_is_shown_and_nothing_else_happens(name, tmp_path):
    model = named(name)
    run = fl.simulate(model, 10.0, progress=False)
    fl.plot_run(run)
    pyplot.savefig(tmp_path / "run.png")
    pyplot.close("all")
    assert len(run[f"{name}'"]) == len(run.t)


def test_no_name_becomes_html():
    model = named(IMAGE)
    explorer = fl.explore(model, panels=("response",))
    assert explorer.error is None
    assert "&lt;img" in model.describe()._repr_html_()
    assert "<img" not in model.describe()._repr_html_()
    scripts = "".join(text_of(f"{name}.js") for name in (*FRONT_END, "python_engine"))
    assert not re.search("innerHTML|outerHTML|insertAdjacentHTML|document.write", scripts)  # only texts


def test_a_section_may_have_any_name():
    assert fl.steady_state(named("lambda"), transient=20.0, window=30.0, section="lambda'").kind == "periodic"
