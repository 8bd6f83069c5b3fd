"""A depot to look at, and a real browser to look with."""

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from browser import CHROMIUM, QUIET
from depot import Depot
from program import PATIENCE_S

REQUIRED = "BRAKE_MONITOR_REQUIRE_BROWSER"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Skip what needs a browser where there is none, unless it is demanded."""
    if CHROMIUM or os.environ.get(REQUIRED) == "1":
        return
    for item in items:
        if item.get_closest_marker("browser"):
            item.add_marker(pytest.mark.skip(reason="needs a browser: apt-get install chromium"))


@pytest.fixture
def depot() -> Iterator[Depot]:
    with ExitStack() as stack:
        made = Depot(stack)
        made.router()
        yield made


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 - only where a browser is

    assert CHROMIUM, "no browser here, and it is demanded: apt-get install chromium"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(QUIET))
        yield browser
        browser.close()


@pytest.fixture
def open_page(chromium: Any) -> Iterator[Callable[..., Any]]:
    """Opens pages; none may complain on its console, and none may ask anybody but the dashboard."""
    contexts, complaints, asked = [], [], set()

    def open_one(address: str, **options: Any) -> Any:
        context = chromium.new_context(**({"viewport": {"width": 1440, "height": 1500}} | options))
        context.set_default_timeout(PATIENCE_S * 1000)
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: complaints.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("request", lambda request: asked.add(request.url.split("/")[2]))
        page.goto(address)
        return page

    open_one.complaints = complaints  # type: ignore[attr-defined]
    yield open_one
    for context in contexts:
        context.close()
    complaints = [
        text for text in complaints if "WebSocket connection" not in text
    ]  # that a server is gone is no fault
    assert not complaints
    assert all(host.startswith("127.0.0.1") for host in asked if host)  # a file has none
