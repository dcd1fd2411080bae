"""Engines that run an ONNX network: OpenCV, which every installation has, and ONNX Runtime, which is an extra."""

from __future__ import annotations

from typing import Final, Literal, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

Engine = Literal["opencv", "onnxruntime"]
DEFAULT_ENGINE: Final = "opencv"

Blob = NDArray[np.float32]

_FATAL_ONLY: Final = 4
"""ONNX Runtime's log level: what goes wrong is raised, so it need not be printed."""


class EngineError(Exception):
    """The engine cannot read or run the network; the text says why."""


class MissingEngineError(EngineError):
    """The engine is not installed."""


class Runner(Protocol):
    """One network in one engine."""

    def run(self, blob: Blob) -> Blob:
        """Return the first output for the one input. Raises EngineError."""
        ...


def open_runner(engine: Engine, onnx: bytes, threads: int) -> Runner:
    """Read an ONNX file. OpenCV takes its number of threads from ``cv2.setNumThreads``, ONNX Runtime this one.

    Raises:
        EngineError: The engine cannot read it.
        MissingEngineError: The engine is not installed.
    """
    return _OnnxRuntime(onnx, threads) if engine == "onnxruntime" else _OpenCv(onnx)


class _OpenCv:
    def __init__(self, onnx: bytes) -> None:
        try:
            self._net = cv2.dnn.readNetFromONNX(np.frombuffer(onnx, np.uint8))
        except (cv2.error, ValueError) as error:
            raise EngineError(str(error)) from error

    def run(self, blob: Blob) -> Blob:
        """Return the first output for the one input."""
        try:
            self._net.setInput(blob)
            return np.asarray(self._net.forward(), np.float32)
        except cv2.error as error:
            raise EngineError(str(error)) from error


class _OnnxRuntime:
    def __init__(self, onnx: bytes, threads: int) -> None:
        try:
            import onnxruntime  # an extra
        except ImportError as error:
            raise MissingEngineError(str(error)) from error
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = threads
        options.inter_op_num_threads = 1
        options.log_severity_level = _FATAL_ONLY
        options.add_session_config_entry("session.intra_op.allow_spinning", "0")  # a waiting thread leaves its core
        try:
            self._session = onnxruntime.InferenceSession(onnx, options, providers=["CPUExecutionProvider"])
        except Exception as error:  # its errors have no class in common
            raise EngineError(str(error)) from error
        self._input = self._session.get_inputs()[0].name

    def run(self, blob: Blob) -> Blob:
        """Return the first output for the one input."""
        try:
            return np.asarray(self._session.run(None, {self._input: blob})[0], np.float32)
        except Exception as error:  # as above
            raise EngineError(str(error)) from error
