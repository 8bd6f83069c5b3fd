// Unpacks the data of the report and draws its figures.
async function unpacked(column) {
  const bytes = Uint8Array.from(atob(column.packed), (one) => one.charCodeAt(0));
  const plain = await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
  if (column.bits === 64) return Array.from(new Float64Array(plain));
  return Array.from(new Uint16Array(plain), (k) => (k === 65535 ? null : column.least + k * column.step));
}

async function all(columns) {
  return Object.fromEntries(await Promise.all(Object.entries(columns).map(async ([name, column]) => [name, await unpacked(column)])));
}

const data = JSON.parse(document.getElementById("packed").textContent);
const { wheelsets, ...wagon } = data.columns;
const rows = { anew: true, ...(await all(wagon)), wheelsets: {} };
for (const i of Object.keys(wheelsets)) rows.wheelsets[i] = await all(wheelsets[i]);

const history = new History(Infinity);
history.radii_m = data.radii_m;
history.period_s = data.period_s;
history.take(rows);

function elapsed(seconds) {
  const [whole, sign] = [Math.abs(seconds), seconds < 0 ? "−" : ""];
  const two = (value) => String(Math.floor(value)).padStart(2, "0");
  const tenths = Number.isInteger(seconds) ? "" : `.${Math.floor((whole * 10) % 10)}`;
  const hours = Math.floor(whole / 3600);
  return `${sign}${hours ? `${hours}:${two((whole / 60) % 60)}` : Math.floor(whole / 60)}:${two(whole % 60)}${tenths}`;
}

tellTimeAs(elapsed);
const ends = [history.time_s[0] ?? 0, history.time_s.at(-1) ?? 1];
const numbers = history.numbers;
const specs = [adhesionChart(), speedChart(numbers), slipChart(numbers), forceChart(numbers), ...numbers.map(frictionChart)];
const charts = specs.map((spec) => new TimeChart(spec, look));
const overSlip = new SlipChart(numbers, 340);
const place = document.getElementById("curves");
place.append(...charts.map((chart) => chart.root));
document.getElementById("over-slip").append(overSlip.root);

function look(from_s, to_s) {
  const view = { ...history.view(from_s, to_s), levels: data.levels, friction_nominal: data.friction_nominal, spans: data.spans };
  for (const chart of [...charts, overSlip]) chart.show(view);
}

function draw() {
  forgetColours();
  for (const chart of [...charts, overSlip]) chart.draw();
}

const showAll = () => look(...ends);
document.getElementById("all").onclick = showAll;
for (const chart of charts) chart.plot.ondblclick = showAll;
for (const button of document.querySelectorAll("button[data-from]")) {
  button.title = "Show this in the figures";
  button.onclick = () => {
    look(Math.max(Number(button.dataset.from), ends[0]), Math.min(Number(button.dataset.to), ends[1]));
    document.getElementById("figures").scrollIntoView();
  };
}
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
addEventListener("beforeprint", () => charts.forEach((chart) => chart.see(true)));
addEventListener("resize", () => [...charts, overSlip].forEach((chart) => chart.fit()));
draw();
showAll();
document.documentElement.dataset.drawn = "true";
