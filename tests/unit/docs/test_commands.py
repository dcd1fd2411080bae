"""Every command of the documents exists, with these options: hawk-drone, hawk-sim and make."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest

from hawk.cli import make_parser as drone_parser
from hawk.sim.cli import make_parser as sim_parser
from tests.sweep import sweep

ROOT = Path(__file__).parents[3]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")
GENERATED = {"command-line.md"}
CHANGES = {"CHANGELOG.md"}
"""It may name what a former release had."""
SENTENCES = {"make one with"}
"""Words of a message that begin like a command."""
_PROGRAM = re.compile(r"(?:^|(?<=[\s/]))(hawk-drone|hawk-sim|make)(?=\s|$)")


def blocks(text: str) -> Iterator[str]:
    """Yield the code of a page: fenced and indented blocks by line, continued lines joined, and code in sentences."""
    text = re.sub(r"\\\n\s*", " ", text)
    for block in re.findall(r"^```(?:sh|bash|console|text)?\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        yield from block.splitlines()
    yield from (line.strip() for line in text.splitlines() if re.match(r" {4}\S", line))
    plain = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    yield from (" ".join(code.split()) for code in re.findall(r"(?<!`)`([^`]+)`(?!`)", plain))


def commands(text: str) -> Iterator[list[str]]:
    """Yield the words of each command of ours on a page."""
    for line in blocks(text):
        for part in re.split(r"&&|\||;|\$\(", line.partition("  #")[0]):
            found = _PROGRAM.search(part)
            before = part[: found.start(1)].split() if found else []
            # a command, not a name in a sentence: nothing before it but sudo, its options and a path
            if found and all(word in ("sudo", "-u", "hawk") or word.endswith(("/", ".venv/bin/")) for word in before):
                if part[found.start(1) :] in SENTENCES:
                    continue
                try:
                    yield shlex.split(part[found.start(1) :], comments=True)
                except ValueError:
                    continue  # a sentence with an apostrophe


FOUND = [
    (page, words)
    for page in PAGES
    if page.name not in GENERATED | CHANGES
    for words in commands(page.read_text(encoding="utf-8"))
]


def is_target(name: str) -> bool:
    """Return True for a target of the Makefile."""
    return re.search(rf"^{re.escape(name)}:", MAKEFILE, re.MULTILINE) is not None


def parser_of(program: str, words: list[str]) -> argparse.ArgumentParser | None:
    """Return the parser of a command line; None for a command that there is not."""
    parser = drone_parser() if program == "hawk-drone" else sim_parser()
    below = next((each for each in parser._actions if isinstance(each, argparse._SubParsersAction)), None)
    if below is None or not words or words[0] in ("--version", "--help"):
        return parser
    if words[0].startswith("-") and program == "hawk-sim":
        return parser
    found = below.choices.get("run" if words[0].startswith("-") else words[0])
    assert found is None or isinstance(found, argparse.ArgumentParser)
    return found


@pytest.mark.slow
@sweep(("page", "words"), FOUND)
def test_the_command_exists_with_these_options(page: Path, words: list[str]) -> None:
    program, *rest = words
    if program == "make":
        targets = [word for word in rest if "=" not in word and not word.startswith("-") and "/" not in word]
        targets = [word for word in targets if word not in ("...", "hawk")]
        assert all(is_target(target) for target in targets), targets
        variables = [word.partition("=")[0] for word in rest if re.match(r"[A-Z]+=", word)]
        assert all(re.search(rf"\b{name}\b", MAKEFILE) for name in variables), variables
        return
    parser = parser_of(program, rest)
    assert parser is not None, f"{program} has no command {rest[0]}"
    options = {name for action in parser._actions for name in action.option_strings}
    given = {word.partition("=")[0] for word in rest if word.startswith("--")}
    assert given <= options


def test_the_start_pages_have_commands_of_each_program() -> None:
    pages = ("first-flight-simulation.md", "first-flight-sitl.md", "first-flight-outside.md")
    texts = [(ROOT / "docs" / name).read_text(encoding="utf-8") for name in pages]
    programs = {words[0] for text in texts for words in commands(text)}
    assert programs == {"hawk-drone", "hawk-sim", "make"}
    assert len(FOUND) > 60


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("    sudo -u hawk /opt/hawk/.venv/bin/hawk-drone check --json", ["hawk-drone", "check", "--json"]),
        ("    .venv/bin/hawk-drone survey --sim \\\n        --out a", ["hawk-drone", "survey", "--sim", "--out", "a"]),
        ("    ./waf configure && make docs  # comment", ["make", "docs"]),
        ("Press `hawk-sim --seed 2`.", ["hawk-sim", "--seed", "2"]),
        ("    hawk-sim photos --out new", ["hawk-sim", "photos", "--out", "new"]),
    ],
)
def test_commands_are_found(line: str, words: list[str]) -> None:
    assert list(commands(f"text\n\n{line}\n")) == [words]


def test_a_name_in_a_sentence_is_no_command() -> None:
    assert list(commands("    the daemon hawk-drone is not make\n")) == []
