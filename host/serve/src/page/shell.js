// The frame around the rooms: which there are, which is open, theme, keys.

import { api, takeToken } from "./api.js";
import { isForPage } from "./dom.js";

const root = document.documentElement;
const main = document.getElementById("room");
const nav = document.getElementById("rooms");
const themeButton = document.getElementById("theme");
const chosen = document.getElementById("finger");

const KEYS = [["1 … 9", "go to a room"], ["t", "light or dark"], ["?", "these keys"]];

let rooms = [];
/** Which devices there are, and the number, from 1, of the one that is looked at. */
let fingers = [];
let finger = 1;
let first = "";
let close = () => {};
let opening = 0;

const isDark = () => (root.dataset.theme ?? (matchMedia("(prefers-color-scheme:dark)").matches ? "dark" : "light")) === "dark";

function showTheme() {
  themeButton.textContent = isDark() ? "Light" : "Dark";
  document.dispatchEvent(new Event("palpate-theme"));
}

function switchTheme() {
  root.dataset.theme = isDark() ? "light" : "dark";
  localStorage.setItem("palpate-theme", root.dataset.theme);
  showTheme();
}

function say(text, warning = false) {
  const message = document.createElement("p");
  message.className = warning ? "message warning" : "message";
  message.setAttribute("role", warning ? "alert" : "status");
  message.textContent = text;
  main.replaceChildren(message);
}

/** Opens the room that the address names (`#live`, of the second finger of a hand `#live/2`), or the one that was asked for at the start. */
async function enter() {
  const named = (name) => rooms.find((room) => room.name === name);
  const [name, number] = location.hash.slice(1).split("/");
  const room = named(name) ?? named(first) ?? rooms[0];
  if (fingers[Number(number) - 1]) finger = Number(number);
  const mine = ++opening;
  close();
  close = () => {};
  document.title = `${room.title} · palpate`;
  showFingers(room);
  for (const link of nav.children) {
    if (link.dataset.room === room.name) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  try {
    const module = await import(`./${room.name}.js`);
    if (mine !== opening) return;
    main.replaceChildren();
    showKeys(module.keys ?? []);
    close = module.open(main, api.of(finger), { fingers, finger }) ?? (() => {});
  } catch (error) {
    say(`${room.title} cannot be shown: ${error.message}`, true);
  }
}

/** Of a hand, which finger a room of one device is about. */
function showFingers(room) {
  chosen.hidden = fingers.length < 2 || !["live", "device"].includes(room.name);
  if (fingers.length < 2) return;
  chosen.lastElementChild.value = finger;
  document.title = chosen.hidden ? `${room.title} · palpate` : `${room.title}, finger ${finger} · palpate`;
}

function showKeys(ofRoom) {
  const list = document.getElementById("keys");
  list.replaceChildren(...[...ofRoom, ...KEYS].flatMap(([key, words]) => {
    const term = document.createElement("dt");
    const mark = document.createElement("kbd");
    mark.textContent = key;
    term.append(mark);
    const meaning = document.createElement("dd");
    meaning.textContent = words;
    return [term, meaning];
  }));
}

function pressed(event) {
  if (!isForPage(event)) return;
  const room = rooms[Number(event.key) - 1];
  if (room) location.hash = room.name;
  else if (event.key === "t") switchTheme();
  else if (event.key === "?") document.getElementById("help").showModal();
  else return;
  event.preventDefault();
}

async function begin() {
  const kept = localStorage.getItem("palpate-theme");
  if (kept) root.dataset.theme = kept;
  showTheme();
  themeButton.addEventListener("click", switchTheme);
  matchMedia("(prefers-color-scheme:dark)").addEventListener("change", showTheme);
  document.getElementById("help-button").addEventListener("click", () => document.getElementById("help").showModal());
  document.addEventListener("keydown", pressed);
  if (!takeToken()) return say("Open the address that `palpate serve` printed: it holds the token without which nothing is shown.", true);
  try {
    ({ rooms, first, fingers } = await api.get("/rooms"));
  } catch (error) {
    return say(error.message, true);
  }
  nav.replaceChildren(...rooms.map((room) => {
    const link = document.createElement("a");
    link.href = `#${room.name}`;
    link.textContent = room.title;
    link.dataset.room = room.name;
    return link;
  }));
  if (rooms.length === 0) return say("There is nothing to show.", true);
  chosen.lastElementChild.replaceChildren(...fingers.map((_, index) => new Option(`Finger ${index + 1}`, index + 1)));
  chosen.lastElementChild.addEventListener("change", ({ target }) => (location.hash = `${location.hash.slice(1).split("/")[0] || "live"}/${target.value}`));
  addEventListener("hashchange", enter);
  await enter();
}

begin();
