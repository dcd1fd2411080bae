"""docs/files.md names the files that the program keeps."""

from __future__ import annotations

from pathlib import Path

from hawk.daemon.announcement import ADDRESS_FILE
from hawk.ddc.fence.keepers import FENCE_FILE
from hawk.ddc.parameters.heights import PARAMETER_FILE
from hawk.web.access.access import LOGIN_FILE
from hawk.web.access.tls import CERTIFICATE_FILE, KEY_FILE
from hawk.web.access.tokens import SECRET_FILE, TOKEN_FILE
from tests.sweep import sweep

TEXT = (Path(__file__).parents[3] / "docs" / "files.md").read_text(encoding="utf-8")
KEPT = [PARAMETER_FILE, FENCE_FILE, TOKEN_FILE, LOGIN_FILE, SECRET_FILE, ADDRESS_FILE, CERTIFICATE_FILE, KEY_FILE]


@sweep("name", KEPT)
def test_a_file_of_the_store_is_listed(name: str) -> None:
    assert f"`{name}`" in TEXT
