"use strict";
(() => {
  const data = JSON.parse(document.getElementById("page-data").textContent);
  if (typeof uPlot === "undefined") return;
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  const unpack = (series) => Float64Array.from(new Int16Array(bytes(series.int16)), (value) => value * series.scale);
  const number = (value) => value.toPrecision(3).replace("-", "−");
  const font = "11px " + getComputedStyle(document.body).fontFamily;
  const made = [], ranges = new Map();

  // Several curves over one time; plots of a group are zoomed together.
  const make = (chart) => {
    const place = document.getElementById(chart.id), values = place.nextElementSibling;
    const x = Float64Array.from({ length: chart.rows }, (_, i) => i * chart.period_s);
    const whole = [x[0], x[x.length - 1]];
    if (!ranges.has(chart.group)) ranges.set(chart.group, chart.view || whole);
    const boxes = [...document.querySelectorAll(`input[data-show][data-of="${chart.id}"]`)];
    const curves = chart.series.map((one) => unpack(one.packed));
    const [low, high] = curves.reduce(([a, b], list) => [list.reduce((m, v) => Math.min(m, v), a), list.reduce((m, v) => Math.max(m, v), b)], [Infinity, -Infinity]);
    const room = 0.05 * (high - low) || 1;
    const axis = { stroke: () => css("soft"), font, grid: { stroke: () => css("grid"), width: 1 }, ticks: { show: false } };
    const zoom = ([from, to]) => {
      const span = Math.min(Math.max(to - from, (whole[1] - whole[0]) / 500), whole[1] - whole[0]);
      const start = Math.min(Math.max(from, whole[0]), whole[1] - span);
      ranges.set(chart.group, [start, start + span]);
      for (const other of made) if (other.group === chart.group) { other.plot.setScale("x", { min: start, max: start + span }); other.place.dataset.view = [start, start + span].map((end) => end.toFixed(4)).join(" "); }
    };
    const plot = new uPlot({
      width: place.clientWidth, height: place.clientHeight, legend: { show: false }, padding: [6, 20, 0, 0],
      scales: { x: { time: false, range: () => ranges.get(chart.group) }, y: { range: () => [low - room, high + room] } },
      axes: [
        { ...axis, size: 22, gap: 2, values: (_, ticks) => ticks.map((tick, i) => (i === ticks.length - 1 ? `${tick} s` : `${tick}`)) },
        { ...axis, size: 46, gap: 4, space: 28, label: chart.unit, labelSize: 14, labelFont: font, labelGap: 0, values: (_, ticks) => ticks.map((tick) => `${tick}`.replace("-", "−")) },
      ],
      series: [{}, ...chart.series.map((one) => ({ label: one.label, stroke: () => css(one.role), width: one.role === "measured" ? 3.5 : 1.5, dash: one.dash, points: { show: false }, show: boxes.find((box) => box.dataset.show === one.label)?.checked ?? true }))],
      cursor: { y: false, points: { size: 6 }, drag: { x: true, y: false, setScale: false, dist: 6 }, sync: { key: chart.group, filters: { pub: (type) => type === "mousemove" || type === "mouseleave" } }, bind: { dblclick: () => () => { zoom(whole); return null; } } },
      hooks: {
        setSelect: [(self) => {
          if (self.select.width < 1) return;
          const from = self.posToVal(self.select.left, "x"), to = self.posToVal(self.select.left + self.select.width, "x");
          self.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
          zoom([from, to]);
        }],
        setCursor: [(self) => {
          const i = self.cursor.left < 0 ? null : self.cursor.idx;
          values.textContent = i === null || i === undefined ? "" : `${number(x[i])} s: ` + chart.series.map((one, place) => (self.series[place + 1].show ? `${one.label} ${number(curves[place][i])}` : "")).filter(Boolean).join(" · ") + ` ${chart.unit}`;
        }],
      },
    }, [x, ...curves], place);
    made.push({ plot, place, group: chart.group });
    place.dataset.drawn = "";
    for (const box of boxes) box.addEventListener("change", () => plot.series.forEach((one, at) => { if (one.label === box.dataset.show) plot.setSeries(at, { show: box.checked }); }));
    for (const button of document.querySelectorAll(`[data-lines-of="${chart.group}"]`)) {
      const [from, to] = button.dataset.view ? button.dataset.view.split(" ").map(Number) : whole;
      button.addEventListener("click", () => zoom([from, to]));
    }
  };
  const waiting = new Map(data.lines.map((chart) => [document.getElementById(chart.id), chart]));
  const draw = (place) => { const chart = waiting.get(place); if (chart) { waiting.delete(place); make(chart); } };
  const near = new IntersectionObserver((entries) => { for (const entry of entries) if (entry.isIntersecting) { near.unobserve(entry.target); draw(entry.target); } }, { rootMargin: "700px 0px" });
  for (const place of waiting.keys()) near.observe(place);
  const resize = () => { for (const { plot, place } of made) if (place.clientWidth !== plot.width) plot.setSize({ width: place.clientWidth, height: place.clientHeight }); };
  let asked = 0;
  const sized = new ResizeObserver(() => { cancelAnimationFrame(asked); asked = requestAnimationFrame(resize); });
  for (const place of waiting.keys()) sized.observe(place);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { for (const { plot } of made) plot.redraw(false, true); });
  addEventListener("beforeprint", () => { [...waiting.keys()].forEach(draw); resize(); });
})();
