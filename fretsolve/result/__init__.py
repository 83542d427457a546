"""The result file: written increment by increment, read complete, failed, stopped or still growing."""

from __future__ import annotations

from fretsolve.result.header import RunHeader
from fretsolve.result.reader import Result, open_result
from fretsolve.result.writer import SAME_COMMAND, HistoryWriter

__all__ = ["SAME_COMMAND", "HistoryWriter", "Result", "RunHeader", "open_result"]
