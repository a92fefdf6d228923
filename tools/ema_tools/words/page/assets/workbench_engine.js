// The module in JavaScript (ema.wasm behind functions), and what belongs to a record. Runs in a page, in a worker and in Node.
const EmaWorkbench = (() => {
  "use strict";

  const CHANNELS = ["position_mm", "motor_position_mm", "current_A", "voltage_V"];
  const OUTPUTS = [...CHANNELS, "speed_mm_s"];
  const COLUMNS = ["time_s", "command_mm", ...OUTPUTS];
  const ROWS_MIN = 100; // EMA_ROWS_MIN
  const NOISE_FLOOR = 5e-4; // of a signal's spread, as `ema identify --values` has it
  const START_NOISE = 4; // standard deviations, as the onboard session has it

  // One instance of the module with one command in its memory, which lies behind `__heap_base`.
  class Desk {
    constructor(instance) {
      this.api = instance.exports;
      this.valueCount = this.api.ema_desk_value_count();
      this.optionCount = this.api.ema_desk_option_count();
      this.rows = 0;
    }

    static async open(bytes) {
      return new Desk((await WebAssembly.instantiate(bytes, {})).instance);
    }

    load(record) {
      this.rows = record.command_mm.length;
      const sizes = { values: 8 * this.valueCount, options: 8 * Math.ceil(this.optionCount / 2), command: 8 * this.rows, out: 8 * 5 * this.rows, number: 8 };
      let at = Math.ceil(this.api.__heap_base.value / 8) * 8;
      this.at = {};
      for (const [name, size] of Object.entries(sizes)) {
        this.at[name] = at;
        at += size;
      }
      const memory = this.api.memory;
      if (memory.buffer.byteLength < at) memory.grow(Math.ceil((at - memory.buffer.byteLength) / 65536));
      this.doubles(this.at.command, this.rows).set(record.command_mm);
    }

    doubles(at, count) {
      return new Float64Array(this.api.memory.buffer, at, count);
    }

    // The model in memory; throws what the module says of one that it refuses.
    model(model) {
      this.doubles(this.at.values, this.valueCount).set(model.values);
      new Int32Array(this.api.memory.buffer, this.at.options, this.optionCount).set(model.options);
      const { values, options, number } = this.at;
      const status = this.api.ema_desk_check(values, options, number);
      if (status !== 0) this.refuse(status, new DataView(this.api.memory.buffer).getInt32(number, true));
    }

    refuse(status, offender = -1) {
      const bytes = new Uint8Array(this.api.memory.buffer, this.api.ema_desk_status_text(status));
      const text = new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
      throw Object.assign(new Error(text), { status, offender });
    }

    // Five arrays by name, rows each.
    simulate(model, startMm) {
      this.model(model);
      const { values, options, command, out } = this.at;
      const status = this.api.ema_desk_simulate(values, options, command, this.rows, startMm, out, 0);
      if (status !== 0) this.refuse(status);
      return Object.fromEntries(OUTPUTS.map((name, k) => [name, this.doubles(out + 8 * k * this.rows, this.rows).slice()]));
    }
  }

  function median(values) {
    const sorted = Float64Array.from(values).sort();
    const middle = sorted.length >> 1;
    return sorted.length % 2 ? sorted[middle] : 0.5 * (sorted[middle - 1] + sorted[middle]);
  }

  // Standard deviation of white noise on a signal, from its fourth differences; as ema_tools.base.noise.
  function whiteNoise(values) {
    let differences = Float64Array.from(values);
    for (let k = 0; k < 4; k += 1) differences = differences.subarray(1).map((value, row) => value - differences[row]);
    if (!differences.length) return 0;
    const centre = median(differences);
    return (1.4826 * median(differences.map((value) => Math.abs(value - centre)))) / Math.sqrt(70);
  }

  function spread(values) {
    const mean = values.reduce((sum, value) => sum + value, 0) / values.length;
    return Math.sqrt(values.reduce((sum, value) => sum + (value - mean) ** 2, 0) / values.length);
  }

  // How noisy each recorded signal is, by name; one that never moves tells nothing.
  function noiseOf(record) {
    const found = {};
    for (const name of CHANNELS) {
      if (!record[name]) continue;
      const noise = Math.max(whiteNoise(record[name]), NOISE_FLOOR * spread(record[name]));
      if (noise > 0) found[name] = noise;
    }
    return found;
  }

  // Where a simulation starts from rest: at the command where the rod may rest there, else at the first rod position.
  function startOf(record, blkUpperMm, noiseMm) {
    const command = record.command_mm[0];
    const position = record.position_mm[0];
    return Math.abs(position - command) <= 0.5 * blkUpperMm + START_NOISE * noiseMm ? command : position;
  }

  // A recording from the text of a CSV. Throws one line that names row and column and says what to do.
  function readCsv(text, file, periodS) {
    const fail = (what) => {
      throw new Error(`${file}: ${what}`);
    };
    const lines = text.replace(/^\uFEFF/, "").split(/\r\n|\n|\r/);
    const split = (line) => line.split(",").map((cell) => cell.trim().replace(/^"(.*)"$/, "$1"));
    const meant = lines.map((line, k) => [line, k + 1]).filter(([line]) => line.trim() && !line.trimStart().startsWith("#"));
    if (!meant.length) fail("holds no rows: give a header row with time_s, command_mm, position_mm and one row per sample");
    const names = split(meant[0][0]);
    const places = {};
    for (const name of COLUMNS) {
      const place = names.indexOf(name);
      if (place < 0) continue;
      if (names.indexOf(name, place + 1) >= 0) fail(`column ${name} stands there twice: leave one out`);
      places[name] = place;
    }
    for (const name of COLUMNS.slice(0, 3)) {
      if (!(name in places)) fail(`column ${name} is missing: rename the one that holds it (found: ${names.slice(0, 8).join(", ")})`);
    }
    const rows = meant.length - 1;
    if (rows < ROWS_MIN) fail(`${rows} rows: give at least ${ROWS_MIN}`);
    const columns = Object.fromEntries(Object.keys(places).map((name) => [name, new Float64Array(rows)]));
    for (let row = 0; row < rows; row += 1) {
      const [line, number] = meant[row + 1];
      const cells = split(line);
      if (cells.length !== names.length) fail(`line ${number}: ${cells.length} fields where the header has ${names.length}: correct the line`);
      for (const name of Object.keys(places)) {
        const cell = cells[places[name]];
        const value = /^[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$/.test(cell) ? Number(cell) : NaN;
        if (!Number.isFinite(value)) fail(`line ${number}: ${name} = ${cell || "(empty)"}: not a number: correct it`);
        columns[name][row] = value;
      }
    }
    const time = columns.time_s;
    const period = (time[rows - 1] - time[0]) / (rows - 1);
    if (!(period > 0)) fail("time_s does not rise: give one row per sample, in order");
    for (let row = 1; row < rows; row += 1) {
      if (Math.abs(time[row] - time[row - 1] - period) > 0.01 * period) {
        fail(`line ${meant[row + 1][1]}: time_s = ${time[row]}: not one period (${period.toPrecision(4)} s) after the row before: record at a constant rate`);
      }
    }
    if (Math.abs(period - periodS) > 1e-3 * periodS) {
      fail(`a row every ${period.toPrecision(4)} s where the actuator records every ${periodS.toPrecision(4)} s: give a record of this actuator`);
    }
    delete columns.time_s;
    return { ...columns, period_s: periodS, start_s: time[0], file };
  }

  return { CHANNELS, Desk, noiseOf, startOf, readCsv };
})();
if (typeof module !== "undefined") module.exports = EmaWorkbench;
