// What stands beside the curves: alarms, pads, health.
import { about, count, described, element, mark, moment, number, renew, setText, span, titled } from "./words.js";

function card(title, kind, ...children) {
  return element("section", { class: `card panel ${kind}` }, element("header", {}, element("h2", {}, title)), ...children);
}

// Redraws only when what it shows has changed.
class Card {
  constructor(title, kind, body) {
    this.body = body;
    this.root = card(title, kind, body);
  }

  show(...values) {
    renew(this.body, values, () => this.parts(...values));
  }
}

export class OpenAlarms extends Card {
  constructor() {
    super("Open alarms", "open", element("ul", { class: "alarms", "aria-live": "polite" }));
    this.unfolded = new Set();
  }

  parts(alarms, gone) {
    const open = alarms.filter((alarm) => alarm.state === "open");
    this.root.classList.toggle("gone", gone);
    if (!open.length) return [element("li", { class: "muted" }, gone ? "None as last heard." : "None.")];
    const items = open.map((alarm) => this.item(alarm));
    return gone ? [element("li", { class: "muted" }, "As last heard:"), ...items] : items;
  }

  item(alarm) {
    const seen = alarm.acknowledged_time_s === null ? "" : element("span", { class: "chip" }, "acknowledged");
    const evidence = element("dl", {});
    for (const [name, value] of Object.entries(alarm.evidence)) {
      const [words, said] = described(name, value);
      evidence.append(element("dt", {}, words), element("dd", {}, said));
    }
    const details = element("details", {}, element("summary", {}, "Evidence"), evidence);
    details.open = this.unfolded.has(alarm.id);
    details.ontoggle = () => (details.open ? this.unfolded.add(alarm.id) : this.unfolded.delete(alarm.id));
    return element("li", {}, first(alarm, `since ${moment(alarm.raised_time_s)}`, seen), element("p", {}, alarm.message),
      Object.keys(alarm.evidence).length ? details : null);
  }
}

export class PastAlarms extends Card {
  constructor() {
    super("Cleared alarms", "history", element("ul", { class: "alarms past scroll", tabindex: "0", "aria-label": "Cleared alarms" }));
  }

  parts(alarms) {
    const past = alarms.filter((alarm) => alarm.state === "cleared");
    if (!past.length) return [element("li", { class: "muted" }, "None that is remembered.")];
    return past.map((alarm) => {
      const lasted = span(alarm.cleared_time_s - alarm.raised_time_s);
      return element("li", {}, first(alarm, `${moment(alarm.raised_time_s)}, for ${lasted}`, ""), element("p", {}, alarm.message));
    });
  }
}

function first(alarm, time, more) {
  const shown = mark(alarm.severity, titled(alarm));
  shown.append(element("span", { class: "unseen" }, ` (${alarm.severity})`));
  return element("div", { class: "first" }, shown, more, element("span", { class: "time" }, time));
}

const NEW_PAD_MM = 35;
const LIMIT_MM = 5;
const MARGIN_MM = 3;

export class Pads extends Card {
  constructor() {
    super("Pads", "wear", element("div", { class: "pads" }));
  }

  parts(wear, meta) {
    if (!wear.length) return [element("p", { class: "muted" }, "Nothing told yet; it comes after a brake application.")];
    const full_mm = meta?.new_pad_thickness_mm ?? NEW_PAD_MM;
    const limit_mm = meta?.pad_limit_mm ?? LIMIT_MM;
    const margin_mm = meta?.pad_margin_mm ?? MARGIN_MM;
    return [...wear.map((own) => this.row(own, full_mm, limit_mm, margin_mm)),
      element("p", { class: "muted small" }, `Bars: thickness of ${number(full_mm, 0)} mm when new; the dashed line is the limit of ${number(limit_mm, 0)} mm, the whisker the 95 % interval.`)];
  }

  row(own, full_mm, limit_mm, margin_mm) {
    const scale = Math.max(full_mm, own.thickness_high_mm ?? 0, own.thickness_mm ?? 0) || 1;
    const percent = (mm) => `${Math.min(Math.max((mm ?? 0) / scale, 0), 1) * 100}%`;
    const left_mm = own.remaining_mm ?? 0;
    const fill = element("div", { class: `fill ${left_mm <= 0 ? "worn" : left_mm <= margin_mm ? "near" : ""}` });
    const limit = element("div", { class: "limit" });
    const interval = element("div", { class: "interval" });
    fill.style.width = percent(own.thickness_mm);
    limit.style.left = percent(limit_mm);
    interval.style.left = percent(own.thickness_low_mm);
    interval.style.right = `calc(100% - ${percent(own.thickness_high_mm)})`;
    const life = [];
    if (own.remaining_stops !== null) life.push(`about ${about(own.remaining_stops)} ${Math.round(own.remaining_stops) === 1 ? "stop" : "stops"}`);
    if (own.remaining_km !== null) life.push(`about ${about(own.remaining_km)} km`);
    const from = own.gauged_time_s === null ? "never measured" : `measured ${moment(own.gauged_time_s)}`;
    const disc = own.disc_temperature_c === null ? "" : `disc about ${number(own.disc_temperature_c, 0)}\u00a0°C`;
    const says = `${number(own.thickness_mm, 1)} mm thick, ${number(own.remaining_mm, 1)} mm remaining`;
    return element("div", { class: "row" },
      element("div", { class: "says" }, element("span", {}, `Wheelset ${own.wheelset}: `, element("b", {}, `${number(own.remaining_mm, 1)} mm`), " remaining"),
        element("span", { class: "muted small" }, [...life, disc].filter(Boolean).join(" · "))),
      element("div", { class: "track", role: "img", "aria-label": says, title: says }, fill, limit, interval),
      element("span", { class: "muted small" }, `${number(own.thickness_mm, 1)} mm (${number(own.thickness_low_mm, 1)} – ${number(own.thickness_high_mm, 1)}), ${from}`));
  }
}

export class Health {
  constructor() {
    this.facts = element("dl", { class: "facts" });
    this.values = new Map();
    this.root = card("Health", "health", this.facts);
    this.before = null;
    this.rates = { frames: null, cpu: null };
  }

  show(health, meta) {
    if (!health) {
      this.fact("", "no word of it yet");
      return;
    }
    if (this.values.delete("")) this.facts.replaceChildren();
    if (this.before && health.uptime_s > this.before.uptime_s) {
      const passed_s = health.uptime_s - this.before.uptime_s;
      this.rates = { frames: (health.frames - this.before.frames) / passed_s, cpu: (health.cpu_s - this.before.cpu_s) / passed_s };
    }
    if (health !== this.before) this.before = health;
    this.fact("Running for", span(health.uptime_s));
    this.fact("Newest data", health.data_age_s === null ? "none yet" : `${number(health.data_age_s * 1000, 0)} ms old`, health.data_age_s === null || health.data_age_s > 2);
    this.fact("CAN frames", `${count(health.frames)}${this.rates.frames === null ? "" : `, ${number(this.rates.frames, 0)} per s`}`);
    this.fact("Not decodable", count(health.decode_errors), health.decode_errors > 0);
    this.fact("Lost frames", count(health.lost_frames), health.lost_frames > 0);
    this.fact("Late samples, outliers", `${count(health.late_samples)}, ${count(health.outliers)}`);
    this.fact("Signals not good", health.stale_signals.join(", ") || "none", health.stale_signals.length > 0);
    this.fact("Buses down", health.buses_down.join(", ") || "none", health.buses_down.length > 0);
    this.fact("Filter restarts", count(health.filter_resets));
    this.fact("Capture to network", latency(health));
    this.fact("Events waiting, lost", `${count(health.events_waiting)}, ${count(health.events_lost)}`, health.events_lost > 0);
    this.fact("Publish failures", count(health.publish_failures), health.publish_failures > 0);
    this.fact("Processor, memory", `${this.rates.cpu === null ? "–" : number(this.rates.cpu * 100, 0)} %, ${number(health.memory_bytes / 1e6, 0)} MB`);
    if (meta) this.fact("Preset, version", `${meta.preset}, ${meta.versions["brake-monitor"] ?? "–"}`);
  }

  fact(name, value, bad = false) {
    let shown = this.values.get(name);
    if (!shown) {
      shown = element("dd", {});
      this.values.set(name, shown);
      this.facts.append(element("dt", {}, name), shown);
    }
    setText(shown, value);
    shown.classList.toggle("bad", bad);
  }
}

// The class that holds the median of all estimates so far.
function latency(health) {
  const all = health.latency_counts.reduce((sum, one) => sum + one, 0);
  let half = all / 2;
  for (let k = 0; k < health.latency_counts.length; k++) {
    half -= health.latency_counts[k];
    if (all && half <= 0) return k < health.latency_bounds_s.length ? `median below ${health.latency_bounds_s[k] * 1000} ms` : "median above 5 s";
  }
  return "–";
}
