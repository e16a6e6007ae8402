"""The state of an explorer as data: what can be set, and what is refused."""

import pytest

import frictionlab as fl
from frictionlab.pages.export import text_of
from tests.helpers.explorers import made
from tests.unit.pages.test_javascript import run_in_node


@pytest.fixture(scope="module")
def unchanged():
    """One for all tests that change no value."""
    return made(fl.SliderOnBelt(mu_k=1.4), ("eigenvalues",), 2.0)


def test_a_state_is_set_again():
    first = made(fl.SliderOnBelt(mu_k=1.4), ("eigenvalues",), 2.0)
    first.controls["impact"].label = "restitution"
    for name, value in {"e": 0.35, "mu_k": 1.27, "switch-geometry": False, "start": "near"}.items():
        first.controls[name].value = value
    other = fl.explore(fl.SliderOnBelt(mu_k=1.4), panels=("eigenvalues",))
    other.set_values(first.changed())
    assert other.result.settings == first.result.settings
    assert other.model == fl.SliderOnBelt(mu_k=1.27, impact=fl.RestitutionImpact(e=0.35)).without("geometry")


HISTORY = """
const seconds = (t) => { performance.now = () => 1000 * t; };
seconds(0);
const history = new StateHistory({ a: 0, b: 0 });
for (const [t, state] of [[5, { a: 1, b: 0 }], [5.1, { a: 2, b: 0 }], [9, { a: 3, b: 0 }]]) {
  seconds(t);
  history.record(state);
}
const before = history.states.map(({ a }) => a), undone = history.step(-1).a;
history.record({ a: 2, b: 1 });
console.log(JSON.stringify([before, undone, history.states, history.step(1)]));
"""


def test_the_steps_of_one_drag_are_undone_together_and_what_was_undone_is_forgotten():
    scripts = "".join(text_of(f"{name}.js") for name in ("words", "state"))
    before, undone, states, after = run_in_node(scripts + HISTORY)
    assert (before, undone) == ([0, 2, 3], 2)
    assert states == [{"a": 0, "b": 0}, {"a": 2, "b": 0}, {"a": 2, "b": 1}]
    assert after is None


LINK = """
const controls = [{ name: "switch-cubic", kind: "switch" }, { name: "mu_k", kind: "number", parameter: true },
  { name: "start", kind: "choice", options: ["rest", "near"] }, { name: "duration", kind: "number" }];
const initial = { "switch-cubic": true, mu_k: 0.3, start: "rest", duration: 2 };
const scene = { name: "two fates", initial, controls, challenges: [] };
const state = { "switch-cubic": false, mu_k: 1.5, start: "near", duration: 5 }, link = linkText(state, scene);
const back = readLink(`#${link}`, scene), odd = readLink("#mu_k=abc&start=sideways&t_end=-1&other=3", scene);
console.log(JSON.stringify([link, back.scene, back.state, odd.state]));
"""


def test_a_link_holds_what_was_changed():
    scripts = "".join(text_of(f"{name}.js") for name in ("words", "state"))
    link, scene, back, odd = run_in_node(scripts + LINK)
    assert link == "scene=two+fates&mu_k=1.5&without=cubic&x0=near&t_end=5"
    assert scene == "two fates"
    assert back == {"switch-cubic": False, "mu_k": 1.5, "start": "near", "duration": 5}
    assert odd == {"switch-cubic": True, "mu_k": 0.3, "start": "rest", "duration": 2}


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("no json", "must be one that an explorer saved"),
        ("{}", "must be one that an explorer saved"),
        ('{"format": "other", "model": {}, "changed": {}}', "got the format 'other'"),
    ],
)
def test_what_is_no_state_is_refused_in_words(content, words):
    attempt = f"try {{ stateFromText({content!r}) }} catch (error) {{ said = error.message }}"
    scripts = "".join(text_of(f"{name}.js") for name in ("words", "state"))
    assert words in run_in_node(f"{scripts} let said; {attempt}; console.log(JSON.stringify(said))")


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"mu_kk": 1.0}, "control 'mu_kk', got none of that name: did you mean 'mu_k'"),
        ({"mu_k": 0.7, "F": "abc"}, "F must be a finite number"),
        ({"mu_k": -1.0}, "mu_k must be at least 0, got -1.0"),
        ({"mu_k": float("nan")}, "mu_k must be a finite number"),
        ({"start": "sideways"}, "start must be a value of its control, got 'sideways'"),
        ({"switch-cubic": "perhaps"}, "switch-cubic must be a value of its control"),
    ],
)
def test_values_that_cannot_be_set_change_nothing(unchanged, values, words):
    before, model = unchanged.values(), unchanged.model
    with pytest.raises(ValueError, match=words):
        unchanged.set_values(values)
    assert (unchanged.values(), unchanged.model) == (before, model)
