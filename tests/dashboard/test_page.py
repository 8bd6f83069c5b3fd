"""The page in a real browser, against real publishers over a real router: what is published is what is shown."""

import json
import re
import signal
import time
from collections.abc import Callable
from typing import Any

import pytest
import zenoh

from brake_monitor.report.words import described, duration
from depot import Depot, shown
from network import session
from program import until

pytestmark = pytest.mark.browser

Open = Callable[..., Any]
SAILING = {"speed_mps": 18.0, "adhesion": 0.083, "adhesion_std": 0.004, "saturated": False}
WHEELSETS = [
    {"slip": 0.10, "pressing_force_n": 41_200.0, "friction": 0.342},
    {"slip": 0.0, "pressing_force_n": 12_700.0},
]

# How many pixels of the curve under a heading have the colour of a name of the style sheet.
PIXELS = """([heading, name]) => {
  const charts = [...document.querySelectorAll(".chart")];
  const chart = charts.find((one) => one.querySelector("h2").textContent.startsWith(heading));
  const canvas = chart.querySelector("canvas");
  document.body.style.caretColor = `var(--${name})`;
  const [r, g, b] = getComputedStyle(document.body).caretColor.match(/[\\d.]+/g).map(Number);
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let k = 0; k < data.length; k += 4) {
    const off = Math.abs(data[k] - r) + Math.abs(data[k + 1] - g) + Math.abs(data[k + 2] - b);
    if (off < 24 && data[k + 3] > 200) count++;
  }
  return count;
}"""


# What a chart says under its heading: label → newest value.
LEGEND = """(heading) => {
  const charts = [...document.querySelectorAll(".chart")];
  const chart = charts.find((one) => one.querySelector("h2").textContent.startsWith(heading));
  const items = [...chart?.querySelectorAll(".legend li") ?? []].filter((item) => item.querySelector("b"));
  const text = (item, part) => item.querySelector(part).innerText;
  return Object.fromEntries(items.map((item) => [text(item, "span"), text(item, "b")]));
}"""


def legend(page: Any, heading: str) -> dict[str, str]:
    """At one moment: charts are made anew and filled while they are looked at."""
    told: dict[str, str] = page.evaluate(LEGEND, heading)
    return told


def pixels(page: Any, heading: str, colour: str) -> int:
    count: int = page.evaluate(PIXELS, [heading, colour])
    return count


def test_what_is_published_is_what_is_shown(depot: Depot, open_page: Open) -> None:
    wagon = depot.wagon("wagon-1", estimate=SAILING, wheelsets=WHEELSETS)
    wagon.says(wear=True)
    depot.dashboard()
    page = open_page(depot.address)
    row = page.locator("tr").filter(has_text="wagon-1")
    row.get_by_text("live").wait_for()
    for text in ("64.8", "0.083", "± 0.004", "in use"):
        row.get_by_text(text).wait_for()
    row.click()
    for heading, told in {
        "Speeds": {"vehicle": "64.8", "wheelset 1": "58.3", "wheelset 2": "64.8"},  # 64.8 km/h less 10 %
        "Pressing forces": {"wheelset 1": "41.2", "wheelset 2": "12.7"},
        "Adhesion": {"in use": "0.083", "all that the rail gives": "–"},
        "Pad friction, wheelset 1": {"friction": "0.342"},
        "Slip": {"wheelset 1": "10.0", "wheelset 2": "0.0"},
    }.items():
        until(lambda heading=heading, told=told: legend(page, heading) == told)
    shown(page, "27.5 mm")  # 2 GJ on 4 pads of 400 cm², 0.2 cm³/MJ: 2.5 mm of 35 mm, 5 mm are the limit
    shown(page, "valid")
    for heading, colour in (
        ("Speeds", "vehicle"), ("Pressing forces", "wheelset-1"), ("Pressing forces", "wheelset-2"),
        ("Adhesion", "info"), ("Pad friction, wheelset 1", "wheelset-1"), ("Slip", "wheelset-1"),
        ("Adhesion over slip", "wheelset-2"),
    ):  # fmt: skip
        until(lambda heading=heading, colour=colour: pixels(page, heading, colour) > 5)
    assert pixels(page, "Adhesion", "alarm") == 0
    wagon.says(estimate=SAILING | {"saturated": True, "adhesion": 0.031}, wheelsets=[{"wsp_active": True}, {}])
    shown(page, "all that the rail gives: very low")
    shown(page, "WSP 1")
    until(lambda: pixels(page, "Adhesion", "alarm") > 20)


# Goes to the fleet; how many pixels of the first wagon's sparkline are drawn once its line is there.
FIRST_SPARKS = """() => new Promise((resolve) => {
  const look = () => {
    const canvas = document.querySelector("tbody canvas");
    if (!canvas) return requestAnimationFrame(look);
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    resolve(data.filter((value, k) => k % 4 === 3 && value > 0).length);
  };
  location.hash = "#/";
  look();
})"""


def test_a_wagons_last_minutes_are_drawn_as_soon_as_its_line_is_there(depot: Depot, open_page: Open) -> None:
    depot.wagon("wagon-1", estimate=SAILING)
    depot.dashboard()
    page = open_page(f"{depot.address}#/wagon/wagon-1")
    shown(page, "in use; the rail may give more")
    assert page.evaluate(FIRST_SPARKS) > 0


def test_the_ladder_stays_where_it_is_whatever_is_said_of_the_rail(depot: Depot, open_page: Open) -> None:
    wagon = depot.wagon("wagon-1")
    depot.dashboard()
    page = open_page(f"{depot.address}#/wagon/wagon-1")
    places = set()
    for change, meaning in (
        ({"saturated": False}, "in use; the rail may give more"),
        ({"saturated": True, "adhesion": 0.09}, "all that the rail gives: low"),
        ({"saturated": True, "adhesion": 0.01}, "all that the rail gives: extremely low"),
    ):
        wagon.says(estimate=SAILING | change, wheelsets=[{}] * 2)
        shown(page, meaning)
        places.add(page.evaluate("document.querySelector('.ladder').getBoundingClientRect().left"))
    assert len(places) == 1


def test_levels_beyond_the_ladder_end_with_it(depot: Depot, open_page: Open) -> None:
    """Else the others are squeezed, and the needle stands on the wrong one."""
    depot.dashboard()
    page = open_page(depot.address)
    widths = page.evaluate("""async () => {
      const { WagonPage } = await import("/wagon.js");
      const { ladder } = new WagonPage(document.createElement("main"), "wagon-1");
      ladder.show(0.06, 0.01, { extremely_low: 0.02, very_low: 0.05, low: 0.3 });
      return [...ladder.rungs.children].map((rung) => parseFloat(rung.style.width));
    }""")
    assert widths[:3] == pytest.approx([10.0, 15.0, 75.0])


def test_held_friction_is_shaded(depot: Depot, open_page: Open) -> None:
    wagon = depot.wagon("wagon-1")
    depot.dashboard()
    page = open_page(f"{depot.address}#/wagon/wagon-1")
    until(lambda: legend(page, "Pad friction, wheelset 1").get("friction") == "0.340")
    unlike = """() => {
      const charts = [...document.querySelectorAll(".chart")];
      const chart = charts.find((one) => one.textContent.includes("Pad friction, wheelset 1"));
      const { data } = chart.querySelector("canvas").getContext("2d").getImageData(60, 20, 400, 60);
      return data.filter((value, k) => k % 4 === 3 && value > 0).length;
    }"""
    until(lambda: pixels(page, "Pad friction, wheelset 1", "wheelset-1") > 5)
    before = page.evaluate(unlike)
    wagon.says(estimate={}, wheelsets=[{"friction_status": "held"}, {}])
    page.keyboard.press("1")
    until(lambda: page.evaluate(unlike) > before + 500)


def test_lanes_of_slide_protection_leave_room_for_slip_however_many_they_are(depot: Depot, open_page: Open) -> None:
    depot.wagon("articulated").says(estimate=SAILING, wheelsets=[{"slip": 0.10, "wsp_active": False}] * 16)
    depot.dashboard()
    page = open_page(f"{depot.address}#/wagon/articulated", viewport={"width": 1280, "height": 3000})
    until(lambda: legend(page, "Slip").get("wheelset 16") == "10.0")
    until(lambda: pixels(page, "Slip", "wheelset-4") > 5)


def test_recent_history_is_there_when_the_page_opens(depot: Depot, open_page: Open) -> None:
    depot.wagon("wagon-1").says(alarm={"id": "old", "cleared_time_s": 1700000002.0, "message": "It was slippery."})
    time.sleep(2.0)
    begun_s = time.time()  # nobody has heard it before
    depot.dashboard()
    heard: list[dict[str, Any]] = []
    page = open_page(depot.address)
    page.on("websocket", lambda socket: socket.on("framereceived", lambda text: heard.append(json.loads(text))))
    page.locator("tr").filter(has_text="wagon-1").get_by_text("live").wait_for()
    until(lambda: "live" in page.content())
    page.locator("a", has_text="wagon-1").click()
    shown(page, "It was slippery.")

    def hears_of_the_past() -> bool:
        page.wait_for_timeout(20)  # what comes is only noted while the browser is spoken with
        return any(message["rows"]["time_s"][0] < begun_s - 1.0 for message in heard if "rows" in message)

    until(hears_of_the_past)
    assert heard[-1]["view"] == "wagon"


def test_an_alarm_appears_and_clears(depot: Depot, open_page: Open) -> None:
    wagon = depot.wagon("wagon-1")
    depot.dashboard()
    page, fleet = open_page(f"{depot.address}#/wagon/wagon-1"), open_page(depot.address)
    shown(page, "None that is remembered.")
    sentence = "Brake 2 drags: stop and feel for a hot disc."
    raised = {"id": "dragging_brake-2-1", "kind": "dragging_brake", "wheelset": 2, "message": sentence}
    wagon.says(alarm=raised | {"evidence": {"pressing_force_n": 9100.0}})
    card = page.locator(".open")
    card.get_by_text(sentence).wait_for()
    card.get_by_text("Dragging brake, wheelset 2").wait_for()
    card.get_by_text("Evidence").click()
    card.get_by_text("9.100 kN").wait_for()
    fleet.locator("tr").filter(has_text="wagon-1").get_by_text("Dragging brake, wheelset 2").wait_for()
    wagon.says(alarm=raised | {"acknowledged_time_s": 1700000003.0, "updated_time_s": 1700000003.0})
    card.get_by_text("acknowledged").wait_for()
    wagon.says(alarm=raised | {"cleared_time_s": 1700000004.0, "updated_time_s": 1700000004.0})
    page.locator(".history").get_by_text(sentence).wait_for()
    card.get_by_text("None.").wait_for()
    fleet.get_by_text("no alarms").wait_for()


def test_a_wagon_that_freezes_stops_and_returns_is_shown(depot: Depot, open_page: Open) -> None:
    wagon = depot.wagon("wagon-1")
    depot.dashboard()
    fleet, page = open_page(depot.address), open_page(f"{depot.address}#/wagon/wagon-1")
    row = fleet.locator("tr").filter(has_text="wagon-1")
    row.get_by_text("live").wait_for()
    wagon.send_signal(signal.SIGSTOP)
    row.get_by_text("frozen").or_(row.get_by_text("gone")).wait_for()
    page.locator(".notice").filter(has_text="What is shown is the last that was heard").wait_for()
    wagon.send_signal(signal.SIGCONT)
    row.get_by_text("live").wait_for()
    wagon.kill()
    row.get_by_text("gone").wait_for()
    shown(page, "The wagon's daemon is gone.")
    depot.wagon("wagon-1").says(estimate={"speed_mps": 10.0}, wheelsets=[{}, {}])
    row.get_by_text("live").wait_for()
    row.get_by_text("36.0").wait_for()
    until(lambda: legend(page, "Speeds").get("vehicle") == "36.0")
    page.locator(".notice").wait_for(state="hidden")


def test_what_is_gone_does_not_look_as_if_it_were_now(depot: Depot, open_page: Open) -> None:
    wagon = depot.wagon("wagon-1")
    wagon.says(estimate={"saturated": True, "adhesion": 0.01}, wheelsets=[{"wsp_active": True}, {}])
    wagon.says(alarm={"id": "a", "kind": "hot_disc", "message": "The disc is hot."})
    depot.dashboard()
    page, fleet = open_page(f"{depot.address}#/wagon/wagon-1"), open_page(depot.address)
    chips = page.locator(".hero .chip")
    page.locator(".open").get_by_text("The disc is hot.").wait_for()
    page.locator(".hero .chip.normal").get_by_text("valid", exact=True).wait_for()
    assert "extremely low" in (page.locator(".chip.extremely_low").text_content() or "")
    wagon.kill()
    chips.get_by_text("last: valid", exact=True).wait_for()
    until(lambda: chips.evaluate_all("(all) => all.map((one) => one.className.trim())") == ["chip"] * 3)
    shown(page, "As last heard:")
    page.locator(".open.gone").get_by_text("The disc is hot.").wait_for()
    fleet.locator("tr.gone").get_by_text("Hot disc").wait_for()
    depot.wagon("wagon-1").says(estimate={}, wheelsets=[{}, {}])
    page.locator(".hero .chip.normal").get_by_text("valid", exact=True).wait_for()
    page.get_by_text("As last heard:").wait_for(state="hidden")


def test_it_recovers_from_a_router_and_a_dashboard_that_go(depot: Depot, open_page: Open) -> None:
    depot.wagon("wagon-1")
    dashboard = depot.dashboard()
    page = open_page(depot.address)
    row = page.locator("tr").filter(has_text="wagon-1")
    row.get_by_text("live").wait_for()
    dashboard.kill()
    dashboard.wait()
    shown(page, "connection to the dashboard lost")
    depot.dashboard()
    page.get_by_text("connection to the dashboard lost").wait_for(state="hidden")
    row.get_by_text("live").wait_for()
    depot.router_child.kill()
    row.get_by_text("gone").wait_for()
    shown(page, "router or daemon no longer answers over Zenoh")
    depot.router()
    row.get_by_text("live").wait_for()
    page.get_by_text("answers over Zenoh").wait_for(state="hidden")
    # A request may have been under way as the dashboard was killed: of that the browser complains, and rightly.
    open_page.complaints[:] = [text for text in open_page.complaints if "ERR_CONNECTION_RESET" not in text]


HOSTILE = '<img src=x onerror="window.owned=1">'


def test_what_is_hostile_does_nothing(depot: Depot, open_page: Open) -> None:
    good = depot.wagon("wagon-1")
    depot.dashboard()
    page = open_page(depot.address)
    row = page.locator("tr").filter(has_text="wagon-1")
    row.get_by_text("live").wait_for()
    message = {
        "state": "open",
        "id": HOSTILE,
        "kind": HOSTILE,
        "wheelset": None,
        "severity": "alarm",
        "message": HOSTILE,
    }
    message |= {"time_s": 1.0, "raised_time_s": 1.0, "acknowledged_time_s": None, "cleared_time_s": None}
    message |= {"evidence": {HOSTILE: HOSTILE}, "sequence": 1, "publish_time_s": 1.0}
    with session(depot.endpoint) as stranger:
        for name in ("wagon-1", HOSTILE):
            token = stranger.liveliness().declare_token(f"brake/v1/{name}")
            for payload in (b"NaN", b'{"time_s": NaN}', b"x" * 2_000_000, b"[1, 2]", b"\xff\xfe", b'{"adhesion": "x"}'):
                for key in ("adhesion", "health", "meta", "axle/1/friction", "axle/1/wear", "alarm/x"):
                    stranger.put(f"brake/v1/{name}/{key}", payload, encoding="application/json")
            patient = zenoh.CongestionControl.BLOCK  # the megabytes before it fill the line
            stranger.put(
                f"brake/v1/{name}/alarm/x", json.dumps(message), encoding="application/json", congestion_control=patient
            )
        page.get_by_text("not understood and left out").wait_for()
        strange = page.locator("tr").filter(has_text=HOSTILE)
        strange.first.wait_for()
        page.locator("a", has_text=HOSTILE).first.click()
        page.locator("h1", has_text=HOSTILE).wait_for()
        page.locator(".open").get_by_text(HOSTILE).first.wait_for()
        page.locator(".open summary").click()
        assert page.locator("main img").count() == 0
        assert page.evaluate("window.owned") is None
        page.keyboard.press("f")
        good.says(estimate={"speed_mps": 5.0}, wheelsets=[{}, {}])
        row.get_by_text("18.0", exact=True).wait_for()  # km/h
        token.undeclare()


def test_it_can_be_worked_by_keyboard(depot: Depot, open_page: Open) -> None:
    depot.wagon("a")
    depot.wagon("b")
    depot.dashboard()
    page = open_page(depot.address)
    page.locator("tr").filter(has_text="live").nth(1).wait_for()
    page.keyboard.press("j")
    page.keyboard.press("j")
    page.keyboard.press("Enter")
    page.locator("h1", has_text="b").wait_for()
    until(lambda: legend(page, "Speeds").get("vehicle") == "64.8")
    page.keyboard.press("4")
    page.get_by_role("button", name="5 min", pressed=True).wait_for()
    page.keyboard.press("p")
    page.get_by_role("button", name="Let run").wait_for()
    page.keyboard.press("j")
    page.locator("h1", has_text="a").wait_for()
    page.keyboard.press("f")
    page.get_by_role("heading", name="Fleet").wait_for()
    page.keyboard.press("/")
    page.keyboard.type("b")
    page.get_by_role("link", name="b", exact=True).wait_for()
    page.get_by_role("link", name="a", exact=True).wait_for(state="hidden")
    page.keyboard.press("Escape")
    page.keyboard.press("?")
    page.get_by_role("heading", name="Keys").wait_for()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_text_is_readable_in_both_themes_and_at_a_phones_width(
    depot: Depot, open_page: Open, scheme: str
) -> None:
    depot.wagon("wagon-with-a-rather-long-name-8127").says(
        estimate={"saturated": True, "adhesion": 0.01}, wheelsets=[{}] * 2
    )
    depot.dashboard()
    page = open_page(depot.address, viewport={"width": 360, "height": 740}, color_scheme=scheme)
    page.locator("tr").filter(has_text="live").wait_for()
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
    page.locator("tbody tr").click()
    shown(page, "extremely low")
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
    contrasts = page.evaluate(CONTRASTS)
    assert {name: ratio for name, ratio in contrasts.items() if ratio < 4.5} == {}  # WCAG 2.1, AA
    is_dark = page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(13, 17, 23)"
    assert is_dark == (scheme == "dark")
    page.keyboard.press("t")
    page.keyboard.press("t")  # system, light, dark
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(13, 17, 23)"
    page.reload()
    shown(page, "Theme: dark")


@pytest.mark.parametrize(
    "estimate",
    [
        {},
        {"adhesion": 0.012, "saturated": True},  # the longest word about the rail
        {"status": "converging", "reasons": ["speed contradicts forces", "unexplained deceleration"]},
    ],
)
def test_nothing_lies_on_another_whatever_the_width_and_however_much_four_wheelsets_say(
    depot: Depot, open_page: Open, estimate: dict[str, Any]
) -> None:
    wagon = depot.wagon("wagon-8127")
    wagon.says(estimate=SAILING | {"sanding": True} | estimate, wheelsets=[{"wsp_active": True}] * 4)
    depot.dashboard()
    page = open_page(f"{depot.address}#/wagon/wagon-8127")
    shown(page, "WSP 4")
    for width in (1720, 1440, 1431, 1400, 1366, 1280, 1160, 1000, 740, 360):
        page.set_viewport_size({"width": width, "height": 1000})
        assert page.evaluate(OVERLAPS) == [], width
        rows = page.evaluate(
            "new Set([...document.querySelectorAll('.tools button')].map((one) => one.offsetTop)).size"
        )
        assert rows == 1, width
        until(lambda width=width: page.evaluate("document.documentElement.scrollWidth") <= width)
        assert page.evaluate(LINES_OF_NAME) == 1, width


# On how many lines the wagon's name stands.
LINES_OF_NAME = """() => {
  const name = document.createRange();
  name.selectNodeContents(document.querySelector(".hero h1"));
  return name.getClientRects().length;
}"""

# The parts of a wagon's heading that lie on one another, or reach beyond the panel.
OVERLAPS = """() => {
  const parts = [
    "h1", ".speed .figure", ".speed .chip", ".adhesion .figure", ".adhesion .chip", ".ladder .rungs", ".tools button",
  ];
  const hero = document.querySelector(".hero").getBoundingClientRect();
  const found = [];
  const boxes = parts.flatMap((part) => [...document.querySelectorAll(`.hero ${part}`)])
    .map((one) => [one.textContent || one.className, one.getBoundingClientRect()]);
  boxes.forEach(([name, a], k) => {
    if (a.left < hero.left || a.right > hero.right || a.bottom > hero.bottom) found.push(name);
    for (const [other, b] of boxes.slice(k + 1)) {
      const beside = a.left > b.right - 1 || b.left > a.right - 1 || a.top > b.bottom - 1 || b.top > a.bottom - 1;
      if (!beside) found.push(`${name} on ${other}`);
    }
  });
  return found;
}"""


# Of every text colour on the ground that it stands on.
CONTRASTS = """() => {
  const pairs = [
    ["ink", "panel"], ["ink", "ground"], ["muted", "panel"], ["muted", "ground"], ["muted", "sunken"],
    ["accent", "panel"], ["good", "panel"], ["info", "panel"], ["warning", "panel"], ["alarm", "panel"],
    ["on-alarm", "alarm"], ["warning", "low"], ["warning", "very-low"],
  ];
  const light = (name) => {
    document.body.style.caretColor = `var(--${name})`;
    const told = getComputedStyle(document.body).caretColor.match(/[\\d.]+/g);
    const parts = told.slice(0, 3).map((part) => {
      const value = part / 255;
      return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2];
  };
  return Object.fromEntries(pairs.map(([a, b]) => {
    const [high, low] = [light(a), light(b)].sort((x, y) => y - x);
    return [`${a} on ${b}`, (high + 0.05) / (low + 0.05)];
  }));
}"""


def test_what_is_left_of_pads_does_not_pretend_to_be_known_to_the_stop(depot: Depot, open_page: Open) -> None:
    wagon = depot.wagon("wagon-1")
    wagon.says(wear={"stops": 934.0, "distance_m": 412_345.0})
    depot.dashboard()
    page = open_page(f"{depot.address}#/wagon/wagon-1")
    told = page.locator(".wear .row").first.get_by_text("stops").text_content() or ""
    stops, km = re.fullmatch(r"about ([\d ]+) stops · about ([\d ]+) km · disc .*", told).groups()
    assert all(re.fullmatch(r"[1-9]\d?0*", life.replace(" ", "")) for life in (stops, km))
    rounded = page.evaluate("""async () => {
      const { about } = await import("/words.js");
      return [82868, 20371, 9940, 104, 12.4, 6.6].map(about);
    }""")
    assert rounded == ["83 000", "20 000", "9 900", "100", "12", "7"]


@pytest.mark.parametrize(("margin_mm", "near"), [(27.4, 0), (27.6, 2)])
def test_pads_are_near_their_limit_where_the_wagon_says_so(
    depot: Depot, open_page: Open, margin_mm: float, near: int
) -> None:
    wagon = depot.wagon("wagon-1", pad_margin_mm=margin_mm)
    wagon.says(wear=True)  # which leaves 27.5 mm
    depot.dashboard()
    page = open_page(f"{depot.address}#/wagon/wagon-1")
    shown(page, "27.5 mm")
    until(lambda: page.locator(".wear .fill.near").count() == near)


def test_evidence_is_written_as_the_report_writes_it(depot: Depot, open_page: Open) -> None:
    evidence = {
        "energy_j": 3789373.0, "torque_nm": -2841.3, "pressing_force_n": 120.4, "torque_apart": -0.406, "creep": 0.0004,
        "adhesion": 0.0312, "latitude_deg_start": 52.005, "wsp_actions": 8.0, "level": "low", "speed_end_mps": None,
    }  # fmt: skip
    depot.dashboard()
    shown_as = open_page(depot.address).evaluate(
        """async (evidence) => {
          const { described } = await import("/words.js");
          return Object.entries(evidence).map(([name, value]) => described(name, value));
        }""",
        evidence,
    )
    assert [tuple(pair) for pair in shown_as] == [described(name, value) for name, value in evidence.items()]


def test_spans_of_time_are_written_as_the_report_writes_them(depot: Depot, open_page: Open) -> None:
    depot.dashboard()
    seconds = [0.4, 59.4, 59.7, 119.6, 3599.7, 7199.6]
    written = open_page(depot.address).evaluate(
        """async (seconds) => {
          const { span } = await import("/words.js");
          return seconds.map(span);
        }""",
        seconds,
    )
    assert written == list(map(duration, seconds))


def test_the_first_word_of_health_takes_the_place_of_there_being_none(depot: Depot, open_page: Open) -> None:
    depot.dashboard()
    page = open_page(f"{depot.address}#/wagon/wagon-1")
    health = page.locator(".health")
    health.get_by_text("no word of it yet").wait_for()
    depot.wagon("wagon-1")
    health.get_by_text("Running for").wait_for()
    assert health.get_by_text("no word of it yet").count() == 0


def test_who_looks_long_does_not_make_the_page_grow(depot: Depot, open_page: Open) -> None:
    """The oldest rows go as new ones come: told six times as many as it keeps, it keeps as many."""
    depot.dashboard()
    page = open_page(depot.address)
    kept = page.evaluate("""async () => {
      const { History } = await import("/history.js");
      const history = new History();
      const columns = (...names) => Object.fromEntries(names.map((name) => [name, Array(100).fill(0.1)]));
      const wagon = columns("speed_mps", "adhesion", "adhesion_std", "adhesion_available");
      const wheelset = columns("slip", "omega_radps", "pressing_force_n", "friction", "friction_std", "held",
        "adhesion", "wsp_active");
      for (let turn = 0; turn < 200; turn++) {
        const time_s = Array.from({ length: 100 }, (_, k) => turn * 10 + k / 10);
        history.take({ anew: turn === 0, time_s, ...wagon, wheelsets: { 1: wheelset } });
      }
      return [history.time_s.length, history.time_s.at(-1), new Set(history.columns().map((one) => one.length)).size];
    }""")
    assert 3000 <= kept[0] <= 3500
    assert kept[1:] == [1999.9, 1]


def test_going_to_wagons_and_back_leaves_nothing_behind(depot: Depot, open_page: Open) -> None:
    depot.wagon("wagon-1")
    depot.dashboard()
    page = open_page(depot.address)
    developer = page.context.new_cdp_session(page)

    def held_after(visits: int) -> dict[str, int]:
        for _ in range(visits):
            page.locator("a", has_text="wagon-1").click()
            until(lambda: legend(page, "Pad friction, wheelset 2").get("friction") == "0.340")
            page.keyboard.press("f")
            page.locator("tr").filter(has_text="live").wait_for()
        developer.send("HeapProfiler.collectGarbage")
        counters: dict[str, int] = developer.send("Memory.getDOMCounters")
        return counters

    before, visits = held_after(3), 10
    after = held_after(visits)
    assert after["nodes"] < before["nodes"] + 20 * visits  # a page of a wagon has some 400
    assert after["jsEventListeners"] < before["jsEventListeners"] + visits
