"""The real daemon, the real simulator, a real browser."""

from __future__ import annotations

import shutil
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from playwright.async_api import Browser, async_playwright

from hawk.simulation import SimulationOptions
from hawk.survey.stack import SimulatedStack

CHROMIUM = shutil.which("chromium") or "/usr/bin/chromium"
SPEED = 3.0


@pytest.fixture
async def browser() -> AsyncIterator[Browser]:
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic"]
        )
        yield browser
        await browser.close()


@pytest.fixture
async def stack(tmp_path: Path) -> AsyncIterator[SimulatedStack]:
    """A daemon that flies the default world; `start` is the test's own business."""
    made = SimulatedStack(SimulationOptions(seed=1, speed=SPEED), tmp_path / "run", None, None)
    yield made
    await made.stop()


@pytest.fixture
def screenshots(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("screenshots")
