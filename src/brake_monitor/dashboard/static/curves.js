// What the curves of a wagon are, as specifications of charts.
import { colour, dashAcross, fillSpans, hatch, runs, top, wheelsetColour, wheelsetDash } from "./charts.js";
import { LEVELS, element } from "./words.js";

const LANE = 13; // height of a WSP lane, px
const SLIP_HEIGHT = 132; // px, below the lanes
const CHART_FRAME = 36; // px, above and below
const SLIDING_PERCENT = 5;

const perWheelset = (numbers, name, of, more = {}) =>
  numbers.map((i) => ({ label: `${name} ${i}`, colour: wheelsetColour(i), dash: wheelsetDash(i), of: (view) => of(view.wheelsets[i]), ...more }));
const all = (view, name) => Object.values(view.wheelsets).flatMap((own) => own[name]);

export function speedChart(numbers) {
  return {
    title: "Speeds", unit: "km/h", decimals: 0, height: 190,
    series: [{ label: "vehicle", colour: "vehicle", width: 2.4, decimals: 1, of: (view) => view.wagon.speed_kmh },
      ...perWheelset(numbers, "wheelset", (own) => own.speed_kmh, { decimals: 1 })],
    range: (view) => [0, top([...view.wagon.speed_kmh, ...all(view, "speed_kmh")], 20, 20, 600)],
  };
}

export function forceChart(numbers) {
  return {
    title: "Pressing forces", unit: "kN per wheelset", decimals: 0, height: 150,
    series: perWheelset(numbers, "wheelset", (own) => own.force_kn, { decimals: 1 }),
    range: (view) => [0, top(all(view, "force_kn"), 20, 20, 500)],
  };
}

// The ladder of adhesion from the worst up, as [name, from, to], as far as the scale goes.
function rungs(levels, top) {
  const names = ["extremely_low", "very_low", "low", "normal"];
  const ends = [0, ...names.map((name) => Math.min(levels[name] ?? top, top))];
  return names.map((name, k) => [name, ends[k], ends[k + 1]]);
}

export function adhesionChart() {
  return {
    title: "Adhesion", unit: "", decimals: 2, height: 230,
    series: [{ label: "in use", colour: "info", decimals: 3, of: (view) => view.wagon.adhesion },
      { label: "all that the rail gives", colour: "alarm", width: 3, decimals: 3, of: (view) => view.wagon.adhesion_available }],
    bands: [{ colour: "info", low: (view) => view.wagon.adhesion_low, high: (view) => view.wagon.adhesion_high }],
    range: (view) => [0, top([...view.wagon.adhesion_high, ...view.wagon.adhesion], 0.12, 0.04, 0.6)],
    under: (u, view) => {
      for (const [name, low, high] of rungs(view.levels, u.scales.y.max)) {
        if (name === "normal") continue;
        const [y, bottom] = [u.valToPos(high, "y", true), u.valToPos(low, "y", true)];
        u.ctx.fillStyle = colour(name.replace("_", "-"));
        u.ctx.fillRect(u.bbox.left, y, u.bbox.width, bottom - y);
      }
    },
    over: (u, view, theme) => {
      const pen = u.ctx;
      pen.save();
      pen.font = `${11 * devicePixelRatio}px system-ui, "Segoe UI", "Liberation Sans", sans-serif`;
      pen.textAlign = "right";
      pen.textBaseline = "middle";
      pen.fillStyle = theme.muted;
      pen.strokeStyle = theme.panel;
      pen.lineWidth = 3 * devicePixelRatio;
      const x = u.bbox.left + u.bbox.width - 6 * devicePixelRatio;
      for (const [name, low, high] of rungs(view.levels, u.scales.y.max)) {
        if (high <= low) continue;
        const y = u.valToPos((low + high) / 2, "y", true);
        pen.strokeText(LEVELS[name], x, y);
        pen.fillText(LEVELS[name], x, y);
      }
      pen.restore();
    },
  };
}

function heldKey() {
  return [element("li", {}, element("span", { class: "chip" }, "▨ held: pad released, not observable"))];
}

export function frictionChart(i) {
  const own = (view) => view.wheelsets[i];
  return {
    title: `Pad friction, wheelset ${i}`, unit: "", decimals: 2, height: 150, bare: true, keys: heldKey,
    series: [{ label: "friction", colour: wheelsetColour(i), dash: [], decimals: 3, of: (view) => own(view).friction }],
    bands: [{ colour: wheelsetColour(i), low: (view) => own(view).friction_low, high: (view) => own(view).friction_high }],
    range: (view) => [0, top([...own(view).friction_high, ...own(view).friction], 0.5, 0.1, 1)],
    under: (u, view, theme) => {
      const pen = u.ctx;
      const { held } = own(view);
      pen.save();
      pen.globalAlpha = 0.35;
      pen.fillStyle = hatch(pen, theme.muted);
      fillSpans(u, runs(view.time_s, (k) => held[k] === 1));
      pen.restore();
      if (view.friction_nominal !== null) dashAcross(u, view.friction_nominal, theme.muted);
    },
  };
}

export function slipChart(numbers) {
  const highest = (view) => top(all(view, "slip_percent"), 10, 10, 100) + 0.5;
  const lanes = numbers.length * LANE + 7; // px
  return {
    title: "Slip and wheel-slide protection", unit: "% of vehicle speed", decimals: 0, height: lanes + SLIP_HEIGHT + CHART_FRAME, ticked: (value, view) => value < highest(view),
    series: perWheelset(numbers, "wheelset", (own) => own.slip_percent, { decimals: 1 }),
    // The lanes of the WSP lie above the highest slip.
    range: (view) => [-2, highest(view) + ((highest(view) + 2) * lanes) / SLIP_HEIGHT],
    under: (u, view, theme) => dashAcross(u, SLIDING_PERCENT, theme.muted),
    over: (u, view, theme) => {
      const pen = u.ctx;
      const lane = LANE * devicePixelRatio;
      pen.save();
      pen.font = `${10 * devicePixelRatio}px system-ui, "Segoe UI", "Liberation Sans", sans-serif`;
      pen.textBaseline = "middle";
      numbers.forEach((i, place) => {
        const y = u.bbox.top + place * lane;
        pen.fillStyle = colour("sunken");
        pen.fillRect(u.bbox.left, y, u.bbox.width, lane - devicePixelRatio);
        pen.fillStyle = colour(wheelsetColour(i));
        const active = runs(view.time_s, (k) => view.wheelsets[i].wsp_active[k] === 1);
        fillSpans(u, active, y, lane - devicePixelRatio, devicePixelRatio);
        pen.fillStyle = theme.muted;
        pen.textAlign = "right";
        pen.fillText(`WSP ${i}`, u.bbox.left - 6 * devicePixelRatio, y + lane / 2);
        pen.textAlign = "left";
        if (view.wheelsets[i].wsp_active.at(-1) === null) pen.fillText("–", u.bbox.left + 4 * devicePixelRatio, y + lane / 2);
      });
      pen.restore();
    },
  };
}
