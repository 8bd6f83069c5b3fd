// Which page is shown, what is heard for it, and the keys.
import { forgetColours } from "./charts.js";
import { FleetPage } from "./fleet.js";
import { WagonPage } from "./wagon.js";
import { count, setText } from "./words.js";

const SILENT_MS = 2000; // the server speaks ten times a second
const RETRY_MS = 700;

const main = document.getElementById("main");
const connection = document.getElementById("connection");
let page = null;
let socket = null;
let heardAt = 0;
let retry = null;

function route() {
  const match = location.hash.match(/^#\/wagon\/(.+)$/);
  let wagon = null;
  try {
    wagon = match ? decodeURIComponent(match[1]) : null;
  } catch {
    wagon = null; // a broken address
  }
  page?.leave();
  main.replaceChildren();
  page = wagon === null ? new FleetPage(main) : new WagonPage(main, wagon);
  document.title = wagon === null ? "Fleet – Brake monitor" : `${wagon} – Brake monitor`;
  listen();
}

function listen() {
  clearTimeout(retry);
  if (socket) {
    socket.onclose = socket.onmessage = null;
    socket.close();
  }
  const query = page.wagon === undefined ? "" : `?wagon=${encodeURIComponent(page.wagon)}`;
  const opened = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/live${query}`);
  socket = opened;
  heardAt = performance.now();
  opened.onmessage = (event) => {
    heardAt = performance.now();
    const message = JSON.parse(event.data);
    connected(true, message.connected ? "" : message.was_connected ? "router or daemon no longer answers over Zenoh; still trying" : "nobody answers over Zenoh yet; still trying");
    page.take(message);
    footer(message);
  };
  opened.onclose = () => {
    connected(false);
    retry = setTimeout(listen, RETRY_MS);
  };
}

function connected(is, remark = "connection to the dashboard lost – what is shown is old") {
  setText(connection, remark);
  connection.classList.toggle("lost", remark !== "");
  document.body.classList.toggle("lost", !is);
}

setInterval(() => {
  if (performance.now() - heardAt > SILENT_MS && !document.hidden) {
    connected(false);
    if (socket.readyState === WebSocket.OPEN) socket.close();
  }
}, 250);

function footer(message) {
  const doubt = message.not_understood ? `, ${count(message.not_understood)} not understood and left out` : "";
  setText(document.getElementById("footer"), `${count(message.heard)} ${message.heard === 1 ? "message" : "messages"} heard${doubt} · times are local, bands are ± one standard deviation`);
}

const themeButton = document.getElementById("theme");

function nextTheme(step) {
  const theme = THEMES[(THEMES.indexOf(document.documentElement.dataset.theme) + step) % THEMES.length];
  if (step) setTheme(theme);
  setText(themeButton, `Theme: ${theme}`);
  if (step) redraw();
}

function redraw() {
  forgetColours();
  page.redraw();
}

const help = document.getElementById("help");
themeButton.onclick = () => nextTheme(1);
document.getElementById("keys").onclick = () => help.showModal();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
addEventListener("hashchange", route);
addEventListener("resize", () => page.fit());

document.addEventListener("keydown", (event) => {
  const isTyping = event.target.matches("input, textarea, select");
  if (event.ctrlKey || event.metaKey || event.altKey || help.open) return;
  if (isTyping) {
    if (event.key === "Escape") event.target.blur();
    return;
  }
  if (event.key === "?") help.showModal();
  else if (event.key === "t") nextTheme(1);
  else if (event.key === "f") location.hash = "#/";
  else if (!page.key(event.key)) return;
  event.preventDefault();
});

nextTheme(0);
route();
