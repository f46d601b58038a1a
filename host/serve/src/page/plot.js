// uPlot in the colours of the page, with shaded stretches, zoom by dragging, and the width of its place.

import { reading } from "./reading.js";

/** Numbers of an axis: few digits, no separators. */
const plain = new Intl.NumberFormat("en", { maximumSignificantDigits: 8, useGrouping: false });

/** The colour of a name in the palette (`ink`, `c0`, …), or what the name says itself. */
export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim() || name;
}

/** Draws into `root`:
 *  - `x`: sorted numbers; `series`: `[{label, values, colour, dash, width, show}]`, values as long as x, null for none
 *  - `axes`: `{x: label, y: label}`; `units`: `{unit, unitOfX}` of what is read under the cursor; `height`: px; `label`: what the
 *    figure is, for those who do not see it
 *  - `bands`: `[{from, to, colour, text, foot, name}]`: shaded stretches of x with words at their head and foot, and under the cursor
 *  - `onZoom(from, to)`: another stretch of x is asked for, by dragging, the wheel with Ctrl, or moving with Shift held;
 *    `onZoom(null)`: double click. A drag that is high as well as wide takes a stretch of y too.
 *  - `group`: plots of one group share the cursor.
 *  - `extent()`: least and greatest y to show, in place of those of the series; null for those.
 *  Returns `{set({x, values, bands, breaks}), range(from, to), show(index, shown), resize(height), canvas(), close()}`; `breaks` are the indices of
 *  the points that no line leads to, because nothing is known before them. */
export function plot(root, { x, series, axes = {}, units = {}, bands = [], onZoom, height = 200, label, group, zero, extent }) {
  const place = document.createElement("div");
  place.className = "plot";
  place.setAttribute("role", "img");
  place.setAttribute("aria-label", label ?? [axes.y, axes.x].filter(Boolean).join(" over "));
  root.append(place);

  let colours = new Map();
  const paint = (name) => {
    if (!colours.has(name)) colours.set(name, colour(name));
    return colours.get(name);
  };
  let shaded = bands;
  let broken = [];
  /** The stretch of y that was taken, or null for all that is drawn. */
  let taken = null;
  const box = reading(place, series, units);
  /** Stretches in px without a line: those of missing values, and those before a break. */
  const gaps = (u, _, first, last, missing) => {
    const at = (point) => u.valToPos(u.data[0][point], "x", true);
    const cuts = broken.filter((point) => point > first && point <= last).map((point) => [at(point - 1), at(point)]);
    return cuts.length ? missing.concat(cuts).sort(([a], [b]) => a - b) : missing;
  };

  const axis = (text, more) => ({
    label: text, stroke: () => paint("muted"), font: "12px system-ui", labelFont: "12px system-ui", labelGap: 0,
    values: (_, splits) => splits.map((value) => (value === null ? "" : plain.format(value).replace("-", "−"))),
    grid: { stroke: () => paint("grid"), width: 1 }, ticks: { stroke: () => paint("line"), width: 1, size: 4 }, ...more,
  });
  const options = {
    width: Math.max(place.clientWidth, 100), height, legend: { show: false }, pxAlign: 0,
    cursor: {
      sync: group ? { key: group } : undefined, points: { show: false },
      drag: { x: Boolean(onZoom), y: Boolean(onZoom), uni: 40, setScale: false },
      bind: {
        dblclick: () => () => { taken = null; onZoom?.(null); return null; },
        mousedown: (u, _, handler) => (event) => (event.shiftKey && onZoom ? carry(u, event) : handler(event)),
      },
    },
    scales: {
      x: { time: false },
      y: { range: (_, least, most) => taken ?? padded(...(extent?.() ?? [least, most]), zero) },
    },
    axes: [axis(axes.x, { size: axes.x ? 24 : 22, labelSize: 18 }), axis(axes.y, { size: 52, labelSize: 18 })],
    series: [{}, ...series.map((one) => ({
      label: one.label, show: one.show ?? true, stroke: () => paint(one.colour), width: one.width ?? 1.25,
      dash: one.dash, points: { show: false }, spanGaps: false, gaps,
    }))],
    hooks: {
      drawClear: [(u) => shade(u, shaded, paint)],
      draw: [(u) => box.draw(u, paint("ink"))],
      setCursor: [(u) => box.show(u, shaded)],
      setSelect: [(u) => select(u)],
    },
  };
  const u = new window.uPlot(options, [x, ...series.map((one) => one.values)], place);
  u.over.addEventListener("wheel", turned, { passive: false });
  u.over.addEventListener("click", clicked);

  function select(u) {
    const { left, top, width, height: high } = u.select;
    if (!onZoom || Math.max(width, high) < 4) return;
    const all = { wide: width >= u.over.clientWidth - 1, high: high >= u.over.clientHeight - 1 };
    const [from, to] = [left, left + width].map((at) => u.posToVal(at, "x"));
    if (!all.high) taken = [top + high, top].map((at) => u.posToVal(at, "y"));
    u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    if (all.wide) u.redraw(false, true);
    else onZoom(from, to);
    if (!all.high) u.setScale("y", { min: taken[0], max: taken[1] });
  }

  /** The plot goes with the pointer until the button is let go. */
  function carry(u, event) {
    const { min, max } = u.scales.x;
    const y = { ...u.scales.y };
    const [perX, perY] = [(max - min) / u.over.clientWidth, (y.max - y.min) / u.over.clientHeight];
    const begin = { x: event.clientX, y: event.clientY };
    const moved = (now) => {
      const [dx, dy] = [(begin.x - now.clientX) * perX, (now.clientY - begin.y) * perY];
      if (Math.abs(now.clientY - begin.y) > 3) taken = [y.min + dy, y.max + dy];
      onZoom(min + dx, max + dx);
    };
    addEventListener("mousemove", moved);
    addEventListener("mouseup", () => removeEventListener("mousemove", moved), { once: true });
  }

  /** The wheel zooms about the pointer with Ctrl, in y with Alt as well, and moves along x with Shift. Alone it scrolls the page. */
  function turned(event) {
    if (!onZoom || !(event.ctrlKey || event.shiftKey)) return;
    event.preventDefault();
    const by = event.deltaY || event.deltaX;
    const about = (scale, at, factor) => [at - (at - u.scales[scale].min) * factor, at + (u.scales[scale].max - at) * factor];
    const factor = Math.exp(by / 400);
    if (event.ctrlKey && event.altKey) {
      taken = about("y", u.posToVal(event.offsetY, "y"), factor);
      u.setScale("y", { min: taken[0], max: taken[1] });
    } else if (event.ctrlKey) onZoom(...about("x", u.posToVal(event.offsetX, "x"), factor));
    else {
      const { min, max } = u.scales.x;
      const step = ((max - min) * by) / 1000;
      onZoom(min + step, max + step);
    }
  }

  let pressedAt = 0;
  u.over.addEventListener("mousedown", (event) => (pressedAt = event.clientX));
  /** A click, not a drag, sets a mark, or takes it away. */
  function clicked(event) {
    if (Math.abs(event.clientX - pressedAt) > 3 || event.shiftKey) return;
    box.mark(u);
    box.show(u, shaded);
    u.redraw(false, false);
  }

  const resize = new ResizeObserver(() => {
    const width = place.clientWidth;
    if (width > 0 && width !== u.width) u.setSize({ width, height: u.height });
  });
  resize.observe(place);
  const themed = () => {
    colours = new Map();
    u.redraw(false, true);
  };
  document.addEventListener("palpate-theme", themed);
  // On paper everything is light.
  const paper = matchMedia("print");
  paper.addEventListener("change", themed);

  let shownRange = null;
  return {
    set({ x, values, bands, breaks = [] }) {
      if (bands) shaded = bands;
      if (x) broken = breaks;
      if (x) u.setData([x, ...values], shownRange === null);
      else u.redraw(false, false);
    },
    range(from, to) {
      shownRange = [from, to];
      u.setScale("x", { min: from, max: to });
    },
    show(index, shown) {
      u.setSeries(index + 1, { show: shown });
    },
    resize(height) {
      if (height !== u.height) u.setSize({ width: u.width, height });
    },
    canvas: () => u.ctx.canvas,
    close() {
      resize.disconnect();
      document.removeEventListener("palpate-theme", themed);
      paper.removeEventListener("change", themed);
      u.destroy();
      place.remove();
    },
  };
}

/** A little room above and below; a flat line is in the middle. */
function padded(least, most, zero) {
  if (least === null || most === null) return [-1, 1];
  const [low, high] = zero ? [Math.min(least, 0), Math.max(most, 0)] : [least, most];
  const room = Math.max((high - low) * 0.08, Math.abs(high) * 1e-6, 1e-9);
  return [low - room, high + room];
}

function shade(u, bands, paint) {
  const { ctx } = u;
  const { left, top, width, height } = u.bbox;
  const scale = devicePixelRatio;
  ctx.save();
  ctx.beginPath();
  ctx.rect(left, top, width, height);
  ctx.clip();
  ctx.font = `${11 * scale}px system-ui`;
  ctx.textAlign = "left";
  ctx.textBaseline = "alphabetic";
  for (const { from, to, colour, text, foot } of bands) {
    const begin = Math.max(u.valToPos(from, "x", true), left);
    const end = Math.min(u.valToPos(to, "x", true), left + width);
    if (end <= begin) continue;
    if (colour) {
      ctx.globalAlpha = 0.13;
      ctx.fillStyle = paint(colour);
      ctx.fillRect(begin, top, Math.max(end - begin, scale), height);
    }
    ctx.globalAlpha = 1;
    ctx.fillStyle = paint("muted");
    const room = end - begin - 6 * scale;
    if (text && ctx.measureText(text).width < room) ctx.fillText(text, begin + 3 * scale, top + 12 * scale);
    if (foot && ctx.measureText(foot).width < room) ctx.fillText(foot, begin + 3 * scale, top + height - 4 * scale);
  }
  ctx.restore();
}
