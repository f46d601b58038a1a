// The last seconds of a session, in bins about a pixel wide, in memory of a fixed size.

export const SIGNALS = 20;
/** Windows that there is room for; when it is full the older half goes. */
const ROOM = 4;
/** Points of a bin: its first value, its extremes in the order in which they came, its last value. */
const POINTS = 4;

/** Reads a binary message of the websocket. */
export function readRows(buffer) {
  const view = new DataView(buffer);
  const [rowsLost, framesDropped, rowsDropped, arrivedMs, first] = [0, 8, 16, 24, 32].map((at) => view.getFloat64(at, true));
  const count = view.getUint32(40, true);
  const times = new Float64Array(buffer, 48, count);
  const gaps = new Float64Array(buffer, 48 + 8 * count, count);
  const values = [];
  for (let signal = 0; signal < view.getUint32(44, true); signal++) {
    values.push(new Float32Array(buffer, 48 + 16 * count + 4 * count * signal, count));
  }
  return { rowsLost, framesDropped, rowsDropped, arrivedMs, first, count, times, gaps, values };
}

/** Reads a view of the session: when each bin begins and ends, how long nothing was known before, and the points of each signal. */
export function readView(buffer) {
  const [count, signals] = new Float64Array(buffer, 0, 2);
  const [from, to, gaps] = [0, 1, 2].map((part) => new Float64Array(buffer, 16 + 8 * count * part, count));
  const courses = Array.from({ length: signals }, (_, signal) =>
    Array.from({ length: POINTS }, (_, point) => new Float32Array(buffer, 16 + 24 * count + 4 * count * (POINTS * signal + point), count)));
  return { count, from, to, gaps, courses };
}

/** A view as columns to draw: the points of each bin spread over its time, and the points before which nothing is known. */
export function columnsOf({ count, from, to, gaps, courses }) {
  const x = new Float64Array(POINTS * count);
  const values = courses.map(() => new Float32Array(POINTS * count));
  const breaks = [];
  for (let bin = 0; bin < count; bin++) {
    const place = POINTS * bin;
    spread(x, place, from[bin], to[bin]);
    if (gaps[bin] > 0 && bin > 0) breaks.push(place);
    for (let signal = 0; signal < values.length; signal++) {
      for (let point = 0; point < POINTS; point++) values[signal][place + point] = courses[signal][point][bin];
    }
  }
  return { x, values, breaks };
}

/** The times of the points of a bin. */
function spread(x, place, from, to) {
  for (let point = 0; point < POINTS - 1; point++) x[place + point] = from + ((to - from) * point) / (POINTS - 1);
  x[place + POINTS - 1] = to;
}

export class Window {
  constructor(seconds, columns) {
    this.resize(seconds, columns);
  }

  /** Forgets everything; from now on for so many seconds in so many bins. */
  resize(seconds, columns) {
    this.seconds = seconds;
    this.width = seconds / columns;
    this.room = ROOM * columns;
    this.x = new Float64Array(POINTS * this.room);
    this.values = Array.from({ length: SIGNALS }, () => new Float32Array(POINTS * this.room));
    /** Whether nothing is known before a bin. */
    this.broken = new Uint8Array(this.room);
    this.bins = 0;
    this.last = -Infinity;
    this.bin = NaN;
    /** Number of the row that comes next. */
    this.next = NaN;
  }

  /** Takes rows of the stream. */
  take({ first, count, times, gaps, values }) {
    const missed = first > this.next;
    this.next = first + count;
    const course = values.map((all) => [all, all, all, all]);
    for (let row = 0; row < count; row++) {
      const gap = row === 0 && missed ? times[0] - this.last : gaps[row];
      this.add(times[row], times[row], gap, course, row);
    }
  }

  /** Takes a view of the session. */
  fill({ count, from, to, gaps, courses }) {
    for (let bin = 0; bin < count; bin++) this.add(from[bin], to[bin], gaps[bin], courses, bin);
  }

  add(from, to, gap, courses, at) {
    if (from <= this.last) return;
    this.last = to;
    const bin = Math.floor(from / this.width);
    // Less than the width of a bin cannot be seen.
    const broken = gap > this.width;
    if (bin === this.bin && !broken) return this.extend(to, courses, at);
    if (this.bins === this.room) this.forget();
    this.bin = bin;
    this.broken[this.bins] = broken ? 1 : 0;
    const place = POINTS * this.bins++;
    spread(this.x, place, from, to);
    for (let signal = 0; signal < SIGNALS; signal++) {
      for (let point = 0; point < POINTS; point++) this.values[signal][place + point] = courses[signal][point][at];
    }
  }

  /** Goes on with the last bin. */
  extend(to, courses, at) {
    const place = POINTS * (this.bins - 1);
    spread(this.x, place, this.x[place], to);
    for (let signal = 0; signal < SIGNALS; signal++) {
      const [, early, late, last] = courses[signal];
      goOn(this.values[signal], place, early[at], late[at], last[at]);
    }
  }

  forget() {
    const half = this.room / 2;
    this.x.copyWithin(0, POINTS * half);
    this.broken.copyWithin(0, half);
    for (const all of this.values) all.copyWithin(0, POINTS * half);
    this.bins -= half;
  }

  /** What is in the window now, to draw. */
  columns() {
    const from = this.last - this.seconds;
    let first = 0;
    while (first < this.bins - 1 && this.x[POINTS * first + POINTS - 1] < from) first++;
    const cut = (all) => all.subarray(POINTS * first, POINTS * this.bins);
    const breaks = [];
    for (let bin = first + 1; bin < this.bins; bin++) if (this.broken[bin]) breaks.push(POINTS * (bin - first));
    return { x: cut(this.x), values: this.values.map(cut), breaks };
  }

  /** The last value of a signal. */
  value(signal) {
    return this.bins ? this.values[signal][POINTS * this.bins - 1] : NaN;
  }
}

/** Takes later extremes and a last value into the points of a bin. */
function goOn(all, place, early, late, last) {
  const [wasEarly, wasLate] = [all[place + 1], all[place + 2]];
  const [low, high] = wasEarly < wasLate ? [wasEarly, wasLate] : [wasLate, wasEarly];
  const [newLow, newHigh] = early < late ? [early, late] : [late, early];
  const [lower, higher] = [newLow < low, newHigh > high];
  if (lower && higher) [all[place + 1], all[place + 2]] = [early, late];
  else if (lower) [all[place + 1], all[place + 2]] = [high, newLow];
  else if (higher) [all[place + 1], all[place + 2]] = [low, newHigh];
  all[place + 3] = last;
}
