"""`adaptnet play`: which view it opens."""

import pytest
from evaluation_cases import save_tiny_base

from sb3_adaptnet.commands import play
from sb3_adaptnet.commands.main import main
from sb3_adaptnet.play import browser


def test_without_viser_one_sentence_says_what_to_install(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(browser, "viser", None)
    assert main(["play", str(save_tiny_base(tmp_path)), "--view", "browser"]) == 2
    printed = capsys.readouterr()
    assert "pip install viser" in printed.err and printed.err.count("\n") == 1


def test_it_plays_as_many_steps_as_asked_and_closes_the_view(tmp_path, capsys, monkeypatch):
    shown = []

    class Counting:
        running, address = True, "http://here"

        def __init__(self, worlds, controls, host, port):
            self.place = host, port

        def show(self):
            shown.append(self.place)

        def close(self):
            shown.append("closed")

    monkeypatch.setattr(play, "Browser", Counting)
    words = ["--view", "browser", "--port", "9", "--steps", "3", "--threads", "1"]
    assert main(["play", str(save_tiny_base(tmp_path)), *words]) == 0
    assert shown == [("127.0.0.1", 9)] * 3 + ["closed"] and "open http://here" in capsys.readouterr().out


@pytest.mark.parametrize("port", ["70000", "-5", "http", "8_0"])
def test_a_port_that_cannot_be_is_refused(tmp_path, capsys, port):
    with pytest.raises(SystemExit, match="2"):
        main(["play", "walk", "--port", port])
    assert "is not a port, a number from 0 to 65535" in capsys.readouterr().err


def test_an_address_of_another_machine_is_refused(tmp_path, capsys):
    base = save_tiny_base(tmp_path)
    assert main(["play", str(base), "--view", "browser", "--host", "192.0.2.1"]) == 2  # kept for documents: RFC 5737
    said = capsys.readouterr().err
    assert "cannot be served at '192.0.2.1'" in said or "needs the package viser" in said
