// uPlot in the colours of the page, with shaded stretches, zoom by dragging, and the width of its place.

/** The colour of a name in the palette (`ink`, `c0`, …), or what the name says itself. */
export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim() || name;
}

/** Draws into `root`:
 *  - `x`: sorted numbers; `series`: `[{label, values, colour, dash, width, show}]`, values as long as x, null for none
 *  - `axes`: `{x: label, y: label}`; `height`: px; `label`: what the figure is, for those who do not see it
 *  - `bands`: `[{from, to, colour, text, foot}]`: shaded stretches of x with words at their head and foot
 *  - `onZoom(from, to)`: x was dragged over; `onZoom(null)`: double click
 *  - `group`: plots of one group share the cursor.
 *  Returns `{set({x, values, bands}), range(from, to), show(index, shown), close()}`. */
export function plot(root, { x, series, axes = {}, bands = [], onZoom, height = 200, label, group, zero }) {
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

  const axis = (text, more) => ({
    label: text, stroke: () => paint("muted"), font: "12px system-ui", labelFont: "12px system-ui", labelGap: 0,
    grid: { stroke: () => paint("grid"), width: 1 }, ticks: { stroke: () => paint("line"), width: 1, size: 4 }, ...more,
  });
  const options = {
    width: Math.max(place.clientWidth, 100), height, legend: { show: false }, pxAlign: 0,
    cursor: {
      sync: group ? { key: group } : undefined, points: { show: false },
      drag: { x: Boolean(onZoom), y: false, setScale: false },
      bind: { dblclick: () => () => { onZoom?.(null); return null; } },
    },
    scales: {
      x: { time: false },
      y: { range: (_, least, most) => padded(least, most, zero) },
    },
    axes: [axis(axes.x, { size: axes.x ? 24 : 22, labelSize: 18 }), axis(axes.y, { size: 52, labelSize: 18 })],
    series: [{}, ...series.map((one) => ({
      label: one.label, show: one.show ?? true, stroke: () => paint(one.colour), width: one.width ?? 1.25,
      dash: one.dash, points: { show: false }, spanGaps: false,
    }))],
    hooks: {
      drawClear: [(u) => shade(u, shaded, paint)],
      setSelect: [(u) => {
        if (!onZoom || u.select.width < 4) return;
        const from = u.posToVal(u.select.left, "x");
        const to = u.posToVal(u.select.left + u.select.width, "x");
        u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
        onZoom(from, to);
      }],
    },
  };
  const u = new window.uPlot(options, [x, ...series.map((one) => one.values)], place);

  const resize = new ResizeObserver(() => {
    const width = place.clientWidth;
    if (width > 0 && width !== u.width) u.setSize({ width, height });
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
    set({ x, values, bands }) {
      if (bands) shaded = bands;
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
