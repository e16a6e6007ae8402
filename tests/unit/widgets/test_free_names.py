"""Names of coordinates are free: what looks like HTML, TeX or Python is shown as it is."""

import pytest
from matplotlib import pyplot

import frictionlab as fl
from frictionlab.models import Friction, Mechanics
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


def html_in(widget):
    """Texts that a widget and those within it put on the page as HTML."""
    allowed = getattr(widget, "description_allow_html", False) or getattr(widget, "tooltip_allow_html", False)
    assert not allowed
    own = [widget.value] if "HTML" in type(widget).__name__ else []
    return [*own, *(text for child in getattr(widget, "children", ()) for text in html_in(child))]


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
    texts = [*html_in(explorer.widget), model.describe()._repr_html_()]
    assert any("&lt;img" in text for text in texts)
    assert [text for text in texts if "<img" in text] == []


def test_a_section_may_have_any_name():
    assert fl.steady_state(named("lambda"), transient=20.0, window=30.0, section="lambda'").kind == "periodic"
