"""README, docs, examples and YAML: snippets run, links lead somewhere, names are public, commands exist."""

import argparse
import pkgutil
import re
import tomllib
from pathlib import Path
from types import ModuleType

import pytest
import yaml

from sb3_adaptnet import load_policy
from sb3_adaptnet.commands.main import make_parser

ROOT = Path(__file__).resolve().parents[1]
GUIDES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("**/*.md")), ROOT / "examples" / "README.md"]
PAGES = [*GUIDES, ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"]
PROGRAMS = [*sorted((ROOT / "examples").glob("*.py")), *sorted((ROOT / "zoo_configs").glob("*.yml"))]
"""What users copy from, besides pages."""
SMALLER = {
    "num_envs=256": "num_envs=64, num_threads=1",
    "1_600_000": "2_000",
    "progress_bar=True": "progress_bar=False",
}
DEEP = tuple(f"adapt_envs.motion.{room}" for room in ("importing", "exporting", "synthesis", "gaits"))
"""Folders within a folder whose names are public all the same."""
PLACEHOLDERS = ("NAME", "STYLE", "BASE")
"""Words in paths that stand for others."""


def by_name(path):
    return str(path.relative_to(ROOT))


def blocks(page, language):
    return re.findall(rf"```{language}\n(.*?)```", page.read_text(), re.DOTALL)


def test_the_readmes_snippets_run_in_order(tmp_path, monkeypatch):
    """As a user writes them, with fewer worlds and samples; the base is the real one."""
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    snippets = blocks(PAGES[0], "python")
    assert not [large for large in SMALLER if large not in "".join(snippets)]
    for snippet in snippets:
        for large, small in SMALLER.items():
            snippet = snippet.replace(large, small)
        exec(compile(snippet, "README.md", "exec"), names)
    assert names["model"].num_timesteps >= 2_000
    assert names["observation"].shape == (784,) and names["picture"].shape == (480, 640, 3)
    assert not names["terminated"], "walk-stoop fell within a second"
    observation, policy = names["observation"], names["policy"]
    own = load_policy("my_stoop.safetensors", names["env"])
    assert (own.predict(observation, deterministic=True)[0] != policy.predict(observation, deterministic=True)[0]).any()


@pytest.mark.parametrize("page", PAGES, ids=by_name)
def test_links_lead_somewhere(page):
    links = [link for link in re.findall(r"\]\(([^)#\s]+)", page.read_text()) if "://" not in link]
    assert not [link for link in links if not (page.parent / link).exists()]
    if page.is_relative_to(ROOT / "docs"):  # the site has nothing else
        assert not [link for link in links if not (page.parent / link).resolve().is_relative_to(ROOT / "docs")]


@pytest.mark.parametrize("page", [*PAGES, *PROGRAMS], ids=by_name)
def test_named_files_exist(page):
    folders = "|".join(path.name for path in ROOT.iterdir() if path.is_dir() and path.name[0] not in "._")
    paths = re.findall(rf"(?<![\w/.:-])((?:{folders})/[\w./-]*\w)", page.read_text())
    missing = [path for path in paths if not (ROOT / path).exists() and not path.startswith("runs/")]
    assert not [path for path in missing if not any(word in path for word in PLACEHOLDERS)]


def names_used(text):
    """Dotted names of both packages in `text`: in prose, as imports, in YAML."""
    text = re.sub(r"\(\n\s*([^)]*?)\n\)", lambda found: " ".join(found[1].split()), text)
    for folder, imported in re.findall(r"from ((?:adapt_envs|sb3_adaptnet)[\w.]*) import ([\w, ]+)", text):
        yield from (f"{folder}.{name.strip()}" for name in imported.split(",") if name.strip())
    yield from re.findall(r"(?<![\w./])(?:adapt_envs|sb3_adaptnet)(?:\.[A-Za-z_]\w*)+(?!/)", text)


def is_public(name):
    """Whether `name` is a folder, or stands in the `__all__` of a folder that is not deep."""
    found = pkgutil.resolve_name(name)
    if isinstance(found, ModuleType):
        return hasattr(found, "__path__") and (name.count(".") == 1 or name in DEEP)
    folder, _, last = name.rpartition(".")
    return (folder.count(".") <= 1 or folder in DEEP) and last in pkgutil.resolve_name(folder).__all__


@pytest.mark.parametrize("page", [*GUIDES, ROOT / "CONTRIBUTING.md", *PROGRAMS], ids=by_name)
def test_names_are_short_public_and_there(page):
    assert not [name for name in names_used(page.read_text()) if not is_public(name)]


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("see `adapt_envs.model.TERRAINS`.", ["adapt_envs.model.TERRAINS"]),
        ("from sb3_adaptnet import (\n    A,\n    B,\n)  # words", ["sb3_adaptnet.A", "sb3_adaptnet.B"]),
        ("    - sb3_adaptnet.AttributeRamp: {last: 1}", ["sb3_adaptnet.AttributeRamp"]),
        ("`adapt_envs/model/terrain.py`, my_adapt_envs.x, adapt_envs:AdaptNet/Walk", []),
    ],
)
def test_names_are_found(text, names):
    assert list(names_used(text)) == names


@pytest.mark.parametrize("deep", ["adapt_envs.model.terrain", "adapt_envs.model.terrain.perlin", "adapt_envs.env"])
def test_deep_names_are_not_public(deep):
    assert not is_public(deep)


@pytest.mark.parametrize("page", PAGES, ids=by_name)
def test_lines_are_short_enough_to_compare(page):
    text = re.sub(r"```.*?```", "", page.read_text(), flags=re.DOTALL)
    whole = ("|", "!", "  |")  # tables and pictures cannot be broken
    assert not [line for line in text.splitlines() if len(line) > 120 and not line.startswith(whole)]


def table_rows(page):
    """Rows of tables whose first cell is an environment's id."""
    return re.findall(r"^\| `AdaptNet/.*$", page.read_text(), re.MULTILINE)


def test_every_environment_is_on_one_familys_page():
    families = [row for page in (ROOT / "docs" / "families").glob("*.md") for row in table_rows(page)]
    assert sorted(families) == sorted(table_rows(ROOT / "docs" / "environments.md"))


def test_the_quick_starts_snippets_are_the_readmes_which_run():
    quick = blocks(ROOT / "docs" / "quick_start.md", "python")
    assert quick and set(quick) <= set(blocks(ROOT / "README.md", "python"))


def pages_of(nav):
    """Files in a table of contents, however deep."""
    for entry in nav if isinstance(nav, list) else nav.values():
        yield from [entry] if isinstance(entry, str) else pages_of(entry)


def test_the_site_shows_every_page():
    nav = yaml.safe_load((ROOT / "mkdocs.yml").read_text())["nav"]
    assert sorted(pages_of(nav)) == sorted(
        str(page.relative_to(ROOT / "docs")) for page in (ROOT / "docs").glob("**/*.md")
    )


def test_contributors_see_every_room():
    text = (ROOT / "CONTRIBUTING.md").read_text()
    rooms = [
        file.parent for package in ("adapt_envs", "sb3_adaptnet") for file in ROOT.glob(f"{package}/**/__init__.py")
    ]
    assert not [room.name for room in rooms if room.parent != ROOT and f"{room.name}/ " not in text]


def test_the_version_is_one():
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert yaml.safe_load((ROOT / "CITATION.cff").read_text())["version"] == version
    assert re.search(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)[1] == version


def parser_of(parser, words):
    """The parser of the (sub-)subcommand that `words` begin with."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            return parser_of(action.choices[words[0]], words[1:])
    return parser


@pytest.mark.parametrize("page", PAGES, ids=by_name)
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
