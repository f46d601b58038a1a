// The frame around the rooms: which there are, which is open, theme, keys.

import { api, takeToken } from "./api.js";
import { isForPage } from "./dom.js";

const root = document.documentElement;
const main = document.getElementById("room");
const nav = document.getElementById("rooms");
const themeButton = document.getElementById("theme");

const KEYS = [["1 … 9", "go to a room"], ["t", "light or dark"], ["?", "these keys"]];

let rooms = [];
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

/** Opens the room that the address names, or the one that was asked for at the start. */
async function enter() {
  const named = (name) => rooms.find((room) => room.name === name);
  const room = named(location.hash.slice(1)) ?? named(first) ?? rooms[0];
  const mine = ++opening;
  close();
  close = () => {};
  for (const link of nav.children) {
    if (link.dataset.room === room.name) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  document.title = `${room.title} · palpate`;
  try {
    const module = await import(`./${room.name}.js`);
    if (mine !== opening) return;
    main.replaceChildren();
    showKeys(module.keys ?? []);
    close = module.open(main, api) ?? (() => {});
  } catch (error) {
    say(`${room.title} cannot be shown: ${error.message}`, true);
  }
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
    ({ rooms, first } = await api.get("/rooms"));
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
  addEventListener("hashchange", enter);
  await enter();
}

begin();
