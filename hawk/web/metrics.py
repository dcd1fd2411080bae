"""Metrics in the Prometheus text format, version 0.0.4."""

from __future__ import annotations

import math
from typing import Final

from hawk.web.counters import Counters
from hawk.web.services import WebServices

METRICS_CONTENT_TYPE: Final = "text/plain; version=0.0.4; charset=utf-8"


def metrics_text(services: WebServices, counters: Counters) -> str:
    """Return all metrics; what is not known is left out."""
    lag = services.loop_lag()
    status = services.status.value
    lines: list[str] = []

    def add(name: str, kind: str, text: str, value: float | None, labels: str = "") -> None:
        if value is None or math.isnan(value):
            return
        head = f"hawk_{name}"
        if f"# TYPE {head} {kind}" not in lines:
            lines.extend((f"# HELP {head} {text}", f"# TYPE {head} {kind}"))
        lines.append(f"{head}{labels} {_number(value)}")

    for quantile, value in (("0.5", lag.p50_ms), ("0.99", lag.p99_ms), ("1", lag.max_ms)):
        text = "Lag of the event loop over the last minute."
        add("loop_lag_seconds", "gauge", text, value / 1e3, f'{{quantile="{quantile}"}}')
    add("clients", "gauge", "Connected pages.", len(services.side.hub))
    add("video_clients", "gauge", "Viewers of the video.", counters.video_clients)
    add("video_frames_total", "counter", "Frames handed to viewers.", counters.video_frames)
    add("video_latency_seconds", "gauge", "Age of the newest frame when handed out.", counters.frame_latency_s)
    add("heartbeats_total", "counter", "Heartbeats sent to pages.", counters.heartbeats)
    add("heartbeats_failed_total", "counter", "Heartbeats that could not be built.", counters.heartbeats_failed)
    add("status_age_seconds", "gauge", "Age of the state machine's last status.", services.status.age)
    add("frame_age_seconds", "gauge", "Age of the newest annotated frame.", services.video.age)
    if status is not None:
        add("vision_rate_hertz", "gauge", "Frames fused per second.", status.vision_rate)
        add("armed", "gauge", "1 when armed.", None if status.armed is None else float(status.armed))
        add("battery_percent", "gauge", "Battery left.", status.battery_percentage)
        for state, count in (("free", status.free), ("taken", status.taken), ("unknown", status.unknown)):
            add("stalls", "gauge", "Stalls on the map.", count, f'{{state="{state}"}}')
        for item in status.health:
            add("healthy", "gauge", "1 when the part is healthy.", float(item.healthy), f'{{part="{item.name}"}}')
    return "\n".join(lines) + "\n"


def _number(value: float) -> str:
    if math.isinf(value):
        return "+Inf" if value > 0 else "-Inf"
    return repr(float(value))
