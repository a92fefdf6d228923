// Least squares on a record: the weighted residual of a model, and the values that make it least. Runs in a page, in a worker and in Node.
const EmaFit = (() => {
  "use strict";

  const STEPS = [0.05, 0.2, 0.6]; // shares of a value's scale over which a slope is taken [precision]
  const ROUGH = 144; // squared change below which a difference may be the model's own roughness [precision]
  const SPREAD_STEP = [0.01, 0.1]; // the same of a value with a prior: of the value, or of its standard deviation where that is zero [precision]
  const RUNS = 120; // model runs of one fit, after which it ends [effort]
  const CREDIBLE = 3; // standard deviations to which what scatters goes where nothing is fitted, as everywhere in the tools [chance]
  const DONE = 1e-4; // share of the cost: a step that lowers it by less was the last by its slopes [precision]
  const REFRESHED = 4; // times that all slopes are taken again [effort]
  const DAMPED = [1e-6, 1e-3, 1e-1, 1, 10, 100]; // shares of the curvature added to it, until a step lowers the cost [judgement]
  const FACTORS = [1e-2, 1e2]; // by which a first size is scaled [judgement]
  const SAME_DIGITS = 4; // errors equal to so many digits, as they are shown, are equal: fewer values come first

  const dot = (a, b) => {
    let sum = 0;
    for (let k = 0; k < a.length; k += 1) sum += a[k] * b[k];
    return sum;
  };
  function minus(a, b, factor = 1) {
    const found = new Float64Array(a.length);
    for (let k = 0; k < a.length; k += 1) found[k] = a[k] - factor * b[k];
    return found;
  }

  // Solves a symmetric positive system [n][n] by Cholesky; null where it is singular.
  function solved(matrix, right) {
    const n = right.length;
    const lower = matrix.map((row) => Float64Array.from(row));
    for (let j = 0; j < n; j += 1) {
      for (let k = 0; k < j; k += 1) lower[j][j] -= lower[j][k] ** 2;
      if (!(lower[j][j] > 0)) return null;
      lower[j][j] = Math.sqrt(lower[j][j]);
      for (let i = j + 1; i < n; i += 1) {
        for (let k = 0; k < j; k += 1) lower[i][j] -= lower[i][k] * lower[j][k];
        lower[i][j] /= lower[j][j];
      }
    }
    const x = Float64Array.from(right);
    for (let i = 0; i < n; i += 1) {
      for (let k = 0; k < i; k += 1) x[i] -= lower[i][k] * x[k];
      x[i] /= lower[i][i];
    }
    for (let i = n - 1; i >= 0; i -= 1) {
      for (let k = i + 1; k < n; k += 1) x[i] -= lower[k][i] * x[k];
      x[i] /= lower[i][i];
    }
    return x;
  }

  // The solution of `solved` with no element farther than `reach`: what one may not do, the others then do not answer (an active set, which grows to the first bound on the way and gives up the
  // bound that the cost would leave).
  function solvedWithin(matrix, right, reach) {
    const n = right.length;
    const x = new Float64Array(n);
    const held = new Int8Array(n);
    for (let round = 0; round < 10 * n; round += 1) {
      const free = [...x.keys()].filter((k) => !held[k]);
      const best = solved(free.map((i) => free.map((j) => matrix[i][j])), free.map((i) => right[i] - x.reduce((sum, at, j) => sum + (held[j] ? matrix[i][j] * at : 0), 0)));
      if (!best) return x;
      let share = 1;
      let first = -1;
      free.forEach((k, i) => {
        const most = Math.abs(best[i]) > reach ? (Math.sign(best[i]) * reach - x[k]) / (best[i] - x[k]) : 1;
        if (most < share) [share, first] = [most, k];
      });
      free.forEach((k, i) => { x[k] += share * (best[i] - x[k]); });
      if (first >= 0) {
        held[first] = Math.sign(x[first]);
        continue;
      }
      const inward = [...x.keys()].map((k) => (held[k] ? -held[k] * (right[k] - x.reduce((sum, at, j) => sum + matrix[k][j] * at, 0)) : 0));
      const worst = inward.indexOf(Math.max(...inward));
      if (!(inward[worst] > 1e-9 * Math.abs(right[worst]))) return x;
      held[worst] = 0;
    }
    return x;
  }

  // By each signal's white noise, sample by sample.
  class WhiteNoise {
    constructor(rows, target, noise, names) {
      Object.assign(this, { rows, target, noise, names });
      this.numbers = names.length * rows;
    }

    whiten(signals) {
      const { rows } = this;
      const vector = new Float64Array(this.numbers);
      this.names.forEach((name, k) => {
        const [signal, weight] = [signals[name], 1 / this.noise[name]];
        for (let row = 0; row < rows; row += 1) vector[k * rows + row] = weight * signal[row];
      });
      return vector;
    }
  }

  // Noise by name where the weights of all lines of each signal are equal, so that no transform is needed (Parseval's theorem); null where they are not. A line stands for its mirror image, too.
  function flatNoise(weights) {
    const found = Object.entries(weights).map(([name, list]) => [name, Math.SQRT2 / list[1], list.subarray(1, list.length - 1).every((one) => one === list[1])]);
    return found.every(([, , flat]) => flat) ? Object.fromEntries(found) : null;
  }

  // As a diagnosis: lines of the spectrum, each times its weight. A transform takes two signals, as the parts of complex numbers.
  class Lines {
    constructor(rows, target, weights) {
      Object.assign(this, { rows, target, weights, names: Object.keys(target) });
      this.numbers = rows * this.names.length;
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

    whiten(signals) {
      const { rows, names, re, im } = this;
      const lines = Math.floor(rows / 2) + 1;
      const vector = new Float64Array(2 * lines * names.length);
      const scale = 0.5 / Math.sqrt(rows);
      for (let k = 0; k < names.length; k += 2) {
        const [first, second] = [names[k], names[k + 1]];
        this.inRe.set(signals[first].subarray(0, rows));
        if (second) this.inIm.set(signals[second].subarray(0, rows));
        else this.inIm.fill(0);
        this.transform(rows, 0, 1, 0);
        for (let line = 0, at = 2 * k * lines; line < lines; line += 1, at += 2) {
          const mirror = (rows - line) % rows;
          const weight = scale * this.weights[first][line];
          vector[at] = weight * (re[line] + re[mirror]);
          vector[at + 1] = weight * (im[line] - im[mirror]);
          if (!second) continue;
          const other = scale * this.weights[second][line];
          vector[at + 2 * lines] = other * (im[line] + im[mirror]);
          vector[at + 2 * lines + 1] = other * (re[mirror] - re[line]);
        }
      }
      return vector;
    }
  }

  // Weighted residual and cost of models on one record. `weighed` is a diagnosis': values with a prior (`spread`), and signals that the record may hold (`zeros` and `gains` of sensors, `slight` effects
  // of the model `unit`).
  class Misfit {
    constructor(desk, model, startMm, whitener, weighed = null) {
      Object.assign(this, { desk, options: model.options, given: Float64Array.from(model.values), startMm, whitener, runs: 0 });
      this.spread = weighed ? weighed.spread : [];
      this.additive = [];
      if (weighed && weighed.zeros) this.add(weighed);
      const square = this.additive.map((one) => this.additive.map((other) => dot(one, other)));
      square.forEach((row, k) => { row[k] += 1; });
      this.square = square;
    }

    add({ zeros, gains, unit, slight }) {
      const { names, target } = this.whitener;
      const rows = target[names[0]].length;
      const none = Object.fromEntries(names.map((name) => [name, new Float64Array(rows)]));
      for (const [name, size] of Object.entries(zeros)) this.additive.push(this.whitener.whiten({ ...none, [name]: new Float64Array(rows).fill(size) }));
      if (!Object.keys(gains).length && !slight.length) return;
      const values = Float64Array.from(this.given);
      const put = (changes) => changes.forEach(([id, value]) => { values[id] = value; });
      put(unit);
      const base = this.simulate(values);
      for (const [name, share] of Object.entries(gains)) this.additive.push(this.whitener.whiten({ ...none, [name]: base[name].map((value) => share * value) }));
      for (const { changes, size } of slight) {
        const before = changes.map(([id]) => [id, values[id]]);
        put(changes);
        const trial = this.simulate(values);
        this.additive.push(this.whitener.whiten(Object.fromEntries(names.map((name) => [name, minus(trial[name], base[name]).map((value) => value / size)]))));
        put(before);
      }
    }

    simulate(values) {
      this.runs += 1;
      return this.desk.simulate({ values, options: this.options }, this.startMm);
    }

    // Weighted residual, `zeros` of the sensors not taken off; `simulated` where it is known.
    residual(values, simulated = null) {
      const { names, target } = this.whitener;
      const shown = simulated ?? this.simulate(values);
      return this.whitener.whiten(Object.fromEntries(names.map((name) => [name, minus(target[name], shown[name])])));
    }

    bestZeros(residual) {
      return this.additive.length ? solved(this.square, this.additive.map((one) => dot(one, residual))) : new Float64Array(0);
    }

    // The same no farther than is credible.
    credibleZeros(residual) {
      return this.additive.length ? solvedWithin(this.square, this.additive.map((one) => dot(one, residual)), CREDIBLE) : new Float64Array(0);
    }

    // The residual with the zeros of the sensors taken off.
    corrected(residual, zeros) {
      const found = Float64Array.from(residual);
      zeros.forEach((at, j) => {
        const signal = this.additive[j];
        if (at) for (let k = 0; k < found.length; k += 1) found[k] -= at * signal[k];
      });
      return found;
    }

    prior(values) {
      return this.spread.reduce((sum, one) => sum + deviation(one, values) ** 2, 0);
    }

    cost(values, residual, zeros) {
      const rest = this.corrected(residual, zeros);
      return dot(rest, rest) + dot(zeros, zeros) + this.prior(values);
    }

    error(cost) {
      return Math.sqrt(cost / this.whitener.numbers);
    }
  }

  // `rodAlone`: the rod position by its white noise, whatever else there is.
  function misfitOf(desk, { model, startMm, record, noise, weighed, rodAlone }) {
    const names = rodAlone ? ["position_mm"] : Object.keys(noise);
    if (rodAlone || !weighed) return new Misfit(desk, model, startMm, new WhiteNoise(record.command_mm.length, record, noise, names));
    const { rows, target, weights } = weighed;
    const flat = flatNoise(weights);
    return new Misfit(desk, model, startMm, flat ? new WhiteNoise(rows, target, flat, Object.keys(target)) : new Lines(rows, target, weights), weighed);
  }

  // A value with a prior, in standard deviations from where it is expected.
  const deviation = (one, values) => (values[one.ids[0]] - one.zeros[0]) / one.std;

  function put(unknown, values, value) {
    values[unknown.ids[0]] = value;
    for (let k = 1; k < unknown.ids.length; k += 1) values[unknown.ids[k]] = (unknown.zeros[k] / unknown.zeros[0]) * value;
  }

  // The values to be fitted: rows of the page and values with a prior, each once.
  function unknowns(misfit, rows) {
    const found = misfit.spread.map((one) => ({ ...one, spread: true }));
    for (const row of rows) {
      const known = found.find((one) => one.ids[0] === row.id);
      if (known) continue;
      found.push({ ids: [row.id], lower: row.bounds[0], upper: row.bounds[1], scale: row.scale, std: Infinity });
    }
    return found;
  }

  function slope(misfit, unknown, values, residual) {
    const value = values[unknown.ids[0]];
    const scale = unknown.scale || Math.abs(value) || 0.1 * (unknown.upper - unknown.lower);
    const widths = unknown.spread ? [value ? SPREAD_STEP[0] * Math.abs(value) : SPREAD_STEP[1] * unknown.std] : STEPS.map((step) => step * scale);
    let column = new Float64Array(residual.length);
    for (const width of widths) {
      const up = value + width <= unknown.upper;
      const to = up ? value + width : Math.max(value - width, unknown.lower);
      if (to === value) continue;
      const moved = Float64Array.from(values);
      put(unknown, moved, to);
      let change;
      try {
        change = minus(residual, misfit.residual(moved));
      } catch {
        break; // the model refuses the values
      }
      column = change.map((one) => one / (to - value));
      if (dot(change, change) > ROUGH) break;
    }
    return column;
  }

  // Products of all columns with each other, those of `known` that are the same columns not computed again.
  function gram(columns, known) {
    const place = new Map(known ? known.columns.map((one, k) => [one, k]) : []);
    const at = columns.map((one) => place.get(one));
    const square = columns.map(() => new Array(columns.length));
    columns.forEach((one, j) => {
      for (let k = 0; k <= j; k += 1) square[j][k] = square[k][j] = at[j] === undefined || at[k] === undefined ? dot(one, columns[k]) : known.square[at[j]][at[k]];
    });
    return { columns, square };
  }

  // Fits `free` from `start` (values of the model). `columns`: known slopes; `known`: their products. `report(cost, values, zeros)` is called at every better point.
  function leastSquares(misfit, free, start, { columns = [], refreshed = REFRESHED, known = null, report = () => {} } = {}) {
    let values = Float64Array.from(start);
    let residual = misfit.residual(values);
    let zeros = misfit.bestZeros(residual);
    let cost = misfit.cost(values, residual, zeros);
    const slopes = free.map((_, k) => columns[k]);
    let fresh = columns.length === 0; // whether all slopes were taken at this very point
    let refreshes = refreshed;
    let products = known;
    for (const last = misfit.runs + RUNS; misfit.runs < last; ) {
      free.forEach((unknown, k) => {
        if (!slopes[k] || !unknown.spread) slopes[k] = slope(misfit, unknown, values, residual);
      });
      const step = attempt();
      const gain = step ? cost - step.cost : 0;
      const allFresh = fresh;
      if (step) {
        ({ values, residual, zeros, cost } = step);
        report(cost, values, zeros);
        fresh = false;
      }
      if (gain > DONE * cost) continue;
      if (allFresh || refreshes === 0) break;
      refreshes -= 1;
      fresh = true;
      free.forEach((unknown, k) => { if (unknown.spread) slopes[k] = null; });
    }
    free.forEach((unknown, k) => { slopes[k] ??= slope(misfit, unknown, values, residual); });
    return { values, zeros, residual, cost, slopes, products };

    // The first damped step that lowers the cost.
    function attempt() {
      const rest = misfit.corrected(residual, zeros);
      const all = [...slopes, ...misfit.additive];
      const count = free.length;
      products = gram(all, products);
      const scale = all.map((_, k) => Math.sqrt(products.square[k][k]) || 1);
      const square = products.square.map((row, j) => row.map((one, k) => one / (scale[j] * scale[k])));
      const down = all.map((column, k) => dot(column, rest) / scale[k]);
      all.forEach((_, k) => {
        const std = k < count ? free[k].std : 1;
        const at = k < count ? (std < Infinity ? deviation(free[k], values) : 0) : zeros[k - count];
        square[k][k] += 1 / (std * scale[k]) ** 2;
        down[k] -= at / (std * scale[k]);
      });
      for (const damping of DAMPED) {
        const damped = square.map((row, k) => row.map((one, j) => (j === k ? one * (1 + damping) + 1e-12 : one)));
        const trial = Float64Array.from(values);
        const held = new Set();
        for (let pass = 0; pass <= count; pass += 1) {
          // a value that reaches its bound is held, and the others are solved again
          const at = all.map((_, k) => k).filter((k) => !held.has(k));
          const step = solved(at.map((k) => at.map((j) => damped[k][j])), at.map((k) => down[k] - [...held].reduce((sum, j) => sum + damped[k][j] * (trial[free[j].ids[0]] - values[free[j].ids[0]]) * scale[j], 0)));
          if (!step) break;
          let out = false;
          at.forEach((k, place) => {
            if (k >= count) return;
            const wanted = values[free[k].ids[0]] + step[place] / scale[k];
            const kept = Math.min(Math.max(wanted, free[k].lower), free[k].upper);
            put(free[k], trial, kept);
            if (kept !== wanted) {
              held.add(k);
              out = true;
            }
          });
          if (!out) break;
        }
        try {
          const after = misfit.residual(trial);
          const its = misfit.bestZeros(after);
          const costs = misfit.cost(trial, after, its);
          if (costs < cost) return { values: trial, residual: after, zeros: its, cost: costs };
        } catch {
          // the model refuses the values: a smaller step
        }
      }
      return null;
    }
  }

  // Every combination of the values of `starts` ({field: [..]}).
  const combined = (starts) => Object.entries(starts).reduce((list, [field, values]) => list.flatMap((one) => values.map((value) => ({ ...one, [field]: value }))), [{}]);

  // The `count` best first values of an effect from `values` of the model, jointly with what `base` fits: each start is simulated once (a phase: twice), and its size is scaled to lower the cost most.
  function screened(misfit, base, effect, from, count) {
    const [size] = effect.rows;
    const phase = effect.rows.find((row) => !row.whole && row.field.endsWith("phase_rad"));
    const all = [...base.slopes, ...misfit.additive];
    const before = misfit.residual(from);
    const rest = { vector: before, shared: all.map((one) => dot(one, before)) };
    const stds = [...base.free.map((one) => one.std), ...misfit.additive.map(() => 1)];
    const square = gram(all, base.products).square.map((row, j) => row.map((one, k) => one * (j === k ? 1 + 1e-12 : 1) + (j === k ? 1 / stds[j] ** 2 : 0)));
    const seen = (changes) => {
      const values = Float64Array.from(from);
      for (const row of effect.rows) values[row.id] = changes[row.field] ?? row.on;
      const vector = minus(before, misfit.residual(values));
      return { vector, shared: all.map((one) => dot(one, vector)) };
    };
    const oneSided = !(size.bounds[0] < size.zero);
    const product = (one, other, by = solved(square, other.shared)) => dot(one.vector, other.vector) - (by ? dot(one.shared, by) : 0);
    const found = [];
    for (const start of combined(effect.starts)) {
      try {
        const changes = { ...start };
        const first = changes[size.field] ?? size.on;
        let share;
        let gain;
        if (phase) {
          const [one, other] = [0, Math.PI / 2].map((at) => seen({ ...changes, [phase.field]: at }));
          const by = solved([[product(one, one), product(one, other)], [product(one, other), product(other, other)]], [product(one, rest), product(other, rest)]);
          if (!by) continue;
          share = Math.hypot(by[0], by[1]);
          changes[phase.field] = Math.atan2(by[1], by[0]);
          gain = by[0] * product(one, rest) + by[1] * product(other, rest);
        } else {
          const one = seen(changes);
          const along = product(one, rest);
          const length = product(one, one);
          if (!(length > 0)) continue;
          share = along / length;
          gain = along * share;
          if (share < 0 && oneSided) gain = -gain;
        }
        if (!(size.field in start)) {
          const factor = Math.sign(share || 1) * Math.min(Math.max(Math.abs(share), FACTORS[0]), FACTORS[1]);
          changes[size.field] = size.zero + (first - size.zero) * (share < 0 && oneSided ? 0.1 : factor);
        }
        const values = Float64Array.from(from);
        for (const row of effect.rows) values[row.id] = Math.min(Math.max(changes[row.field] ?? row.on, row.bounds[0]), row.bounds[1]);
        found.push({ values, gain });
      } catch {
        // the model refuses this start
      }
    }
    return found.sort((a, b) => b.gain - a.gain).slice(0, count);
  }

  // The fit of `rows` and of the values with a prior, without any further effect.
  function based(misfit, rows, values, report = () => {}) {
    const free = unknowns(misfit, rows);
    const found = leastSquares(misfit, free, values, { report });
    return { free, first: values, ...found, products: gram([...found.slopes, ...misfit.additive], found.products) };
  }

  // One effect with all of its values free, jointly with what `base` fits. null where the model refuses every start.
  function withEffect(misfit, base, effect, report = () => {}) {
    const rows = effect.rows.filter((row) => !row.whole);
    const free = [...base.free, ...unknowns({ spread: [] }, rows)];
    let best = null;
    // from the fitted model, and from the one before it: without the effect, the others may have run away
    const starts = [...screened(misfit, base, effect, base.values, 2), ...screened(misfit, base, effect, base.first, 1)];
    for (const { values } of starts) {
      try {
        const found = leastSquares(misfit, free, values, { columns: base.slopes, known: base.products, refreshed: 0, report });
        if (!best || found.cost < best.cost) best = found;
      } catch {
        // the model refuses this start
      }
    }
    if (!best) return null;
    const end = leastSquares(misfit, free, best.values, { columns: base.slopes, known: base.products, report });
    const edge = rows.filter((row) => end.values[row.id] !== row.zero && row.bounds.includes(end.values[row.id])).map((row) => row.name);
    return { name: effect.name, values: Array.from(end.values), zeros: Array.from(end.zeros), cost: end.cost, error: misfit.error(end.cost), count: rows.length, edge };
  }

  // The ticked `rows` and the values with a prior, from `values`. Each of `effects`, of which all that is ticked is free, is sought from its other starts, too.
  function fitted(misfit, rows, effects, values, report) {
    const plain = rows.filter((row) => !row.whole);
    let best = leastSquares(misfit, unknowns(misfit, plain), values, { report });
    for (const effect of effects) {
      const ids = new Set(effect.rows.map((row) => row.id));
      const without = Float64Array.from(best.values);
      without[effect.rows[0].id] = effect.rows[0].zero;
      const found = withEffect(misfit, based(misfit, plain.filter((row) => !ids.has(row.id)), without), effect, (cost, ...at) => cost < best.cost && report(cost, ...at));
      if (found && found.cost < best.cost) best = found;
    }
    return { values: Array.from(best.values), zeros: Array.from(best.zeros), error: misfit.error(best.cost) };
  }

  // Least error first; of errors that are equal to the digits shown, the fewer values first.
  const inOrder = (list) => list.sort((a, b) => Number(a.error.toPrecision(SAME_DIGITS)) - Number(b.error.toPrecision(SAME_DIGITS)) || a.count - b.count || a.error - b.error);

  return { Lines, misfitOf, based, withEffect, fitted, inOrder };
})();
if (typeof module !== "undefined") module.exports = EmaFit;
