// Curves over time, and adhesion over slip, drawn with uPlot.
import { clock, element, number, setText, svg } from "./words.js";

const FONT = '12px system-ui, "Segoe UI", Roboto, "Liberation Sans", "DejaVu Sans", sans-serif';
const DASHES = [[], [7, 4], [2, 3], [10, 3, 2, 3]]; // of wheelsets 1, 2, 3, 4: never colour alone

let tellTime = clock;

// How the time axis is written, when not as the time of day.
export function tellTimeAs(write) {
  tellTime = write;
}

const colours = new Map();

// A colour of the style sheet as a canvas takes it, in the theme that holds now.
export function colour(name, alpha = 1) {
  const key = `${name} ${alpha}`;
  if (!colours.has(key)) {
    const probe = document.getElementById("main");
    probe.style.caretColor = `var(--${name})`;
    const [r, g, b] = getComputedStyle(probe).caretColor.match(/[\d.]+/g);
    colours.set(key, `rgba(${r}, ${g}, ${b}, ${alpha})`);
  }
  return colours.get(key);
}

export function forgetColours() {
  colours.clear();
}

export const wheelsetColour = (i) => `wheelset-${((i - 1) % 4) + 1}`;
export const wheelsetDash = (i) => DASHES[(i - 1) % 4];

// The end of a scale from 0 that holds the values, in steps that do not fidget.
export function top(values, least, step, most) {
  let highest = least;
  for (const value of values) if (value !== null && value > highest) highest = value;
  return Math.min(Math.ceil(highest / step - 1e-6) * step, most);
}

function swatch(series) {
  const line = svg("line", { x1: 1, y1: 5, x2: 25, y2: 5, "stroke-width": series.width ?? 2 });
  line.style.stroke = `var(--${series.colour})`;
  line.setAttribute("stroke-dasharray", (series.dash ?? []).join(" "));
  return svg("svg", { viewBox: "0 0 26 10", "aria-hidden": "true" }, line);
}

// Runs of samples for which `is` holds, as [from, to] in time.
export function runs(times, is) {
  const found = [];
  let begun = null;
  for (let k = 0; k < times.length; k++) {
    if (is(k)) begun ??= times[k];
    else if (begun !== null) {
      found.push([begun, times[k]]);
      begun = null;
    }
  }
  if (begun !== null) found.push([begun, times.at(-1)]);
  return found;
}

export function hatch(context, ink) {
  const tile = document.createElement("canvas");
  tile.width = tile.height = 8;
  const pen = tile.getContext("2d");
  pen.strokeStyle = ink;
  pen.lineWidth = 1;
  pen.beginPath();
  for (const shift of [-8, 0, 8]) {
    pen.moveTo(shift, 8);
    pen.lineTo(shift + 8, 0);
  }
  pen.stroke();
  return context.createPattern(tile, "repeat");
}

function axis(theme, more) {
  return {
    stroke: theme.muted, font: FONT, grid: { stroke: theme.grid, width: 1 }, ticks: { stroke: theme.grid, width: 1, size: 4 }, ...more,
  };
}

// A place to draw in, and what uPlot has drawn there.
class Chart {
  constructor(height) {
    this.height = height;
    this.view = null;
  }

  get size() {
    return { width: Math.max(this.plot.clientWidth, 200), height: this.height };
  }

  fit() {
    if (this.u && this.plot.clientWidth !== this.u.width) this.u.setSize(this.size);
  }

  destroy() {
    this.u?.destroy();
    this.u = null;
  }
}

// spec: title, unit, decimals, height, label (for those who do not see it), series [{label, colour, dash, width, of(view) → column}],
//       bands [{colour, low(view), high(view)}], range(view) → [least, greatest], ticked(value, view), under(u, view, theme), over(u, view, theme)
export class TimeChart extends Chart {
  constructor(spec, onSelect) {
    super(spec.height);
    this.spec = spec;
    this.onSelect = onSelect;
    this.isSeen = false;
    this.values = [];
    const keys = spec.series.map((series) => {
      const value = element("b", {}, "–");
      this.values.push(value);
      return element("li", {}, swatch(series), element("span", {}, series.label), value);
    });
    if (spec.keys) keys.push(...spec.keys());
    this.plot = element("div", { class: "plot", role: "img", "aria-label": `${spec.title} over time, ${spec.unit || "no unit"}` });
    this.root = element("section", { class: spec.bare ? "chart" : "chart panel" },
      element("header", {}, element("h2", {}, spec.title, " ", element("span", { class: "unit" }, spec.unit)), element("ul", { class: "legend" }, ...keys)),
      this.plot);
    this.watcher = new IntersectionObserver(([entry]) => this.see(entry.isIntersecting), { rootMargin: "60px" });
    this.watcher.observe(this.plot);
  }

  draw() {
    this.u?.destroy();
    const { spec } = this;
    const theme = { grid: colour("grid"), muted: colour("muted"), ink: colour("ink"), panel: colour("panel") };
    const bands = spec.bands ?? [];
    const series = [{}];
    for (const band of bands) series.push(edge(band), edge(band));
    for (const one of spec.series) {
      series.push({ stroke: colour(one.colour), width: one.width ?? 1.8, dash: one.dash ?? [], points: { show: false }, spanGaps: false });
    }
    const options = {
      ...this.size, legend: { show: false }, series,
      bands: bands.map((band, k) => ({ series: [2 * k + 1, 2 * k + 2], fill: colour(band.colour, 0.22) })),
      cursor: { sync: { key: "time" }, drag: { x: true, y: false, setScale: false }, y: false, points: { size: 6 } },
      scales: { x: { time: true }, y: { range: () => (this.view ? spec.range(this.view) : [0, 1]) } },
      axes: [
        axis(theme, { space: 80, size: 28, values: (u, splits) => splits.map(tellTime) }),
        axis(theme, { size: 50, space: 26, incrs: steps(spec.decimals), values: (u, splits) => splits.map((value) => (this.view && spec.ticked?.(value, this.view) === false ? "" : number(value, spec.decimals))) }),
      ],
      padding: [8, 24, 0, 0],
      hooks: {
        drawClear: [(u) => this.view && behind(u, this.view.spans ?? []), (u) => this.view && spec.under?.(u, this.view, theme)],
        draw: [(u) => this.view && spec.over?.(u, this.view, theme)],
        setSelect: [(u) => {
          if (u.select.width > 4) this.onSelect(u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x"));
          u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
        }],
        setCursor: [() => this.tell()],
      },
    };
    this.u = new uPlot(options, this.data(), this.plot);
    if (this.view) this.show(this.view);
  }

  data() {
    const { spec, view } = this;
    if (!view) return [[], ...(spec.bands ?? []).flatMap(() => [[], []]), ...spec.series.map(() => [])];
    return [view.time_s, ...(spec.bands ?? []).flatMap((band) => [band.high(view), band.low(view)]), ...spec.series.map((one) => one.of(view))];
  }

  // Whether anybody sees it: else it is not drawn.
  see(isSeen) {
    this.isSeen = isSeen;
    if (isSeen && this.view) this.show(this.view);
  }

  show(view) {
    this.view = view;
    if (!this.u || !this.isSeen) return;
    this.u.batch(() => {
      this.u.setData(this.data(), false);
      this.u.setScale("x", { min: view.from_s, max: view.to_s });
    });
    this.tell();
  }

  tell() {
    const under = this.u.cursor.idx;
    const at = under ?? this.view?.time_s.length - 1;
    const before = 2 * (this.spec.bands ?? []).length + 1;
    this.spec.series.forEach((one, k) => setText(this.values[k], number(this.u.data[before + k]?.[at], one.decimals ?? this.spec.decimals)));
  }

  destroy() {
    this.watcher.disconnect();
    super.destroy();
  }
}

// Distances between ticks, none finer than the decimals tell.
function steps(decimals) {
  const all = [];
  for (let power = -decimals; power < 4; power++) for (const one of [1, 2, 5]) all.push(Number((one * 10 ** power).toPrecision(3)));
  return all;
}

// Fills stretches of time, from the top to the bottom of the picture or in a lane of it, each with the least width.
export function fillSpans(u, spans, top = u.bbox.top, height = u.bbox.height, least = 0) {
  for (const [from_s, to_s] of spans) {
    const left = Math.max(u.valToPos(from_s, "x", true), u.bbox.left);
    const right = Math.min(u.valToPos(to_s, "x", true), u.bbox.left + u.bbox.width);
    if (right > left) u.ctx.fillRect(left, top, Math.max(right - left, least), height);
  }
}

// A dashed line across the picture.
export function dashAcross(u, value, ink) {
  const y = u.valToPos(value, "y", true);
  u.ctx.save();
  u.ctx.strokeStyle = ink;
  u.ctx.setLineDash([3 * devicePixelRatio, 4 * devicePixelRatio]);
  u.ctx.beginPath();
  u.ctx.moveTo(u.bbox.left, y);
  u.ctx.lineTo(u.bbox.left + u.bbox.width, y);
  u.ctx.stroke();
  u.ctx.restore();
}

// Stretches of time behind the curves.
function behind(u, spans) {
  u.ctx.fillStyle = colour("span");
  fillSpans(u, spans);
}

function edge(band) {
  return { stroke: colour(band.colour, 0), width: 0, points: { show: false }, spanGaps: false };
}

const SHAPES = [
  (pen, x, y, r) => pen.rect(x - r, y - r, 2 * r, 2 * r),
  (pen, x, y, r) => { pen.moveTo(x + r, y); pen.arc(x, y, r, 0, 2 * Math.PI); },
  (pen, x, y, r) => { pen.moveTo(x, y - r); pen.lineTo(x + r, y + r); pen.lineTo(x - r, y + r); pen.closePath(); },
  (pen, x, y, r) => { pen.moveTo(x, y - r); pen.lineTo(x + r, y); pen.lineTo(x, y + r); pen.lineTo(x - r, y); pen.closePath(); },
];
const FADES = 4;

// Adhesion over slip of every wheelset: the newer a point, the stronger; the wheelsets by colour and shape.
export class SlipChart extends Chart {
  constructor(wheelsets, height) {
    super(height);
    this.wheelsets = wheelsets;
    this.plot = element("div", { class: "plot", role: "img", "aria-label": "Adhesion over slip of every wheelset" });
    const keys = wheelsets.map((i) => {
      const shape = svg("path", { d: ["M9 1h8v8H9z", "M13 1a4 4 0 1 0 .01 0z", "M13 1l4.500 8h-9z", "M13 0l5 5-5 5-5-5z"][(i - 1) % 4] });
      shape.style.fill = `var(--${wheelsetColour(i)})`;
      return element("li", {}, svg("svg", { viewBox: "0 0 26 10", "aria-hidden": "true" }, shape), element("span", {}, `wheelset ${i}`));
    });
    this.root = element("section", { class: "chart panel" },
      element("header", {}, element("h2", {}, "Adhesion over slip"), element("ul", { class: "legend" }, ...keys)), this.plot);
  }

  draw() {
    this.u?.destroy();
    const theme = { grid: colour("grid"), muted: colour("muted") };
    const inks = this.wheelsets.map((i) => Array.from({ length: FADES }, (_, k) => colour(wheelsetColour(i), 0.18 + 0.62 * (k / (FADES - 1)))));
    this.u = new uPlot({
      ...this.size, legend: { show: false }, series: [{}, { points: { show: false }, width: 0 }],
      cursor: { show: false },
      scales: { x: { time: false, range: () => [-1, this.ends?.[0] ?? 30] }, y: { range: () => [0, this.ends?.[1] ?? 0.15] } },
      axes: [axis(theme, { label: "slip, %", labelSize: 18, labelFont: FONT, labelGap: 0, size: 28 }), axis(theme, { size: 50, values: (u, splits) => splits.map((v) => number(v, 2)) })],
      padding: [8, 12, 0, 0],
      hooks: { draw: [(u) => this.view && this.points(u, inks)] },
    }, [[0, 100], [null, null]], this.plot);
    if (this.view) this.show(this.view);
  }

  show(view) {
    this.view = view;
    if (!this.u) return;
    const columns = this.wheelsets.map((i) => view.wheelsets[i]);
    this.ends = [top(columns.flatMap((own) => own.slip_percent), 9.5, 10, 100) + 0.5, top(columns.flatMap((own) => own.adhesion), 0.1, 0.05, 0.6)];
    this.u.setData([[0, 100], [null, null]]);
  }

  points(u, inks) {
    const pen = u.ctx;
    const { left, top: above, width, height } = u.bbox;
    const r = 2.2 * devicePixelRatio;
    const count = this.view.time_s.length;
    pen.save();
    pen.beginPath();
    pen.rect(left, above, width, height);
    pen.clip();
    this.wheelsets.forEach((i, place) => {
      const own = this.view.wheelsets[i];
      for (let fade = 0; fade < FADES; fade++) {
        pen.fillStyle = inks[place][fade];
        pen.beginPath();
        for (let k = Math.floor((count * fade) / FADES); k < Math.floor((count * (fade + 1)) / FADES); k++) {
          if (own.slip_percent[k] === null || own.adhesion[k] === null) continue;
          SHAPES[(i - 1) % 4](pen, u.valToPos(own.slip_percent[k], "x", true), u.valToPos(own.adhesion[k], "y", true), r);
        }
        pen.fill();
      }
    });
    pen.restore();
  }
}
