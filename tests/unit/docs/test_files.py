"""docs/files.md names the files that the program keeps."""

from __future__ import annotations

from pathlib import Path

import pytest

from hawk.ddc.fence_file import FENCE_FILE
from hawk.ddc.params import PARAMETER_FILE
from hawk.web.access_keeper import LOGIN_FILE
from hawk.web.make_certificate import CERTIFICATE_FILE, KEY_FILE
from hawk.web.private_files import ADDRESS_FILE, SECRET_FILE
from hawk.web.tokens import TOKEN_FILE

TEXT = (Path(__file__).parents[3] / "docs" / "files.md").read_text(encoding="utf-8")
KEPT = [PARAMETER_FILE, FENCE_FILE, TOKEN_FILE, LOGIN_FILE, SECRET_FILE, ADDRESS_FILE, CERTIFICATE_FILE, KEY_FILE]


@pytest.mark.parametrize("name", KEPT)
def test_a_file_of_the_store_is_listed(name: str) -> None:
    assert f"`{name}`" in TEXT
