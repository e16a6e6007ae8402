"""Which of the paper's nonlinearities the chaos needs, as an ablation answers."""

import frictionlab as fl


def test_chaos_needs_both_the_moving_load_and_the_non_smooth_behaviours():
    """At mu_k = 2.5, under Eq. (13): without either the motion from rest is periodic, or has no end."""

    def kind(model):
        return {"kind": str(fl.steady_state(model, transient=250.0, window=50.0, progress=False).kind)}

    model = fl.SliderOnBelt(mu_k=2.5)
    found = fl.ablation(model, kind, ["nonsmooth", "geometry"], progress=False)
    assert found[()]["kind"] == "non-periodic"
    assert found.leave_one_out("kind = non-periodic") == {"without nonsmooth": -1.0, "without geometry": -1.0}
    assert found["geometry"]["kind"] == "periodic"
    effects = found.effects("kind = non-periodic")
    assert effects["nonsmooth x geometry"] == 1.0
