"""Write what describes the command line, from the parsers of ``hawk-drone`` and ``hawk-sim``.

``python packaging/command_line.py`` writes ``docs/command-line.md``, and below ``packaging/share`` the man pages and
completions of bash and zsh, which the wheel installs into ``share``. ``--check`` fails when one is out of date.
"""

from __future__ import annotations

import argparse
import re
import sys
import textwrap
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import shtab
from argparse_manpage.manpage import Manpage

from hawk.cli import make_parser as drone_parser
from hawk.sim.cli import make_parser as sim_parser

ROOT: Final = Path(__file__).resolve().parent.parent
SHARE: Final = Path("packaging/share")
PURPOSE: Final = {
    "hawk-drone": "fly a drone over a parking lot and map its free and taken stalls",
    "hawk-sim": "simulate an ArduCopter with a camera over a parking lot",
}
STATUS: Final = {
    "hawk-drone": "0: success. 1: something failed; the reason is printed. 2: wrong options or settings, a lot or "
    "survey that is not there, or a plan that cannot be read. survey: 3: no lot was found, 4: the lot was not seen "
    "whole, 130: interrupted, the drone came home first.",
    "hawk-sim": "0: ended by a signal or with its parent, or the photographs are written. "
    "1: an address is not free, or a folder cannot be written. 2: wrong options.",
}
OTHER: Final = {"hawk-drone": "hawk-sim", "hawk-sim": "hawk-drone"}
COMPLETED: Final = {"FILE": shtab.FILE, "RECORDING": shtab.FILE, "FILM": shtab.FILE, "DIR": shtab.DIRECTORY}
"""Completion by the name that the help gives a value."""

_WIDTH: Final = 120
"""Characters of a line of the page."""
_HEADER: Final = """# Command line

Written by `packaging/command_line.py` from the parsers of both programs: change those and run this again.

`hawk-drone` without a command is `hawk-drone run`; `--version` prints its version. `--help` of a command describes each
option, and so do `man hawk-drone` and `man hawk-sim` where the package put its man pages (`share/man` beside the `bin`
of the programs). Other settings are in [settings.md](settings.md). Completion of commands, options and files: for bash
`source share/bash-completion/completions/hawk-drone`, for zsh the folder `share/zsh/site-functions` in `fpath`. In the
source `share` is `packaging/share`.
"""


class _Formatter(argparse.HelpFormatter):
    """Lines of one length, whatever the terminal's is."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, width=80)


def files() -> dict[Path, str]:
    """Return every file by its path below the repository, with its text."""
    parsers = {"hawk-drone": drone_parser(), "hawk-sim": sim_parser()}
    written = {Path("docs/command-line.md"): reference(list(parsers.values()))}
    for name, parser in parsers.items():
        _complete_paths(parser)
        written[SHARE / "man" / "man1" / f"{name}.1"] = man_page(parser)
        written[SHARE / "bash-completion" / "completions" / name] = _completion(parser, "bash")
        written[SHARE / "zsh" / "site-functions" / f"_{name}"] = _completion(parser, "zsh")
    return written


def reference(parsers: list[argparse.ArgumentParser]) -> str:
    """Return the page (Markdown): each program with its commands, the purpose and the synopsis of each.

    The options of the others are for simulations alone; ``--help`` shows them.
    """
    program, *others = parsers
    blocks = [_HEADER, f"## {program.prog}", "", _sentence(PURPOSE[program.prog]), ""]
    for parser, purpose in commands(program):
        blocks += [f"### {parser.prog}", "", _sentence(purpose), "", _synopsis(parser), ""]
    blocks += [f"Exit status: {STATUS[program.prog]}", ""]
    for other in others:
        rows = {other.prog: PURPOSE[other.prog]} | {found.prog: purpose for found, purpose in commands(other)}
        blocks += [f"## {other.prog}", "", "`--help` shows the options of each:", ""]
        blocks += [*(f"- `{prog}`: {_sentence(purpose)}" for prog, purpose in rows.items()), ""]
        blocks += [f"Exit status: {STATUS[other.prog]}", ""]
    return "\n".join(blocks)


def man_page(parser: argparse.ArgumentParser) -> str:
    """Return the man page of a program (troff). It has no date: the same release gives the same page."""
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    for each in [parser, *(found for found, _ in commands(parser))]:
        each.formatter_class = _Formatter
    page = Manpage(parser, _data={"manual_title": "hawk", "description": PURPOSE[parser.prog]})
    page.source, page.date = f"hawk {version}", ""
    page.add_section("EXIT STATUS", ">", STATUS[parser.prog])
    page.add_section("SEE ALSO", ">", f".BR {OTHER[parser.prog]} (1).\nEverything else: /docs/ of a running daemon.")
    return str(page)


def commands(parser: argparse.ArgumentParser) -> Iterator[tuple[argparse.ArgumentParser, str]]:
    """Yield the parser of each command of a program, with its purpose."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            purposes = {each.dest: each.help or "" for each in action._choices_actions}
            yield from ((found, purposes[name]) for name, found in action.choices.items())


def shown(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    """Return the options and arguments that the help shows."""
    hidden = (argparse._SubParsersAction, argparse._HelpAction)
    return [each for each in parser._actions if each.help != argparse.SUPPRESS and not isinstance(each, hidden)]


def _synopsis(parser: argparse.ArgumentParser) -> str:
    """Return a command with its arguments and options, as a block of code; brackets: an option that may be left out."""
    usage = " ".join(parser.format_usage().removeprefix("usage: ").replace(" [-h]", "").split())
    whole = re.sub(r"(--[\w-]+) (?=[\w{\[])", "\\1\0", usage)
    lines = textwrap.wrap(whole, _WIDTH - 8, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False)
    return "\n".join(f"    {line}" for line in lines).replace("\0", " ")


def _sentence(text: str) -> str:
    """Return the text with a capital and a full stop; a first word that is no word stays as it is."""
    first, space, rest = text.partition(" ")
    start = first[:1].upper() + first[1:] if first.isalpha() else first
    return f"{start}{space}{rest}".removesuffix(".") + "." if text else ""


def _completion(parser: argparse.ArgumentParser, shell: str) -> str:
    return str(shtab.complete(parser, shell))


def _complete_paths(parser: argparse.ArgumentParser) -> None:
    """Let the shell complete files and folders where an option wants one."""
    for each in [parser, *(found for found, _ in commands(parser))]:
        for action in shown(each):
            kind = COMPLETED.get(str(action.metavar))
            if kind is not None:
                action.complete = kind  # type: ignore[attr-defined] # shtab's own attribute


def main(arguments: list[str] | None = None) -> int:
    """Write or check; return the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--check", action="store_true", help="only say whether the files are up to date")
    is_check = parser.parse_args(arguments).check
    old = []
    for path, text in files().items():
        target = ROOT / path
        if target.is_file() and target.read_text(encoding="utf-8") == text:
            continue
        if is_check:
            old.append(path)
        else:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text, encoding="utf-8")
    for path in old:
        print(f"{path} is out of date: run python packaging/command_line.py", file=sys.stderr)
    return 1 if old else 0


if __name__ == "__main__":
    sys.exit(main())
