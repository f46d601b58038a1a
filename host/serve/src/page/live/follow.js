// The stream of one finger: its rows in a window, its regions and gaps, and from the session what the page has not seen.

import { GAUGES } from "./signals.js";
import { Window, readRows, readView } from "./window.js";

/** Events kept of each kind: regions of a gauge, and gaps. */
const [MOST_REGIONS, MOST_GAPS] = [4_000, 1_000];
/** Later than any row of a session, s. */
const FOR_EVER = 864_000;

/** Follows the stream that `api` reaches.
 *  - `span()`: how many seconds are shown, in how many columns
 *  - `told(health)`: how device and session are; `happened(event)`: a new event; `state(isOpen, why)`: whether the stream is there;
 *    `failed(why)`: the session could not be asked
 *  Returns `{now, regions, gaps, arrivedMs, arrived, refill(), close()}`: the window, the regions of each gauge, what is missing, and
 *  when the last row that was pushed came to the server, ms since 1970, with its session time, s. */
export function follow(api, { span, told, happened, state, failed }) {
  const [seconds, columns] = span();
  const finger = { now: new Window(seconds, columns), regions: noRegions(), gaps: [], arrivedMs: 0, arrived: 0, refill };
  let rowsDropped = 0;
  let newest = 0;
  let waiting = null;
  /** Rows that come while the session is asked. */
  let meanwhile = null;
  finger.close = api.socket("/live/stream", (data, send) => {
    if (typeof data === "string") return heard(JSON.parse(data));
    send("ok");
    const rows = readRows(data);
    if (rows.rowsDropped > rowsDropped) refill();
    rowsDropped = rows.rowsDropped;
    finger.now.take(rows);
    meanwhile?.push(rows);
    if (rows.count) Object.assign(finger, { arrivedMs: rows.arrivedMs, arrived: rows.times[rows.count - 1] });
  }, (isOpen, why) => {
    rowsDropped = 0;
    if (isOpen) refill();
    state(isOpen, why);
  });

  function heard({ health, events }) {
    newest = health.now_s;
    for (const event of events) {
      keep(event);
      happened(event);
    }
    told(health);
  }

  function keep(event) {
    if (event.kind === "state") remember(finger.regions[event.gauge], event, MOST_REGIONS);
    else if (event.kind === "gap") remember(finger.gaps, event, MOST_GAPS);
  }

  /** What the page missed, or has not seen because it looks at a longer stretch now, from the session. */
  async function refill() {
    if (waiting) return;
    waiting = ask();
    await waiting;
    waiting = null;
  }

  async function ask() {
    const [seconds, columns] = span();
    const from = Math.max(0, (Number.isFinite(finger.now.last) ? finger.now.last : newest) - seconds);
    meanwhile = [];
    try {
      const [bytes, events] = await Promise.all([
        api.bytes(`/live/view?from=${from}&to=${FOR_EVER}&bins=${2 * columns}`), api.get(`/live/events?from=${from}&to=${FOR_EVER}`),
      ]);
      Object.assign(finger, { regions: noRegions(), gaps: [] });
      events.forEach(keep);
      finger.now.resize(seconds, columns);
      finger.now.fill(readView(bytes));
      meanwhile.forEach((rows) => finger.now.take(rows));
    } catch (error) {
      failed(error.message);
    }
    meanwhile = null;
  }

  return finger;
}

const noRegions = () => Array.from({ length: GAUGES }, () => []);

function remember(list, item, most) {
  list.push(item);
  if (list.length > most) list.splice(0, most / 2);
}
