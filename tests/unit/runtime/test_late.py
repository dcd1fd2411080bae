from __future__ import annotations

import sys
from pathlib import Path

import pytest

from hawk.runtime.late import late, late_functions


def test_a_late_module_is_loaded_by_its_first_use_and_follows_its_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "hawk_of_a_test.py").write_text("def number():\n    return 7\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    module = late("hawk_of_a_test")
    assert "hawk_of_a_test" not in sys.modules
    assert module.number() == 7
    monkeypatch.setattr("hawk_of_a_test.number", lambda: 8)
    assert module.number() == 8
    with pytest.raises(AttributeError, match="letter"):
        module.letter()
    with pytest.raises(ModuleNotFoundError, match="hawk_of_no_test"):
        late("hawk_of_no_test").number()
    del sys.modules["hawk_of_a_test"]


def test_a_function_of_a_late_module_is_handed_over_before_it_is_loaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "hawk_of_another_test.py").write_text("def number(first, *, second):\n    return first + second\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    number = late_functions("hawk_of_another_test").number
    assert "hawk_of_another_test" not in sys.modules
    assert number(3, second=4) == 7
    del sys.modules["hawk_of_another_test"]
