"""Words for what pydantic refuses."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, get_args

import pytest
from pydantic import BaseModel, TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from hawk.comm.cameras import calibration
from hawk.config import addresses
from hawk.config.sections import Config
from hawk.formats.validation import BOUNDED, PLAIN, wrong_values
from hawk.lots.plan.operations import NAMES, OPERATIONS
from hawk.picture import webodm
from hawk.picture.photographs import lenses
from hawk.sim import camera_server
from hawk.survey import truth
from hawk.web.v1 import bodies, parameters, plan_files
from hawk.web.v1.features import parameters as features_parameters

ODD: list[Any] = [
    None, True, -1, 0, 10**12, 10**400, 0.5, -1e300, math.inf, math.nan, "", "x", "7", "x" * 5000, "\0", "\ud800", b"x",
    [], [1], [1, 2, 3], ["x"] * 2000, {}, {"x": 1}, {"do": "fly"}, {"do": "move"}, object(),
]  # fmt: skip
ENGLISH = ("Input ", "should ", "String ", "List ", "Tuple ", "Value error", "valid ", "Field required", "permitted")


def models_of(module: Any) -> Iterator[type[BaseModel]]:
    for each in vars(module).values():
        if isinstance(each, type) and issubclass(each, BaseModel) and each.__module__ == module.__name__:
            yield each


MODELS: list[type[BaseModel]] = [
    Config, *OPERATIONS,
    *(
        model
        for module in (
            bodies, parameters, features_parameters, plan_files, lenses, webodm, truth, camera_server, addresses,
            calibration,
        )
        for model in models_of(module)
    ),
]  # fmt: skip


def inner(kind: Any) -> Iterator[type[BaseModel]]:
    """Yield the models within the type of a field."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        yield kind
        return
    for part in get_args(kind):
        yield from inner(part)


def parts(model: type[BaseModel]) -> set[type[BaseModel]]:
    """Return a model and those within its fields."""
    found = {model}
    for field in model.model_fields.values():
        for each in inner(field.annotation):
            if each not in found:
                found |= parts(each)
    return found


def refusals(model: type[BaseModel]) -> Iterator[ValidationError]:
    """Yield the errors of a model about odd values in each of its fields, about none and about one too many."""
    for name, field in model.model_fields.items():
        for odd in ODD:
            for given in (odd, [odd]):
                yield from refused(model, {key_of(name, field): given, "x-ray": 1})
    for odd in ODD:
        yield from refused(model, odd)


def key_of(name: str, field: FieldInfo) -> str:
    return field.alias or name


def refused(model: type[BaseModel], given: Any) -> Iterator[ValidationError]:
    try:
        model.model_validate(given)
    except ValidationError as error:
        yield error


@pytest.mark.slow
def test_every_error_that_a_model_can_raise_has_words_of_ours() -> None:
    seen: dict[str, str] = {}
    for model in {part for each in MODELS for part in parts(each)}:
        for error in refusals(model):
            for problem, wrong in zip(error.errors(), wrong_values(error, model, NAMES), strict=True):
                seen[problem["type"]] = wrong.reason
                assert not any(words in wrong.reason for words in ENGLISH), (model, problem, wrong.reason)
                assert len(wrong.field) <= 80
    own = {"value_error", "assertion_error", "union_tag_not_found"}
    assert set(seen) <= {*PLAIN, *BOUNDED, *own}, set(seen) - {*PLAIN, *BOUNDED, *own}
    assert len(seen) > 15


@pytest.mark.parametrize(
    ("model", "given", "field", "reason"),
    [
        (bodies.LotSplit, {"name": "S", "outline": [[52, 5]]}, "outline", "must be a list of 3 or more, not 1"),
        (bodies.LotSplit, {"name": 5, "outline": [[52, 5]] * 3}, "name", "must be text"),
        (bodies.LotSplit, {"outline": [[52, 5]] * 3}, "name", "is missing: write it"),
        (bodies.LotSplit, {"name": "S", "outline": [[52]] * 3}, "outline[0][1]", "is missing: write it"),
        (bodies.LotName, {"name": "", "colour": 1}, "name", "must have 1 or more characters"),
        (bodies.Keep, {"keep": 1}, "keep", "must be true or false"),
        (bodies.LinkDays, {"days": 400}, "days", "must be 366 or less"),
        (bodies.Choose, {"place": -1}, "place", "must lie between 0 and 1000"),
        (bodies.Chosen, {"survey": "x" * 36, "begin": "some"}, "survey", "must have the form ^[0-9a-f-]{36}$"),
        (parameters.Listed, {"limit": "1001"}, "limit", "must lie between 1 and 1000"),
        (
            Config,
            {"flight": {"colour": 99.0}},
            "flight.colour",
            "is not known here: leave it out",
        ),
    ],
)
def test_a_wrong_value_is_named_with_the_remedy(
    model: type[BaseModel], given: Any, field: str, reason: str
) -> None:  # fmt: skip
    with pytest.raises(ValidationError) as caught:
        model.model_validate(given)
    (wrong, *_) = wrong_values(caught.value, model)
    assert (wrong.field, wrong.reason) == (field, reason)


def test_words_for_a_form_replace_the_pattern() -> None:
    with pytest.raises(ValidationError) as caught:
        TypeAdapter(parameters.Id).validate_python("x")
    (wrong,) = wrong_values(caught.value, forms=parameters.FORMS)
    assert wrong.reason == "must be an id, 36 characters, as the lists have it"
