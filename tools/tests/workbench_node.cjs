// The workbench's own scripts in Node: one JSON of jobs on stdin, one of answers on stdout. Arrays of float64 travel as base64.
const fs = require("fs");
const path = require("path");
const given = JSON.parse(fs.readFileSync(0, "utf8"));
const Engine = require(path.join(given.assets, "workbench_engine.js"));
const Text = require(path.join(given.assets, "workbench_text.js"));

const unpacked = (text) => {
  const bytes = Buffer.from(text, "base64");
  return new Float64Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
};
const packed = (list) => Buffer.from(list.buffer, list.byteOffset, list.byteLength).toString("base64");

const kinds = {
  simulate: (desk, job) => Object.fromEntries(Object.entries(desk.simulate(job.model, job.start_mm)).map(([name, list]) => [name, packed(list)])),
  objective: (desk, job) => desk.objective(job.model, job.weight, job.start_mm),
  fit: (desk, job) => {
    const runs = [];
    const found = desk.fit(job.model, job.search, (run, cost, best) => runs.push([run, cost, best]) >= (job.stop_after ?? Infinity));
    return { ...found, random_state: String(found.random_state), model_steps: String(found.model_steps), runs };
  },
  weighed: (desk, job) => {
    const of = (columns) => Object.fromEntries(Object.entries(columns).map(([name, text]) => [name, unpacked(text)]));
    return new Engine.Weighed(job.rows, of(job.target), of(job.weights)).error(of(job.simulated));
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
  numbers: (desk, job) => Array.from(unpacked(job.numbers), (value) => [Text.repr(value), Text.nine(value), Text.literal(value)]),
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
