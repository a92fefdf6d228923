// The module itself in JavaScript: ema.wasm behind functions, and what belongs to a record rather than to the page. Runs in a page, in a worker and in Node.
const EmaWorkbench = (() => {
  "use strict";

  const CHANNELS = ["position_mm", "motor_position_mm", "current_A", "voltage_V"];
  const OUTPUTS = [...CHANNELS, "speed_mm_s"];
  const COLUMNS = ["time_s", "command_mm", ...OUTPUTS];
  const ROWS_MIN = 100; // EMA_ROWS_MIN
  const NOISE_FLOOR = 5e-4; // of a signal's spread, as `ema identify --values` has it
  const START_NOISE = 4; // standard deviations, as the onboard session has it
  const LINES = { i32: 4, f64: 8, i64: 8, u64: 8 };

  // The structures of ema_desk.h: name, type, count. Their sizes are compared with the module's.
  const SEARCH = [
    ["identified_count", "i32"], ["identified_id", "i32", 4], ["identified_lower", "f64", 4], ["identified_upper", "f64", 4],
    ["identified_min_shift_percent", "f64", 4], ["weight", "f64", 4], ["start", "f64", 4], ["start_at_healthy", "i32"], ["abandon", "i32"],
    ["int16_record", "i32"], ["slice_steps", "i32"], ["evaluation_budget", "i32"], ["reanneal_interval", "i32"],
    ["initial_temperature", "f64"], ["cooling", "f64"], ["function_tolerance", "f64"], ["seed", "i64"],
  ];
  const RESULT = [
    ["estimate", "f64", 4], ["std", "f64", 4], ["shift_percent", "f64", 4], ["at_bound", "i32", 4], ["objective_before", "f64"],
    ["objective_after", "f64"], ["residual_rms_mm", "f64"], ["residual_correlation", "f64"], ["model_steps", "i64"], ["evaluations", "i32"],
    ["accepted", "i32"], ["accepted_uphill", "i32"], ["outcome", "i32"], ["verdict", "i32"], ["adequate", "i32"], ["reasons", "i32"],
    ["random_state", "u64"], ["bias", "f64", 4], ["half_95", "f64", 4],
    ["scatter_percent", "f64", 4], ["today", "f64", 4],
  ];
  const STRUCTURES = { search: SEARCH, result: RESULT };

  // Offsets as C lays them out, and the size: every member at a multiple of its own size, the whole at one of 8.
  function layout(fields) {
    let at = 0;
    const places = fields.map(([name, type, count = 0]) => {
      const bytes = LINES[type];
      const offset = Math.ceil(at / bytes) * bytes;
      at = offset + bytes * Math.max(count, 1);
      return { name, type, count, offset };
    });
    return { places, size: Math.ceil(at / 8) * 8 };
  }

  const one = {
    i32: { read: (view, at) => view.getInt32(at, true), write: (view, at, value) => view.setInt32(at, value, true) },
    f64: { read: (view, at) => view.getFloat64(at, true), write: (view, at, value) => view.setFloat64(at, value, true) },
    i64: { read: (view, at) => view.getBigInt64(at, true), write: (view, at, value) => view.setBigInt64(at, BigInt(value), true) },
    u64: { read: (view, at) => view.getBigUint64(at, true), write: (view, at, value) => view.setBigUint64(at, BigInt(value), true) },
  };

  function readStructure(view, base, places) {
    const found = {};
    for (const { name, type, count, offset } of places) {
      const read = (k) => one[type].read(view, base + offset + k * LINES[type]);
      found[name] = count ? Array.from({ length: count }, (_, k) => read(k)) : read(0);
    }
    return found;
  }

  function writeStructure(view, base, places, values) {
    for (const { name, type, count, offset } of places) {
      const given = count ? values[name] : [values[name]];
      for (let k = 0; k < Math.max(count, 1); k += 1) one[type].write(view, base + offset + k * LINES[type], given[k] ?? 0);
    }
  }

  // One instance of the module with one record in its memory. `progress(runs, cost, best, values)` is called after each model run of a fit; true stops it.
  class Desk {
    constructor(instance) {
      this.api = instance.exports;
      this.progress = null;
      this.layouts = Object.fromEntries(Object.entries(STRUCTURES).map(([name, fields]) => [name, layout(fields)]));
      Object.values(this.layouts).forEach(({ size }, kind) => {
        if (this.api.ema_wasm_size(kind) !== size) throw new Error("ema.wasm was built from other sources than this page: build the project again");
      });
      this.valueCount = this.api.ema_desk_value_count();
      this.optionCount = this.api.ema_desk_option_count();
      this.rows = 0;
    }

    static async open(bytes) {
      let desk = null;
      const told = (runs, cost, best, at) => {
        if (!desk.progress) return 0;
        const values = at ? Array.from(new Float64Array(desk.api.memory.buffer, at, 4)) : null;
        return desk.progress(runs, cost, best, values) ? 1 : 0;
      };
      const { instance } = await WebAssembly.instantiate(bytes, { env: { ema_wasm_progress: told } });
      desk = new Desk(instance);
      return desk;
    }

    // Puts a record into memory: {command_mm, position_mm, ...} arrays of the same length; what is absent is no signal.
    load(record) {
      this.rows = record.command_mm.length;
      const sizes = {
        values: 8 * this.valueCount, options: 8 * Math.ceil(this.optionCount / 2), command: 8 * this.rows, channels: 8 * 4 * this.rows,
        out: 8 * 5 * this.rows, weight: 32, number: 8, search: this.layouts.search.size, result: this.layouts.result.size,
        lent: 8 * Math.ceil((20 * this.rows) / 8),
      };
      let at = Math.ceil(this.api.__heap_base.value / 8) * 8;
      this.at = {};
      for (const [name, size] of Object.entries(sizes)) {
        this.at[name] = at;
        at += size;
      }
      const memory = this.api.memory;
      if (memory.buffer.byteLength < at) memory.grow(Math.ceil((at - memory.buffer.byteLength) / 65536));
      this.api.ema_wasm_lend(this.at.lent, sizes.lent);
      this.doubles(this.at.command, this.rows).set(record.command_mm);
      const channels = this.doubles(this.at.channels, 4 * this.rows);
      CHANNELS.forEach((name, k) => {
        const column = record[name];
        for (let row = 0; row < this.rows; row += 1) channels[4 * row + k] = column ? column[row] : NaN;
      });
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

    // The module's own objective, in mm^2 s with weight 1 on the rod position.
    objective(model, weight, startMm) {
      this.model(model);
      this.doubles(this.at.weight, 4).set(weight);
      const at = this.at;
      const status = this.api.ema_desk_objective(at.values, at.options, at.command, at.channels, at.weight, this.rows, startMm, at.number);
      if (status !== 0) this.refuse(status);
      return this.doubles(at.number, 1)[0];
    }

    // The module's session with its annealer, to its end: `wanted` replaces what the actuator's own [search] table says.
    fit(model, wanted, progress = null) {
      this.model(model);
      const { at, layouts } = this;
      let status = this.api.ema_desk_search_default(at.values, at.options, at.search);
      if (status !== 0) this.refuse(status);
      const view = () => new DataView(this.api.memory.buffer);
      const search = readStructure(view(), at.search, layouts.search.places);
      writeStructure(view(), at.search, layouts.search.places, { ...search, ...wanted });
      this.progress = progress;
      try {
        status = this.api.ema_wasm_identify(at.values, at.options, at.command, at.channels, this.rows, at.search, at.result, 0);
      } finally {
        this.progress = null;
      }
      if (status !== 0) this.refuse(status);
      return readStructure(view(), at.result, layouts.result.places);
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

  // Weights of the objective: 1 on the rod position, the others by how noisy they are beside it; with the rod alone nothing else.
  function weightsOf(noise, rodAlone) {
    return CHANNELS.map((name) => (noise[name] && !(rodAlone && name !== "position_mm") ? (noise.position_mm / noise[name]) ** 2 : 0));
  }

  // The objective as a multiple of the sensor noise: rms over the signals that are weighted.
  function errorOf(objective, record, noise, weight) {
    const seconds = record.period_s * record.command_mm.length;
    return Math.sqrt(objective / (seconds * weight.filter((one) => one > 0).length)) / noise.position_mm;
  }

  // How a diagnosis weighs a record: lines of the spectrum of what is left, each times its weight; the rms of the whole. A transform takes two signals, as the parts of complex numbers.
  class Weighed {
    constructor(rows, target, weights) {
      Object.assign(this, { rows, target, weights, names: Object.keys(target) });
      const turn = (2 * Math.PI) / rows;
      this.cos = Float64Array.from({ length: rows }, (_, k) => Math.cos(turn * k));
      this.sin = Float64Array.from({ length: rows }, (_, k) => -Math.sin(turn * k));
      for (const name of ["inRe", "inIm", "re", "im", "partRe", "partIm"]) this[name] = new Float64Array(rows);
    }

    // Of `size` numbers from `from` on in steps of `stride`, to `to` and on: by the smallest factor, whatever the factors are.
    transform(size, from, stride, to) {
      const { re, im, partRe, partIm, cos, sin, rows } = this;
      if (size === 1) {
        re[to] = this.inRe[from];
        im[to] = this.inIm[from];
        return;
      }
      let factor = 2;
      while (size % factor) factor += 1;
      const part = size / factor;
      for (let k = 0; k < factor; k += 1) this.transform(part, from + k * stride, stride * factor, to + k * part);
      for (let k = 0; k < part; k += 1) {
        for (let q = 0; q < factor; q += 1) {
          const step = ((k + q * part) * stride) % rows;
          let sumRe = re[to + k];
          let sumIm = im[to + k];
          for (let r = 1, place = step; r < factor; r += 1, place = (place + step) % rows) {
            const at = to + r * part + k;
            sumRe += re[at] * cos[place] - im[at] * sin[place];
            sumIm += re[at] * sin[place] + im[at] * cos[place];
          }
          partRe[q] = sumRe;
          partIm[q] = sumIm;
        }
        for (let q = 0; q < factor; q += 1) {
          re[to + q * part + k] = partRe[q];
          im[to + q * part + k] = partIm[q];
        }
      }
    }

    error(simulated) {
      const { rows, names, re, im } = this;
      let sum = 0;
      for (let k = 0; k < names.length; k += 2) {
        const [first, second] = [names[k], names[k + 1]];
        for (let row = 0; row < rows; row += 1) {
          this.inRe[row] = this.target[first][row] - simulated[first][row];
          this.inIm[row] = second ? this.target[second][row] - simulated[second][row] : 0;
        }
        this.transform(rows, 0, 1, 0);
        const one = this.weights[first];
        const other = second && this.weights[second];
        for (let line = 0; line < one.length; line += 1) {
          const mirror = (rows - line) % rows;
          sum += ((re[line] + re[mirror]) ** 2 + (im[line] - im[mirror]) ** 2) * 0.25 * one[line] ** 2;
          if (other) sum += ((im[line] + im[mirror]) ** 2 + (re[mirror] - re[line]) ** 2) * 0.25 * other[line] ** 2;
        }
      }
      return Math.sqrt(sum / rows / (rows * names.length));
    }
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

  return { CHANNELS, OUTPUTS, Desk, Weighed, noiseOf, weightsOf, errorOf, startOf, readCsv };
})();
if (typeof module !== "undefined") module.exports = EmaWorkbench;
