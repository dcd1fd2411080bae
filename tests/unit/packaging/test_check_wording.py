from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[3]


def load() -> ModuleType:
    specification = importlib.util.spec_from_file_location("check_wording", ROOT / "packaging" / "check_wording.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


wording = load()


def found(name: str, source: str) -> list[tuple[int, str]]:
    """Return line and message of each finding in a file of that name."""
    return [(finding.line, finding.message) for finding in wording.findings(Path(name), source)]


@pytest.mark.parametrize(
    "words", ["lays", "laid", "Tells", "told", "ways", "whoever", "so many", "be let", "heeded", "puts aside", "anew"]
)
def test_each_private_word_is_found_with_its_replacement(words: str) -> None:
    ((line, message),) = found("page.md", f"Heading\n\nThe drone {words} it.\n")
    assert line == 3
    assert message.startswith(f"'{words}': say ")


def test_words_that_only_contain_one_are_free() -> None:
    assert not found("page.md", "always a runway, its layout and `way_m`; a renewal, teller and delays\n")


@pytest.mark.parametrize("opening", ["What", "Whoever", "How", "Where", "Whether", "Who"])
def test_a_docstring_does_not_open_with_a_clause(opening: str) -> None:
    messages = [message for _, message in found("module.py", f'def f() -> None:\n    """{opening} is done."""\n')]
    assert f"a docstring begins with a verb or a noun, not with '{opening}'" in messages


def test_only_docstrings_and_comments_of_code_are_read() -> None:
    assert not found("module.py", 'way = "the way home"\nprint(way, "# told")\n')
    assert found("module.py", "x = 1  # the way home\n") == [(1, "'way': say path, route, direction, distance, manner")]
    assert [line for line, _ in found("module.py", 'x = 1\n"""A number.\n\nIt was laid out.\n"""\n')] == [4]


def test_comments_of_toml_and_typescript_are_read() -> None:
    assert [line for line, _ in found("a.toml", 'a = "the way # home"\nb = 1 # the way\n')] == [2]
    source = 'const a = "http://way"; // told\n/**\n * The way.\n */\nconst b = "the way";\n'
    assert [line for line, _ in found("a.ts", source)] == [1, 3]


def test_comments_of_messages_are_read_and_the_messages_are_not() -> None:
    assert [line for line, _ in found("en.ftl", "# the way\nstraight = The straight way\n## told\n")] == [1, 3]


def test_code_quotations_and_terms_are_free() -> None:
    assert not found("page.md", 'The key `way`, the words "on the way", a request under way.\n')
    assert not found("module.py", '"""The specification says "until told otherwise"; ``way`` is metres."""\n')


def test_rooms_limit_the_files_and_lift_the_exemption(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wording, "NOT_YET_CLEAN", ("packaging",))
    everything = wording.checked_files(ROOT, [])
    assert Path("README.md") in everything
    assert Path("packaging/check_wording.py") not in everything
    assert set(wording.checked_files(ROOT, ["packaging"])) >= {Path("packaging/check_wording.py")}
    assert all(path.is_relative_to("docs") for path in wording.checked_files(ROOT, ["docs"]))


def test_rooms_that_are_not_yet_clean_exist() -> None:
    assert [room for room in wording.NOT_YET_CLEAN if not (ROOT / room).exists()] == []


def test_the_exit_status_says_whether_something_was_found(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(wording, "ROOT", tmp_path)
    monkeypatch.setattr(wording, "checked_files", lambda _root, _rooms: [Path("a.md")])
    (tmp_path / "a.md").write_text("A path.\n")
    assert wording.main([]) == 0
    (tmp_path / "a.md").write_text("A way.\n")
    assert wording.main([]) == 1
    assert capsys.readouterr().out.startswith("a.md:1: 'way'")
