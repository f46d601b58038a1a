// One trace: measurement and model, the residual below, regions shaded, zoom linked.

import { plot } from "../plot.js";
import { h, number, quantity } from "../dom.js";
import { picture as asPicture, table } from "../save.js";

const SHADES = { loading: "c2", "early hold": "c4", "late hold": "c0", unloading: "c3" };
const MOST_NAMED = 12;
/** Heights of measurement and residual, px. */
const [UPPER, LOWER] = [280, 170];
/** When to ask again for regions that are still being looked for, ms. */
const AGAIN = 1000;

/**
 * The plots of one trace. `picker` stands before the buttons; `ask(path)` fetches; `fail(error)` hears what went wrong; `trace()` gives its number. `update(info)` draws anew with
 * `{trace, label, signal, unit, noise, beside}`; `go(from, to)` zooms; `hover(effect)` lays a candidate's forecast over.
 */
export function overlay(root, picker, ask, fail) {
  const place = h("div", { class: "lab-plots" });
  const told = h("p", { class: "lab-legend", "aria-live": "polite" });
  const buttons = h(
    "div",
    { class: "tools" },
    picker,
    h("button", { onclick: () => go(null, null) }, "Whole trace"),
    h("button", { onclick: () => scale(0.5), "aria-label": "Zoom in" }, "+"),
    h("button", { onclick: () => scale(2), "aria-label": "Zoom out" }, "−"),
    h("button", { onclick: () => pan(-0.5), "aria-label": "Earlier" }, "◀"),
    h("button", { onclick: () => pan(0.5), "aria-label": "Later" }, "▶"),
    h("button", { class: "lab-picture", onclick: () => save(picture), title: "This view as a picture (PNG)" }, "Picture"),
    h("button", { class: "lab-data", onclick: () => save(points), title: "The points of this view as a table (CSV)" }, "Data"),
  );
  root.append(buttons, told, place);
  let info = null;
  let shown = { from: null, to: null };
  let data = null;
  let forecast = null;
  /** What was asked for what is drawn: a forecast is of the same pixels. */
  let asFor = "";
  let plots = null;
  let flight = null;
  let wanted = false;
  let again;

  /** Asks for what is to be seen. One question is under way at a time; when it is answered, the latest is asked next. */
  function load() {
    wanted = true;
    flight ??= fly().catch(fail).finally(() => (flight = null));
    return flight;
  }

  async function fly() {
    while (wanted) {
      wanted = false;
      const [mine, asked] = [info, query()];
      const found = await ask(`/lab/overlay?${asked}`);
      if (mine !== info) continue;
      [data, forecast, asFor] = [found, null, asked];
      draw();
      // The pointer or the focus may have been there before what is drawn.
      if (hovered) hover(hovered);
    }
    clearTimeout(again);
    if (data && data.regions === null) again = setTimeout(load, AGAIN);
  }

  function query() {
    const range = shown.from === null ? "" : `&from=${shown.from}&to=${shown.to}`;
    const width = Math.max(place.clientWidth - 60, 200);
    return `trace=${info.trace}&width=${width}${range}`;
  }

  function draw() {
    const fits = Boolean(data.predicted);
    if (!plots || plots.fits !== fits || plots.signal !== info.signal || plots.label !== info.label) build(fits);
    const regions = data.regions ?? [];
    const few = regions.length <= MOST_NAMED;
    const bands = regions
      .filter(([, , name]) => SHADES[name])
      .map(([from, to, name]) => ({ from, to, colour: SHADES[name], name, text: few || shown.from !== null ? name : "" }));
    const same = forecast && forecast.time.length === data.time.length;
    const none = data.time.map(() => null);
    const level = (value) => data.time.map(() => value);
    const other = info.beside && data.beside?.time.length === data.time.length ? data.beside : null;
    const above = [data.measured, ...(fits ? [other?.predicted ?? none, data.predicted, same ? forecast.foretold : none] : [])];
    plots.upper.set({ x: data.time, values: above, bands });
    plots.upper.range(shown.from ?? data.whole[0], shown.to ?? data.whole[1]);
    if (fits) {
      const noise = info.noise ?? null;
      const below = [other?.residual ?? none, data.residual, same ? forecast.left : none, level(noise), level(noise === null ? null : -noise)];
      plots.lower.set({ x: data.time, values: below, bands: bands.map((band) => ({ ...band, text: "" })) });
      plots.lower.range(shown.from ?? data.whole[0], shown.to ?? data.whole[1]);
    }
    legend(fits, same, other);
  }

  function build(fits) {
    plots?.upper.close();
    plots?.lower?.close();
    const group = "lab";
    const onZoom = (from, to) => go(from, to ?? null);
    const model = [
      { label: "other model", colour: "c3", dash: [9, 3, 2, 3], width: 1.6 },
      { label: "model", colour: "c1", width: 1.6 },
      { label: "predicted", colour: "c2", dash: [6, 3], width: 1.6 },
    ].map((one) => ({ ...one, values: [] }));
    const upper = plot(place, {
      x: [],
      series: [{ label: "measured", colour: "ink", values: [] }, ...(fits ? model : [])],
      axes: { x: fits ? "" : "time, s", y: quantity(info.signal, info.unit) },
      units: { unit: info.unit },
      // Until there is a residual its room is the measurement's.
      height: fits ? UPPER : UPPER + LOWER,
      label: `${info.label}: measured${fits ? " and model" : ""} over time`,
      onZoom,
      group,
    });
    const residual = [
      { label: "residual of the other", colour: "c3" },
      { label: "residual", colour: "c0" },
      { label: "predicted", colour: "c2" },
      { label: "noise", colour: "muted", dash: [4, 4] },
      { label: "", colour: "muted", dash: [4, 4] },
    ].map((one) => ({ ...one, values: [] }));
    const lower = fits
      ? plot(place, {
          x: [],
          series: residual,
          axes: { x: "time, s", y: `residual, ${info.unit}` },
          units: { unit: info.unit },
          height: LOWER,
          label: `${info.label}: measured minus model over time`,
          onZoom,
          group,
          zero: true,
        })
      : null;
    plots = { upper, lower, fits, signal: info.signal, label: info.label };
  }

  function legend(fits, foretold, other) {
    const key = (name, text) => h("span", { class: `lab-key lab-key-${name}` }, text);
    told.replaceChildren(
      ...[
        key("measured", "measured"),
        fits && key("model", "model"),
        fits && key("residual", "residual"),
        fits && info.noise && key("floor", "noise"),
        other && key("other", `other model: ${info.beside}`),
        ...Object.entries(SHADES).filter(([name]) => data.regions?.some(([, , of]) => of === name)).map(([name, shade]) => h("span", { class: `lab-key lab-shade lab-shade-${shade}` }, name)),
        data.regions === null && h("span", { class: "muted" }, "regions are being looked for …"),
        foretold && key("foretold", `with ${forecast.effect} (${forecast.law}), predicted: ${number(forecast.rms)} ${info.unit} RMS`),
      ].filter(Boolean),
    );
  }

  const save = (how) => data && Promise.resolve(how(`${info.label.replace(/\.csv$/, "")}-${info.signal}`)).catch(fail);

  function picture(name) {
    const heading = `${info.label}: ${quantity(info.signal, info.unit)}${plots.fits ? ", measured and model" : ""}`;
    const residual = plots.lower ? [{ drawn: plots.lower, heading: `residual, ${info.unit}` }] : [];
    return asPicture(name, [{ drawn: plots.upper, heading }, ...residual]);
  }

  function points(name) {
    const modelled = plots.fits ? [[`predicted_${info.unit}`, data.predicted], [`residual_${info.unit}`, data.residual]] : [];
    table(name, [["time_s", data.time], [info.signal, data.measured], ...modelled]);
  }

  function go(from, to) {
    shown = to === null ? { from: null, to: null } : { from, to };
    return info ? load() : null;
  }

  const range = () => [shown.from ?? data.whole[0], shown.to ?? data.whole[1]];

  function scale(factor) {
    if (!data) return;
    const [from, to] = range();
    const [middle, half] = [(from + to) / 2, ((to - from) / 2) * factor];
    clamped(middle - half, middle + half);
  }

  function pan(part) {
    if (!data) return;
    const [from, to] = range();
    clamped(from + part * (to - from), to + part * (to - from));
  }

  function clamped(from, to) {
    const [first, last] = data.whole;
    if (to - from >= last - first) return go(null, null);
    const shift = Math.max(first - from, 0) + Math.min(last - to, 0);
    go(from + shift, to + shift);
  }

  let waiting;
  let hovered = null;
  function hover(effect) {
    clearTimeout(waiting);
    hovered = effect;
    if (!info || !data?.predicted) return;
    waiting = setTimeout(async () => {
      const mine = data;
      const found = effect && (await ask(`/lab/forecast?effect=${encodeURIComponent(effect)}&${asFor}`).catch(() => null));
      if (mine !== data || effect !== hovered) return;
      forecast = found;
      draw();
    }, effect ? 60 : 0);
  }

  return {
    update(next) {
      const other = !info || info.trace !== next.trace || info.label !== next.label;
      info = next;
      if (other) shown = { from: null, to: null };
      return load();
    },
    go,
    hover,
    scale,
    pan,
    /** Where a region begins and ends in the whole trace, s; none where it is not known. */
    extent: (name) => data?.extents?.[name] ?? null,
    close() {
      clearTimeout(waiting);
      clearTimeout(again);
      plots?.upper.close();
      plots?.lower?.close();
    },
  };
}
