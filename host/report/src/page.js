
"use strict";
// Makes the figures of a report answer: crosshair with values, zoom, legend, download. Without this
// script the page shows the same figures, still. Positions are in user units of the picture, 640 across.
(() => {
  const WIDTH = 640;
  const SVG = "http://www.w3.org/2000/svg";
  const DIGITS = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  const round = v => Math.round(Math.max(-1e5, Math.min(1e5, v)) * 100) / 100;
  const minus = text => String(text).replace(/-/g, "−");
  const superscript = n => String(n).replace(/-/, "⁻").replace(/\d/g, d => DIGITS[d]);

  function element(name, attributes, parent) {
    const node = document.createElementNS(SVG, name);
    for (const key in attributes) node.setAttribute(key, attributes[key]);
    if (parent) parent.append(node);
    return node;
  }

  function html(name, className, text, parent) {
    const node = document.createElement(name);
    if (className) node.className = className;
    if (text !== undefined) node.textContent = text;
    if (parent) parent.append(node);
    return node;
  }

  // ---- axes -------------------------------------------------------------------------------------------

  const share = (axis, v) => axis.log
    ? (v > 0 ? Math.log(v / axis.range[0]) / Math.log(axis.range[1] / axis.range[0]) : NaN)
    : (v - axis.range[0]) / (axis.range[1] - axis.range[0]);
  const at = (axis, v) => v === null ? NaN : axis.drawn[0] + share(axis, v) * (axis.drawn[1] - axis.drawn[0]);
  const holds = (axis, v) => { const s = share(axis, v); return s >= -1e-9 && s <= 1 + 1e-9; };

  function value(axis, position) {
    const s = (position - axis.drawn[0]) / (axis.drawn[1] - axis.drawn[0]);
    const [low, high] = axis.range;
    return axis.log ? low * Math.pow(high / low, s) : low + s * (high - low);
  }

  function linearTicks([low, high], target, exponent) {
    const raw = (high - low) / target;
    let power = Math.floor(Math.log10(raw));
    let factor = [1, 2, 5].find(f => f * Math.pow(10, power) >= raw * (1 - 1e-9));
    if (!factor) { factor = 1; power += 1; }
    const size = Number(`${factor}e${power}`);
    const ticks = [];
    for (let k = Math.ceil(low / size - 1e-9); k <= high / size + 1e-9 && ticks.length < 50; k++) {
      const decimals = Math.min(20, Math.max(0, exponent - power));
      const shown = Number(`${k * factor}e${power - exponent}`).toFixed(decimals);
      ticks.push([Number(`${k * factor}e${power}`), minus(Number(shown) === 0 ? shown.replace("-", "") : shown)]);
    }
    return ticks;
  }

  function ticks(axis, target) {
    const [low, high] = axis.range;
    if (!axis.log || Math.log10(high / low) < 0.7) return linearTicks(axis.range, target, axis.exponent);
    const from = Math.ceil(Math.log10(low) - 1e-9), to = Math.floor(Math.log10(high) + 1e-9);
    const decades = Math.max(0, to - from + 1), every = Math.max(1, Math.ceil(decades / target));
    const found = [];
    for (let d = from - 1; d <= to; d++) {
      if ((((d - from) % every) + every) % every) continue;
      for (const f of decades * 3 <= target + 1 ? [1, 2, 5] : [1]) {
        const v = Number(`${f}e${d}`);
        if (!holds(axis, v)) continue;
        const plain = d >= -3 && d <= 4;
        found.push([v, plain ? v.toFixed(Math.max(0, -d)) : `${f === 1 ? "" : f + "×"}10${superscript(d)}`]);
      }
    }
    return found;
  }

  function fittingTicks(axis, length, room) {
    for (let target = Math.max(2, Math.floor(length / room(""))); target > 2; target--) {
      const found = ticks(axis, target);
      const widest = Math.max(0, ...found.map(t => room(t[1])));
      if (Math.max(1, found.length - 1) * widest <= length) return found;
    }
    return ticks(axis, 2);
  }

  // ---- numbers ----------------------------------------------------------------------------------------

  function show(v, unit) {
    if (v === null || !Number.isFinite(v)) return "–";
    const size = Math.abs(v);
    let text = size !== 0 && (size < 1e-4 || size >= 1e6) ? v.toExponential(4) : Number(v.toPrecision(5)).toString();
    text = text.replace(/e([+-]?\d+)/, (_, e) => "×10" + superscript(Number(e)));
    return text.replace("-", "−") + (unit ? " " + unit : "");
  }

  function showSample(series, i, unit) {
    if (series.kind === "band") return `${show(series.y[i])} … ${show(series.other[i], unit)}`;
    if (series.kind === "bars") return `${show(series.y[i])} ± ${show(series.other[i], unit)}`;
    return show(series.y[i], unit);
  }

  // ---- curves -----------------------------------------------------------------------------------------

  function linePath(points) {
    let d = "", run = 0;
    const lift = () => { if (run === 1) d += "m-1 0h2"; run = 0; };
    for (const [x, y] of points) {
      if (!Number.isFinite(x) || !Number.isFinite(y)) { lift(); continue; }
      d += `${run++ ? "L" : "M"}${round(x)} ${round(y)}`;
    }
    lift();
    return d;
  }

  function stairs(points) {
    const out = [];
    points.forEach((p, i) => {
      if (i && Number.isFinite(points[i - 1][1]) && Number.isFinite(p[1])) out.push([p[0], points[i - 1][1]]);
      out.push(p);
    });
    return out;
  }

  function bandPath(points, upper) {
    let d = "", run = [];
    const close = () => {
      if (run.length) d += linePath([...run.map(i => points[i]), ...run.reverse().map(i => [points[i][0], upper[i]])]) + "z";
      run = [];
    };
    points.forEach((p, i) => [p[0], p[1], upper[i]].every(Number.isFinite) ? run.push(i) : close());
    close();
    return d;
  }

  function barPath(x, series, yAxis) {
    let d = "";
    x.forEach((px, i) => {
      const error = Math.abs(series.other[i]);
      const low = at(yAxis, series.y[i] - error), high = at(yAxis, series.y[i] + error);
      if (series.other[i] === null || ![px, low, high].every(Number.isFinite)) return;
      for (const y of [low, high]) d += `M${round(px - 3)} ${round(y)}h6`;
      d += `M${round(px)} ${round(low)}V${round(high)}`;
    });
    return d;
  }

  // ---- one figure -------------------------------------------------------------------------------------

  class Plot {
    constructor(figure, data) {
      this.figure = figure;
      this.canvas = figure.querySelector(".canvas");
      this.svg = figure.querySelector("svg");
      this.x = data.x;
      this.panels = data.panels.map((panel, i) => ({
        ...panel, node: this.svg.querySelector(`[data-panel="${i}"]`), last: i === data.panels.length - 1,
        series: panel.series.map(s => ({ ...s, x: data.columns[s.x], hidden: false })),
      }));
      const forward = new Map(data.columns.map(c => [c, c.every((v, i) => v !== null && (!i || v >= c[i - 1]))]));
      for (const series of this.series()) series.forward = forward.get(series.x);
      for (const axis of [this.x, ...this.panels.map(p => p.y)]) axis.home = [...axis.range];
      this.top = Math.min(...this.panels.map(p => p.y.drawn[1]));
      this.bottom = Math.max(...this.panels.map(p => p.y.drawn[0]));
      this.overlay = element("g", {}, this.svg);
      this.values = html("div", "values", undefined, figure);
      this.values.hidden = true;
      this.spoken = html("div", "spoken", undefined, figure);
      this.spoken.setAttribute("aria-live", "polite");
      figure.classList.add("live");
      this.svg.setAttribute("role", "group");
      this.canvas.tabIndex = 0;
      this.canvas.setAttribute("role", "application");
      this.canvas.setAttribute("aria-roledescription", "plot");
      this.canvas.setAttribute("aria-label", this.svg.getAttribute("aria-label")
        + " Left and right arrows read values, plus and minus zoom, 0 shows all.");
      this.listen();
      this.legends();
    }

    series() { return this.panels.flatMap(p => p.series); }

    listen() {
      const svg = this.svg;
      svg.addEventListener("pointermove", e => this.move(e));
      svg.addEventListener("pointerleave", () => { if (!this.drag) this.hide(); });
      svg.addEventListener("pointerdown", e => this.down(e));
      svg.addEventListener("pointerup", e => this.up(e));
      svg.addEventListener("pointercancel", () => { this.drag = null; this.hide(); });
      svg.addEventListener("dblclick", e => { if (!e.target.closest("[data-legend]")) this.reset(); });
      svg.addEventListener("wheel", e => this.wheel(e), { passive: false });
      this.canvas.addEventListener("keydown", e => this.key(e));
      this.canvas.addEventListener("blur", () => this.hide());
    }

    legends() {
      this.panels.forEach(panel => panel.node.querySelectorAll("[data-legend]").forEach(node => {
        const series = panel.series[node.dataset.legend];
        const box = node.getBBox();
        element("rect", { x: box.x - 2, y: box.y - 1, width: box.width + 4, height: box.height + 2,
          fill: "transparent", class: "hit" }, node);
        node.setAttribute("tabindex", "0");
        node.setAttribute("role", "button");
        node.setAttribute("aria-label", "Show " + series.name);
        node.setAttribute("aria-pressed", "true");
        const toggle = () => {
          series.hidden = !series.hidden;
          node.classList.toggle("off", series.hidden);
          node.setAttribute("aria-pressed", String(!series.hidden));
          panel.node.querySelector(`[data-series="${node.dataset.legend}"]`).style.display = series.hidden ? "none" : "";
          this.hide();
        };
        node.addEventListener("click", toggle);
        node.addEventListener("keydown", e => {
          if (e.key !== "Enter" && e.key !== " ") return;
          e.preventDefault();
          e.stopPropagation();
          toggle();
        });
      }));
    }

    // ---- pointer and keys

    point(event) {
      const box = this.svg.getBoundingClientRect();
      const scale = WIDTH / box.width;
      return [(event.clientX - box.left) * scale, (event.clientY - box.top) * scale];
    }

    panelAt(y) { return this.panels.find(p => y >= p.y.drawn[1] && y <= p.y.drawn[0]); }

    inside([x, y]) {
      return x >= this.x.drawn[0] - 4 && x <= this.x.drawn[1] + 4 && y >= this.top && y <= this.bottom;
    }

    down(event) {
      const here = this.point(event);
      if (event.button || event.pointerType === "touch" || !this.inside(here)) return;
      if (event.target.closest("[data-legend]")) return;
      this.drag = { from: here, panel: this.panelAt(here[1]) };
      this.svg.setPointerCapture(event.pointerId);
    }

    selection(here) {
      const clamp = (v, a, b) => Math.min(Math.max(v, Math.min(a, b)), Math.max(a, b));
      const { from, panel } = this.drag;
      const x = [from[0], here[0]].map(v => clamp(v, ...this.x.drawn)).sort((a, b) => a - b);
      const boxed = panel && Math.abs(here[1] - from[1]) > Math.max(24, 0.15 * (panel.y.drawn[0] - panel.y.drawn[1]));
      const y = boxed ? [from[1], here[1]].map(v => clamp(v, ...panel.y.drawn)).sort((a, b) => a - b) : null;
      return { x, y };
    }

    move(event) {
      const here = this.point(event);
      if (!this.drag) return this.inside(here) ? this.read(here[0], here[1]) : this.hide();
      this.hide();
      const { x, y } = this.selection(here);
      const [top, bottom] = y || [this.top, this.bottom];
      element("rect", { class: "zoom", x: x[0], y: top, width: x[1] - x[0], height: bottom - top }, this.overlay);
    }

    up(event) {
      if (!this.drag) return;
      const { x, y } = this.selection(this.point(event));
      const panel = this.drag.panel;
      this.drag = null;
      this.hide();
      if (x[1] - x[0] < 6) return;
      const range = x.map(v => value(this.x, v));
      if (y) panel.y.range = [value(panel.y, y[1]), value(panel.y, y[0])];
      this.x.range = range;
      this.draw();
    }

    wheel(event) {
      const here = this.point(event);
      const wanted = event.ctrlKey || event.metaKey || this.canvas.contains(document.activeElement);
      if (!wanted || !this.inside(here)) return;
      event.preventDefault();
      this.zoom(Math.pow(1.0015, event.deltaY), here[0]);
    }

    key(event) {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const middle = this.at === undefined ? (this.x.drawn[0] + this.x.drawn[1]) / 2 : at(this.x, this.at);
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      const actions = {
        "+": () => this.zoom(0.7, middle), "=": () => this.zoom(0.7, middle),
        "-": () => this.zoom(1 / 0.7, middle), "0": () => this.reset(),
        Home: () => this.read(this.x.drawn[0]), End: () => this.read(this.x.drawn[1]),
        Escape: () => this.hide(),
      };
      const action = step ? () => event.shiftKey ? this.pan(0.2 * step) : this.step(step) : actions[event.key];
      if (!action) return;
      event.preventDefault();
      action();
      if (!this.values.hidden) this.spoken.textContent = this.values.dataset.words;
    }

    /// Moves the crosshair to the next sample that is at least one unit away.
    step(direction) {
      const now = this.at === undefined ? this.x.drawn[direction > 0 ? 0 : 1] - direction : at(this.x, this.at);
      let best = null;
      for (const series of this.series().filter(s => !s.hidden)) {
        for (const v of series.x) {
          const gap = (at(this.x, v) - now) * direction;
          if (gap >= 0.999 && holds(this.x, v) && (best === null || gap < best)) best = gap;
        }
      }
      if (best !== null) this.read(now + best * direction);
    }

    // ---- range

    /// Scales the x range about a position, never beyond where it began.
    zoom(factor, position) {
      const s = (position - this.x.drawn[0]) / (this.x.drawn[1] - this.x.drawn[0]);
      const width = this.x.drawn[1] - this.x.drawn[0];
      const ends = [position - s * width * factor, position + (1 - s) * width * factor];
      this.limit(ends.map(e => value(this.x, e)));
    }

    pan(portion) {
      const width = this.x.drawn[1] - this.x.drawn[0];
      const [low, high] = this.x.drawn.map(e => value(this.x, e + portion * width));
      if (low >= this.x.home[0] && high <= this.x.home[1]) this.limit([low, high]);
      else if (portion < 0) this.limit([this.x.home[0], value(this.x, this.x.drawn[1] - (at(this.x, this.x.range[0]) - at(this.x, this.x.home[0])))]);
      else this.limit([value(this.x, this.x.drawn[0] + (at(this.x, this.x.home[1]) - at(this.x, this.x.range[1]))), this.x.home[1]]);
    }

    limit([low, high]) {
      low = Math.max(low, this.x.home[0]);
      high = Math.min(high, this.x.home[1]);
      const finest = 1e-9 * Math.max(Math.abs(low), Math.abs(high), this.x.home[1] - this.x.home[0]);
      if (!(high - low > finest)) return;
      this.x.range = [low, high];
      this.draw();
    }

    reset() {
      for (const axis of [this.x, ...this.panels.map(p => p.y)]) axis.range = [...axis.home];
      this.draw();
    }

    // ---- drawing

    draw() {
      const spot = this.at;
      this.hide();
      for (const panel of this.panels) {
        this.drawTicks(panel);
        this.drawCurves(panel);
        this.place(panel);
      }
      if (spot !== undefined && holds(this.x, spot) && document.activeElement === this.canvas) this.read(at(this.x, spot));
    }

    drawTicks(panel) {
      const [left, right] = this.x.drawn, [bottom, top] = panel.y.drawn;
      const line = (kind, x1, y1, x2, y2, parent) => element("line",
        { class: kind, x1: round(x1), y1: round(y1), x2: round(x2), y2: round(y2) }, parent);
      const label = (x, y, anchor, text, parent) => {
        element("text", { class: "pl-text pl-num", x: round(x), y: round(y), "text-anchor": anchor }, parent).textContent = text;
      };
      const across = panel.node.querySelector('[data-ticks="y"]');
      across.replaceChildren();
      for (const [v, text] of fittingTicks(panel.y, bottom - top, t => t ? 19 : 34)) {
        const y = at(panel.y, v);
        line("pl-grid", left, y, right, y, across);
        label(left - 8, y + 4.5, "end", text, across);
      }
      const up = panel.node.querySelector('[data-ticks="x"]');
      up.replaceChildren();
      for (const [v, text] of fittingTicks(this.x, right - left, t => t ? 8 * t.length + 16 : 70)) {
        const x = at(this.x, v);
        line("pl-grid", x, top, x, bottom, up);
        line("pl-axis", x, bottom, x, bottom + 5, up);
        if (panel.last) label(x, bottom + 19, "middle", text, up);
      }
    }

    drawCurves(panel) {
      panel.series.forEach((series, index) => {
        const node = panel.node.querySelector(`[data-series="${index}"]`);
        const set = (part, d) => { const path = node.querySelector(part); if (path) path.setAttribute("d", d); };
        const x = series.x.map(v => at(this.x, v));
        const points = x.map((px, i) => [px, at(panel.y, series.y[i])]);
        const dots = () => points.filter(p => p.every(Number.isFinite))
          .map(p => `M${round(p[0])} ${round(p[1])}${series.marker}`).join("");
        if (series.kind === "line") set(".pl-line", linePath(points));
        if (series.kind === "step") set(".pl-line", linePath(stairs(points)));
        if (series.kind === "band") set(".pl-band", bandPath(points, series.other.map(v => at(panel.y, v))));
        if (series.kind === "bars") set(".pl-line", barPath(x, series, panel.y));
        if (series.marker) set(".pl-dot", dots());
      });
    }

    /// Moves what stands at a place in the data: spans, marks, levels, remarks, their names.
    place(panel) {
      panel.node.querySelectorAll("g[data-x],g[data-y]").forEach(node => {
        const { x, y } = node.dataset;
        const seen = (x === undefined || holds(this.x, +x)) && (y === undefined || holds(panel.y, +y));
        node.style.display = seen ? "" : "none";
        const to = [x === undefined ? 0 : at(this.x, +x), y === undefined ? 0 : at(panel.y, +y)];
        node.setAttribute("transform", `translate(${to.map(round).join(",")})`);
      });
      panel.node.querySelectorAll("[data-from]").forEach(node => {
        const ends = [node.dataset.from, node.dataset.to].map(v => at(this.x, +v));
        if (node.tagName === "rect") {
          node.setAttribute("x", round(ends[0]));
          node.setAttribute("width", Math.max(0, round(round(ends[1]) - round(ends[0]))));
          return;
        }
        const [left, right] = this.x.drawn;
        const visible = ends.map(v => Math.min(Math.max(v, left), right));
        const isMark = node.dataset.from === node.dataset.to;
        const seen = isMark ? holds(this.x, +node.dataset.from) : visible[1] - visible[0] > 14;
        node.style.display = seen ? "" : "none";
        if (seen) node.setAttribute("x", round((visible[0] + visible[1]) / 2));
      });
    }

    // ---- reading values

    /// Index of the sample nearest to a position, and how far it is; null without one in view.
    nearest(series, panel, px, py) {
      let best = null;
      const look = i => {
        const dx = at(this.x, series.x[i]) - px;
        if (!holds(this.x, series.x[i]) || !Number.isFinite(dx) || series.y[i] === null) return;
        const dy = series.forward || py === undefined ? 0 : at(panel.y, series.y[i]) - py;
        const gap = Math.hypot(dx, dy);
        if (best === null || gap < best.gap) best = { i, gap };
      };
      if (!series.forward) { series.x.forEach((_, i) => look(i)); return best; }
      const wanted = value(this.x, px);
      let low = 0, high = series.x.length;
      while (low < high) { const mid = (low + high) >> 1; if (series.x[mid] < wanted) low = mid + 1; else high = mid; }
      for (let i = Math.max(0, low - 3); i < Math.min(series.x.length, low + 3); i++) look(i);
      return best;
    }

    read(px, py) {
      const shown = this.panels.flatMap(panel => panel.series.filter(s => !s.hidden).map(series => ({ panel, series })));
      for (const row of shown) row.hit = this.nearest(row.series, row.panel, px, py);
      const found = shown.filter(row => row.hit).sort((a, b) => a.hit.gap - b.hit.gap);
      this.hide();
      if (!found.length || found[0].hit.gap > 60) return;
      this.at = found[0].series.x[found[0].hit.i];
      const hair = at(this.x, this.at);
      element("line", { class: "hair", x1: hair, x2: hair, y1: this.top, y2: this.bottom }, this.overlay);
      const rows = shown.filter(row => {
        if (row.series.forward) row.hit = this.nearest(row.series, row.panel, hair);
        return row.hit && row.hit.gap < 12;
      });
      for (const { panel, series, hit } of rows) {
        const y = at(panel.y, series.y[hit.i]);
        if (series.kind === "band" || !holds(panel.y, series.y[hit.i])) continue;
        const group = element("g", { class: series.colour }, this.overlay);
        element("circle", { class: "knob", cx: at(this.x, series.x[hit.i]), cy: y, r: 4 }, group);
      }
      this.label(rows, hair, py);
    }

    label(rows, hair, py) {
      const head = `${this.x.label || "x"} ${show(this.at, this.x.unit)}`;
      const table = html("table");
      html("th", "", head, table.insertRow()).colSpan = 2;
      const words = [head];
      for (const { panel, series, hit } of rows) {
        const name = this.panels.length > 1 && !series.name ? panel.y.label : series.name || panel.y.label;
        const text = showSample(series, hit.i, panel.y.unit);
        const row = table.insertRow();
        const cell = html("th", "", undefined, row);
        cell.scope = "row";
        html("i", series.colour, undefined, cell);
        cell.append(name);
        html("td", "", text, row);
        words.push(`${name} ${text}`);
      }
      this.values.replaceChildren(table);
      this.values.dataset.words = words.join(", ");
      this.values.hidden = false;
      const box = this.svg.getBoundingClientRect(), frame = this.figure.getBoundingClientRect();
      const scale = box.width / WIDTH, size = this.values.getBoundingClientRect();
      let left = box.left - frame.left + hair * scale + 14;
      if (left + size.width > frame.width) left -= size.width + 28;
      const middle = (py === undefined ? (this.top + this.bottom) / 2 : py) * scale - size.height / 2;
      this.values.style.left = Math.max(0, left) + "px";
      this.values.style.top = Math.max(0, Math.min(middle, box.height - size.height)) + "px";
    }

    hide() {
      this.overlay.replaceChildren();
      this.values.hidden = true;
      this.at = undefined;
    }
  }

  // ---- the page ---------------------------------------------------------------------------------------

  function picture(figure) {
    const copy = figure.querySelector("svg").cloneNode(true);
    copy.querySelectorAll(".hit,.hair,.knob,.zoom").forEach(node => node.remove());
    copy.setAttribute("role", "img");
    const style = element("style", {});
    style.textContent = JSON.parse(document.getElementById("figure-style").textContent);
    copy.prepend(style);
    return new XMLSerializer().serializeToString(copy);
  }

  // What is drawn, a row a point, with as many points and digits as the figure has.
  function table(data) {
    const cell = text => /[",\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text;
    const named = axis => cell(axis.unit ? `${axis.label} (${axis.unit})` : axis.label);
    const lines = [`series,quantity,${named(data.x)},value,upper end or error`];
    for (const panel of data.panels) {
      for (const series of panel.series) {
        const x = data.columns[series.x];
        const row = (y, i) => [cell(series.name), named(panel.y), x[i] ?? "", y ?? "", series.other[i] ?? ""];
        lines.push(...series.y.map((y, i) => row(y, i).join(",")));
      }
    }
    return lines.join("\n") + "\n";
  }

  function download(figure, text, ending, type) {
    const file = new Blob([text], { type });
    const link = html("a");
    const title = figure.querySelector(".pl-title");
    const name = (title ? title.textContent : "").toLowerCase().replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-|-$/g, "");
    link.download = (name || figure.id) + ending;
    link.href = URL.createObjectURL(file);
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  for (const figure of document.querySelectorAll("figure")) {
    const data = figure.querySelector("script.data");
    const drawn = data ? JSON.parse(data.textContent) : null;
    const plot = drawn ? new Plot(figure, drawn) : null;
    const tools = html("div", "tools", undefined, figure);
    if (plot) {
      const all = html("button", "", "Show all", tools);
      all.type = "button";
      all.addEventListener("click", () => plot.reset());
    }
    const save = (ending, type, text) => {
      const button = html("button", "", `Save ${ending.slice(1).toUpperCase()}`, tools);
      button.type = "button";
      button.addEventListener("click", () => download(figure, text(), ending, type));
    };
    save(".svg", "image/svg+xml", () => picture(figure));
    if (drawn) save(".csv", "text/csv", () => table(drawn));
    if (plot) html("span", "hint", "Drag to zoom; click, then turn the wheel; double-click shows all. Keys: ← → + − 0.", tools);
  }

  for (const block of document.querySelectorAll(".code")) {
    const button = html("button", "", "Copy", block);
    button.type = "button";
    button.addEventListener("click", async () => {
      const text = block.querySelector("code");
      try {
        await navigator.clipboard.writeText(text.textContent);
        button.textContent = "Copied";
      } catch {
        getSelection().selectAllChildren(text);
        button.textContent = "Selected";
      }
      setTimeout(() => { button.textContent = "Copy"; }, 1500);
    });
  }

  const root = document.documentElement;
  const isDark = () => (root.dataset.theme || (matchMedia("(prefers-color-scheme:dark)").matches ? "dark" : "light")) === "dark";
  const theme = html("button", "", isDark() ? "Light" : "Dark");
  theme.id = "theme";
  theme.type = "button";
  theme.setAttribute("aria-label", "Switch between light and dark");
  theme.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
    theme.textContent = isDark() ? "Light" : "Dark";
  });
  document.body.prepend(theme);

  // A table or a command that is wider than the page can be scrolled by keyboard.
  const boxes = (kind) => [...document.querySelectorAll(kind)];
  const numbered = (box) => (box.tagName === "PRE" ? `Command ${boxes("pre").indexOf(box) + 1}` : `Table ${boxes("div.table").indexOf(box) + 1}`);
  const scrollable = () => {
    for (const box of boxes("div.table,pre")) {
      const isWide = box.scrollWidth > box.clientWidth;
      box.toggleAttribute("tabindex", isWide);
      if (!isWide) continue;
      box.tabIndex = 0;
      box.setAttribute("role", "region");
      box.setAttribute("aria-label", box.querySelector("caption")?.textContent || numbered(box));
    }
  };
  scrollable();
  addEventListener("resize", scrollable);
})();
