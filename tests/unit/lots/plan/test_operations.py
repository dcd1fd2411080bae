"""Any JSON value as an operation is one, or is refused with a field and words."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.lots.plan.operations import NAMES, OPERATIONS, Operation, operation_of
from hawk.lots.values import LotInputError
from tests.examples import examples

ODD = st.sampled_from([10**400, -(10**30), 1e308, float("inf"), float("nan"), "\ud800", "\0", "", "1e5", "x" * 5000])
SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=50) | ODD
KEYS = st.text(max_size=5) | ODD.map(str)
VALUES = st.recursive(SCALARS, lambda part: st.lists(part) | st.dictionaries(KEYS, part))
FIELDS = st.sampled_from(sorted({name for each in OPERATIONS for name in each.model_fields} | {"all", "\ud800"}))
ASKED = st.builds(lambda do, fields: {"do": do, **fields}, st.sampled_from(NAMES), st.dictionaries(FIELDS, VALUES))


@pytest.mark.nightly
@settings(max_examples=examples(100), deadline=None)
@given(VALUES | ASKED)
def test_any_json_value_is_an_operation_or_is_refused_with_a_field_and_words(given_value: Any) -> None:
    operation, refusal = _read(given_value)
    if refusal is None:
        assert operation is not None
        assert operation.do in NAMES
    else:
        assert refusal.field
        assert len(refusal.reason) < 300
        assert "\n" not in refusal.reason


def _read(value: Any) -> tuple[Operation | None, LotInputError | None]:
    try:
        return operation_of(value), None
    except LotInputError as refused:
        return None, refused
