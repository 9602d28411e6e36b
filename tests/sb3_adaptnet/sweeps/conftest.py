"""What tests of sweeps share: the processes of runs find the toy environment."""

import pytest
from toy_zoo import python_path


@pytest.fixture(autouse=True)
def _toy_for_processes(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", python_path())
