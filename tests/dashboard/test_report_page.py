"""A report in a real browser, opened as a file: its figures are drawn and can be zoomed, and it asks nobody."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from brake_monitor.cli import main
from brake_monitor.settings.example_vehicles import example_config
from program import until

pytestmark = pytest.mark.browser

INK = """() => [...document.querySelectorAll("#figures canvas")].map((canvas) => {
  const { data } = canvas.getContext("2d").getImageData(60, 10, canvas.width - 80, canvas.height - 60);
  return new Set(data).size;
})"""
AXIS = """() => document.querySelector("#curves canvas").toDataURL()"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_its_figures_are_drawn_and_can_be_zoomed(tmp_path: Path, open_page: Callable[..., Any], scheme: str) -> None:
    report, log = tmp_path / "leaf.html", tmp_path / "leaf.log"
    assert main(["simulate", "leaf", "-o", str(log)]) == 0
    assert main(["report", "-c", str(example_config("wagon")), str(log), "-o", str(report)]) == 0
    page = open_page(report.as_uri(), color_scheme=scheme, viewport={"width": 1200, "height": 3000})
    page.locator("html[data-drawn=true]").wait_for()
    until(lambda: min(page.evaluate(INK)) > 5)
    assert len(page.evaluate(INK)) == 7  # adhesion, speeds, slip, forces, two frictions, adhesion over slip
    whole = page.evaluate(AXIS)
    page.locator("#stops button").first.click()
    until(lambda: page.evaluate(AXIS) != whole)
    page.get_by_role("button", name="Show all").click()
    until(lambda: page.evaluate(AXIS) == whole)
    canvas = page.locator("#curves .u-over").first.bounding_box()
    page.mouse.move(canvas["x"] + 200, canvas["y"] + 50)
    page.mouse.down()
    page.mouse.move(canvas["x"] + 400, canvas["y"] + 50, steps=5)
    page.mouse.up()
    until(lambda: page.evaluate(AXIS) != whole)
    page.set_viewport_size({"width": 360, "height": 740})
    until(lambda: page.evaluate("document.documentElement.scrollWidth") <= 360)


def test_what_was_never_scrolled_to_is_printed_as_well(tmp_path: Path, open_page: Callable[..., Any]) -> None:
    report, log = tmp_path / "dry.html", tmp_path / "dry.log"
    assert main(["simulate", "dry", "--vehicle", "rig", "-o", str(log)]) == 0
    assert main(["report", "-c", str(example_config("rig")), str(log), "-o", str(report)]) == 0
    page = open_page(report.as_uri(), viewport={"width": 1200, "height": 500})
    page.locator("html[data-drawn=true]").wait_for()
    last = """() => [...document.querySelectorAll("#curves canvas")].at(-1).toDataURL()"""
    unseen = page.evaluate(last)
    page.pdf()
    assert page.evaluate(last) != unseen
