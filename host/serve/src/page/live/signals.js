// What a fingertip streams.

export const GAUGES = 4;
/** How much of it can be shown at once, s. */
export const STRETCHES = [2, 5, 10, 30, 60];
/** What is drawn of each gauge: name, colour, dash, shown at first; the order is that of the stream. */
export const SIGNALS = [
  ["signal", "ink", undefined, true, "raw, as calibrated strain: FA + SA"],
  ["FA", "c1", undefined, true, "fast adapting"],
  ["SA", "c0", undefined, true, "slowly adapting"],
  ["elastic input", "c3", [6, 3], false, "the response without memory to the same motion"],
  ["equilibrium", "c2", [8, 4], true, "where the signal will settle if the motion stops"],
];
