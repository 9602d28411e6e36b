"""`adaptnet bench train` accounts for every second."""

import json

import pytest
from toy_zoo import TOY, conf

from sb3_adaptnet.commands.main import main


def test_bench_train_accounts_for_the_whole_iteration(tmp_path, capsys):
    words = [
        "bench",
        "train",
        "--id",
        TOY,
        "--worlds",
        "8",
        "--iterations",
        "1",
        "--conf-file",
        conf(tmp_path),
        "--json",
    ]
    assert main(words) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["speedup_over_plain"] == pytest.approx(
        figures["samples_per_second"] / figures["plain_samples_per_second"]
    )
    assert all(figures["seconds"][part] > 0 for part in ("act", "simulate", "discriminators", "update", "other"))
    assert sum(figures["seconds"].values()) == pytest.approx(64 / figures["samples_per_second"])
