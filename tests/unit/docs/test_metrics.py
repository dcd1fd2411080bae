"""docs/metrics.md names the figures that the daemon gives, and no other."""

from __future__ import annotations

import ast
import re
from pathlib import Path

from hawk.comm.protocol.heartbeat import DroneStatus, HealthItem, PartsStatus, PerceptionStatus, VehicleStatus
from hawk.web.metrics import Access, computer_figures, metrics_text
from hawk.web.services import Counters
from tests.unit.web.rig import Rig

ROOT = Path(__file__).parents[3]
TEXT = (ROOT / "docs" / "metrics.md").read_text(encoding="utf-8")
LIST = "\n".join(line for line in TEXT.splitlines() if line.startswith("- `hawk_"))


COMPUTER = (
    *computer_figures(ROOT, Path("/nowhere")),
    ("temperature_celsius", "gauge", "Of the computer's parts.", 45.2, {"zone": "cpu-thermal"}),
)


def counted_by_the_daemon() -> set[str]:
    """Return the names of the counters that the daemon adds to those of the web server."""
    tree = ast.parse((ROOT / "hawk" / "daemon" / "root.py").read_text(encoding="utf-8"))
    (table,) = (
        node.value.body
        for node in ast.walk(tree)
        if isinstance(node, ast.keyword) and node.arg == "counters" and isinstance(node.value, ast.Lambda)
    )
    assert isinstance(table, ast.Dict)
    return {f"hawk_{ast.literal_eval(key)}_total" for key in table.keys if key is not None}


async def test_every_figure_is_in_the_list_and_the_list_has_no_other() -> None:
    rig = Rig()
    rig.publish(
        DroneStatus(
            vehicle=VehicleStatus(armed=True, battery_percentage=80.0),
            perception=PerceptionStatus(vision_rate=6.0),
            parts=PartsStatus(health=(HealthItem(name="link", healthy=True, reason=""),)),
        )
    )
    text = metrics_text(rig.services(), Counters(frame_latency_s=0.1), Access(), COMPUTER)
    given = set(re.findall(r"^# TYPE (\w+)", text, re.MULTILINE)) | counted_by_the_daemon()
    assert {"hawk_loop_lag_seconds", "hawk_log_lines_dropped_total"} <= given
    assert set(re.findall(r"`(hawk_\w+)", LIST)) == given
    labels = dict(re.findall(r"^(hawk_\w+)\{(\w+)=", text, re.MULTILINE))
    assert dict(re.findall(r"`(hawk_\w+)\{(\w+)\}`", LIST)) == labels
