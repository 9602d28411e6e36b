"""What tests of sweeps share: the processes of runs find the toy environment."""

import os

import pytest
from toy_zoo import ROOT


@pytest.fixture(autouse=True)
def _toy_for_processes(monkeypatch):
    given = filter(None, [os.environ.get("PYTHONPATH")])
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(ROOT), str(ROOT / "tests"), *given]))
