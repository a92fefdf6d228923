// The workbench's own scripts in Node: one JSON of jobs on stdin, one of answers on stdout. Arrays of float64 travel as base64.
const fs = require("fs");
const path = require("path");
const given = JSON.parse(fs.readFileSync(0, "utf8"));
const Engine = require(path.join(given.assets, "workbench_engine.js"));
const Fit = require(path.join(given.assets, "workbench_fit.js"));
const Text = require(path.join(given.assets, "workbench_text.js"));

const unpacked = (text) => {
  const bytes = Buffer.from(text, "base64");
  return new Float64Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
};
const packed = (list) => Buffer.from(list.buffer, list.byteOffset, list.byteLength).toString("base64");

const all = (columns) => Object.fromEntries(Object.entries(columns).map(([name, text]) => [name, unpacked(text)]));
// What is left of a record, as the page's worker makes it of the page's own data.
const misfitOf = (desk, { data }, record) => {
  const weighed = data.weighed && { ...data.weighed, target: all(data.weighed.target), weights: all(data.weighed.weights) };
  const startMm = Engine.startOf(record, data.start.blk_upper_mm, data.start.noise_mm);
  return Fit.misfitOf(desk, { model: data.model, startMm, record, noise: Engine.noiseOf(record), weighed, rodAlone: false });
};

const kinds = {
  simulate: (desk, job) => Object.fromEntries(Object.entries(desk.simulate(job.model, job.start_mm)).map(([name, list]) => [name, packed(list)])),
  // The error of values of the model, the zeros of the sensors at their best.
  error: (desk, job, record) => {
    const misfit = misfitOf(desk, job, record);
    return job.values.map((values) => {
      const left = misfit.residual(values);
      return misfit.error(misfit.cost(values, left, misfit.bestZeros(left)));
    });
  },
  rank: (desk, job, record) => {
    const misfit = misfitOf(desk, job, record);
    const base = Fit.based(misfit, job.rows, job.data.model.values);
    const found = job.effects.map((effect) => Fit.withEffect(misfit, base, effect)).filter((one) => one);
    return { base: misfit.error(base.cost), runs: misfit.runs, ranked: Fit.inOrder(found).map(({ name, error, values, edge }) => ({ name, error, values, edge })) };
  },
  fit: (desk, job, record) => {
    const errors = [];
    const misfit = misfitOf(desk, job, record);
    const found = Fit.fitted(misfit, job.rows, job.effects, job.values ?? job.data.model.values, (cost) => errors.push(misfit.error(cost)));
    return { ...found, errors, runs: misfit.runs };
  },
  weighed: (desk, job) => {
    const lines = new Fit.Lines(job.rows, all(job.target), all(job.weights));
    const simulated = all(job.simulated);
    const left = lines.whiten(Object.fromEntries(lines.names.map((name) => [name, lines.target[name].map((value, row) => value - simulated[name][row])])));
    return Math.sqrt(left.reduce((sum, value) => sum + value * value, 0) / lines.numbers);
  },
  noise: (desk, job, record) => Engine.noiseOf(record),
  csv: (desk, job) => {
    const record = Engine.readCsv(job.text, job.file, job.period_s);
    return Object.fromEntries(Object.entries(record).map(([name, value]) => [name, value instanceof Float64Array ? packed(value) : value]));
  },
  texts: (desk, job) => {
    const valueOf = (row) => job.values[row.name] ?? row.value;
    return { toml: Text.toml(job.toml, job.rows, valueOf), header: Text.header(job.header, job.rows, valueOf) };
  },
  numbers: (desk, job) => Array.from(unpacked(job.numbers), (value) => [Text.repr(value), Text.literal(value)]),
};

(async () => {
  const desk = given.wasm ? await Engine.Desk.open(fs.readFileSync(given.wasm)) : null;
  let record = null;
  const answers = [];
  for (const job of given.jobs) {
    try {
      if (job.record) {
        record = Object.fromEntries(Object.entries(job.record).map(([name, text]) => [name, unpacked(text)]));
        desk.load(record);
      }
      answers.push({ answer: kinds[job.kind](desk, job, record) });
    } catch (error) {
      answers.push({ error: error.message, offender: error.offender ?? null });
    }
  }
  process.stdout.write(JSON.stringify(answers));
})();
