"""A simulated survey in a folder that an earlier one used."""

from __future__ import annotations

from pathlib import Path

from hawk.survey.run import set_store_aside


def test_an_earlier_store_is_renamed_and_none_is_lost(tmp_path: Path) -> None:
    store = tmp_path / "store"
    for content in ("first", "second"):
        store.mkdir()
        (store / "map").write_text(content)
        set_store_aside(store)
        assert not store.exists()
    assert [(tmp_path / f"store-{number}" / "map").read_text() for number in (1, 2)] == ["first", "second"]


def test_without_an_earlier_store_there_is_nothing_to_do(tmp_path: Path) -> None:
    set_store_aside(tmp_path / "store")
    assert list(tmp_path.iterdir()) == []
