"""The real daemon, the real simulator, a real browser."""

from __future__ import annotations

import asyncio
import shutil
import sys
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path

import pytest
import pytest_asyncio
from playwright.async_api import Browser, async_playwright

from hawk.sim.launch import SimulationOptions
from hawk.survey.stack import SimulatedStack
from tests.forked import start_program
from tests.integration.daemon_support import PatientStack
from tests.pace import PATIENCE_S, speed_here

CHROMIUM = shutil.which("chromium") or "/usr/bin/chromium"
SWITCHED_OFF = "WebUIOmniboxPopup,WebUIOmniboxAimPopup"
"""Two pages that Chromium loads for the address bar of each new window: 0.75 s of a processor, and nobody sees them."""
LAUNCHER = f"""#!{sys.executable}
import os, sys
from hawk.runtime.process import SIMULATOR_NICENESS, set_session_niceness
set_session_niceness(SIMULATOR_NICENESS)
off = {SWITCHED_OFF!r}
given = [each + "," + off if each.startswith("--disable-features=") else each for each in sys.argv[1:]]
os.execv({CHROMIUM!r}, [{CHROMIUM!r}, *given])
"""
"""Puts the browser where the simulator is: the operator's computer, too, is another one, which the daemon does not slow
down. Without this vision goes before the browser where the daemon's session goes before others, and clicks take 4 s.
Of a switch that is given twice Chromium hears the last one: `SWITCHED_OFF` is added to what Playwright switches off."""
SPEED = speed_here(3.0)
CAMERA_HZ = 5.0
"""Pictures in a simulated second: vision keeps up with them, beside a browser."""
FAKE_DRONE = Path(__file__).resolve().parents[2] / "packaging" / "fake_drone.py"


@pytest.fixture(scope="session")
def launcher(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("browser") / "chromium"
    made.write_text(LAUNCHER)
    made.chmod(0o755)
    return made


@pytest_asyncio.fixture(loop_scope="session", scope="session")
async def one_browser(launcher: Path) -> AsyncIterator[Browser]:
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(
            executable_path=launcher, args=["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic"]
        )
        yield browser
        await browser.close()


@pytest_asyncio.fixture(loop_scope="session")
async def browser(one_browser: Browser) -> AsyncIterator[Browser]:
    """The browser; the pages of a test are closed with it."""
    yield one_browser
    for context in one_browser.contexts:
        await context.close()


@pytest_asyncio.fixture(loop_scope="session")
async def stack(tmp_path: Path) -> AsyncIterator[SimulatedStack]:
    """A daemon that flies the default world; `start` is the test's own business."""
    made = PatientStack(SimulationOptions(seed=1, speed=SPEED, camera_rate=CAMERA_HZ), tmp_path / "run", None, None)
    yield made
    await made.stop()


@pytest_asyncio.fixture(loop_scope="session")
async def fake() -> AsyncIterator[Callable[..., Awaitable[tuple[asyncio.subprocess.Process, str]]]]:
    """Start the made-up drone in a scene, with options; return its process and the page's address."""
    started: list[asyncio.subprocess.Process] = []

    async def start(scene: str, *options: str) -> tuple[asyncio.subprocess.Process, str]:
        process = await start_program(
            sys.executable, str(FAKE_DRONE), scene, "--port", "0", *options, stdout=asyncio.subprocess.PIPE
        )
        started.append(process)
        assert process.stdout is not None
        async with asyncio.timeout(PATIENCE_S):
            return process, (await process.stdout.readline()).decode().strip()

    yield start
    for process in started:
        if process.returncode is None:
            process.kill()
        await process.wait()


@pytest.fixture
def screenshots(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("screenshots")
