// Questions to the server that gave this page. Each carries the token of the address that was printed.

const KEPT = "palpate-token";

/** Takes the token out of the address, where it would be seen, and keeps it for this tab. */
export function takeToken() {
  const found = /^#token=([0-9a-f]+)/.exec(location.hash);
  if (found) {
    sessionStorage.setItem(KEPT, found[1]);
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem(KEPT) !== null;
}

const token = () => sessionStorage.getItem(KEPT) ?? "";

async function ask(path, options = {}) {
  const headers = { "x-palpate-token": token(), ...options.headers };
  let response;
  try {
    response = await fetch(`/api${path}`, { ...options, headers });
  } catch {
    throw { message: "palpate does not answer; is `palpate serve` still running?" };
  }
  if (response.ok) return response;
  const text = await response.text();
  let message = text;
  try {
    message = JSON.parse(text).message ?? text;
  } catch {
    // Then the text itself is the message.
  }
  throw { message: message || `${response.status} ${response.statusText}`, status: response.status };
}

/** Where a question about a device goes, of a hand to the finger of this number, from 1. */
const ofFinger = (number) => (path) => path.replace(/^\/(live|device)\//, `/fingers/${number}/$1/`);

export const api = {
  /** The same questions, those about a device to the finger of this number, from 1. */
  of(number) {
    const at = ofFinger(number);
    const of = {};
    for (const [name, ask] of Object.entries(api)) of[name] = (path, ...rest) => ask(at(path), ...rest);
    return { ...of, of: api.of };
  },
  /** Resolves to the JSON of `/api` + path; rejects with `{message}`. */
  get: async (path) => (await ask(path)).json(),
  /** The same as an ArrayBuffer. */
  bytes: async (path) => (await ask(path)).arrayBuffer(),
  /** Sends JSON and resolves to JSON. */
  post: async (path, json) =>
    (await ask(path, {
      method: "POST",
      headers: { "content-type": "application/json" },
      body: JSON.stringify(json),
    })).json(),
  /** Sends a file and resolves to JSON. */
  upload: async (path, file) =>
    (await ask(path, { method: "POST", headers: { "content-type": "application/octet-stream" }, body: file })).json(),
  /** Opens a websocket, again whenever it ends. `onMessage(data, send)` gets text or an ArrayBuffer; `onState(open, why)` is
   *  told whether it is there, and if not, why. Returns a function that closes it. */
  socket(path, onMessage, onState = () => {}) {
    let socket, timer, closed = false;
    const open = () => {
      socket = new WebSocket(`ws://${location.host}/api${path}`, ["palpate", `token.${token()}`]);
      socket.binaryType = "arraybuffer";
      // One that is not wanted any more is closed when it is open: before, the browser takes that for an error.
      socket.onopen = () => (closed ? socket.close() : onState(true));
      socket.onmessage = (event) => closed || onMessage(event.data, (text) => socket.send(text));
      socket.onclose = async () => {
        if (closed) return;
        // A websocket does not say why it was refused; a question does.
        const why = await ask("/rooms").then(() => "the stream is not there; waiting for it", (error) => error.message);
        if (closed) return;
        onState(false, why);
        timer = setTimeout(open, 500);
      };
    };
    open();
    return () => {
      closed = true;
      clearTimeout(timer);
      if (socket.readyState === WebSocket.OPEN) socket.close();
    };
  },
};
