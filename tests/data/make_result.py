"""Writes ``result_vN.h5``, the sample of format version N, once, when a version that writes it is released.

``python tests/data/make_result.py``; samples of earlier formats are never made anew.
"""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parents[1]), str(HERE.parent)]

from fake_states import fake_header, fake_states  # noqa: E402

from fretsolve.result import HistoryWriter  # noqa: E402
from fretsolve.result.layout import FORMAT_VERSION  # noqa: E402

if __name__ == "__main__":
    out = HERE / f"result_v{FORMAT_VERSION}.h5"
    with HistoryWriter.open(out, fake_header(every=3, increments=4)) as writer:
        for state in fake_states(4):
            writer.append(state)
        writer.finish("complete")
