"""The table of switches is complete; nothing here looks at a clock."""

from frictionlab.bench import switches


def test_each_switch_pays():
    found = {row.without: row for row in switches.switches(t_end=0.1, repeats=1)}
    full = found[()]
    assert len(found) == 8
    assert found[("geometry",)].states == 8 < full.states
    assert (found[("nonsmooth",)].modes, found[("nonsmooth",)].guards) == (1, 0)
    assert found[("cubic",)].products < full.products
    assert found[switches.SWITCHES].products == 0
    assert all(row.operations < full.operations for names, row in found.items() if names)
    assert len(switches.switch_table(list(found.values())).splitlines()) == 10
