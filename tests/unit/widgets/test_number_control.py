"""Numbers that are typed are taken or refused in words; what a browser tells is a position's value."""

import pytest

import frictionlab as fl
from frictionlab.models.composition import parameter_metadata
from frictionlab.widgets.number_control import number_from_text, slider

pytestmark = pytest.mark.plain_python

MODEL = fl.SliderOnBelt()
ABOUT = parameter_metadata(type(MODEL), MODEL.components)


@pytest.fixture
def mu_k():
    return slider("mu_k", ABOUT["mu_k"], 0.3)


def hear(control, text):
    """What the browser sends when a text was typed."""
    control.field._handle_custom_msg({"typed": text}, [])


@pytest.mark.parametrize(
    ("text", "value"),
    [("0,5", 0.5), ("0.5", 0.5), (" 1.25 ", 1.25), (",5", 0.5), ("5e-1", 0.5), ("2", 2.0), ("0,125", 0.125)],
)
def test_a_number_is_taken_with_point_or_comma(mu_k, text, value):
    hear(mu_k, text)
    assert (mu_k.value, mu_k.field.value, mu_k.message) == (value, value, "")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "-1",
            "mu_k must be at least 0, got -1.0: raise mu_k (its default is 0.3). The slider goes from 0 to 3",
        ),
        ("\N{MINUS SIGN}1", "mu_k must be at least 0, got -1.0"),
        ("1e99", "mu_k must be from 0 to 3 here, got 1e+99: take one between, or set it in Python"),
        ("1e999", "mu_k must be a finite number, got inf"),
        ("abc", "mu_k must be one number, got 'abc': write for example 0.5"),
        ("", "mu_k must be one number, got ''"),
        ("nan", "mu_k must be one number, got 'nan'"),
        ("1 2", "mu_k must be one number, got '1 2'"),
        ("1,2,3", "mu_k must be one number, got '1,2,3'"),
        ("1,000", "whose comma has two meanings: write 1000 or 1.0000"),
    ],
)
def test_what_is_no_value_is_refused_in_words_and_changes_nothing(mu_k, text, words):
    seen = []
    mu_k.observe(seen.append, names="value")
    hear(mu_k, text)
    assert words in mu_k.message
    assert mu_k.message.endswith("The value is still 0.3.")
    assert (mu_k.value, mu_k.field.value, seen) == (0.3, 0.3, [])


def test_the_message_goes_with_the_next_value(mu_k):
    hear(mu_k, "abc")
    assert mu_k.message
    mu_k.field.value = mu_k.positions[7]
    assert (mu_k.value, mu_k.message) == (mu_k.positions[7], "")
    hear(mu_k, "abc")
    hear(mu_k, "0,7")
    assert (mu_k.value, mu_k.message) == (0.7, "")


@pytest.mark.parametrize("text", ["1,000", "12,500", "1,000,000", "1,000.5", "0x10", "1_000", "1..5", "e5"])
def test_ambiguous_and_foreign_notations_are_refused(text):
    with pytest.raises(ValueError, match="F must be one number"):
        number_from_text("F", text)


def test_a_value_beyond_the_slider_set_in_python_moves_its_end(mu_k):
    mu_k.value = 3.7
    assert (mu_k.field.value, mu_k.max) == (3.7, 3.7)
