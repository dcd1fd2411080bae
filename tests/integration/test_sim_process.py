"""hawk-sim as a process: how it starts, what its pictures are tied to, how it ends."""

from __future__ import annotations

import json
import os
import re
import select
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.integration.sim_support import Pilot, free_udp_port, get_json, simulation, small_picture
from tests.pace import PATIENCE_S

pytestmark = pytest.mark.integration

RED, GREEN, BLUE = (0, 0, 220), (0, 220, 0), (220, 0, 0)


def read_parts(url: str, count: int) -> list[tuple[float, np.ndarray]]:
    """Return stamps and pictures of the first parts of an MJPEG stream, read as any client would."""
    parts = []
    with urllib.request.urlopen(url, timeout=PATIENCE_S) as stream:  # noqa: S310
        for _ in range(count):
            head = b""
            while not head.endswith(b"\r\n\r\n"):
                head += stream.readline()
            length = int(re.search(rb"Content-Length: (\d+)", head)[1])  # type: ignore[index]
            stamp = float(re.search(rb"X-Timestamp: ([\d.]+)", head)[1])  # type: ignore[index]
            picture = cv2.imdecode(np.frombuffer(stream.read(length), np.uint8), cv2.IMREAD_COLOR)
            assert picture is not None
            parts.append((stamp, picture))
            stream.readline()
    return parts


def quarters(folder: Path) -> Path:
    """Write 100 x 100 m: red in the north-west, green in the north-east, blue in the south-west, grey in the rest."""
    ground = np.full((400, 400, 3), 120, np.uint8)
    ground[:200, :200], ground[:200, 200:], ground[200:, :200] = RED, GREEN, BLUE
    path = folder / "quarters.png"
    cv2.imwrite(str(path), ground)
    return path


def strongest(picture: np.ndarray, row: float, column: float) -> tuple[int, ...]:
    """Return the colour about a place in the picture (fractions), as 0 and 1."""
    y, x = round(row * picture.shape[0]), round(column * picture.shape[1])
    mean = picture[y - 20 : y + 20, x - 20 : x + 20].reshape(-1, 3).mean(0)
    return tuple(int(value > 110) for value in mean)


@pytest.mark.parametrize("heading", [0, 90])
def test_the_picture_shows_the_world_as_it_lies(tmp_path: Path, heading: int) -> None:
    port = free_udp_port()
    with simulation(
        f"--world={quarters(tmp_path)}",
        "--metres-per-pixel=0.25",
        "--start=50,50",
        f"--heading={heading}",
        "--speed=4",
        "--gnss-sigma=0",
        "--gnss-wait=1",
        f"--mavlink=udpout:127.0.0.1:{port}",
    ) as ready:
        pilot = Pilot(f"udpin://127.0.0.1:{port}")
        try:
            pilot.ready()
            pilot.take_off(20.0)
            stamp, picture = read_parts(f"{ready['http']}/stream", 3)[-1]
            seen = [strongest(picture, row, column) for row in (0.3, 0.7) for column in (0.3, 0.7)]
            boot = pilot.messages["LOCAL_POSITION_NED"]["time_boot_ms"] / 1000.0
        finally:
            pilot.close()
    assert picture.shape == (720, 1280, 3)
    # BGR: north-west, north-east, south-west, south-east; with the nose to the east the top of the picture is east
    north_west, north_east, south_west, south_east = (0, 0, 1), (0, 1, 0), (1, 0, 0), (1, 1, 1)
    if heading == 0:
        assert seen == [north_west, north_east, south_west, south_east]
    else:
        assert seen == [north_east, south_east, north_west, south_west]
    assert abs(boot - stamp) < 2.0


def test_stamps_advance_by_a_frame_period_of_simulated_time(tmp_path: Path) -> None:
    with simulation(
        f"--world={small_picture(tmp_path)}", "--metres-per-pixel=0.5", "--speed=0.5", "--mavlink=udpin:127.0.0.1:0"
    ) as ready:
        stamps = [stamp for stamp, _ in read_parts(f"{ready['http']}/stream", 12)]
        status = get_json(f"{ready['http']}/status")
    steps = np.diff(stamps)
    assert steps.min() > 0.05
    assert float(np.median(steps)) == pytest.approx(1 / 15, abs=0.011)
    assert status["frames_drawn"] >= 12


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_it_ends_cleanly_while_somebody_looks(tmp_path: Path, number: int) -> None:
    command = [sys.executable, "-m", "hawk.sim.cli", f"--world={small_picture(tmp_path)}", "--metres-per-pixel=0.5"]
    command += ["--http=127.0.0.1:0", "--mavlink=udpin:127.0.0.1:0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        url = json.loads(process.stdout.readline())["http"]
        with urllib.request.urlopen(f"{url}/stream", timeout=PATIENCE_S) as stream:  # noqa: S310
            stream.read(1000)
            process.send_signal(number)
            assert process.wait(10) == 0
        assert process.stderr is not None
        assert process.stderr.read() == ""


def test_it_ends_with_its_parent(tmp_path: Path) -> None:
    world = small_picture(tmp_path)
    script = (
        "import os, subprocess, sys\n"
        "child = subprocess.Popen([sys.executable, '-m', 'hawk.sim.cli', '--world', sys.argv[1],"
        " '--metres-per-pixel', '0.5', '--http', '127.0.0.1:0', '--mavlink', 'udpin:127.0.0.1:0',"
        " '--parent-pid', str(os.getpid())], stdout=subprocess.PIPE)\n"
        "child.stdout.readline()\n"
        "print(child.pid, flush=True)\n"
        "os.kill(os.getpid(), 9)\n"
    )
    parent = subprocess.run(
        [sys.executable, "-c", script, str(world)], capture_output=True, text=True, timeout=PATIENCE_S, check=False
    )
    assert parent.returncode == -signal.SIGKILL
    pid = int(parent.stdout)
    try:
        ending = os.pidfd_open(pid)
    except ProcessLookupError:
        return
    ended, _, _ = select.select([ending], [], [], 10.0)
    os.close(ending)
    assert ended


def test_the_truth_is_written_and_served_alike(tmp_path: Path) -> None:
    saved = tmp_path / "truth.json"
    with simulation("--seed=3", f"--save-truth={saved}", "--mavlink=udpin:127.0.0.1:0") as ready:
        served = get_json(f"{ready['http']}/truth")
    written = json.loads(saved.read_text())
    assert len(written["stalls"]) >= 80
    assert {name: served[name] for name in written} == written
    assert served["start"]["x"] == pytest.approx(written["start_m"][0], abs=1e-3)
