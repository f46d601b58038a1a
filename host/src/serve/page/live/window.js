// The last seconds of a session, in bins about a pixel wide, in memory of a fixed size.

export const SIGNALS = 20;
/** Windows that there is room for; when it is full the older half goes. */
const ROOM = 4;

/** Reads a binary message of the websocket. */
export function readRows(buffer) {
  const view = new DataView(buffer);
  const [rowsLost, framesDropped, rowsDropped, arrivedMs, first] = [0, 8, 16, 24, 32].map((at) => view.getFloat64(at, true));
  const count = view.getUint32(40, true);
  const times = new Float64Array(buffer, 48, count);
  const values = [];
  for (let signal = 0; signal < view.getUint32(44, true); signal++) {
    values.push(new Float32Array(buffer, 48 + 8 * count + 4 * count * signal, count));
  }
  return { rowsLost, framesDropped, rowsDropped, arrivedMs, first, count, times, values };
}

/** Reads a view of the session: for each bin its time, and of each signal the least and the greatest. */
export function readView(buffer) {
  const [count, signals] = new Float64Array(buffer, 0, 2);
  const times = new Float64Array(buffer, 16, count);
  const least = [], greatest = [];
  for (let signal = 0; signal < signals; signal++) {
    const at = 16 + 8 * count + 8 * count * signal;
    least.push(new Float32Array(buffer, at, count));
    greatest.push(new Float32Array(buffer, at + 4 * count, count));
  }
  return { count, times, least, greatest };
}

/** A view as columns to draw: each bin twice, once with its least and once with its greatest. */
export function columnsOf({ count, times, least, greatest }) {
  const x = new Float64Array(2 * count);
  for (let bin = 0; bin < count; bin++) {
    const end = bin + 1 < count ? times[bin + 1] : times[bin];
    x[2 * bin] = times[bin];
    x[2 * bin + 1] = (times[bin] + end) / 2;
  }
  const values = least.map((least, signal) => {
    const all = new Float32Array(2 * count);
    for (let bin = 0; bin < count; bin++) {
      all[2 * bin] = least[bin];
      all[2 * bin + 1] = greatest[signal][bin];
    }
    return all;
  });
  return { x, values };
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
    this.x = new Float64Array(2 * this.room);
    this.values = Array.from({ length: SIGNALS }, () => new Float32Array(2 * this.room));
    this.bins = 0;
    this.last = -Infinity;
    this.bin = NaN;
  }

  /** Takes rows of the stream. */
  take({ count, times, values }) {
    for (let row = 0; row < count; row++) this.add(times[row], values, values, row);
  }

  /** Takes a view of the session. */
  fill({ count, times, least, greatest }) {
    for (let bin = 0; bin < count; bin++) this.add(times[bin], least, greatest, bin);
  }

  add(time, least, greatest, at) {
    if (time < this.last) return;
    this.last = time;
    const bin = Math.floor(time / this.width);
    if (bin !== this.bin) {
      if (this.bins === this.room) this.forget();
      this.bin = bin;
      const place = 2 * this.bins++;
      this.x[place] = time;
      this.x[place + 1] = time;
      for (let signal = 0; signal < SIGNALS; signal++) {
        this.values[signal][place] = least[signal][at];
        this.values[signal][place + 1] = greatest[signal][at];
      }
      return;
    }
    const place = 2 * this.bins - 2;
    this.x[place + 1] = time;
    for (let signal = 0; signal < SIGNALS; signal++) {
      const all = this.values[signal];
      if (least[signal][at] < all[place]) all[place] = least[signal][at];
      if (greatest[signal][at] > all[place + 1]) all[place + 1] = greatest[signal][at];
    }
  }

  forget() {
    const half = this.room / 2;
    this.x.copyWithin(0, 2 * half);
    for (const all of this.values) all.copyWithin(0, 2 * half);
    this.bins -= half;
  }

  /** What is in the window now, to draw. */
  columns() {
    const from = this.last - this.seconds;
    let first = 0;
    while (first < this.bins - 1 && this.x[2 * first + 1] < from) first++;
    const cut = (all) => all.subarray(2 * first, 2 * this.bins);
    return { x: cut(this.x), values: this.values.map(cut) };
  }

  /** The last value of a signal. */
  value(signal) {
    return this.bins ? this.values[signal][2 * this.bins - 1] : NaN;
  }
}
