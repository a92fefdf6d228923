"use strict";
(async () => {
  const data = JSON.parse(document.getElementById("page-data").textContent);
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
  const coarse = matchMedia("(pointer: coarse)").matches;
  const config = { responsive: true, displayModeBar: false, doubleClick: false, scrollZoom: false };

  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  // The library comes packed; a browser that cannot unpack it says so in place of the curves.
  if (!("DecompressionStream" in window)) {
    for (const plot of document.querySelectorAll(".plot")) plot.textContent = "This browser cannot draw the curves: open the page in one of 2023 or later.";
    return;
  }
  const library = document.createElement("script");
  library.textContent = await new Response(new Blob([bytes(plotlyPacked)]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  document.head.append(library);

  const unpack = (series) => Float64Array.from(new Int16Array(bytes(series.int16)), (value) => value * series.scale);
  const times = (time) => {
    const row = time.kept ? new Uint32Array(bytes(time.kept)) : Uint32Array.from({ length: time.rows }, (_, i) => i);
    return Float64Array.from(row, (i) => time.start_s + i * time.period_s);
  };

  // Colours belong to roles, so that a change between light and dark only asks the style sheet again.
  const paint = (figure) => {
    const font = { family: getComputedStyle(document.body).fontFamily, size: 12, color: css("soft") };
    const layout = { ...figure.layout, font, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", showlegend: false, autosize: true, height: figure.height };
    layout.hoverlabel = { bgcolor: css("card"), bordercolor: css("line"), font: { color: css("ink") } };
    for (const key of Object.keys(layout)) {
      if (/^[xy]axis/.test(key)) {
        layout[key] = { gridcolor: css("grid"), zerolinecolor: css("line"), linecolor: css("line"), tickfont: { size: 11 }, fixedrange: true, ...layout[key] };
        if (layout[key].title) layout[key].title = { font: { size: 12 }, ...layout[key].title };
      }
    }
    const traces = figure.data.map((trace) => {
      const colour = css(trace.meta.role === "measured" && trace.mode === "markers" ? "ring" : trace.meta.role);
      const painted = { ...trace };
      if (painted.mode && painted.mode.includes("lines")) painted.line = { ...painted.line, color: colour };
      if (painted.mode !== "lines") painted.marker = { ...painted.marker, color: colour };
      // Two more hexadecimal digits: the band lets the grid through.
      // The valley is dark, and lines between the levels stay faint.
      if (painted.type === "contour") { painted.colorscale = [[0, colour + "b0"], [1, colour + "10"]]; painted.line = { ...painted.line, color: css("line") }; }
      if (painted.fill) painted.fillcolor = colour + "30";
      if (painted.error_x) painted.error_x = { ...painted.error_x, color: colour };
      return painted;
    });
    return [traces, layout];
  };

  // Rows to draw between two times: all of them, or the extremes of each of `width` pieces.
  const thin = (x, y, from, to, width) => {
    if (to - from <= 4 * width) return [Array.from(x.subarray(from, to)), Array.from(y.subarray(from, to))];
    const outX = [], outY = [];
    for (let piece = 0; piece < width; piece++) {
      const start = from + Math.floor(((to - from) * piece) / width), stop = from + Math.floor(((to - from) * (piece + 1)) / width);
      let low = start, high = start;
      for (let i = start + 1; i < stop; i++) {
        if (y[i] < y[low]) low = i;
        if (y[i] > y[high]) high = i;
      }
      for (const i of low < high ? [low, high] : [high, low]) { outX.push(x[i]); outY.push(y[i]); }
    }
    return [outX, outY];
  };
  const rowAt = (x, time) => {
    let low = 0, high = x.length;
    while (low < high) { const middle = (low + high) >> 1; if (x[middle] < time) low = middle + 1; else high = middle; }
    return low;
  };
  // The largest 1, 2 or 5 times a power of ten that fits, so that a strip is marked at -t and t.
  const roundTick = (top) => {
    const power = 10 ** Math.floor(Math.log10(top)), lead = top / power;
    return power * (lead >= 5 ? 5 : lead >= 2 ? 2 : 1);
  };
  const reach = (series) => {
    let low = Infinity, high = -Infinity;
    for (const values of series) for (const value of values) { low = Math.min(low, value); high = Math.max(high, value); }
    const margin = 0.04 * (high - low) || 1;
    return [low - margin, high + margin];
  };
  const largest = (values) => values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);

  class CurveSet {
    constructor(set) {
      this.id = set.id;
      this.x = times(set.time);
      this.ends = [this.x[0], this.x[this.x.length - 1]];
      this.range = this.ends;
      this.channels = set.channels.map((channel) => {
        const measured = unpack(channel.measured), models = {};
        for (const [key, packed] of Object.entries(channel.residual)) {
          const residual = unpack(packed);
          models[key] = { residual, simulated: measured.map((m, i) => m - residual[i] / channel.residual_scale) };
        }
        const all = Object.values(models);
        return {
          ...channel, measured, models,
          range: reach([measured, ...all.map((m) => m.simulated)]),
          strip: 1.2 * Math.max(...all.map((m) => largest(m.residual))) || 1,
        };
      });
      this.plots = [...document.querySelectorAll(`[data-curves="${set.id}"]`)];
      for (const button of document.querySelectorAll(`[data-zoom-of="${set.id}"]`)) {
        button.addEventListener("click", () => this.zoom(this.next(button.dataset.zoom)));
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
      for (const plot of this.plots) if (plot.data) this.draw(plot);
    }

    figure(role, width) {
      const [from, to] = [Math.max(0, rowAt(this.x, this.range[0]) - 1), Math.min(this.x.length, rowAt(this.x, this.range[1]) + 2)];
      const rows = this.channels.length;
      const traces = [], annotations = [];
      const layout = { margin: { l: 58, r: 10, t: 20, b: 40 }, dragmode: coarse ? false : "zoom", hovermode: "closest", annotations };
      // Each channel takes its share of the height: the signal, then its residual strip close below it.
      this.channels.forEach((channel, index) => {
        const share = 1 / rows, foot = 1 - (index + 1) * share, gap = index === rows - 1 ? 0 : 0.075;
        const model = channel.models[role], main = 2 * index + 1, strip = 2 * index + 2;
        const tick = roundTick(channel.strip / 1.1);
        const split = foot + gap + 0.36 * (share - gap);
        const add = (name, values, axis, traceRole, line, unit) => {
          const [x, y] = thin(this.x, values, from, to, width);
          traces.push({ type: "scatter", mode: "lines", x, y, name, xaxis: "x", yaxis: "y" + axis, meta: { role: traceRole }, line: { width: line, simplify: true }, hovertemplate: `${name} %{y:.4~g} ${unit} at %{x:.3f} s<extra></extra>` });
        };
        add("measured", channel.measured, main, "measured", 3.5, channel.unit);
        add("simulated", model.simulated, main, role === "before" ? "before" : "after", 1.4, channel.unit);
        add("residual", model.residual, strip, role === "before" ? "before" : "after", 1.1, channel.residual_unit);
        const title = (text) => ({ text, standoff: 6, font: { size: 11 } });
        layout["yaxis" + main] = { domain: [split + 0.012, foot + share - (index === 0 ? 0 : 0.012)], range: channel.range, title: title(channel.unit), nticks: 5 };
        layout["yaxis" + strip] = { domain: [foot + gap, split - 0.012], range: [-channel.strip, channel.strip], title: title(channel.residual_unit), tickvals: [-tick, tick], zeroline: true };
        const note = (text, y, anchor) => annotations.push({ text, x: anchor === "left" ? 0 : 1, xref: "paper", xanchor: anchor, y, yref: "paper", yanchor: "bottom", showarrow: false, font: { size: 12, color: css("ink") } });
        note(channel.title, foot + share - (index === 0 ? 0 : 0.012), "left");
        note(`residual rms <b>${channel.rms_text[role]}</b>`, foot + share - (index === 0 ? 0 : 0.012), "right");
      });
      layout.xaxis = { range: this.range, fixedrange: coarse, title: { text: "Time, s", standoff: 8 }, anchor: "y" + 2 * rows, zeroline: false };
      return { data: traces, layout, height: 40 + 215 * rows };
    }

    draw(plot) {
      const [traces, layout] = paint(this.figure(plot.dataset.model, Math.max(120, plot.clientWidth - 70)));
      const first = !plot.data;
      Plotly.react(plot, traces, layout, config);
      if (!first) return;
      plot.on("plotly_relayout", (change) => {
        if ("xaxis.range[0]" in change) this.zoom([change["xaxis.range[0]"], change["xaxis.range[1]"]]);
      });
      plot.on("plotly_doubleclick", () => this.zoom(this.ends));
    }
  }

  // Plots are drawn when they come near the window: a phone does not wait for those far below.
  const draws = new Map(), sets = new Map();
  for (const set of data.curves.map((packed) => new CurveSet(packed))) {
    sets.set(set.id, set);
    for (const plot of set.plots) draws.set(plot, () => set.draw(plot));
  }
  for (const figure of data.figures) {
    const plot = document.getElementById(figure.id);
    draws.set(plot, () => {
      const first = !plot.data;
      Plotly.react(plot, ...paint(figure), config);
      // A part of the time that is clicked is shown in the curves.
      if (first && figure.zooms && sets.has(figure.zooms)) {
        plot.on("plotly_click", ({ points: [point] }) => {
          const set = sets.get(figure.zooms);
          set.zoom([point.x - figure.half, point.x + figure.half]);
          set.plots[0].scrollIntoView({ block: "nearest" });
        });
      }
    });
  }
  const near = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      near.unobserve(entry.target);
      draws.get(entry.target)();
    }
  }, { rootMargin: "700px 0px" });
  for (const plot of draws.keys()) near.observe(plot);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draws.forEach((draw, plot) => plot.data && draw()));
  addEventListener("beforeprint", () => draws.forEach((draw, plot) => plot.data || draw()));
})();
