// The last minutes of a wagon as columns; the oldest go as new ones come, so that the page never grows.

const ROWS_KEPT = 3000;
const SLACK = 500; // rows cut off at once
const GAP_S = 1.5; // a longer pause between rows is drawn as a gap
const PERIODS = 3;
const SLOWEST_MPS = 1; // below it slip has no meaning, and none is given

const WAGON = ["speed_mps", "adhesion", "adhesion_std", "adhesion_available"];
const WHEELSET = ["slip", "omega_radps", "pressing_force_n", "friction", "friction_std", "held", "adhesion", "wsp_active"];

// What is drawn besides what was heard, each from one row's values.
const WAGON_DRAWN = {
  speed_kmh: (w) => scaled(w.speed_mps, 3.6),
  adhesion_low: (w) => minus(w.adhesion, w.adhesion_std),
  adhesion_high: (w) => minus(w.adhesion, scaled(w.adhesion_std, -1)),
};
const WHEELSET_DRAWN = {
  speed_kmh: wheelSpeed,
  slip_percent: (own, w) => (w.speed_mps > SLOWEST_MPS ? scaled(own.slip, 100) : null),
  force_kn: (own) => scaled(own.pressing_force_n, 1e-3),
  friction_low: (own) => minus(own.friction, own.friction_std),
  friction_high: (own) => minus(own.friction, scaled(own.friction_std, -1)),
};

const scaled = (value, factor) => (value === null ? null : value * factor);
const minus = (value, other) => (value === null || other === null ? null : value - other);

// Circumferential speed: from slip, which knows the learned radius; near standstill from the configured one.
function wheelSpeed(own, w, radius_m) {
  if (w.speed_mps === null) return null;
  if (w.speed_mps > SLOWEST_MPS) return own.slip === null ? null : w.speed_mps * (1 - own.slip) * 3.6;
  return own.omega_radps === null || radius_m === undefined ? null : own.omega_radps * radius_m * 3.6;
}

export class History {
  constructor(rowsKept = ROWS_KEPT) {
    this.rowsKept = rowsKept;
    this.radii_m = [];
    this.period_s = 0.1;
    this.clear();
  }

  clear() {
    this.time_s = [];
    this.wagon = columns([...WAGON, ...Object.keys(WAGON_DRAWN)]);
    this.wheelsets = {};
  }

  get numbers() {
    return Object.keys(this.wheelsets).map(Number);
  }

  take(rows) {
    if (rows.anew) this.clear();
    for (const i of Object.keys(rows.wheelsets)) this.wheelsets[i] ??= this.late();
    for (let k = 0; k < rows.time_s.length; k++) this.add(rows, k);
    if (this.time_s.length > this.rowsKept + SLACK) this.cut(this.time_s.length - this.rowsKept);
  }

  // Columns of a wheelset that is heard of late.
  late() {
    const made = columns([...WHEELSET, ...Object.keys(WHEELSET_DRAWN)]);
    for (const column of Object.values(made)) for (const _ of this.time_s) column.push(null);
    return made;
  }

  add(rows, k) {
    const time_s = rows.time_s[k];
    const before_s = this.time_s.at(-1);
    if (before_s !== undefined && time_s - before_s > Math.max(GAP_S, PERIODS * this.period_s)) this.gap(before_s + 1e-3);
    this.time_s.push(time_s);
    const w = Object.fromEntries(WAGON.map((name) => [name, rows[name][k]]));
    for (const name of WAGON) this.wagon[name].push(w[name]);
    for (const [name, of] of Object.entries(WAGON_DRAWN)) this.wagon[name].push(of(w));
    for (const i of this.numbers) {
      const own = Object.fromEntries(WHEELSET.map((name) => [name, rows.wheelsets[i]?.[name][k] ?? null]));
      for (const name of WHEELSET) this.wheelsets[i][name].push(own[name]);
      for (const [name, of] of Object.entries(WHEELSET_DRAWN)) this.wheelsets[i][name].push(of(own, w, this.radii_m[i - 1]));
    }
  }

  gap(time_s) {
    this.time_s.push(time_s);
    for (const column of this.columns()) column.push(null);
  }

  cut(rows) {
    this.time_s.splice(0, rows);
    for (const column of this.columns()) column.splice(0, rows);
  }

  columns() {
    return [this.wagon, ...Object.values(this.wheelsets)].flatMap((part) => Object.values(part));
  }

  // The rows between two times, and one beyond at either end, so that lines go on to the edge.
  view(from_s, to_s) {
    const first = Math.max(place(this.time_s, from_s) - 1, 0);
    const end = Math.min(place(this.time_s, to_s) + 1, this.time_s.length);
    const part = (all) => Object.fromEntries(Object.entries(all).map(([name, column]) => [name, column.slice(first, end)]));
    return {
      from_s, to_s, time_s: this.time_s.slice(first, end), wagon: part(this.wagon),
      wheelsets: Object.fromEntries(Object.entries(this.wheelsets).map(([i, own]) => [i, part(own)])),
    };
  }
}

function columns(names) {
  return Object.fromEntries(names.map((name) => [name, []]));
}

// How many times are before `time_s`.
function place(times, time_s) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] < time_s) low = middle + 1;
    else high = middle;
  }
  return low;
}
