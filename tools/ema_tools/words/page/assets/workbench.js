// The workbench in the page: one model and one record in memory, a worker that fits, and what is drawn of them. States errors, never a verdict.
(async () => {
  "use strict";
  const { CHANNELS, Desk, noiseOf, startOf, readCsv } = EmaWorkbench;
  const root = document.querySelector("[data-workbench]");
  const data = JSON.parse(document.getElementById("workbench-data").textContent);
  const FAULTS = ["screw.csj_Nm", "screw.blk_mm"];
  const UNDONE_MAX = 200; // changes that can be undone
  const ONE_CHANGE_MS = 800; // moves of one value in quicker succession are one change
  const TIMES = 101; // redraws that the median is taken of
  // title, unit, and of the residual its unit and how many of them are in one
  const SHOWN = {
    position_mm: ["Rod position", "mm", "\u00b5m", 1000], motor_position_mm: ["Motor position", "mm", "\u00b5m", 1000], current_A: ["Motor current", "A", "A", 1], voltage_V: ["Motor voltage", "V", "V", 1],
  };

  function make(tag, attributes = {}, ...children) {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
      if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
      else if (value === true) element.setAttribute(name, "");
      else if (value !== false && value !== undefined) element.setAttribute(name, value);
    }
    element.append(...children);
    return element;
  }
  const digits = (value, count = 4) => (value === 0 ? "0" : Math.abs(value) >= 1e5 || Math.abs(value) < 1e-4 ? value.toExponential(count - 1) : value.toPrecision(count)).replace("-", "\u2212");

  const message = make("p", { class: "bench-message", role: "status", "aria-live": "polite" }, "Unpacking the module \u2026");
  root.append(message);
  const say = (text, refused = false) => {
    message.textContent = text;
    message.classList.toggle("refused", refused);
  };
  const lacking = [["DecompressionStream", "unpack it"], ["WebAssembly", "run it"], ["Worker", "fit beside the page"]].find(([name]) => !(name in window));
  if (lacking) return say(`This browser cannot ${lacking[1]}: open the page in one of 2023 or later.`, true);

  async function inflated(text) {
    const bytes = Uint8Array.from(atob(text), (one) => one.charCodeAt(0));
    return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer());
  }
  // float32 numbers whose first bytes stand together, then the second ones, and so on
  async function column(text, rows) {
    const planes = await inflated(text);
    const bytes = new Uint8Array(4 * rows);
    for (let k = 0; k < bytes.length; k += 1) bytes[k] = planes[(k % 4) * rows + (k >> 2)];
    return Float64Array.from(new Float32Array(bytes.buffer));
  }

  const module = await inflated(data.module);
  const desk = await Desk.open(module);
  const given = { ...data.record };
  for (const [name, text] of Object.entries(data.record.columns)) given[name] = await column(text, data.record.rows);
  if (data.weighed) {
    const [target, weights] = [{}, {}];
    for (const [name, text] of Object.entries(data.weighed.target)) target[name] = await column(text, data.record.rows);
    for (const [name, text] of Object.entries(data.weighed.weights)) weights[name] = await column(text, Math.floor(data.weighed.rows / 2) + 1);
    given.weighed = { ...data.weighed, target, weights };
  }
  let record = null;
  let noise = null;
  let startMm = 0;
  let view = [0, 0];
  let rodAlone = false;
  let running = null; // what the worker does
  let misfit = null; // of the record with the model
  const times = [];

  const effects = data.effects;
  const rows = [...data.rows, ...effects.flatMap((effect) => effect.rows)];
  const unseen = data.unseen; // values without a slider, which a model that is loaded may set
  const rowOf = Object.fromEntries([...rows, ...unseen].map((row) => [row.name, row]));
  const values = Float64Array.from(data.model.values);
  let zeros = new Float64Array(0); // sensor zeros and slight effects that a fit has found, in standard deviations
  const isOn = (effect) => values[effect.rows[0].id] !== effect.rows[0].zero;

  // ---- the worker: the same engine and module, so that the page stays alive while it fits

  const source = `${document.getElementById("workbench-engine").textContent}
    let opened = null; // what is asked meanwhile waits for it
    let desk = null;
    const found = (job, misfit) => {
      if (job.kind === "fit") {
        return EmaFit.fitted(misfit, job.rows, job.effects, job.values, (cost, values, zeros) => postMessage({ id: job.id, runs: misfit.runs, error: misfit.error(cost), values, zeros }));
      }
      const base = EmaFit.based(misfit, job.rows, job.values);
      const ranked = [{ name: "", values: base.values, zeros: base.zeros, error: misfit.error(base.cost), count: 0, edge: [] }];
      for (const effect of job.effects) {
        postMessage({ id: job.id, ranked: EmaFit.inOrder(ranked), next: effect.name });
        const one = EmaFit.withEffect(misfit, base, effect);
        if (one) ranked.push(one);
      }
      return EmaFit.inOrder(ranked);
    };
    onmessage = async ({ data }) => {
      try {
        if (data.open) {
          opened = EmaWorkbench.Desk.open(data.open).then((one) => {
            desk = one;
            desk.load(data.setting.record);
            return data.setting;
          });
          return;
        }
        const setting = await opened;
        postMessage({ id: data.id, found: found(data, EmaFit.misfitOf(desk, { ...setting, rodAlone: data.rodAlone })) });
      } catch (error) {
        postMessage({ id: data.id, refused: error.message, offender: error.offender });
      }
    };`;
  const workerUrl = URL.createObjectURL(new Blob([source], { type: "text/javascript" }));
  let worker = null;
  let asked = 0;
  function openWorker() {
    if (worker) worker.terminate();
    worker = new Worker(workerUrl);
    worker.postMessage({ open: module, setting: setting() });
  }
  // What a misfit is of, as the worker takes it.
  function setting() {
    const columns = Object.fromEntries(["command_mm", ...CHANNELS].filter((name) => record[name]).map((name) => [name, record[name]]));
    return { model: data.model, startMm, record: columns, noise, weighed: record.weighed };
  }
  function weigh() {
    misfit = EmaFit.misfitOf(desk, { ...setting(), rodAlone });
    zeros = new Float64Array(misfit.additive.length);
  }
  // One job in the worker, whose progress goes to `report`. Resolves with null where it was stopped.
  function inWorker(job, report) {
    asked += 1;
    const id = asked;
    return new Promise((resolve, reject) => {
      running = { stop: () => resolve(null) };
      worker.onmessage = ({ data: heard }) => {
        if (heard.id !== id) return;
        if (heard.refused) reject(Object.assign(new Error(refusal(heard)), heard));
        else if (heard.found) resolve(heard.found);
        else report(heard);
      };
      worker.onerror = () => reject(new Error("the worker ended: reload the page"));
      worker.postMessage({ id, rodAlone, values, ...job });
    });
  }
  function refusal(error) {
    const name = data.names[error.offender];
    const what = error.refused || error.message;
    return name ? `${name}: ${what}: move it back` : `${what}: change the model or the record`;
  }

  // ---- what is computed and drawn

  const weighed = () => !rodAlone && record.weighed !== undefined;
  let shown = null;
  function compute(settle = false) {
    const simulated = misfit.simulate(values);
    const weightedResidual = misfit.residual(values, simulated);
    if (settle) zeros = misfit.credibleZeros(weightedResidual);
    const signals = {};
    for (const name of CHANNELS.filter((one) => record[one])) {
      const residual = record[name].map((value, row) => value - simulated[name][row]);
      const norm = (list) => Math.sqrt(list.reduce((sum, value) => sum + value * value, 0));
      const whole = norm(record[name]);
      signals[name] = { measured: record[name], simulated: simulated[name], residual, rms: norm(residual) / Math.sqrt(residual.length), percent: whole > 0 ? (100 * norm(residual)) / whole : null };
    }
    shown = { error: misfit.error(misfit.cost(values, weightedResidual, zeros)), signals };
  }
  function draw(mark = null) {
    for (const [name, { canvas, title }] of Object.entries(plots)) {
      const signal = shown.signals[name];
      const [shownAs, , unit, scale] = SHOWN[name];
      EmaPlots.draw(canvas, signal, view, record.start_s, record.period_s, mark, scale, unit);
      let sum = 0;
      for (let k = view[0]; k <= view[1]; k += 1) sum += signal.residual[k] ** 2;
      const rms = Math.sqrt(sum / (view[1] - view[0] + 1));
      const times = noise[name] ? `, ${digits(rms / noise[name], 3)} times its noise` : "";
      title.textContent = `residual ${digits(scale * rms, 3)} ${unit} rms in view${times}${signal.percent === null ? "" : `; ${digits(signal.percent, 3)} % of the whole`}`;
      canvas.setAttribute("aria-label", `${shownAs}, measured and simulated against time, and their difference: ${title.textContent}`);
    }
  }
  let pending = null;
  let settling = false; // whether the zeros of the sensors follow the next time
  // Once a frame at most; what is reported is from the first change to the drawn picture.
  function redraw() {
    if (pending !== null) return;
    pending = performance.now();
    requestAnimationFrame(() => {
      const from = pending;
      pending = null;
      try {
        compute(settling);
        settling = false;
        draw();
        tellError();
        if (message.classList.contains("refused")) say("");
      } catch (error) {
        say(refusal(error), true);
        return;
      }
      times.push(performance.now() - from);
      if (times.length > TIMES) times.shift();
      timing.textContent = `${record.file}: ${(record.period_s * record.command_mm.length).toPrecision(3)} s redrawn in ${medianTime().toFixed(0)} ms, median of ${times.length}`;
    });
  }
  const medianTime = () => [...times].sort((a, b) => a - b)[times.length >> 1] ?? NaN;
  function tellError() {
    errorOut.value = digits(shown.error, 4);
    errorOf1.textContent = rodAlone ? "times the sensor noise, rod position alone" : weighed() ? "times the sensor noise, as the diagnosis weighs it" : "times the sensor noise, all signals";
  }

  // ---- values and effects

  const inputs = {};
  function setValue(row, value, silent = false) {
    values[row.id] = value;
    if (!inputs[row.name]) return silent ? undefined : redraw();
    const { slider, number } = inputs[row.name];
    if (value < Number(slider.min)) slider.min = value;
    if (value > Number(slider.max)) slider.max = value;
    slider.value = value;
    if (document.activeElement !== number) number.value = Number(value.toPrecision(5));
    if (!silent) redraw();
  }
  function valueRow(row, ticked) {
    const identity = `bench-${row.name.replace(/\W/g, "-")}`;
    const tick = make("input", { type: "checkbox", checked: ticked, "aria-label": `fit ${row.label}`, title: "fit this value" });
    const slider = make("input", { type: "range", min: row.low, max: row.high, step: "any", id: identity });
    const number = make("input", { type: "number", step: "any", "aria-label": `${row.label}${row.unit ? `, ${row.unit}` : ""}` });
    const change = (value) => {
      remember(row.name);
      setValue(row, value);
    };
    slider.addEventListener("input", () => change(Number(slider.value)));
    number.addEventListener("input", () => Number.isFinite(number.valueAsNumber) && change(number.valueAsNumber));
    inputs[row.name] = { tick, slider, number };
    return make("div", { class: "bench-row", title: row.remark }, tick, make("label", { for: identity }, row.label, row.unit ? make("small", {}, ` ${row.unit}`) : ""), number, slider);
  }
  // What can be undone: values, zeros of the sensors and ticks before each change.
  const undone = [];
  let changed = { what: "", at: -Infinity };
  const ticks = () => rows.filter((row) => inputs[row.name].tick.checked);
  function remember(what = "") {
    const at = performance.now();
    const same = what && what === changed.what && at - changed.at < ONE_CHANGE_MS;
    changed = { what, at };
    if (same) return;
    undone.push({ values: Float64Array.from(values), zeros, ticked: ticks() });
    if (undone.length > UNDONE_MAX) undone.shift();
    undoButton.disabled = running !== null;
  }
  function undo() {
    if (running || !undone.length) return;
    const before = undone.pop();
    changed = { what: "", at: -Infinity };
    undoButton.disabled = !undone.length;
    for (const row of rows) inputs[row.name].tick.checked = before.ticked.includes(row);
    take(before);
  }
  // The values of a whole model, and the zeros of the sensors that go with them.
  function take(other) {
    for (const row of [...rows, ...unseen]) setValue(row, other.values[row.id], true);
    zeros = other.zeros.length === zeros.length ? Float64Array.from(other.zeros) : zeros;
    effects.forEach(showEffect);
    tellUnseen();
    redraw();
  }
  const switches = {};
  // On, all values of an effect are fitted; off, it leaves the model as it was without it, to the bit.
  function turn(effect, on) {
    const [size] = effect.rows;
    for (const row of effect.rows) {
      const off = effect.active ? (row === size ? size.zero : values[row.id]) : row.value;
      setValue(row, on ? row.on : off, true);
      inputs[row.name].tick.checked = on;
    }
    showEffect(effect);
  }
  function showEffect(effect) {
    switches[effect.name].box.checked = isOn(effect);
    switches[effect.name].rows.hidden = !isOn(effect);
    switches[effect.name].equation.hidden = !isOn(effect);
  }
  function effectPart(effect) {
    const box = make("input", { type: "checkbox", onchange: () => { remember(); turn(effect, box.checked); redraw(); } });
    const part = make("div", { class: "bench-rows" }, ...effect.rows.map((row) => valueRow(row, false)));
    const equation = make("p", { class: "equation", title: effect.source }, effect.equation);
    switches[effect.name] = { box, rows: part, equation };
    return make("div", { class: "bench-effect" }, make("label", {}, box, make("span", {}, effect.title, " ", make("code", {}, effect.name))), equation, part);
  }
  // Any values by name, as the actuator's file has them; `fresh`: all others as the model was given.
  function load(changes, fresh = false) {
    remember();
    if (fresh) reset();
    settling = Object.keys(changes).length > 0;
    for (const [name, value] of Object.entries(changes)) {
      if (!rowOf[name]) throw new Error(`${name}: the workbench has no such value: it has ${Object.keys(rowOf).join(", ")}`);
      setValue(rowOf[name], value, true);
    }
    effects.forEach(showEffect);
    tellUnseen();
    redraw();
  }
  const unlike = () => unseen.filter((row) => values[row.id] !== row.value);
  // What a model that was loaded sets beside the sliders is said, or the error would be of values that nobody sees.
  function tellUnseen() {
    const set = unlike();
    unseenPart.hidden = !set.length;
    unseenPart.replaceChildren(make("legend", {}, `${set.length} value${set.length === 1 ? "" : "s"} without a slider, set by the loaded model`),
      make("ul", {}, ...set.map((row) => make("li", { title: row.remark, "data-set": row.name }, `${row.label}: ${digits(values[row.id])}${row.unit ? ` ${row.unit}` : ""}, was ${digits(row.value)} `, make("code", {}, row.name)))));
  }
  function reset() {
    zeros = new Float64Array(zeros.length);
    for (const row of [...rows, ...unseen]) setValue(row, row.value, true);
    tellUnseen();
    for (const row of rows) inputs[row.name].tick.checked = FAULTS.includes(row.name);
    effects.forEach(showEffect);
    fall.hidden = true;
    redraw();
  }

  // ---- fits

  function busy(on) {
    for (const button of [fitButton, rankButton, resetButton]) button.disabled = on;
    undoButton.disabled = on || !undone.length;
    stopButton.disabled = !on;
  }
  // An effect as a fit takes it: what is not ticked stays as it is.
  function ofFit(effect) {
    const starts = Object.fromEntries(Object.entries(effect.starts).filter(([field]) => effect.rows.some((row) => row.field === field && inputs[row.name].tick.checked)));
    const effectRows = effect.rows.map((row) => (inputs[row.name].tick.checked ? row : { ...row, whole: true, on: values[row.id] }));
    return { ...effect, rows: effectRows, starts };
  }
  const fallen = [];
  function drawFall() {
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [fall.clientWidth, fall.clientHeight];
    fall.width = width * ratio;
    fall.height = height * ratio;
    const context = fall.getContext("2d");
    context.scale(ratio, ratio);
    const logs = fallen.map(([, best]) => Math.log10(best));
    const [low, high] = [Math.min(...logs), Math.max(...logs)];
    const end = fallen[fallen.length - 1];
    context.strokeStyle = getComputedStyle(root).getPropertyValue("--after").trim() || "#0a6aa8";
    context.lineWidth = 2;
    context.beginPath();
    fallen.forEach(([run], k) => context.lineTo(4 + (run / end[0]) * (width - 8), height - 6 - ((logs[k] - low) / (high - low || 1)) * (height - 24)));
    context.stroke();
    context.fillStyle = getComputedStyle(root).color;
    context.font = `11px ${getComputedStyle(document.body).fontFamily}`;
    context.fillText(`error ${digits(fallen[0][1], 3)}, now ${digits(end[1], 3)} after ${end[0]} model runs, logarithmic`, 4, 11);
    fall.setAttribute("aria-label", `Error during the fit: ${digits(fallen[0][1], 3)} at first, ${digits(end[1], 3)} after ${end[0]} model runs`);
  }
  async function fit() {
    const fitted = ticks();
    if (!fitted.length) return say("Nothing is ticked: tick the values that are to be fitted.", true);
    const sought = effects.filter((effect) => isOn(effect) && inputs[effect.rows[0].name].tick.checked && effect.rows.length > 1).map(ofFit);
    const whole = fitted.find((row) => row.whole && !sought.some((effect) => effect.rows.some((one) => one.id === row.id)));
    if (whole) return say(`${whole.name} is a whole number, which is tried together with the size of its effect: tick that, too.`, true);
    for (const row of fitted) row.bounds = [Math.min(row.bounds[0], values[row.id]), Math.max(row.bounds[1], values[row.id])];
    remember();
    busy(true);
    fall.hidden = false;
    fallen.length = 0;
    let best = null;
    const before = shown.error;
    const began = performance.now();
    try {
      const found = await inWorker({ kind: "fit", rows: fitted, effects: sought }, (heard) => {
        best = heard;
        fallen.push([heard.runs, heard.error]);
        requestAnimationFrame(drawFall);
        say(`Fitting ${fitted.map((row) => row.label).join(", ")}: ${heard.runs} model runs, error ${digits(heard.error)}`);
      });
      if (found || best) take(found ?? best);
      const edge = found ? fitted.filter((row) => row.bounds.includes(values[row.id]) && values[row.id] !== row.zero).map((row) => row.label) : [];
      say(
        found
          ? `Fitted: error ${digits(before)} before, ${digits(found.error)} after ${fallen.length ? fallen[fallen.length - 1][0] : 0} model runs in ${((performance.now() - began) / 1000).toFixed(1)} s${edge.length ? `; on a bound of the fit: ${edge.join(", ")}` : ""}.`
          : "Stopped; the model has the best values so far.",
      );
    } catch (error) {
      say(error.message, true);
    } finally {
      running = null;
      busy(false);
    }
  }
  // Every effect that the model does not hold, each with all of its values, CSJ, BLK and what is ticked: the error that is left.
  async function rank() {
    const rowsOfAll = rows.filter((row) => !row.whole && (inputs[row.name].tick.checked || FAULTS.includes(row.name)) && (values[row.id] > 0 || !FAULTS.includes(row.name)));
    const candidates = effects.filter((effect) => effect.ranked && !isOn(effect));
    const began = performance.now();
    let ranked = [];
    busy(true);
    rankPart.hidden = false;
    try {
      const found = await inWorker({ kind: "rank", rows: rowsOfAll, effects: candidates }, (heard) => {
        ranked = heard.ranked;
        const place = candidates.findIndex((effect) => effect.name === heard.next);
        say(`Ranking ${place + 1} of ${candidates.length}: ${candidates[place].title}`);
        showRank(ranked);
      });
      if (!found) return say(`Stopped after ${Math.max(ranked.length - 1, 0)} of ${candidates.length}.`);
      showRank(found);
      say(`Ranked ${found.length - 1} effects in ${((performance.now() - began) / 1000).toFixed(0)} s, least error first. This is no verdict: ema diagnose weighs them.`);
    } catch (error) {
      say(error.message, true);
    } finally {
      running = null;
      busy(false);
    }
  }
  function showRank(ranked) {
    rankBody.replaceChildren(
      ...ranked.map((one) => {
        const effect = effects.find((other) => other.name === one.name);
        const title = effect ? effect.title : "No effect, both faults alone";
        const own = effect ? effect.rows.map((row) => `${row.field} ${digits(one.values[row.id], 3)}${one.edge.includes(row.name) ? " (on a bound)" : ""}`).join(", ") : "\u2013";
        const use = () => {
          remember();
          take(one);
          for (const row of effect ? effect.rows : []) inputs[row.name].tick.checked = true;
        };
        return make("tr", { "data-effect": one.name },
          make("th", { scope: "row" }, title),
          make("td", {}, digits(one.error)),
          ...FAULTS.map((name) => make("td", {}, digits(one.values[rowOf[name].id]))),
          make("td", { class: "left" }, own),
          make("td", {}, make("button", { type: "button", "aria-label": `load ${title}`, onclick: use }, "load")));
      }),
    );
  }
  function stop() {
    if (!running) return;
    running.stop();
    openWorker();
  }

  // ---- records and files

  function useRecord(next) {
    desk.load(next);
    record = next;
    noise = noiseOf(next);
    if (!noise.position_mm) throw new Error(`${next.file}: position_mm never moves: give a record in which the rod moves`);
    startMm = startOf(next, data.start.blk_upper_mm, data.start.noise_mm);
    weigh();
    view = [0, next.command_mm.length - 1];
    times.length = 0;
    plotPart.replaceChildren();
    for (const name of Object.keys(plots)) delete plots[name];
    for (const name of CHANNELS.filter((one) => next[one])) {
      const title = make("small");
      const canvas = make("canvas", { role: "img", "data-channel": name });
      plots[name] = { canvas, title };
      zoomable(canvas);
      plotPart.append(make("figure", {}, make("h3", {}, `${SHOWN[name][0]}, ${SHOWN[name][1]} `, title), canvas));
    }
    openWorker();
  }
  function zoomable(canvas) {
    let from = null;
    const at = (event) => event.clientX - canvas.getBoundingClientRect().left;
    canvas.addEventListener("pointerdown", (event) => {
      from = at(event);
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => from !== null && draw([from, at(event)]));
    canvas.addEventListener("pointerup", (event) => {
      const ends = [from, at(event)].sort((a, b) => a - b);
      from = null;
      const zoomed = ends.map((px) => EmaPlots.rowAt(canvas, px, view));
      if (ends[1] - ends[0] > 6 && zoomed[1] - zoomed[0] > 8) view = zoomed;
      draw();
    });
    canvas.addEventListener("pointercancel", () => { from = null; draw(); });
    canvas.addEventListener("dblclick", whole);
  }
  function whole() {
    view = [0, record.command_mm.length - 1];
    draw();
  }
  // The same without a mouse: plus and minus zoom, arrows move, Home shows the whole record.
  function byKey(event) {
    const end = record.command_mm.length - 1;
    const [first, last] = view;
    const span = last - first;
    const [from, size] = { "+": [first + span / 4, span / 2], "=": [first + span / 4, span / 2], "-": [first - span / 2, 2 * span], ArrowLeft: [first - span / 4, span], ArrowRight: [first + span / 4, span], Home: [0, end] }[event.key] ?? [];
    if (from === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    const kept = Math.min(Math.max(Math.round(size), 8), end);
    const start = Math.min(Math.max(Math.round(from), 0), end - kept);
    view = [start, start + kept];
    draw();
  }
  async function takeFile(file) {
    const before = record;
    try {
      if (running) throw new Error(`${file.name}: a fit is running: stop it first`);
      useRecord(readCsv(await file.text(), file.name, data.record.period_s));
      compute();
      draw();
      tellError();
      redraw();
      say(`${file.name}: ${record.command_mm.length} rows with ${CHANNELS.filter((name) => record[name]).join(", ")}.`);
    } catch (error) {
      if (record !== before || !shown) useRecord(before);
      redraw();
      await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
      say(error.message, true);
    }
  }
  const valueOf = (row) => values[row.id];
  const texts = { toml: () => EmaText.toml(data.actuator.toml, [...rows, ...unlike()], valueOf), header: () => EmaText.header(data.actuator.header, [...rows, ...unlike()], valueOf) };
  function save(name, text) {
    const url = URL.createObjectURL(new Blob([text], { type: "text/plain" }));
    make("a", { href: url, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(url), 1000);
  }

  // ---- the page's part

  const unseenPart = make("fieldset", { class: "bench-unseen", hidden: true });
  const plots = {};
  const plotPart = make("div", { class: "bench-plots", tabindex: "0", role: "group", "aria-label": "Signals of the workbench over time. Plus and minus zoom, arrow keys move, Home shows the whole record.", onkeydown: byKey });
  const errorOut = make("output", { "aria-label": "error" });
  const errorOf1 = make("span");
  const timing = make("p", { class: "note" });
  const fall = make("canvas", { class: "bench-fall", role: "img", "aria-label": "Error during the fit", hidden: true });
  const fitButton = make("button", { type: "button", class: "first", onclick: fit }, "Fit ticked values");
  const rankButton = make("button", { type: "button", onclick: rank }, "Rank all effects");
  const stopButton = make("button", { type: "button", onclick: stop, disabled: true }, "Stop");
  const undoButton = make("button", { type: "button", onclick: undo, disabled: true, title: "Ctrl+Z" }, "Undo");
  const resetButton = make("button", { type: "button", onclick: () => { remember(); reset(); } }, "Reset");
  const picker = make("input", { type: "file", accept: ".csv,text/csv", id: "bench-file", onchange: () => picker.files[0] && takeFile(picker.files[0]) });
  const drop = make("div", { class: "bench-drop" }, make("label", { for: "bench-file" }, "Another record of this actuator: drop a CSV anywhere on the page, or choose one. Columns time_s, command_mm, position_mm and, where there are any, motor_position_mm, current_A, voltage_V. "), picker);
  const rod = make("input", { type: "checkbox", onchange: () => { rodAlone = rod.checked; weigh(); redraw(); } });
  const rankBody = make("tbody");
  const rankPart = make("div", { class: "bench-rank scroll", role: "region", "aria-label": "Table: effects ranked", tabindex: "0", hidden: true },
    make("table", {}, make("caption", {}, "Error left, in multiples of the sensor noise, after all values of each effect were fitted with CSJ, BLK and what is ticked. No verdict: effects that look alike fit alike."),
      make("thead", {}, make("tr", {}, ...["Effect", "Error left", "CSJ, Nm", "BLK, mm", "Values", "Load"].map((text, k) => make("th", { scope: "col", ...(k === 0 || k === 4 ? { class: "left" } : {}) }, text)))), rankBody));
  const panel = make("form", { class: "bench-panel", "aria-label": "Model", onsubmit: (event) => event.preventDefault() },
    make("div", { class: "bench-tools" }, fitButton, rankButton, stopButton, undoButton, resetButton), fall,
    make("p", { class: "note" }, "A tick beside a value: it is fitted."),
    make("fieldset", {}, make("legend", {}, "Machine"), ...data.rows.map((row) => valueRow(row, FAULTS.includes(row.name)))),
    unseenPart,
    make("label", { class: "bench-row" }, rod, "Compare the rod position alone, as in flight"),
    make("fieldset", {}, make("legend", {}, "Effects"), ...effects.map(effectPart)),
    drop,
    make("div", { class: "bench-tools" },
      make("button", { type: "button", onclick: () => save(data.actuator.file.replace(/(\.toml)?$/, ".toml"), texts.toml()) }, "Actuator (TOML)"),
      make("button", { type: "button", onclick: () => save("ema_actuator_data.h", texts.header()) }, "C header")));
  const legend = make("ul", { class: "legend" }, ...[["measured", "measured"], ["after", "simulated here"], ["before", "measured minus simulated"]].map(([key, text]) => make("li", {}, make("span", { class: `key ${key}` }), text)));
  const wholeButton = make("button", { type: "button", onclick: whole }, "Whole record");
  try {
    root.append(
      make("div", { class: "bench-head" }, make("p", { class: "bench-error" }, "Error ", errorOut, " ", errorOf1), message),
      make("div", { class: "bench-body" }, make("div", {}, legend, plotPart, make("div", { class: "bench-tools" }, wholeButton, make("span", { class: "note" }, "Drag across a plot to zoom all of them, or press + and \u2212 on them; double click for the whole record.")), timing), panel),
      rankPart);
    useRecord(given);
    for (const row of rows) setValue(row, row.value, true);
    effects.forEach(showEffect);
    compute();
    draw();
    tellError();
    redraw();
    say("");
  } catch (error) {
    return say(refusal(error), true);
  }
  let over = 0;
  const files = (event) => event.dataTransfer && [...event.dataTransfer.types].includes("Files");
  document.addEventListener("dragenter", (event) => { if (files(event)) { over += 1; drop.classList.add("over"); } });
  document.addEventListener("dragleave", (event) => { if (files(event) && --over <= 0) drop.classList.remove("over"); });
  document.addEventListener("dragover", (event) => files(event) && event.preventDefault());
  document.addEventListener("drop", (event) => {
    if (!files(event)) return;
    event.preventDefault();
    over = 0;
    drop.classList.remove("over");
    if (event.dataTransfer.files[0]) takeFile(event.dataTransfer.files[0]);
  });
  document.addEventListener("keydown", (event) => {
    if (event.key.toLowerCase() !== "z" || !(event.ctrlKey || event.metaKey) || event.shiftKey) return;
    if (!root.contains(event.target) && /^(INPUT|TEXTAREA|SELECT)$/.test(event.target.tagName)) return;
    event.preventDefault();
    undo();
  });
  window.addEventListener("resize", () => draw());
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw());

  // For other parts of the page, and for whoever looks at the workbench from outside.
  window.emaWorkbench = {
    load,
    texts,
    state: () => ({
      error: shown.error,
      rms: Object.fromEntries(Object.entries(shown.signals).map(([name, signal]) => [name, signal.rms])),
      percent: Object.fromEntries(Object.entries(shown.signals).map(([name, signal]) => [name, signal.percent])),
      values: Array.from(values),
      noise,
      start_mm: startMm,
      file: record.file,
      view: [...view],
      rows: record.command_mm.length,
      redraws: times.length,
      median_ms: medianTime(),
      undone: undone.length,
      running: running !== null,
      message: message.textContent,
    }),
  };
})();
