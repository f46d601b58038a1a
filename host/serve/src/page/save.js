// What is seen, as a file: plots as a picture, their points as a table.

import { h } from "./dom.js";

/** Offers a file to be kept. */
export function download(name, blob) {
  const address = URL.createObjectURL(blob);
  h("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

/** Plots, each with its heading, below each other on the ground of the page. */
export async function picture(name, plots) {
  const scale = devicePixelRatio;
  const head = 22 * scale;
  const canvases = plots.map(({ drawn }) => drawn.canvas());
  const sheet = h("canvas", {});
  sheet.width = Math.max(...canvases.map((of) => of.width));
  sheet.height = canvases.reduce((sum, of) => sum + of.height + head, 0);
  const ink = sheet.getContext("2d");
  const style = getComputedStyle(document.documentElement);
  ink.fillStyle = style.getPropertyValue("--bg");
  ink.fillRect(0, 0, sheet.width, sheet.height);
  ink.fillStyle = style.getPropertyValue("--ink");
  ink.font = `${13 * scale}px system-ui`;
  let top = 0;
  canvases.forEach((canvas, k) => {
    ink.fillText(plots[k].heading, 8 * scale, top + 16 * scale);
    ink.drawImage(canvas, 0, top + head);
    top += head + canvas.height;
  });
  download(`${name}.png`, await new Promise((resolve) => sheet.toBlob(resolve, "image/png")));
}

/** Columns as CSV: `[[name, values], …]`; what is not known stays empty. */
export function table(name, columns) {
  const cell = (value) => (value === null || value === undefined || !Number.isFinite(value) ? "" : String(value));
  const rows = Array.from(columns[0][1], (_, row) => columns.map(([, values]) => cell(values[row])).join(","));
  const text = [columns.map(([of]) => of).join(","), ...rows, ""].join("\n");
  download(`${name}.csv`, new Blob([text], { type: "text/csv" }));
}
