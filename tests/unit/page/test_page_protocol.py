"""The page's types are those of the messages."""

import importlib.util
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[3]


def load(name: str) -> ModuleType:
    specification = importlib.util.spec_from_file_location(name, ROOT / "packaging" / f"{name}.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


page_protocol = load("page_protocol")


@pytest.mark.slow
@pytest.mark.parametrize("path", list(page_protocol.files()), ids=lambda path: str(path.name))
def test_the_page_knows_every_message_and_command_as_it_is(path: Path) -> None:
    assert path.read_text("utf-8") == page_protocol.files()[path], "run: python packaging/page_protocol.py"


@pytest.mark.slow
def test_check_names_the_files_that_are_out_of_date(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(page_protocol, "SOURCES", tmp_path)
    for name in ("protocol.ts", "command-table.ts", "api.ts"):
        (tmp_path / name).write_text("old", "utf-8")
    assert page_protocol.main(["--check"]) == 1
    late = "out of date, run python packaging/page_protocol.py: protocol.ts, command-table.ts, api.ts\n"
    assert capsys.readouterr().err == late
    assert page_protocol.main([]) == 0
    assert page_protocol.main(["--check"]) == 0


@pytest.mark.parametrize(
    ("schema", "expected"),
    [
        ({"type": "integer"}, "number"),
        ({"const": "Ack", "type": "string"}, '"Ack"'),
        ({"enum": ["a", "b"], "type": "string"}, '"a" | "b"'),
        ({"anyOf": [{"type": "number"}, {"type": "integer"}, {"type": "null"}]}, "number | null"),
        ({"type": "array", "items": {"$ref": "#/$defs/Point"}}, "Point[]"),
        ({"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}, "[number, number]"),
        ({"type": "object", "additionalProperties": True}, "Record<string, unknown>"),
        ({"type": "array", "items": {"anyOf": [{"type": "number"}, {"type": "null"}]}}, "(number | null)[]"),
    ],
)
def test_types(schema: dict[str, Any], expected: str) -> None:
    assert page_protocol._type(schema) == expected


def test_a_kind_of_schema_that_is_not_known_is_an_error_rather_than_a_wrong_type() -> None:
    with pytest.raises(KeyError):
        page_protocol._type({"type": "object"})
