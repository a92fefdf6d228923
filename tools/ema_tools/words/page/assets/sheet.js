"use strict";
(() => {
  const started = performance.now();
  const data = JSON.parse(document.getElementById("page-data").textContent);
  const all = (selector, within = document) => [...within.querySelectorAll(selector)];
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();

  // What no library is needed for: copying the command, the menu, the keys of the heat maps.
  for (const button of all("[data-copy]")) {
    button.addEventListener("click", async () => {
      const source = document.getElementById(button.dataset.copy), label = button.innerHTML;
      try {
        await navigator.clipboard.writeText(source.textContent);
      } catch {
        // a page from disk may be refused the clipboard: the text is selected instead
        getSelection().selectAllChildren(source);
        document.execCommand("copy");
      }
      button.textContent = "copied";
      setTimeout(() => { button.innerHTML = label; }, 1500);
    });
  }
  const links = new Map(all("nav a").map((link) => [link.hash.slice(1), link]));
  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      for (const link of links.values()) link.removeAttribute("aria-current");
      links.get(entry.target.id)?.setAttribute("aria-current", "true");
    }
  }, { rootMargin: "-20% 0px -70% 0px" });
  for (const section of all("main > section")) seen.observe(section);

  // what a link leads to is seen at once
  for (const link of all('a[href^="#"]')) link.addEventListener("click", () => { for (const one of all(`${link.hash} > details.whole`)) one.open = true; });

  // A rung of the ladder in the workbench, which may still be unpacking.
  for (const button of all("[data-load]")) {
    button.addEventListener("click", () => {
      if (!window.emaWorkbench) return;
      window.emaWorkbench.load(JSON.parse(button.dataset.load), true);
      document.getElementById("workbench").scrollIntoView();
    });
  }

  const cells = all("button.cell");
  for (const table of all("table.heat")) {
    table.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] }[event.key];
      const cell = event.target.closest("td");
      if (!step || !cell) return;
      const rows = all("tbody tr", table), row = rows.indexOf(cell.parentElement) + step[0];
      const next = rows[row]?.cells[cell.cellIndex + step[1]]?.querySelector("button.cell");
      event.preventDefault();
      if (!next) return;
      event.target.tabIndex = -1;
      next.tabIndex = 0;
      next.focus();
    });
  }
  const reading = document.getElementById("cell");
  const say = (cell) => { reading.textContent = cell ? cell.getAttribute("aria-label") : "\u00a0"; };
  for (const cell of cells) {
    cell.addEventListener("pointerenter", () => say(cell));
    cell.addEventListener("focus", () => say(cell));
  }

  // Paper is light; this listener comes before those that draw.
  addEventListener("beforeprint", () => { document.documentElement.dataset.light = ""; });
  addEventListener("afterprint", () => { delete document.documentElement.dataset.light; });

  if (typeof uPlot === "undefined" || !data.channels) return;

  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const unpack = (series) => Float64Array.from(new Int16Array(bytes(series.int16).buffer), (value) => value * series.scale);
  const row = data.time.kept ? new Uint32Array(bytes(data.time.kept).buffer) : Uint32Array.from({ length: data.time.rows }, (_, i) => i);
  const time = Float64Array.from(row, (i) => data.time.start_s + i * data.time.period_s);
  const whole = [time[0], time[time.length - 1]];
  const least = 10 * data.time.period_s;
  const binOf = Object.fromEntries(Object.entries(data.bins).map(([by, text]) => [by, bytes(text)]));
  const keys = Object.keys(data.models);
  const shown = { measured: true, ...Object.fromEntries(keys.map((key) => [key, true])) };
  let range = whole, fit = false, lit = null, at = null;

  const rowAt = (value) => {
    let low = 0, high = time.length;
    while (low < high) { const middle = (low + high) >> 1; if (time[middle] < value) low = middle + 1; else high = middle; }
    return low;
  };
  // To three digits, as in the sentences.
  const number = (value) => {
    if (!Number.isFinite(value)) return "–";
    if (value === 0) return "0";
    const power = Number(value.toExponential(2).split("e")[1]);
    if (power < -3 || power >= 6) return value.toExponential(2).replace("e-", "×10^−").replace("e+", "×10^").replace(/^-/, "−");
    return value.toFixed(Math.max(0, 2 - power)).replace(/^-/, "−");
  };
  const reach = (lists, middle) => {
    let low = Infinity, high = -Infinity;
    for (const [values, from, to] of lists) for (let i = from; i < to; i++) { const v = values[i]; if (v < low) low = v; if (v > high) high = v; }
    if (!(high >= low)) return [-1, 1];
    if (middle) { high = Math.max(Math.abs(low), Math.abs(high)); low = -high; }
    const room = 0.06 * (high - low) || 1;
    return [low - room, high + room];
  };

  const channels = data.channels.map((channel) => {
    const measured = unpack(channel.measured), residual = {}, simulated = {};
    for (const key of keys) {
      residual[key] = unpack(channel.residual[key]);
      simulated[key] = measured.map((value, i) => value - residual[key][i] / channel.residual_scale);
    }
    return { ...channel, measured, residual, simulated, element: document.querySelector(`[data-channel="${channel.name}"]`), plots: [] };
  });
  const plots = channels.flatMap((channel) => ["main", "residual"].map((kind) => ({ channel, kind, element: channel.element.querySelector(`.plot.${kind}`), plot: null })));

  // Scale: of the whole record and of every curve, so that plots can be compared, or of what is in view and switched on.
  const scaleOf = ({ channel, kind }) => {
    const [from, to] = fit ? [rowAt(range[0]), rowAt(range[1]) + 1] : [0, time.length];
    const on = (key) => !fit || shown[key];
    const lists = keys.filter(on).map((key) => [kind === "main" ? channel.simulated[key] : channel.residual[key], from, Math.min(to, time.length)]);
    if (kind === "main" && on("measured")) lists.push([channel.measured, from, Math.min(to, time.length)]);
    return reach(lists, kind === "residual");
  };

  const bands = (plot) => {
    if (!lit) return;
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.fillStyle = css("mark");
    const values = binOf[lit.by];
    let start = -1;
    for (let i = 0; i <= time.length; i++) {
      const inside = i < time.length && values[i] === lit.bin;
      if (inside && start < 0) start = i;
      if (!inside && start >= 0) {
        const left = plot.valToPos(time[start], "x", true), right = plot.valToPos(time[i - 1], "x", true);
        if (right >= bbox.left && left <= bbox.left + bbox.width) {
          const from = Math.max(left, bbox.left);
          ctx.fillRect(from, bbox.top, Math.max(2, Math.min(right, bbox.left + bbox.width) - from), bbox.height);
        }
        start = -1;
      }
    }
    ctx.restore();
  };

  const font = "11px " + getComputedStyle(document.body).fontFamily;
  const make = (one) => {
    const { channel, kind, element } = one;
    const main = kind === "main";
    const series = [{}];
    const values = [time];
    if (main) {
      values.push(channel.measured);
      series.push({ label: "measured", stroke: () => css("measured"), width: 4, points: { show: false }, show: shown.measured });
    }
    for (const key of keys) {
      values.push(main ? channel.simulated[key] : channel.residual[key]);
      series.push({ label: key, stroke: () => css(key), width: main ? 1.5 : 1, points: { show: false }, show: shown[key] });
    }
    const axis = { stroke: () => css("soft"), font, grid: { stroke: () => css("grid"), width: 1 }, ticks: { show: false } };
    const plot = new uPlot({
      width: element.clientWidth, height: element.clientHeight,
      legend: { show: false },
      padding: [6, 18, main ? 2 : 0, 0],
      scales: { x: { time: false, range: () => range }, y: { range: () => scaleOf(one) } },
      axes: [
        main ? { ...axis, size: 4, values: () => [] } : { ...axis, size: 20, gap: 2, values: (_, ticks) => ticks.map((tick, i) => (i === ticks.length - 1 ? `${tick} s` : `${tick}`.replace("-", "−"))) },
        { ...axis, size: 50, gap: 4, space: main ? 26 : 16, label: main ? undefined : `residual, ${channel.residual_unit}`, labelSize: 13, labelFont: font, labelGap: 0, values: (_, ticks) => ticks.map((tick) => `${tick}`.replace("-", "−")) },
      ].map((one_, place) => (place === 1 && main ? { ...one_, size: 63, label: undefined } : one_)),
      series,
      cursor: {
        y: false,
        points: { size: 6 },
        drag: { x: true, y: false, setScale: false, dist: 6 },
        sync: { key: "signals", filters: { pub: (type) => type === "mousemove" || type === "mouseleave" } },
        bind: { dblclick: () => () => { zoom(whole); return null; } },
      },
      hooks: {
        drawClear: [bands],
        setSelect: [(self) => {
          if (self.select.width < 1) return;
          const from = self.posToVal(self.select.left, "x"), to = self.posToVal(self.select.left + self.select.width, "x");
          self.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
          zoom([from, to]);
        }],
        setCursor: [(self) => { if (self.cursor.event || self.cursor.left >= 0 || at !== null) read(self.cursor.left < 0 ? null : self.cursor.idx); }],
      },
    }, values, element);
    plot.over.dataset.plot = channel.name;
    one.plot = plot;
  };

  function read(index) {
    if (index === at) return;
    at = index;
    for (const channel of channels) {
      const place = channel.element.querySelector("[data-values]");
      if (index === null || index === undefined) { place.textContent = ""; continue; }
      const parts = [`${number(time[index])} s: measured ${number(channel.measured[index])}`];
      place.replaceChildren(parts[0]);
      for (const key of keys) {
        if (!shown[key]) continue;
        const text = document.createElement("span");
        text.className = key;
        text.textContent = ` · model ${number(channel.simulated[key][index])}, residual ${number(channel.residual[key][index])} ${channel.residual_unit}`;
        place.append(text);
      }
    }
  }

  // Rms of every residual over the rows in view, and which cells have moments there.
  const inView = () => {
    const from = rowAt(range[0]), to = Math.min(time.length, rowAt(range[1]) + (time[rowAt(range[1])] === range[1] ? 1 : 0));
    const zoomed = range[0] > whole[0] || range[1] < whole[1];
    for (const channel of channels) {
      for (const key of keys) {
        let sum = 0;
        const values = channel.residual[key];
        for (let i = from; i < to; i++) sum += values[i] * values[i];
        const place = channel.element.querySelector(`[data-rms="${key}"]`);
        place.textContent = number(Math.sqrt(sum / Math.max(1, to - from)));
      }
      channel.element.querySelector("[data-where]").textContent = zoomed ? "in view" : "of the record";
    }
    document.body.classList.toggle("zoomed", zoomed);
    document.getElementById("plots").dataset.view = range.map((end) => end.toFixed(4)).join(" ");
    if (!zoomed) return;
    const there = {};
    for (const [by, values] of Object.entries(binOf)) there[by] = new Set(values.subarray(from, to));
    for (const cell of cells) cell.classList.toggle("lit", !there[cell.dataset.by] || there[cell.dataset.by].has(Number(cell.dataset.bin)));
  };

  const draw = () => { for (const { plot } of plots) plot.setScale("x", { min: range[0], max: range[1] }); };
  const redraw = () => { for (const { plot } of plots) plot.redraw(false, true); };

  function zoom([from, to]) {
    let span = Math.min(Math.max(to - from, least), whole[1] - whole[0]);
    const start = Math.min(Math.max(from, whole[0]), whole[1] - span);
    range = span >= whole[1] - whole[0] ? whole : [start, start + span];
    draw();
    inView();
  }
  const next = (how) => {
    const [from, to] = range, span = to - from;
    if (how === "in") return [from + span / 4, to - span / 4];
    if (how === "out") return [from - span / 2, to + span / 2];
    if (how === "earlier") return [from - span / 2, to - span / 2];
    if (how === "later") return [from + span / 2, to + span / 2];
    return whole;
  };
  for (const button of all("[data-zoom]")) button.addEventListener("click", () => zoom(next(button.dataset.zoom)));

  const show = (wanted) => {
    Object.assign(shown, wanted);
    for (const box of all("[data-series]")) box.checked = shown[box.dataset.series];
    for (const { plot } of plots) plot.series.forEach((one, place) => { if (place) plot.setSeries(place, { show: shown[one.label] }); });
    at = undefined;
    if (fit) draw();
  };
  for (const box of all("[data-series]")) box.addEventListener("change", () => show({ [box.dataset.series]: box.checked }));
  for (const box of all("[data-fit]")) box.addEventListener("change", () => { fit = box.checked; draw(); });
  for (const button of all("[data-model]")) {
    button.addEventListener("click", () => {
      show({ measured: true, ...Object.fromEntries(keys.map((key) => [key, key === button.dataset.model])) });
      document.getElementById("signals").scrollIntoView();
    });
  }

  for (const cell of cells) {
    cell.addEventListener("click", () => {
      const again = cell.getAttribute("aria-pressed") === "true";
      for (const other of cells) other.setAttribute("aria-pressed", "false");
      if (!again) cell.setAttribute("aria-pressed", "true");
      const bin = Number(cell.dataset.bin);
      lit = again || !binOf[cell.dataset.by] ? null : { by: cell.dataset.by, bin };
      redraw();
    });
  }

  document.getElementById("plots").addEventListener("keydown", (event) => {
    const step = Math.max(1, Math.round((rowAt(range[1]) - rowAt(range[0])) / (event.shiftKey ? 10 : 100)));
    const move = { ArrowLeft: -step, ArrowRight: step }[event.key];
    if (move) {
      const from = rowAt(range[0]), to = Math.min(time.length - 1, rowAt(range[1]));
      const index = Math.min(to, Math.max(from, (at ?? (move > 0 ? from - step : to + step)) + move));
      for (const { plot } of plots) plot.setCursor({ left: plot.valToPos(time[index], "x"), top: 10 }, false);
      read(index);
      const channel = channels[0];
      document.getElementById("reading").textContent = `${number(time[index])} s: ` + channels.map((one) => `${one.title} ${number(one.measured[index])} ${one.unit}, residual ${number(one.residual[keys[keys.length - 1]][index])} ${one.residual_unit}`).join("; ");
    } else if (event.key === "+" || event.key === "=") zoom(next("in"));
    else if (event.key === "-") zoom(next("out"));
    else if (event.key === "Home" || event.key === "0") zoom(whole);
    else return;
    event.preventDefault();
  });

  for (const one of plots) make(one);
  inView();
  const resize = () => {
    for (const { plot, element } of plots) {
      const size = { width: element.clientWidth, height: element.clientHeight };
      if (size.width !== plot.width || size.height !== plot.height) plot.setSize(size);
    }
  };
  let asked = 0;
  new ResizeObserver(() => { cancelAnimationFrame(asked); asked = requestAnimationFrame(resize); }).observe(document.getElementById("plots"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  // Paper is narrower than the screen.
  addEventListener("beforeprint", () => {
    for (const { plot } of plots) plot.setSize({ width: 340, height: plot.height > 150 ? 120 : 90 });
  });
  addEventListener("afterprint", resize);
  document.documentElement.dataset.drawnMs = (performance.now() - started).toFixed(0);
})();
