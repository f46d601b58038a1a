// What lies under the cursor of a plot, and how far that is from a mark.

import { h, number } from "./dom.js";

/** Between the cursor and the box beside it, px. */
const BESIDE = 12;

/** The box of a plot of `series`, whose values are in `unit` over `unitOfX`, with so many decimals or four digits. */
export function reading(place, series, { unit = "", unitOfX = "s", decimals }) {
  const box = h("div", { class: "plot-reading", "aria-hidden": "true", hidden: true });
  place.append(box);
  let mark = null;

  const told = (value) => (decimals === undefined ? number(value, 4) : value.toFixed(decimals).replace("-", "−"));
  const signed = (value) => (value > 0 ? `+${told(value)}` : told(value));
  const line = (one, value, from) => {
    const far = from === null || from === undefined ? "" : signed(value - from);
    return [h("span", { class: `plot-key plot-key-${one.colour}` }), h("span", {}, one.label), h("span", {}, `${told(value)} ${unit}`), h("span", {}, far)];
  };

  return {
    /** Follows the cursor. */
    show(u, bands) {
      const { idx, left } = u.cursor;
      const at = idx === null || idx === undefined ? undefined : u.data[0][idx];
      box.hidden = at === undefined || left < 0;
      if (box.hidden) return;
      const region = bands.find((band) => band.name && band.from <= at && at <= band.to)?.name;
      const lines = series.flatMap((one, index) => {
        const value = u.data[index + 1][idx];
        const shown = u.series[index + 1].show && value !== null && value !== undefined && Number.isFinite(value);
        return shown && one.label ? line(one, value, mark && mark.values[index]) : [];
      });
      box.replaceChildren(
        h("strong", {}, `${number(at, 5)} ${unitOfX}`, mark ? ` · Δ ${number(at - mark.x, 4)} ${unitOfX}` : ""),
        region ? h("span", { class: "plot-region" }, region) : "",
        h("div", { class: "plot-values" }, lines),
      );
      const beyond = left + BESIDE + box.offsetWidth > u.over.clientWidth;
      const x = u.over.offsetLeft + (beyond ? left - BESIDE - box.offsetWidth : left + BESIDE);
      box.style.transform = `translate(${Math.max(Math.round(x), 0)}px, ${u.over.offsetTop + 4}px)`;
    },
    /** Sets the mark where the cursor is, or takes it away. */
    mark(u) {
      const { idx } = u.cursor;
      mark = mark || idx === null || idx === undefined ? null : { x: u.data[0][idx], values: series.map((_, index) => u.data[index + 1][idx]) };
    },
    /** Draws the mark. */
    draw(u, colour) {
      if (!mark) return;
      const { ctx, bbox } = u;
      const x = Math.round(u.valToPos(mark.x, "x", true)) + 0.5;
      if (x < bbox.left || x > bbox.left + bbox.width) return;
      ctx.save();
      ctx.strokeStyle = colour;
      ctx.setLineDash([6, 4]);
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      ctx.restore();
    },
  };
}
