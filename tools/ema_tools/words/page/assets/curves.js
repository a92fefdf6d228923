"use strict";
(() => {
  const data = JSON.parse(document.getElementById("page-data").textContent);
  const all = (selector, within = document) => [...within.querySelectorAll(selector)];
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
  if (typeof uPlot === "undefined") return;

  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  const unpack = (series) => Float64Array.from(new Int16Array(bytes(series.int16)), (value) => value * series.scale);
  const number = (value) => value.toPrecision(3).replace("-", "−");
  const reach = (lists, middle) => {
    let low = Infinity, high = -Infinity;
    for (const values of lists) for (const value of values) { if (value < low) low = value; if (value > high) high = value; }
    if (middle) { high = Math.max(Math.abs(low), Math.abs(high)) || 1; low = -high; }
    const room = 0.05 * (high - low) || 1;
    return [low - room, high + room];
  };
  const element = (kind, className, text = "") => Object.assign(document.createElement(kind), { className, textContent: text });
  const font = "11px " + getComputedStyle(document.body).fontFamily;
  const drawn = new Set();

  // All curves of one result: what is zoomed in one is zoomed in all.
  class CurveSet {
    constructor(set) {
      const { time } = set;
      const row = time.kept ? new Uint32Array(bytes(time.kept)) : Uint32Array.from({ length: time.rows }, (_, i) => i);
      this.x = Float64Array.from(row, (i) => time.start_s + i * time.period_s);
      this.ends = [this.x[0], this.x[this.x.length - 1]];
      this.range = this.ends;
      this.id = set.id;
      this.plots = [];
      const boxes = all(`input[data-show][data-of="${set.id}"]`);
      this.shown = Object.fromEntries(boxes.map((box) => [box.dataset.show, box.checked]));
      for (const box of boxes) {
        box.addEventListener("change", () => {
          this.shown[box.dataset.show] = box.checked;
          for (const { plot } of this.plots) plot.series.forEach((one, place) => { if (one.label === box.dataset.show) plot.setSeries(place, { show: box.checked }); });
        });
      }
      this.channels = set.channels.map((channel) => {
        const measured = unpack(channel.measured), residual = {}, simulated = {};
        for (const [key, packed] of Object.entries(channel.residual)) {
          residual[key] = unpack(packed);
          simulated[key] = measured.map((value, i) => value - residual[key][i] / channel.residual_scale);
        }
        // one scale before and after, so that the two can be compared
        return { ...channel, measured, residual, simulated, range: reach([measured, ...Object.values(simulated)]), strip: reach(Object.values(residual), true) };
      });
      for (const button of all(`[data-zoom-of="${set.id}"]`)) button.addEventListener("click", () => this.zoom(this.next(button.dataset.zoom)));
      for (const picture of all(`[data-zooms="${set.id}"]`)) {
        picture.addEventListener("click", (event) => {
          const mark = event.target.closest("[data-x]"), half = Number(picture.dataset.half);
          if (!mark) return;
          this.zoom([Number(mark.dataset.x) - half, Number(mark.dataset.x) + half]);
          all(`[data-curves="${set.id}"]`)[0].scrollIntoView({ block: "nearest" });
        });
      }
    }

    next(how) {
      const [from, to] = this.range, span = to - from;
      if (how === "in") return [from + span / 4, to - span / 4];
      if (how === "out") return [from - span / 2, to + span / 2];
      if (how === "earlier") return [from - span / 2, to - span / 2];
      if (how === "later") return [from + span / 2, to + span / 2];
      return this.ends;
    }

    zoom([from, to]) {
      const [first, last] = this.ends;
      const span = Math.min(Math.max(to - from, (last - first) / 500), last - first);
      const start = Math.min(Math.max(from, first), last - span);
      this.range = [start, start + span];
      for (const place of all(`[data-curves="${this.id}"]`)) place.dataset.view = this.range.map((end) => end.toFixed(4)).join(" ");
      for (const { plot } of this.plots) plot.setScale("x", { min: start, max: start + span });
    }

    // One plot: the signal, or its residual.
    add(place, channel, model, main, values) {
      const role = model === "before" ? "before" : "after";
      const axis = { stroke: () => css("soft"), font, grid: { stroke: () => css("grid"), width: 1 }, ticks: { show: false } };
      const minus = (ticks) => ticks.map((tick) => `${tick}`.replace("-", "−"));
      const seconds = (_, ticks) => ticks.map((tick, i) => (i === ticks.length - 1 ? `${tick} s` : `${tick}`));
      const curve = (label, stroke, width) => ({ label, stroke: () => css(stroke), width, points: { show: false }, show: this.shown[label] ?? true });
      const plot = new uPlot({
        width: place.clientWidth, height: place.clientHeight,
        legend: { show: false }, padding: [6, 18, main ? 2 : 0, 0],
        scales: { x: { time: false, range: () => this.range }, y: { range: () => (main ? channel.range : channel.strip) } },
        axes: [
          main ? { ...axis, size: 4, values: () => [] } : { ...axis, size: 20, gap: 2, values: seconds },
          { ...axis, size: main ? 60 : 47, gap: 4, space: main ? 26 : 18, label: main ? undefined : channel.residual_unit, labelSize: 13, labelFont: font, labelGap: 0, values: (_, ticks) => minus(ticks) },
        ],
        series: main ? [{}, curve("measured", "measured", 3.5), curve(model, role, 1.4)] : [{}, curve(model, role, 1)],
        cursor: { y: false, points: { size: 6 }, drag: { x: true, y: false, setScale: false, dist: 6 }, sync: { key: this.id, filters: { pub: (type) => type === "mousemove" || type === "mouseleave" } }, bind: { dblclick: () => () => { this.zoom(this.ends); return null; } } },
        hooks: {
          setSelect: [(self) => {
            if (self.select.width < 1) return;
            const from = self.posToVal(self.select.left, "x"), to = self.posToVal(self.select.left + self.select.width, "x");
            self.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
            this.zoom([from, to]);
          }],
          setCursor: [(self) => {
            const i = self.cursor.left < 0 ? null : self.cursor.idx;
            values.textContent = i === null || i === undefined ? "" : `${number(this.x[i])} s: measured ${number(channel.measured[i])} ${channel.unit} · simulated ${number(channel.simulated[model][i])}, residual ${number(channel.residual[model][i])} ${channel.residual_unit}`;
          }],
        },
      }, main ? [this.x, channel.measured, channel.simulated[model]] : [this.x, channel.residual[model]], place);
      this.plots.push({ plot, place });
    }

    draw(place) {
      const model = place.dataset.model;
      for (const channel of this.channels) {
        const head = element("div", "head"), values = element("div", "values");
        head.append(element("b", "", `${channel.title}, ${channel.unit}`), element("span", "", `residual rms ${channel.rms_text[model]}`));
        const main = element("div", "main"), rest = element("div", "rest");
        place.append(head, main, values, rest);
        this.add(main, channel, model, true, values);
        this.add(rest, channel, model, false, values);
      }
      place.dataset.drawn = "";
    }
  }

  // Plots are drawn when they come near the window: a phone does not wait for those far below.
  const sets = new Map(data.curves.map((packed) => [packed.id, new CurveSet(packed)]));
  const draw = (place) => {
    if (drawn.has(place)) return;
    drawn.add(place);
    sets.get(place.dataset.curves).draw(place);
  };
  const places = all("[data-curves]");
  const near = new IntersectionObserver((entries) => {
    for (const entry of entries) if (entry.isIntersecting) { near.unobserve(entry.target); draw(entry.target); }
  }, { rootMargin: "700px 0px" });
  for (const place of places) near.observe(place);
  const plots = () => [...sets.values()].flatMap((set) => set.plots);
  let asked = 0;
  const resize = () => {
    for (const { plot, place } of plots()) if (place.clientWidth !== plot.width) plot.setSize({ width: place.clientWidth, height: place.clientHeight });
  };
  const sized = new ResizeObserver(() => { cancelAnimationFrame(asked); asked = requestAnimationFrame(resize); });
  for (const place of places) sized.observe(place);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { for (const { plot } of plots()) plot.redraw(false, true); });
  addEventListener("beforeprint", () => { places.forEach(draw); resize(); });
})();
