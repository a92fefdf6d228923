// The actuator's file and its C header with other values, as `ema` writes them; and numbers as Python writes them. Runs in a page and in Node.
const EmaText = (() => {
  "use strict";

  const REMARK_COLUMN = 36;

  // repr() of a float: the shortest digits that give it back, with an exponent where Python has one.
  function repr(value) {
    const [mantissa, power] = Math.abs(value).toExponential().split("e");
    const exponent = Number(power);
    const sign = value < 0 || Object.is(value, -0) ? "-" : "";
    if (value !== 0 && (exponent < -4 || exponent >= 16)) {
      return `${sign}${mantissa}e${exponent < 0 ? "-" : "+"}${String(Math.abs(exponent)).padStart(2, "0")}`;
    }
    const digits = mantissa.replace(".", "");
    if (exponent < 0) return `${sign}0.${"0".repeat(-exponent - 1)}${digits}`;
    const whole = digits.slice(0, exponent + 1).padEnd(exponent + 1, "0");
    return `${sign}${whole}.${digits.slice(exponent + 1) || "0"}`;
  }

  // The shortest C literal with the float32 value nearest to `value`.
  function literal(value) {
    const single = Math.fround(value);
    let digits = 1;
    while (Math.fround(Number(single.toPrecision(digits))) !== single) digits += 1;
    return `${repr(Number(single.toPrecision(digits)))}f`;
  }

  function place(lines, heading) {
    const first = lines.findIndex((line) => line.trim() === heading);
    if (first < 0) return null;
    let last = first + 1;
    while (last < lines.length && !/^\s*\[/.test(lines[last])) last += 1;
    while (last > first + 1 && !lines[last - 1].trim()) last -= 1;
    return { first, last };
  }

  function tomlLine(row, value) {
    const entry = `${row.field} = ${repr(value)}`;
    return `${entry}${" ".repeat(Math.max(1, REMARK_COLUMN - entry.length))}# ${row.remark}`;
  }

  // The text of the actuator's file with the values of `rows`; comments stay.
  function toml(text, rows, valueOf) {
    const lines = text.replace(/\n$/, "").split("\n");
    for (const row of rows) {
      const value = valueOf(row);
      const heading = `[${row.table}]`;
      let table = place(lines, heading);
      const key = new RegExp(`^(\\s*${row.field}\\s*=\\s*)([^#\\s]+)(.*)$`);
      const at = table ? lines.findIndex((line, k) => k > table.first && k < table.last && key.test(line)) : -1;
      if (at >= 0) {
        const [, before, old, after] = key.exec(lines[at]);
        if (Number(old.replace(/_/g, "")) !== value) lines[at] = `${before}${repr(value)}${after}`;
        continue;
      }
      if (value === row.zero) continue;
      if (!table) {
        // a table of an effect goes behind the last of them, or to the end
        let end = lines.length;
        for (let k = lines.length - 1; k >= 0; k -= 1) {
          if (/^\s*\[effects\./.test(lines[k])) {
            end = place(lines, lines[k].trim()).last;
            break;
          }
        }
        lines.splice(end, 0, "", heading);
        table = { first: end + 1, last: end + 2 };
      }
      lines.splice(table.last, 0, tomlLine(row, value));
    }
    return `${lines.join("\n")}\n`;
  }

  // The C header that `ema export` writes, with the values of `rows`.
  function header(text, rows, valueOf) {
    const lines = text.split("\n");
    for (const row of rows) {
      const value = valueOf(row);
      if (value === row.value) continue;
      const block = `{ /* ${row.table.startsWith("effects.") ? row.table.slice("effects.".length) : "params"} */`;
      const first = lines.findIndex((line) => line.trim() === block);
      const remark = `, /* ${row.field} */`;
      const at = lines.findIndex((line, k) => k > first && line.endsWith(remark));
      lines[at] = `${/^ */.exec(lines[at])[0]}${literal(value)}${remark}`;
    }
    return lines.join("\n");
  }

  return { repr, literal, toml, header };
})();
if (typeof module !== "undefined") module.exports = EmaText;
