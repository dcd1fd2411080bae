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
    assert not found(
        "a.py", "def gateway(WAYPOINT, layout, alwaysOn, foretold, Wayne, DELAY, awayFrom, display): ...\n"
    )


@pytest.mark.parametrize("opening", ["What", "Whoever", "How", "Where", "Whether", "Who"])
def test_a_docstring_does_not_open_with_a_clause(opening: str) -> None:
    messages = [message for _, message in found("module.py", f'def f() -> None:\n    """{opening} is done."""\n')]
    assert f"a docstring begins with a verb or a noun, not with '{opening}'" in messages


def test_docstrings_and_comments_of_code_are_read() -> None:
    assert found("module.py", "x = 1  # the way home\n") == [(1, "'way': say path, route, direction, distance, manner")]
    assert [line for line, _ in found("module.py", 'x = 1\n"""A number.\n\nIt was laid out.\n"""\n')] == [4]


@pytest.mark.parametrize(
    "source",
    [
        "way_m = 1",
        "WAY_M = 1",
        "self.best_way = 1",
        "def is_told(): ...",
        "async def beginAnew(): ...",
        "class LaidDown: ...",
        "def f(told): ...",
        "def f(*, so_many=1): ...",
        "f(way_m=1)",
        "for way in range(3): ...",
        "import numpy as way",
        "try: ...\nexcept OSError as told: ...",
        "match x:\n case [told]: ...",
        "match x:\n case [*told]: ...",
        "[way for way in x]",
    ],
)
def test_each_name_that_python_code_defines_is_read(source: str) -> None:
    assert found("module.py", f"{source}\n")


def test_a_name_is_shown_whole() -> None:
    ((line, message),) = found("module.py", "x = 1\nway_m = 2\n")
    assert (line, message) == (2, "'way' in 'way_m': say path, route, direction, distance, manner")


def test_names_that_others_define_are_free() -> None:
    assert not found("module.py", "x = file.tell() + way.x + f(told)\n")


@pytest.mark.parametrize("name", ["chores", "dearest", "untold", "Inquiry", "wishes", "manner"])
def test_some_words_are_private_in_names_alone(name: str) -> None:
    ((_, message),) = found("module.py", f"{name} = 1\n")
    assert message.startswith(f"'{name}': say ")
    assert not found("page.md", f"The {name} of it.\n")
    assert not found("module.py", f'x = "The {name} of it."\n')


@pytest.mark.parametrize(
    "source",
    [
        'say("No way there is known.")',
        'log.warning("the end of %s could not be told", name)',
        'parser.add_argument("--seeds", help="way and time")',
        'raise ValueError(f"no way from {start}")',
        'x = {"way_m": 1}',
        'x["way_m"]',
        'Field(alias="Way Left")',
    ],
)
def test_strings_and_keys_of_python_code_are_read(source: str) -> None:
    assert [line for line, _ in found("module.py", f"{source}\n")] == [1]


def test_a_class_is_named_for_what_it_does() -> None:
    ((_, message),) = found("module.py", "class LinkWatch: ...\n")
    assert message.startswith("'LinkWatch': a reading observes, a rule decides")
    assert not found("module.py", "class Watchdog: ...\nwatch = 1\n")


@pytest.mark.parametrize("path", ["a/way_home.py", "tests/test_way_home.py", "laid/a.md", "a/FlightTold.ts"])
def test_paths_of_files_are_read(path: str) -> None:
    assert [line for line, _ in found(path, "")] == [1]


def test_comments_and_keys_of_toml_are_read() -> None:
    assert [line for line, _ in found("a.toml", 'a = "the way # home"\nb = 1 # the way\nway = 2\n')] == [2, 3]


def test_all_of_typescript_is_read() -> None:
    source = 'const a = "http://way"; // told\n/**\n * The way.\n */\nconst b = "the way";\nlet toldOf = b.wayHome;\n'
    assert [line for line, _ in found("a.ts", source)] == [1, 3, 5, 6, 6]


def test_messages_of_a_person_s_language_are_read() -> None:
    source = "# the way\nstraight = The straight way\n## told\nway-home = { $told }\n"
    assert sorted(line for line, _ in found("en.ftl", source)) == [1, 2, 3, 4, 4]


def test_messages_of_other_languages_are_not_read() -> None:
    assert Path("hawk/web/page/src/messages/en.ftl") in wording.checked_files(ROOT, ["hawk/web/page/src/messages"])
    assert Path("hawk/web/page/src/messages/fr.ftl") not in wording.checked_files(ROOT, ["hawk/web/page/src/messages"])


@pytest.mark.parametrize("suffix", ["html", "svg"])
def test_texts_and_comments_of_markup_are_read(suffix: str) -> None:
    source = '<p title="the way">\n<!-- told -->\nboth ways</p>\n'
    assert sorted(line for line, _ in found(f"a.{suffix}", source)) == [1, 2, 3]


def test_keys_of_json_are_read_and_values_are_not() -> None:
    assert [line for line, _ in found("a.json", '{\n"way_m": "told",\n"x": "way"}\n')] == [2]


def test_code_quotations_and_terms_are_free() -> None:
    assert not found("page.md", 'The key `way`, the words "on the way", a request under way.\n')
    assert not found("module.py", '"""The specification says "until told otherwise"; ``way`` is metres."""\n')
    assert not found("module.py", "calls_under_way, underWay, UNDER_WAY = f('a flight under way')\n")
    assert not found("module.py", 'raise ValueError("the key `way` of https://a.example/way")\n')


def test_exceptions_are_of_one_word_in_one_file(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wording, "EXCEPTIONS", {("a.py", "way"): "a reason"})
    assert not found("a.py", "way = 1\n")
    assert found("a.py", "told = 1\n")
    assert found("b.py", "way = 1\n")


@pytest.mark.parametrize(("path", "word"), wording.EXCEPTIONS)
def test_every_exception_is_needed(path: str, word: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wording, "EXCEPTIONS", {})
    messages = [message for _, message in found(path, (ROOT / path).read_text("utf-8"))]
    assert any(f"'{word}'" in message for message in messages)


def test_files_of_examples_may_hold_private_words(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wording, "EXAMPLES", ("a.py",))
    assert not found("a.py", 'way = "the way"\n')
    assert found("a.py", "x = 1  # the way\n")


def test_rooms_limit_the_files() -> None:
    everything = wording.checked_files(ROOT, [])
    assert Path("README.md") in everything
    assert Path("packaging/check_wording.py") in everything
    assert set(wording.checked_files(ROOT, ["packaging"])) >= {Path("packaging/check_wording.py")}
    assert all(path.is_relative_to("docs") for path in wording.checked_files(ROOT, ["docs"]))


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
