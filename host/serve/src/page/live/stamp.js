// Names of recordings.

/** Date and time for a file's name. */
export function stamp() {
  const two = (n) => String(n).padStart(2, "0");
  const d = new Date();
  return `${d.getFullYear()}${two(d.getMonth() + 1)}${two(d.getDate())}-${two(d.getHours())}${two(d.getMinutes())}${two(d.getSeconds())}`;
}
