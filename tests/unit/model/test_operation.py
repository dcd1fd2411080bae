from __future__ import annotations

import pytest
from pydantic import TypeAdapter

from hawk.model.operation import FlightSoFar


@pytest.mark.parametrize("key", ["distance_m", "way"])
def test_a_flight_of_a_version_before_is_read(key: str) -> None:
    text = f'{{"seconds": 30.0, "{key}": 40.0}}'
    assert TypeAdapter(FlightSoFar).validate_json(text) == FlightSoFar(30.0, 40.0)


def test_a_flight_comes_back_from_its_json() -> None:
    flight = FlightSoFar(30.0, 40.0, parameters={"RTL_ALT": 1500.0})
    adapter = TypeAdapter(FlightSoFar)
    assert adapter.validate_json(adapter.dump_json(flight)) == flight
