// What the curves of a wagon are, as specifications of charts.
import { colour, hatch, runs, top, wheelsetColour, wheelsetDash } from "./charts.js";
import { element } from "./words.js";

const LANE = 13; // height of a WSP lane, px
const SLIP_HEIGHT = 165; // px, with the lanes
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

export function adhesionChart() {
  return {
    title: "Adhesion", unit: "", decimals: 2, height: 230,
    series: [{ label: "in use", colour: "info", decimals: 3, of: (view) => view.wagon.adhesion },
      { label: "all that the rail gives", colour: "alarm", width: 3, decimals: 3, of: (view) => view.wagon.adhesion_available }],
    bands: [{ colour: "info", low: (view) => view.wagon.adhesion_low, high: (view) => view.wagon.adhesion_high }],
    range: (view) => [0, top([...view.wagon.adhesion_high, ...view.wagon.adhesion], 0.12, 0.04, 0.6)],
    under: (u, view) => {
      const pen = u.ctx;
      let before = 0;
      for (const name of ["extremely_low", "very_low", "low"]) {
        const below = Math.min(view.levels[name], u.scales.y.max);
        const [y, bottom] = [u.valToPos(below, "y", true), u.valToPos(before, "y", true)];
        pen.fillStyle = colour(name.replace("_", "-"));
        pen.fillRect(u.bbox.left, y, u.bbox.width, bottom - y);
        before = below;
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
      const { levels } = view;
      const x = u.bbox.left + u.bbox.width - 6 * devicePixelRatio;
      for (const [name, low, high] of [["extremely low", 0, levels.extremely_low], ["very low", levels.extremely_low, levels.very_low], ["low", levels.very_low, levels.low], ["normal", levels.low, u.scales.y.max]]) {
        if (high <= low) continue;
        const y = u.valToPos((low + Math.min(high, u.scales.y.max)) / 2, "y", true);
        pen.strokeText(name, x, y);
        pen.fillText(name, x, y);
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
      const bars = hatch(pen, theme.muted);
      const { held } = own(view);
      pen.save();
      pen.globalAlpha = 0.35;
      pen.fillStyle = bars;
      for (const [from_s, to_s] of runs(view.time_s, (k) => held[k] === 1)) {
        const left = Math.max(u.valToPos(from_s, "x", true), u.bbox.left);
        const right = Math.min(u.valToPos(to_s, "x", true), u.bbox.left + u.bbox.width);
        if (right > left) pen.fillRect(left, u.bbox.top, right - left, u.bbox.height);
      }
      pen.restore();
      if (view.friction_nominal !== null) {
        const y = u.valToPos(view.friction_nominal, "y", true);
        pen.save();
        pen.strokeStyle = theme.muted;
        pen.setLineDash([3 * devicePixelRatio, 4 * devicePixelRatio]);
        pen.beginPath();
        pen.moveTo(u.bbox.left, y);
        pen.lineTo(u.bbox.left + u.bbox.width, y);
        pen.stroke();
        pen.restore();
      }
    },
  };
}

export function slipChart(numbers) {
  const highest = (view) => top(all(view, "slip_percent"), 10, 10, 100) + 0.5;
  return {
    title: "Slip and wheel-slide protection", unit: "% of vehicle speed", decimals: 0, height: SLIP_HEIGHT + CHART_FRAME, ticked: (value, view) => value < highest(view),
    series: perWheelset(numbers, "wheelset", (own) => own.slip_percent, { decimals: 1 }),
    // The lanes of the WSP lie above the highest slip.
    range: (view) => {
      const lanes = numbers.length * LANE + 7;
      return [-2, highest(view) + ((highest(view) + 2) * lanes) / (SLIP_HEIGHT - lanes)];
    },
    under: (u, view, theme) => {
      const y = u.valToPos(SLIDING_PERCENT, "y", true);
      u.ctx.save();
      u.ctx.strokeStyle = theme.muted;
      u.ctx.setLineDash([3 * devicePixelRatio, 4 * devicePixelRatio]);
      u.ctx.beginPath();
      u.ctx.moveTo(u.bbox.left, y);
      u.ctx.lineTo(u.bbox.left + u.bbox.width, y);
      u.ctx.stroke();
      u.ctx.restore();
    },
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
        for (const [from_s, to_s] of runs(view.time_s, (k) => view.wheelsets[i].wsp_active[k] === 1)) {
          const left = Math.max(u.valToPos(from_s, "x", true), u.bbox.left);
          const right = Math.min(u.valToPos(to_s, "x", true), u.bbox.left + u.bbox.width);
          if (right > left) pen.fillRect(left, y, Math.max(right - left, devicePixelRatio), lane - devicePixelRatio);
        }
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
