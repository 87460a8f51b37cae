"""See a report drawn: ``python -m servogen.reports.browser report.html [-s picture.png]``.

Opens the page in headless Chromium and finds out whether every plot stands there with every trace,
whether the console stayed silent, and whether the page asked for anything but itself. Exit status
0 all well, 1 a plot is missing or something was said, 2 no browser or no page.
"""

from __future__ import annotations

import argparse
import base64
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from servogen.reports.chromium import BrowserError, Page, open_page

# Per plot: traces given, those drawn with a line, a marker or a fill that has an extent, and size.
_LOOK = """
[...document.querySelectorAll(".plot")].map((div) => {
  const given = (div.data || []).filter((t) => (t.x || []).some((v, i) =>
    v !== null && t.y[i] !== null));
  const seen = [...div.querySelectorAll(".main-svg .trace")].filter((trace) =>
    [...trace.querySelectorAll("path")].some((path) => {
      const box = path.getBBox();
      return box.width > 0 || box.height > 0;
    }));
  const box = div.getBoundingClientRect();
  return { id: div.id, given: given.length, seen: seen.length,
           width: Math.round(box.width), height: Math.round(box.height) };
})
"""
_SMALLEST = 100  # pixels, of a plot that can be read
_ERRORS = ("error", "warning", "assert")


@dataclass(frozen=True)
class Seen:
    """``plots``: how many; ``faults``: one line for each thing that is wrong."""

    plots: int
    faults: list[str]


def look(
    report: Path, screenshot: Path | None = None, patience_s: float = 60.0, **view: Any
) -> Seen:
    """Open a report and judge what is drawn.

    Args:
        screenshot: a PNG of the whole page.
        patience_s: how long drawing may take.
        view: ``width``, ``dark``, ``selector``, ``scale``: see ``photograph``.

    Raises:
        BrowserError: no Chromium, or it does not answer.
    """
    with open_page() as page:
        _set_view(page, **view)
        page.send("Page.navigate", url=report.resolve().as_uri())
        finished = page.wait_for("document.body && document.body.dataset.drawn", patience_s)
        plots = page.evaluate(_LOOK)
        if screenshot is not None:
            screenshot.write_bytes(photograph(page, view.get("selector")))
        faults = [] if finished else ["the page did not finish drawing"]
        faults += _plot_faults(plots) + _spoken(page.events)
    return Seen(len(plots), faults)


def _plot_faults(plots: list[dict[str, Any]]) -> list[str]:
    if not plots:
        return ["there is no plot on the page"]
    faults = []
    for plot in plots:
        if plot["seen"] < plot["given"] or not plot["given"]:
            faults.append(f"{plot['id']}: {plot['seen']} of {plot['given']} traces drawn")
        if min(plot["width"], plot["height"]) < _SMALLEST:
            faults.append(f"{plot['id']}: only {plot['width']} by {plot['height']} pixels")
    return faults


def _spoken(events: list[dict[str, Any]]) -> list[str]:
    """Console errors and warnings, exceptions, and requests beyond the page itself."""
    faults = []
    for event in events:
        method, found = event.get("method"), event.get("params", {})
        if method == "Runtime.exceptionThrown":
            details = found["exceptionDetails"]
            said = details.get("exception", {}).get("description") or details.get("text")
            faults.append(f"exception: {said}")
        elif method == "Runtime.consoleAPICalled" and found["type"] in _ERRORS:
            said = " ".join(str(a.get("value", a.get("description"))) for a in found["args"])
            faults.append(f"console {found['type']}: {said}")
        elif method == "Log.entryAdded" and found["entry"]["level"] in _ERRORS:
            faults.append(f"console {found['entry']['level']}: {found['entry']['text']}")
        elif method == "Network.requestWillBeSent":
            url = str(found["request"]["url"])
            if not url.startswith(("file:", "data:", "blob:", "about:")):
                faults.append(f"asked for {url}")
    return faults


def _set_view(
    page: Page,
    width: int = 1280,
    dark: bool = False,
    scale: float = 1.0,
    selector: str | None = None,
) -> None:
    page.send(
        "Emulation.setDeviceMetricsOverride",
        width=width,
        height=900,
        deviceScaleFactor=scale,
        mobile=False,
    )
    scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
    page.send("Emulation.setEmulatedMedia", features=[scheme])


def photograph(page: Page, selector: str | None = None) -> bytes:
    """PNG of the whole page, or of the first element that ``selector`` finds."""
    page.evaluate("document.querySelectorAll('.modebar').forEach((bar) => bar.remove())")
    box = page.evaluate(
        f"(() => {{ const b = document.querySelector({(selector or 'html')!r})"
        ".getBoundingClientRect(); return [b.x + scrollX, b.y + scrollY, b.width, b.height]; })()"
    )
    clip = dict(zip(("x", "y", "width", "height"), box, strict=True)) | {"scale": 1}
    shot = page.send("Page.captureScreenshot", format="png", captureBeyondViewport=True, clip=clip)
    return base64.b64decode(shot["data"])


def main(argv: Sequence[str] | None = None) -> int:
    """Judge a report; the faults go to standard error."""
    parser = argparse.ArgumentParser(prog="python -m servogen.reports.browser")
    parser.add_argument("report", type=Path)
    parser.add_argument("-s", "--screenshot", type=Path, metavar="PNG")
    parser.add_argument("--width", type=int, default=1280, metavar="PIXELS")
    parser.add_argument("--scale", type=float, default=1.0, help="pixels of the PNG per CSS pixel")
    parser.add_argument("--dark", action="store_true")
    parser.add_argument("--selector", help="of the screenshot, for instance '#path figure'")
    given = parser.parse_args(argv)
    if not given.report.is_file():
        print(f"browser: there is no report {given.report}", file=sys.stderr)
        return 2
    try:
        seen = look(
            given.report,
            given.screenshot,
            width=given.width,
            dark=given.dark,
            scale=given.scale,
            selector=given.selector,
        )
    except BrowserError as error:
        print(f"browser: {error}", file=sys.stderr)
        return 2
    for fault in seen.faults:
        print(f"browser: {fault}", file=sys.stderr)
    if seen.faults:
        return 1
    print(f"browser   {seen.plots} plots drawn, no word on the console, nothing asked for")
    return 0


if __name__ == "__main__":
    sys.exit(main())
