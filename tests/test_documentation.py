"""README and docs: their snippets run, their links lead somewhere, their commands exist."""

import argparse
import re
from pathlib import Path

import pytest

from sb3_adaptnet import load_policy
from sb3_adaptnet.commands.main import make_parser

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
SMALLER = {
    "num_envs=512": "num_envs=64, num_threads=1",
    "1_000_000": "2_000",
    "progress_bar=True": "progress_bar=False",
}


def blocks(page, language):
    return re.findall(rf"```{language}\n(.*?)```", page.read_text(), re.DOTALL)


def test_the_readmes_snippets_run_in_order(tmp_path, monkeypatch):
    """As a user writes them, with fewer worlds and samples; the base is the real one."""
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    for snippet in blocks(PAGES[0], "python"):
        for large, small in SMALLER.items():
            snippet = snippet.replace(large, small)
        exec(compile(snippet, "README.md", "exec"), names)
    assert names["model"].num_timesteps >= 2_000 and names["observation"].shape == (784,)
    assert (names["action"] == names["policy"].predict(names["observation"], deterministic=True)[0]).all()
    own = load_policy("my_stoop.safetensors", names["env"])
    assert (own.predict(names["observation"], deterministic=True)[0] != names["action"]).any()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    links = re.findall(r"\]\(([^)#\s]+)", page.read_text())
    assert not [link for link in links if "://" not in link and not (page.parent / link).exists()]


def parser_of(parser, words):
    """The parser of the (sub-)subcommand that `words` begin with."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            return parser_of(action.choices[words[0]], words[1:])
    return parser


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_and_their_options_exist(page):
    text = page.read_text()
    lines = [line for block in re.findall(r"```\n(.*?)```", text, re.DOTALL) for line in block.splitlines()]
    commands = [line for line in [*lines, *re.findall(r"`([^`]+)`", text)] if re.match(r"adaptnet \w+ ", line)]
    for command in commands:
        words = command.split("#")[0].split()[1:]
        if words[0].isupper() or words[1:2] == ["WHAT"]:
            continue
        known = parser_of(make_parser(), words).format_help()
        missing = [option for option in re.findall(r"--[a-z-]+", command.split("#")[0]) if option not in known]
        assert not missing, f"{command}: {missing}"
