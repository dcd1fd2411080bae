"""Page of reference, man pages and completions hold every command and option of the parsers."""

from __future__ import annotations

import argparse
import re
import subprocess
from pathlib import Path

import pytest

from tests.sweep import sweep
from tests.unit.docs.scripts import load

ROOT = Path(__file__).parents[3]
command_line = load("command_line")
PARSERS = {"hawk-drone": command_line.drone_parser(), "hawk-sim": command_line.sim_parser()}
WRITTEN: dict[Path, str] = command_line.files()


def words_of(parser: argparse.ArgumentParser) -> set[str]:
    """Return the commands and long options that the help of a program and of its commands shows."""
    below = dict(command_line.commands(parser))
    found = {each.prog.removeprefix(f"{parser.prog} ") for each in below}
    actions = [action for each in (parser, *below) for action in command_line.shown(each)]
    return found | {option for action in actions for option in action.option_strings if option.startswith("--")}


@sweep("path", sorted(WRITTEN))
def test_every_file_is_what_the_command_writes(path: Path) -> None:
    assert (ROOT / path).read_text(encoding="utf-8") == WRITTEN[path], "run: python packaging/command_line.py"


def test_there_are_pages_and_completions_of_both_programs() -> None:
    assert {path.as_posix() for path in WRITTEN} == {
        "docs/command-line.md",
        *(
            f"packaging/share/{place}"
            for name in PARSERS
            for place in (
                f"man/man1/{name}.1",
                f"bash-completion/completions/{name}",
                f"zsh/site-functions/_{name}",
            )
        ),
    }


@pytest.mark.slow
@sweep("name", PARSERS)
def test_every_command_and_option_is_in_each_of_them(name: str) -> None:
    wanted = words_of(PARSERS[name])
    assert "--speed" in wanted
    assert name == "hawk-sim" or {"run", "tokens", "--continue"} <= wanted
    for path, text in WRITTEN.items():
        if name in path.name or (path.name == "command-line.md" and name == "hawk-drone"):
            plain = text.replace("\\-", "-")
            missing = {word for word in wanted if not re.search(rf"(?<![\w-]){re.escape(word)}(?![\w-])", plain)}
            assert not missing, path


def test_an_option_for_our_own_programs_is_in_none() -> None:
    assert [path for path, text in WRITTEN.items() if "ready-file" in text or "attach-sim" in text] == []


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("hawk-drone sur", "survey"),
        ("hawk-drone survey --cont", "--continue"),
        ("hawk-drone tokens rotate v", "viewer"),
        ("hawk-drone run --config docs/comma", "docs/command-line.md"),
        ("hawk-sim --condition sn", "snow"),
    ],
)
def test_bash_completes(typed: str, offered: str) -> None:
    program, *_ = words = typed.split(" ")
    script = (
        f"source packaging/share/bash-completion/completions/{program}\n"
        f"COMP_WORDS=({' '.join(words)}); COMP_CWORD={len(words) - 1}\n"
        f"_shtab_{program.replace('-', '_')}\n"
        'printf "%s\\n" "${COMPREPLY[@]}"\n'
    )
    run = subprocess.run(
        ["bash", "--norc", "-c", script], cwd=ROOT, capture_output=True, text=True, check=True, timeout=30
    )
    assert offered in run.stdout.split("\n"), run.stderr


@pytest.mark.slow
def test_check_names_what_is_out_of_date(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "pyproject.toml").write_text((ROOT / "pyproject.toml").read_text())
    monkeypatch.setattr(command_line, "ROOT", tmp_path)
    assert command_line.main([]) == 0
    assert command_line.main(["--check"]) == 0
    (tmp_path / "docs" / "command-line.md").write_text("old")
    assert command_line.main(["--check"]) == 1
    assert "docs/command-line.md is out of date: run python packaging/command_line.py" in capsys.readouterr().err


def test_the_synopsis_of_a_command_has_what_it_needs_without_brackets() -> None:
    page = WRITTEN[Path("docs/command-line.md")]
    (survey,) = re.findall(r"^### hawk-drone survey\n(.*?)^### ", page, re.MULTILINE | re.DOTALL)
    assert " --out DIR " in survey
    assert "[--again LOT]" in survey
    assert "    hawk-drone verify [--config FILE] [--store DIR] [FILE]\n" in page
