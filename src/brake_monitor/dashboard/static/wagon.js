// One wagon: how it stands, curves of the last minutes, alarms, pads, health.
import { Health, OpenAlarms, Pads, PastAlarms } from "./cards.js";
import { SlipChart, TimeChart } from "./charts.js";
import { adhesionChart, forceChart, frictionChart, slipChart, speedChart } from "./curves.js";
import { History } from "./history.js";
import { LEVELS, STATES, element, kmh, mark, number, renew, setClass, setText, span } from "./words.js";

const WINDOWS_S = [30, 60, 120, 300];
const LADDER_TOP = 0.2;
const RESTS_MS_PER_S = 1.5; // between two drawings, for each second in the picture: about one pixel
const LONGEST_REST_MS = 450;

export class WagonPage {
  constructor(main, wagon) {
    this.wagon = wagon;
    this.history = new History();
    this.told = { alarms: [], wear: [], levels: { low: 0.1, very_low: 0.05, extremely_low: 0.02 } };
    this.window_s = WINDOWS_S[1];
    this.held = null; // [from, to] while the curves are held
    this.charts = [];
    this.cards = { open: new OpenAlarms(), wear: new Pads(), past: new PastAlarms(), health: new Health() };
    this.build(main);
  }

  build(main) {
    this.state = element("div", {});
    this.speed = element("span", {}, "–");
    this.value = element("span", {}, "–");
    this.std = element("span", { class: "unit" });
    this.meaning = element("div", { class: "chips" });
    this.chips = element("div", { class: "chips" });
    this.ladder = new Ladder();
    this.tools = element("div", { class: "tools", role: "group", "aria-label": "Curves" });
    this.buttons = WINDOWS_S.map((seconds) => {
      const button = element("button", { type: "button" }, seconds < 60 ? `${seconds} s` : `${seconds / 60} min`);
      button.onclick = () => this.choose(seconds);
      return button;
    });
    this.hold = element("button", { type: "button" }, "Hold");
    this.hold.onclick = () => this.toggle();
    this.tools.append(...this.buttons, this.hold);
    this.notice = element("p", { class: "notice panel", role: "status", hidden: "" });
    this.curves = element("div", { class: "curves" });
    this.slip = element("div", {});
    const { open, wear, past, health } = this.cards;
    main.append(
      element("section", { class: "hero panel" },
        element("div", { class: "name" }, element("a", { href: "#/", class: "small" }, "← Fleet"), element("h1", {}, this.wagon), this.state),
        element("div", { class: "speed" }, element("div", { class: "muted small" }, "Speed"), element("div", { class: "figure" }, this.speed, element("span", { class: "unit" }, " km/h")), this.chips),
        element("div", { class: "adhesion" },
          element("div", {}, element("div", { class: "muted small" }, "Adhesion"), element("div", { class: "figure" }, this.value, " ", this.std), this.meaning), this.ladder.root),
        this.tools),
      this.notice,
      element("div", { class: "columns" }, this.curves, element("div", { class: "aside" }, open.root, this.slip, wear.root, past.root, health.root)));
    this.choose(this.window_s);
  }

  take(message) {
    for (const name of ["adhesion", "alarms", "wear", "health", "meta", "levels", "names"]) if (name in message) this.told[name] = message[name];
    if (message.meta) {
      this.history.radii_m = message.meta.wheel_radius_m;
      this.history.period_s = message.meta.estimate_rate_hz > 0 ? 1 / message.meta.estimate_rate_hz : 0.1;
    }
    if (message.rows) this.history.take(message.rows);
    this.message = message;
    this.takenAt = performance.now();
    if (this.history.numbers.join() !== this.drawn) this.compose();
    this.hero();
    this.cards.open.show(this.told.alarms, message.state === "gone");
    this.cards.past.show(this.told.alarms);
    this.cards.wear.show(this.told.wear, this.told.meta ?? null);
    this.cards.health.show(this.told.health, this.told.meta);
    this.request();
  }

  // Draws before the next frame, once, and not at all while nobody looks; over minutes no oftener than a line can move.
  request(now = false) {
    const rest_ms = Math.min(this.window_s * RESTS_MS_PER_S, LONGEST_REST_MS);
    if (!now && performance.now() - (this.drawnAt ?? 0) < rest_ms) return;
    this.frame ??= requestAnimationFrame(() => {
      this.frame = null;
      this.drawnAt = performance.now();
      this.show();
    });
  }

  show() {
    const newest_s = this.history.time_s.at(-1);
    if (newest_s === undefined || document.hidden) return;
    // A wagon that is silent runs out of the picture: the right edge is now, not the last that was heard.
    const age_s = this.message.age_s ?? 0;
    const now_s = newest_s + (age_s > 0.5 ? Math.min(age_s, this.window_s) : 0);
    const [from_s, to_s] = this.held ?? [now_s - this.window_s, now_s];
    const view = this.history.view(from_s, to_s);
    view.levels = this.told.levels;
    view.friction_nominal = this.told.meta?.friction_nominal ?? null;
    for (const chart of this.charts) chart.show(view);
  }

  hero() {
    const { message } = this;
    const adhesion = this.told.adhesion;
    const age = message.state === "frozen" ? ` for ${span(message.age_s)}` : "";
    const said = STATES[message.state] + age;
    renew(this.state, said, () => [mark(message.state, said)]);
    document.body.classList.toggle("stale", message.state !== "live");
    setClass(this.notice, `notice panel ${message.state}`);
    this.notice.hidden = ["live", "silent"].includes(message.state);
    setText(this.notice, {
      frozen: `No new estimate${age}. What is shown is the last that was heard.`,
      gone: "The wagon's daemon is gone. What is shown is the last that was heard.",
      unknown: "Nothing was ever heard of a wagon of this name. It shows up here as soon as it publishes.",
    }[message.state] ?? "");
    if (!adhesion) return;
    const doubt = adhesion.status === "invalid";
    setText(this.speed, number(doubt ? null : kmh(adhesion.speed_mps), 1));
    setText(this.value, number(doubt ? null : adhesion.adhesion, 3));
    setText(this.std, `± ${number(doubt ? null : adhesion.adhesion_std, 3)}`);
    this.ladder.show(doubt ? null : adhesion.adhesion, adhesion.adhesion_std, this.told.levels);
    const level = doubt ? null : message.level;
    const meaning = doubt ? ["", "no valid estimate"] : level ? [level, `all that the rail gives: ${LEVELS[level]}`] : ["", "in use; the rail may give more"];
    this.chipsIn(this.meaning, [meaning]);
    const last = message.state === "live" ? "" : "last: ";
    const chips = [[adhesion.status === "valid" ? "normal" : "strong", last + [adhesion.status, ...adhesion.reasons].join(", ")]];
    if (adhesion.sanding) chips.push(["strong", "sanding"]);
    this.history.numbers.forEach((i) => this.history.wheelsets[i].wsp_active.at(-1) && chips.push(["low", `WSP ${i}`]));
    this.chipsIn(this.chips, chips);
  }

  // In colour only while they are about now.
  chipsIn(place, told) {
    const chips = told.map(([kind, text]) => [this.message.state === "live" ? kind : "", text]);
    renew(place, chips, () => chips.map(([kind, text]) => element("span", { class: `chip ${kind}` }, text)));
  }

  // Make the charts for as many wheelsets as there are.
  compose() {
    for (const chart of this.charts) chart.destroy();
    const numbers = this.history.numbers;
    this.drawn = numbers.join();
    const select = (from_s, to_s) => this.look(from_s, to_s);
    const time = (spec) => new TimeChart(spec, select);
    const [speeds, forces, adhesion] = [time(speedChart(numbers)), time(forceChart(numbers)), time(adhesionChart())];
    const frictions = numbers.map((i) => time(frictionChart(i)));
    const slips = time(slipChart(numbers));
    const overSlip = new SlipChart(numbers, 260);
    this.charts = [adhesion, speeds, forces, slips, ...frictions, overSlip];
    const grid = element("div", { class: "frictions panel" }, ...frictions.map((chart) => chart.root));
    this.curves.replaceChildren(adhesion.root, speeds.root, slips.root, forces.root, ...(numbers.length ? [grid] : []));
    this.slip.replaceChildren(overSlip.root);
    for (const chart of this.charts) chart.plot.ondblclick = () => this.release();
    this.redraw();
  }

  redraw() {
    for (const chart of this.charts) chart.draw();
    this.request(true);
  }

  fit() {
    for (const chart of this.charts) chart.fit();
  }

  choose(seconds) {
    this.window_s = seconds;
    this.release();
  }

  look(from_s, to_s) {
    this.held = [from_s, to_s];
    this.tell();
  }

  toggle() {
    const newest_s = this.history.time_s.at(-1);
    if (this.held) this.release();
    else if (newest_s !== undefined) this.look(newest_s - this.window_s, newest_s);
  }

  release() {
    this.held = null;
    this.tell();
  }

  tell() {
    this.buttons.forEach((button, k) => button.setAttribute("aria-pressed", String(!this.held && WINDOWS_S[k] === this.window_s)));
    setText(this.hold, this.held ? "Let run" : "Hold");
    this.hold.setAttribute("aria-pressed", String(this.held !== null));
    if (this.message) this.request(true);
  }

  key(key) {
    const names = this.told.names ?? [];
    const at = names.indexOf(this.wagon);
    if (key >= "1" && key <= "4") this.choose(WINDOWS_S[key - 1]);
    else if (key === "p") this.toggle();
    else if (key === "Escape" && this.held) this.release();
    else if ((key === "j" || key === "k") && names.length) {
      const next = names[(key === "j" ? at + 1 : Math.max(at, 0) + names.length - 1) % names.length];
      location.hash = `#/wagon/${encodeURIComponent(next)}`;
    } else return false;
    return true;
  }

  leave() {
    cancelAnimationFrame(this.frame);
    document.body.classList.remove("stale");
    for (const chart of this.charts) chart.destroy();
  }
}

// Where the adhesion stands between nothing and plenty.
class Ladder {
  constructor() {
    this.rungs = element("div", { class: "rungs" });
    this.spread = element("div", { class: "spread" });
    this.needle = element("div", { class: "needle" });
    this.ticks = element("div", {});
    this.root = element("div", { class: "ladder", role: "img" }, this.rungs, this.spread, this.needle, this.ticks);
  }

  show(adhesion, std, levels) {
    this.draw(levels);
    const known = adhesion !== null;
    this.needle.hidden = this.spread.hidden = !known;
    if (!known) return;
    const percent = (value) => `${(Math.min(Math.max(value, 0), LADDER_TOP) / LADDER_TOP) * 100}%`;
    this.needle.style.left = percent(adhesion);
    this.spread.style.left = percent(adhesion - std);
    this.spread.style.width = `calc(${percent(adhesion + std)} - ${percent(adhesion - std)})`;
    this.root.setAttribute("aria-label", `Adhesion ${number(adhesion, 3)} on a scale from 0 to ${LADDER_TOP}`);
  }

  draw(levels) {
    const names = ["extremely_low", "very_low", "low"];
    const ends = [0, ...names.map((name) => Math.min(levels[name], LADDER_TOP)), LADDER_TOP];
    const percent = (value) => `${(value / LADDER_TOP) * 100}%`;
    renew(this.rungs, ends, () => [...names, "normal"].map((name, k) => {
      const rung = element("i", { class: name });
      if (name !== "normal") rung.style.width = percent(ends[k + 1] - ends[k]);
      return rung;
    }));
    renew(this.ticks, ends, () => ends.map((end) => {
      const tick = element("span", { class: "tick" }, end ? end.toFixed(2) : "0");
      tick.style.left = percent(end);
      return tick;
    }));
  }
}
