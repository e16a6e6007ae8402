"""Explorers that tests share."""

import pytest

import frictionlab as fl
from tests.helpers.explorers import SHORT


@pytest.fixture(scope="session")
def shared():
    return fl.explore(panels=SHORT)


@pytest.fixture
def explorer(shared):
    shared.reset()
    return shared
