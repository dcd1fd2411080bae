"""Many cases in one test: each failing one is named, and the others are tried all the same."""

from __future__ import annotations

import contextlib
import functools
import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import pytest

Test = Callable[..., Any]


def sweep(names: str | tuple[str, ...], cases: Iterable[Any]) -> Callable[[Test], Test]:
    """Call a test with every case, like ``pytest.mark.parametrize``, but as one test, whose fixtures all cases share.

    It costs a fraction of as many tests. Raises BaseExceptionGroup with the failures; each names its case.

    Args:
        names: Arguments of the test, by commas or as a tuple.
        cases: A value for the one argument, or a tuple with one for each.
    """
    arguments = tuple(name.strip() for name in names.split(",")) if isinstance(names, str) else names
    given = [dict(zip(arguments, case if len(arguments) > 1 else (case,), strict=True)) for case in cases]
    assert given, "a sweep needs cases"

    def decorate(test: Test) -> Test:
        async def swept_async(**fixtures: Any) -> None:
            with _failures(len(given)) as failed:
                for case in given:
                    with failed(case):
                        await test(**case, **fixtures)

        def swept(**fixtures: Any) -> None:
            with _failures(len(given)) as failed:
                for case in given:
                    with failed(case):
                        test(**case, **fixtures)

        made: Test = functools.wraps(test)(swept_async if inspect.iscoroutinefunction(test) else swept)
        signature = inspect.signature(test)
        left = [each for each in signature.parameters.values() if each.name not in arguments]
        made.__signature__ = signature.replace(parameters=left)  # type: ignore[attr-defined]
        return made

    return decorate


@contextlib.contextmanager
def _failures(count: int) -> Iterator[Callable[[Mapping[str, Any]], contextlib.AbstractContextManager[None]]]:
    """Give a context for each case, and raise what failed in them at the end."""
    found: list[BaseException] = []
    names: list[str] = []

    @contextlib.contextmanager
    def case(values: Mapping[str, Any]) -> Iterator[None]:
        try:
            yield
        except (Exception, pytest.fail.Exception) as error:
            names.append(", ".join(f"{name}={value!r}" for name, value in values.items()))
            error.add_note(names[-1])
            found.append(error)

    yield case
    if found:
        raise BaseExceptionGroup("\n".join([f"{len(found)} of {count} cases failed:", *names]), found)
