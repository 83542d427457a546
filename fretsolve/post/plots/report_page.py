"""Put all pictures of a result on one HTML page, with a slider that steps through its increments."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping
from html import escape

from PIL import Image

from fretsolve.post.export.text_report import print_report
from fretsolve.post.plots.canvas import TWO_COLUMNS, rendered, title_of
from fretsolve.post.plots.kinds import KINDS, MOVING, film_dpi
from fretsolve.post.plots.load_history import step_texts
from fretsolve.post.plots.pictures.maps import few_steps, film
from fretsolve.post.plots.pictures.profiles import profiles
from fretsolve.post.plots.sheet import Sheet
from fretsolve.post.plots.snapshot import require_increments
from fretsolve.result import Result

PAGE_STYLE = (
    "body{font-family:sans-serif;max-width:70rem;margin:2rem auto;padding:0 1rem;color:#222}"
    "img{max-width:100%;height:auto}img[hidden]{display:none}input[type=range]{width:100%}"
    "figure{margin:2rem 0}figcaption{color:#555}"
    "pre{overflow-x:auto;background:#f6f6f6;padding:1rem;font-size:.8rem;line-height:1.25}"
)

OWN_MARK = '<meta name="generator" content="fretsolve">'
"""In the head of every page, by which a page is known before it is replaced."""


SLIDER = """<script>
const slider = document.querySelector("#increments input"), frames = document.querySelectorAll("#increments img");
slider.addEventListener("input", () => frames.forEach((frame, k) => { frame.hidden = k !== Number(slider.value); }));
</script>"""
"""Shows the frame that the slider stands at. The arrow keys move it."""


def html_page(
    result: Result,
    pictures: Mapping[str, bytes],
    left_out: Mapping[str, str],
    frames: Mapping[str, bytes],
    dpi: int = Sheet.dpi,
) -> str:
    """Return a page that needs no other file: table, increments, pictures, what is left out and why, and the case.

    pictures: files of the kinds in their first formats; left_out: reasons. Both by the names of the kinds. frames: PNG
    files by what they show. dpi: dots per inch of the pictures that stand still.
    """
    table = io.StringIO()
    print_report(result, file=table)
    title = escape(title_of(result))
    reasons = [f"<li>{escape(name)}: {escape(reason)}</li>" for name, reason in left_out.items()]
    parts = [
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n{OWN_MARK}\n<title>{title}</title>',
        f"<style>{PAGE_STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>",
        f"<pre>{escape(table.getvalue())}</pre>",
        *([_increments(frames, len(result.steps))] if len(frames) > 1 else []),
        *(_figure(name, content, dpi) for name, content in pictures.items()),
        *(["<h2>Left out</h2>\n<ul>", *reasons, "</ul>"] if reasons else []),
        f"<h2>Case</h2>\n<pre>{escape(result.case_yaml)}</pre>\n</body>\n</html>\n",
    ]
    return "\n".join(parts)


def _figure(name: str, content: bytes, dpi: int) -> str:
    caption, file_format = escape(KINDS[name].caption), KINDS[name].formats[0]
    with Image.open(io.BytesIO(content)) as picture:  # in per cent of the page, as wide as two columns of a journal
        inches = picture.width / (film_dpi(dpi) if file_format in MOVING else dpi)
    width = min(100.0 * inches / TWO_COLUMNS, 100.0)
    source = _embedded(content, file_format)
    image = f'<img src="{source}" alt="{name}: {caption}" style="width:{width:.3g}%">'
    return f'<figure id="{name}">\n<h2>{name}</h2>\n{image}\n<figcaption>{caption}</figcaption>\n</figure>'


def increment_frames(result: Result) -> dict[str, bytes]:
    """Return maps, or profiles of a line contact, of at most 24 increments, by their loads.

    Raises PictureError if the result has no fields.
    """
    require_increments(result)
    if len(result.y) > 1:
        drawn = film(result, most=24)  # some tens of kB each
        found = {}
        for step, text in zip(drawn.steps, step_texts(result, drawn.steps, plain=True), strict=True):
            drawn.show(step)
            found[text] = rendered(drawn.figure, "png", 110)
        return found
    steps = few_steps(result, 24)
    figures = [profiles(result, steps=[step]) for step in steps]
    # one scale for panels of one field and unit
    panels = [axes for figure in figures for axes in figure.axes]
    for label in {axes.get_ylabel() for axes in panels}:
        alike = [axes for axes in panels if axes.get_ylabel() == label]
        limits = [axes.get_ylim() for axes in alike]
        for axes in alike:
            axes.set_ylim(min(low for low, _ in limits), max(high for _, high in limits))
    texts = step_texts(result, steps, plain=True)
    return {text: rendered(figure, "png", 110) for text, figure in zip(texts, figures, strict=True)}


def _increments(frames: Mapping[str, bytes], stored: int) -> str:
    """Return the slider with its frames; stored: the number of increments with fields."""
    last = len(frames) - 1
    images = [
        f'<img src="{_embedded(content, "png")}" alt="{escape(text)}"{" hidden" * (k < last)}>'
        for k, (text, content) in enumerate(frames.items())
    ]
    slider = f'<input type="range" min="0" max="{last}" value="{last}" aria-label="increment">'
    shown = "the increments" if len(frames) == stored else f"{len(frames)} of the {stored} increments with fields"
    caption = f"<figcaption>Move the slider to step through {shown}, all drawn in one scale.</figcaption>"
    return "\n".join(['<figure id="increments">', "<h2>increments</h2>", slider, *images, caption, "</figure>", SLIDER])


def _embedded(content: bytes, file_format: str) -> str:
    return f"data:image/{file_format};base64,{base64.b64encode(content).decode()}"
