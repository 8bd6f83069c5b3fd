// How things are named and written for people. Text only ever becomes textContent.

const MARKS = {
  live: "M8 1a7 7 0 1 0 .001 0z", // disc
  frozen: "M2 1h4.5v14H2zM9.500 1H14v14H9.500z", // two bars
  silent: "M8 1a7 7 0 1 0 .001 0zM8 3.500a4.500 4.500 0 1 1 -.001 0z", // ring
  gone: "M3 1l5 5 5-5 2 2-5 5 5 5-2 2-5-5-5 5-2-2 5-5-5-5z", // cross
  unknown: "M3 1l5 5 5-5 2 2-5 5 5 5-2 2-5-5-5 5-2-2 5-5-5-5z",
  info: "M8 1a7 7 0 1 0 .001 0z", // disc
  warning: "M8 1l7.500 14H.5z", // triangle
  alarm: "M5 0h6l5 5v6l-5 5H5l-5-5V5z", // octagon
};

export const STATES = { live: "live", frozen: "frozen", silent: "no estimate yet", gone: "gone", unknown: "never heard of" };
export const LEVELS = { normal: "normal", low: "low", very_low: "very low", extremely_low: "extremely low" };

export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "class") made.className = value;
    else if (value !== null && value !== undefined && value !== false) made.setAttribute(name, value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

const SVG = "http://www.w3.org/2000/svg";

export function svg(tag, attributes, ...children) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

export function mark(kind, text) {
  const shape = svg("svg", { viewBox: "0 0 16 16", "aria-hidden": "true" }, svg("path", { d: MARKS[kind], "fill-rule": "evenodd" }));
  return element("span", { class: `mark ${kind}` }, shape, element("span", {}, text));
}

// Sets what changed and nothing else: the page stays calm and cheap.
export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

export function setClass(node, name) {
  if (node.className !== name) node.className = name;
}

// Renders anew when what is said has changed.
export function renew(node, said, parts) {
  const text = JSON.stringify(said);
  if (node.said === text) return;
  node.said = text;
  node.replaceChildren(...parts());
}

export function number(value, decimals) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

export function count(value) {
  return value.toLocaleString("en-GB").replaceAll(",", " ");
}

// What is only a guess: in two digits, which is more than it is good for.
export function about(value) {
  return count(Math.round(Number(value.toPrecision(2))));
}

export const kmh = (speed_mps) => (speed_mps === null || speed_mps === undefined ? null : speed_mps * 3.6);

// What an alarm is and where: "Hot disc, wheelset 2".
export function titled({ kind, wheelset }) {
  const words = kind.replaceAll("_", " ");
  return words.charAt(0).toUpperCase() + words.slice(1) + (wheelset === null ? "" : `, wheelset ${wheelset}`);
}

export function span(seconds) {
  const whole = Math.max(0, Math.round(seconds));
  if (whole < 60) return `${whole} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${whole % 60} s`;
  if (whole < 172800) return `${Math.floor(whole / 3600)} h ${Math.floor((whole % 3600) / 60)} min`;
  return `${Math.floor(whole / 86400)} days`;
}

const two = (value) => String(value).padStart(2, "0");

export function clock(time_s) {
  const date = new Date(time_s * 1000);
  return Number.isNaN(date.getTime()) ? "–" : `${two(date.getHours())}:${two(date.getMinutes())}:${two(date.getSeconds())}`;
}

export function moment(time_s) {
  const date = new Date(time_s * 1000);
  if (Number.isNaN(date.getTime())) return "–";
  const day = `${date.getFullYear()}-${two(date.getMonth() + 1)}-${two(date.getDate())}`;
  return date.toDateString() === new Date().toDateString() ? clock(time_s) : `${day} ${clock(time_s)}`;
}

const UNITS = {
  mps2: "m/s²", mps: "m/s", radps: "rad/s", deg: "°", mm: "mm", km: "km", kg: "kg", nm: "N m", n: "N", m: "m", j: "J", c: "°C", hz: "Hz",
  bytes: "byte", s: "s",
};

const SHARES = ["apart", "change", "creep", "slip"]; // words of names whose values are shares of something
const PREFIXED = ["J", "N", "N m"];
const PREFIXES = [[1e6, "M"], [1e3, "k"]]; // from which factor on

// As the report has it: "speed_start_mps", 21.3 → ["speed start", "21.3 m/s"]
export function described(name, value) {
  const parts = name.split("_");
  const at = [parts.length - 1, parts.length - 2].find((k) => k > 0 && Object.hasOwn(UNITS, parts[k]));
  const unit = at === undefined ? "" : UNITS[parts.splice(at, 1)[0]];
  const words = parts.join(" ");
  if (typeof value !== "number") return [words, value === null ? "–" : String(value)];
  if (unit === "s" && value > 1e8) return [words, moment(value)];
  if (unit === "°") return [words, `${number(value, 6)} °`];
  const isShare = unit === "" && SHARES.some((word) => parts.includes(word));
  const [factor, prefix] = (PREFIXED.includes(unit) && PREFIXES.find(([least]) => Math.abs(value) >= least)) || [1, ""];
  const shown = isShare ? 100 * value : value / factor;
  const decimals = Number.isInteger(shown) || Math.abs(shown) >= 100 ? 0 : Math.abs(shown) >= 10 ? 1 : 3;
  return [words, `${number(shown, decimals)} ${isShare ? "%" : prefix + unit}`.trim()];
}
