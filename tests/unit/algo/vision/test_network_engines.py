"""Both engines run the same network alike, and each names what it cannot do."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from hawk.algo.vision.app import VisionApp, VisionSettings
from hawk.algo.vision.network import Engine, EngineError, StallNetwork, open_runner
from hawk.algo.vision.network_file import VisionModelError, packaged_weights
from hawk.config.loader import load_config
from hawk.config.sections import Config, ConfigError
from hawk.config.sections import VisionSettings as VisionSection
from hawk.daemon.algorithms import make_manager
from hawk.daemon.start_checks import check_model
from training.scenes import draw_scene

ENGINES = get_args(Engine)
DATA = Path(__file__).parent / "data"


def test_all_engines_answer_alike() -> None:
    picture = draw_scene(np.random.default_rng(5), (160, 224)).image
    first, *others = (StallNetwork.load(engine=engine).run(picture) for engine in ENGINES)
    assert len(others) == 1
    assert first.core.max() > 0.5
    for name in ("lot", "core", "car", "taken", "offset_row", "width"):
        for other in others:
            assert np.allclose(getattr(first, name), getattr(other, name), atol=1e-3)


def test_without_a_choice_the_fastest_engine_that_is_installed_runs_it() -> None:
    assert StallNetwork.load().engine == "onnxruntime"


@pytest.mark.parametrize("engine", ENGINES)
def test_a_chosen_engine_runs_it(engine: Engine) -> None:
    assert StallNetwork.load(engine=engine).engine == engine


@pytest.mark.parametrize("threads", [1, 2])
def test_onnx_runtime_has_as_many_threads_as_it_is_given(threads: int) -> None:
    picture = np.full((64, 96, 3), 90, np.uint8)
    assert np.isfinite(StallNetwork.load(engine="onnxruntime", threads=threads).run(picture).core).all()


@pytest.mark.parametrize("engine", ENGINES)
def test_a_file_that_is_no_network_is_refused_by_name(tmp_path: Path, engine: Engine) -> None:
    broken = tmp_path / "broken.onnx"
    broken.write_bytes(b"no network")
    with pytest.raises(VisionModelError, match=rf"vision\.model: .*broken\.onnx is not an ONNX file that {engine} can"):
        StallNetwork.load(broken, engine)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_network_of_another_kind_is_refused_by_name(engine: Engine) -> None:
    with pytest.raises(VisionModelError, match=r"vision\.model: .*wrong_answer\.onnx answers with shape"):
        StallNetwork.load(DATA / "wrong_answer.onnx", engine)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_run_that_fails_is_an_error_of_the_engine(engine: Engine) -> None:
    with pytest.raises(EngineError):
        open_runner(engine, packaged_weights(), 1).run({"image": np.zeros((1, 3, 64, 66), np.float32)})


@pytest.fixture
def not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "onnxruntime", None)


MISSING = (
    r"vision\.engine: onnxruntime is not installed .*pip install './hawk_drone-.*\.whl\[onnxruntime\]', or set it to"
)


@pytest.mark.usefixtures("not_installed")
def test_an_engine_that_is_not_installed_is_refused_before_the_start() -> None:
    with pytest.raises(ConfigError, match=MISSING):
        check_model(VisionSection(engine="onnxruntime"))
    with pytest.raises(VisionModelError, match=MISSING):
        VisionApp(VisionSettings(engine="onnxruntime"))


@pytest.mark.usefixtures("not_installed")
def test_without_a_choice_opencv_runs_it_where_it_is_alone(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO")
    assert StallNetwork.load().engine == "opencv"
    assert VisionApp(VisionSettings()) is not None
    assert "the network runs in opencv, threads: 1" in caplog.text
    check_model(VisionSection())


def test_a_file_that_is_no_network_is_refused_without_a_choice_too(tmp_path: Path) -> None:
    broken = tmp_path / "broken.onnx"
    broken.write_bytes(b"no network")
    with pytest.raises(VisionModelError, match="is not an ONNX file that the engine can read"):
        StallNetwork.load(broken)


@pytest.mark.usefixtures("not_installed")
def test_in_the_air_opencv_stands_in_for_an_engine_that_is_gone(caplog: pytest.LogCaptureFixture) -> None:
    config = Config(vision=VisionSection(engine="onnxruntime"))
    manager = make_manager(config, "lot", is_simulation=True)
    assert "the packaged network is used in its place, in OpenCV" in caplog.text
    assert manager is not None


def test_an_engine_that_there_is_not_is_refused_with_those_that_there_are() -> None:
    with pytest.raises(ConfigError, match=r"HAWK_VISION__ENGINE: vision\.engine: .*'auto', 'opencv' or 'onnxruntime'"):
        load_config(None, {"HAWK_VISION__ENGINE": "ncnn"})
