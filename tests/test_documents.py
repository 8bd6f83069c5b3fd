"""The pages that engineers read lead where they say: every link within the repository, headings included."""

import re
import tomllib
from pathlib import Path
from typing import get_args

import pytest

from brake_monitor.desk.json_lines import OF_PADS
from brake_monitor.estimation.model.tuning import PRESETS
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.settings.alarm_settings import AlarmSettings
from brake_monitor.settings.config import Preset, TuningOverrides

ROOT = Path(__file__).parents[1]
PAGES = sorted(ROOT / page for page in ("README.md", "CHANGELOG.md")) + sorted(
    page for folder in ("docs", "dbc", "systemd") for page in (ROOT / folder).rglob("*.md")
)
LINK = re.compile(r"\]\(([^)\s]+)\)|(?:src|srcset)=\"([^\"]+)\"")
FENCED = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)


def headings(page: Path) -> set[str]:
    """As they are linked to: small letters, hyphens for blanks, no other signs."""
    titles = re.findall(r"^#+ (.*)$", FENCED.sub("", page.read_text()), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def links(page: Path) -> list[str]:
    found = [link or picture for link, picture in LINK.findall(FENCED.sub("", page.read_text()))]
    return [link for link in found if "://" not in link]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    for link in links(page):
        path, _, heading = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), link
        assert not heading or heading in headings(target), link


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_rows_of_a_table_have_as_many_cells_as_its_heading(page: Path) -> None:
    for table in re.findall(r"(?:^\|.*\n)+", FENCED.sub("", page.read_text()), re.MULTILINE):
        cells = {row: len(re.findall(r"(?<!\\)\|", row)) for row in table.splitlines()}
        assert len(set(cells.values())) == 1, cells


def test_every_equation_stands_where_its_page_says() -> None:
    page = ROOT / "docs" / "evidence" / "equations.md"
    table = page.read_text().partition("| equation | what | file | name |\n")[2].partition("\n\n")[0].splitlines()[1:]
    assert len(table) > 8
    for row in table:
        *_, files, names, _ = row.split("|")
        code = "".join((page.parent / path).read_text() for path in re.findall(r"\]\(([^)]+)\)", files))
        for name in re.findall(r"`(\w+)`", names):
            assert re.search(rf"^ *(?:def |class )?{name}\b(?=[(: =])", code, re.MULTILINE), name


def test_presets_are_what_the_model_s_page_says() -> None:
    page = (ROOT / "docs" / "model.md").read_text()
    table = page.partition("| key of `[estimator.tuning]` |")[2].partition("\n\n")[0].splitlines()[2:]
    keys = []
    for row in table:
        _, cell, _, *told, _ = (cell.strip() for cell in row.split("|"))
        keys.append(key := cell.strip("`"))
        for preset, value in zip(get_args(Preset), told, strict=True):
            if value != "K is no state":
                assert float(value) == getattr(PRESETS[preset], key), (key, preset)
    assert sorted(keys) == sorted(TuningOverrides.__struct_fields__)


@pytest.mark.parametrize(
    ("page", "column"), [("README.md", "raised when"), ("docs/alarms.md", "raised when"), ("docs/alarms.md", "fields")]
)
def test_every_kind_of_alarm_has_its_row(page: str, column: str) -> None:
    table = (ROOT / page).read_text().partition(f"| kind | {column} |")[2].partition("\n\n")[0].splitlines()[2:]
    kinds = {kind for row in table for kind in re.findall(r"`(\w+)`", row.split("|")[1])}
    assert kinds == set(AlarmSettings.__struct_fields__)


def test_every_extra_is_told_with_what_it_brings() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = {
        name: [re.match(r"[\w-]+", package)[0] for package in packages]
        for name, packages in project["optional-dependencies"].items()
        if name not in {"dev", "bench"}
    }
    table = (ROOT / "docs" / "gateway.md").read_text().partition("| extra | brings |")[2].partition("\n\n")[0]
    rows = [[cell.strip(" `") for cell in row.split("|")[1:3]] for row in table.splitlines()[2:]]
    assert {extra: [package] for extra, package in rows} == extras


def test_files_that_the_page_for_developers_names_are_there() -> None:
    named = re.findall(r"`([\w/]+(?:\.py|\.js|/))`", (ROOT / "docs" / "development.md").read_text())
    assert len(named) > 40
    for path in named:
        assert (ROOT / path).exists() or list((ROOT / "src" / "brake_monitor").rglob(path)), path


@pytest.mark.parametrize(("heading", "fields"), [("Alarms", Alarm.__struct_fields__), ("Wear", OF_PADS)])
def test_every_field_of_a_line_that_replay_writes_is_told(heading: str, fields: tuple[str, ...]) -> None:
    section = (ROOT / "docs" / "replay.md").read_text().partition(f"## {heading}: ")[2].partition("\n## ")[0]
    assert sorted(re.findall(r"`([a-z_]+)`", section)) == sorted(fields)


def rows(text: str) -> list[str]:
    """The figures of its tables: all rows but those that name the columns."""
    tables = re.findall(r"^\|.*\n\|[-|]+\n((?:\|.*\n)+)", text, re.MULTILINE)
    return [row for table in tables for row in table.splitlines()]


@pytest.mark.parametrize(("heading", "page", "least"), [("Accuracy", "evidence/own", 22), ("Speed", "speed", 5)])
def test_what_the_first_page_quotes_is_what_was_measured(heading: str, page: str, least: int) -> None:
    """A figure that is measured anew changes in both places; of the long tables the first page has some rows."""
    _, _, rest = (ROOT / "README.md").read_text().partition(f"\n## {heading}\n")
    section = rest.partition("\n## ")[0].split("| live, ")[0]  # which has no table of its own behind it
    measured = rows((ROOT / "docs" / f"{page}.md").read_text())
    quoted = rows(section)
    assert len(quoted) >= least
    for row in quoted:
        assert any(f"{line} ".startswith(row.rstrip("| ") + " |") for line in measured), row


def test_every_page_is_found_from_the_first_one() -> None:
    reached, waiting = set[Path](), [ROOT / "README.md"]
    while waiting:
        page = waiting.pop()
        reached.add(page)
        targets = [(page.parent / link.partition("#")[0]).resolve() for link in links(page)]
        waiting += [target for target in targets if target.suffix == ".md" and target not in reached]
    assert {page for page in PAGES if page.name != "CHANGELOG.md"} <= reached
