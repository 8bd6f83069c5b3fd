// The fleet: every wagon that was heard of, the most urgent first.
import { colour } from "./charts.js";
import { LEVELS, STATES, element, kmh, mark, number, renew, setClass, setText, span, titled } from "./words.js";

const SEVERITIES = ["alarm", "warning", "info"];
const SPARK_WIDTH = 180;
const SPARK_HEIGHT = 30;
const SPARK_TOP = 0.12;
const SPARK_SECONDS = 120;

export class FleetPage {
  constructor(main) {
    this.rows = new Map();
    this.order = "";
    this.tally = element("div", { class: "tally" });
    this.search = element("input", { type: "search", placeholder: "Find a wagon", "aria-label": "Find a wagon" });
    this.search.oninput = () => this.filter();
    this.body = element("tbody");
    const heads = [["Wagon"], ["State"], ["Speed", "km/h", "number"], ["Adhesion now", ""], ["last 2 minutes", `0 – ${SPARK_TOP}`], ["Worst open alarm"], ["Pads left", "mm", "number"]];
    this.table = element("table", { class: "fleet" },
      element("thead", {}, element("tr", {}, ...heads.map(([name, unit, kind]) => element("th", { scope: "col", class: kind ?? "" }, name, unit ? element("span", { class: "unit" }, ` ${unit}`) : "")))),
      this.body);
    this.panel = element("div", { class: "panel" });
    this.nobody = element("p", { class: "empty" }, "No wagon is heard yet. They show up here by themselves as soon as one publishes.");
    this.panel.append(this.nobody);
    main.append(element("div", { class: "headline" }, element("h1", {}, "Fleet"), this.tally, element("span", { class: "spring" }), this.search), this.panel);
  }

  take(message) {
    if (message.wagons.length && !this.table.isConnected) this.panel.replaceChildren(this.table);
    const heard = new Set();
    for (const line of message.wagons) {
      heard.add(line.id);
      if (!this.rows.has(line.id)) this.rows.set(line.id, new Row(line.id));
      this.rows.get(line.id).show(line);
    }
    for (const name of this.rows.keys()) if (!heard.has(name)) this.rows.delete(name);
    this.sort();
    this.tell(message);
  }

  sort() {
    const rows = [...this.rows.values()].sort((a, b) => a.urgency - b.urgency || a.id.localeCompare(b.id, "en", { numeric: true }));
    const order = rows.map((row) => `${row.id}\n`).join("");
    if (order === this.order) return;
    this.order = order;
    const focused = document.activeElement;
    this.body.replaceChildren(...rows.map((row) => row.root));
    if (focused && this.body.contains(focused)) focused.focus();
    this.filter();
  }

  tell(message) {
    const states = Object.fromEntries(Object.keys(STATES).map((state) => [state, 0]));
    const alarms = { alarm: 0, warning: 0, info: 0 };
    for (const line of message.wagons) {
      states[line.state] += 1;
      for (const severity of SEVERITIES) alarms[severity] += line.alarms[severity];
    }
    renew(this.tally, [states, alarms, message.more], () => this.counted(message, states, alarms));
  }

  counted(message, states, alarms) {
    const parts = [element("span", { class: "muted" }, `${message.wagons.length + message.more} wagon${message.wagons.length === 1 ? "" : "s"}`)];
    for (const [state, words] of Object.entries(STATES)) if (states[state]) parts.push(mark(state, `${states[state]} ${words}`));
    for (const severity of SEVERITIES) if (alarms[severity]) parts.push(mark(severity, `${alarms[severity]} ${severity}${alarms[severity] === 1 || severity === "info" ? "" : "s"}`));
    if (!alarms.alarm && !alarms.warning && !alarms.info && message.wagons.length) parts.push(element("span", { class: "muted" }, "no alarms"));
    if (message.more) parts.push(element("span", { class: "muted" }, `${message.more} more are not listed`));
    return parts;
  }

  filter() {
    const wanted = this.search.value.trim().toLowerCase();
    for (const row of this.rows.values()) row.root.hidden = !row.id.toLowerCase().includes(wanted);
  }

  key(key) {
    if (key === "/") this.search.focus();
    else if (key === "j" || key === "k") {
      const links = [...this.body.querySelectorAll("tr:not([hidden]) a")];
      const at = links.indexOf(document.activeElement);
      links[Math.min(Math.max(at + (key === "j" ? 1 : -1), 0), links.length - 1)]?.focus();
    } else return false;
    return true;
  }

  redraw() {
    for (const row of this.rows.values()) row.spark();
  }

  fit() {}

  leave() {}
}

class Row {
  constructor(id) {
    this.id = id;
    this.urgency = 9;
    this.state = element("td", { class: "state" });
    this.speed = element("td", { class: "number speed-now" });
    this.value = element("span", { class: "big" });
    this.std = element("span", { class: "muted small" });
    this.level = element("span", { class: "chip" });
    this.canvas = element("canvas", { width: SPARK_WIDTH * devicePixelRatio, height: SPARK_HEIGHT * devicePixelRatio, "aria-hidden": "true" });
    this.worst = element("td", { class: "worst" });
    this.pads = element("td", { class: "number left" });
    const href = `#/wagon/${encodeURIComponent(id)}`;
    this.root = element("tr", {},
      element("td", { class: "id", title: id }, element("a", { href }, id)), this.state, this.speed,
      element("td", { class: "adhesion-now" }, this.value, " ", this.std, " ", this.level),
      element("td", { class: "spark" }, this.canvas), this.worst, this.pads);
    this.root.onclick = () => (location.hash = href);
  }

  show(line) {
    const worst = line.worst;
    this.urgency = (worst ? SEVERITIES.indexOf(worst.severity) * 2 + (worst.acknowledged ? 1 : 0) : 6) + (line.state === "live" ? 0 : -0.5);
    setClass(this.root, line.state === "live" ? "" : `stale ${line.state}`);
    const age = line.state === "frozen" ? ` ${span(line.age_s)}` : "";
    renew(this.state, line.state + age, () => [mark(line.state, STATES[line.state] + age)]);
    const doubt = line.status === "invalid";
    setText(this.speed, number(doubt ? null : kmh(line.speed_mps), 1));
    setText(this.value, number(doubt ? null : line.adhesion, 3));
    setText(this.std, `± ${number(doubt ? null : line.adhesion_std, 3)}`);
    setText(this.level, doubt ? "invalid" : line.level ? `rail: ${LEVELS[line.level]}` : line.status === "valid" ? "in use" : line.status ?? "–");
    setClass(this.level, `chip ${doubt || line.state !== "live" ? "" : line.level ?? ""}`);
    const open = SEVERITIES.reduce((sum, severity) => sum + line.alarms[severity], 0);
    const more = open > 1 ? ` and ${open - 1} more` : "";
    setClass(this.worst, worst ? "worst" : "worst none");
    renew(this.worst, [worst, more], () => [
      worst ? mark(worst.severity, titled(worst) + (worst.acknowledged ? " (seen)" : "")) : element("span", { class: "muted" }, "–"),
      element("span", { class: "muted small" }, more)]);
    setText(this.pads, number(line.pads_mm, 1));
    if (line.spark) {
      this.values = line.spark;
      this.spark();
    }
  }

  spark() {
    if (!this.values) return;
    const pen = this.canvas.getContext("2d");
    const [width, height] = [this.canvas.width, this.canvas.height];
    const up = (value) => height - 1.5 - (Math.min(value, SPARK_TOP) / SPARK_TOP) * (height - 4);
    pen.clearRect(0, 0, width, height);
    pen.fillStyle = colour("low");
    pen.fillRect(0, up(0.1), width, up(0.05) - up(0.1));
    pen.fillStyle = colour("very-low");
    pen.fillRect(0, up(0.05), width, up(0) - up(0.05));
    pen.strokeStyle = colour("info");
    pen.lineWidth = 1.6 * devicePixelRatio;
    pen.lineJoin = "round";
    pen.beginPath();
    let down = false;
    this.values.forEach((value, k) => {
      if (value === null) {
        down = false;
        return;
      }
      const x = ((SPARK_SECONDS - this.values.length + k + 0.5) / SPARK_SECONDS) * width;
      if (down) pen.lineTo(x, up(value));
      else pen.moveTo(x, up(value));
      down = true;
    });
    pen.stroke();
  }
}
