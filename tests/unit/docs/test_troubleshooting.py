"""The words of docs/troubleshooting.md are those that the programs say, so that a search finds them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from hawk.comm.protocol.command_table import COMMAND_TABLE
from tests.sweep import sweep

ROOT = Path(__file__).parents[3]
TEXT = (ROOT / "docs" / "troubleshooting.md").read_text(encoding="utf-8")
SYMPTOMS = re.findall(r"^- ((?:[^`:]|`[^`]*`)*): ", TEXT, re.MULTILINE)
SAID = sorted({words for symptom in SYMPTOMS for words in re.findall(r"`([^`]+)`", symptom)})
NO_WORDS = {"/dev/tty…", "camera.mount_yaw_deg"}
"""Marked for another reason."""


@pytest.fixture(scope="module")
def sources() -> str:
    """Return all that the programs could say: adjacent strings joined, white space as one space."""
    messages = ROOT / "hawk" / "web" / "page" / "src" / "messages" / "en.ftl"
    files = [*(ROOT / "hawk").rglob("*.py"), messages, *(ROOT / "hawk" / "web" / "access" / "login").iterdir()]
    texts = [path.read_text(encoding="utf-8") for path in files if "node_modules" not in path.parts]
    joined = re.sub(r"[\"']\s*\n\s*f?[\"']", "", "\n".join(texts))
    return re.sub(r"\s+", " ", joined)


def test_the_page_has_more_than_eighty_sentences() -> None:
    assert len(SAID) > 80


@pytest.mark.slow
@sweep("words", [words for words in SAID if words not in NO_WORDS])
def test_the_sources_have_each_sentence(words: str, sources: str) -> None:
    parts = [part.strip(" :.") for part in words.split("…")]
    missing = [part for part in parts if part and part not in sources]
    assert not missing


def test_every_refusal_of_a_state_is_explained() -> None:
    """Some explain themselves: of commands that only programs send, or that ask for what is so already."""
    reasons = {reason for row in COMMAND_TABLE.values() for reason in row.states.values()}
    said = {reason for reason in reasons if reason.endswith(" first.")}
    known = {"Armed: disarm first.", "Flying: land first.", "Landing: Hold first.", "In the air: land first."}
    assert said
    assert said - known <= set(SAID)
