"use strict";
(() => {
  const POLL_MS = 400;
  const place = (name) => document.getElementById(name);
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
  const phases = { waiting: "waiting", recording: "recording", judging: "judging", judged: "complete" };
  const charts = new Map();
  let seen = -1, lost = 0;

  // a number stays on one line with its unit
  const kept = (text) => text.replace(/(?<=\d) (?=%|mm|Nm|µm|s\b)/g, "\u00a0");
  const minus = (ticks) => ticks.map((tick) => `${tick}`.replace("-", "−"));
  const element = (kind, text, name) => {
    const made = document.createElement(kind);
    if (text !== undefined) made.textContent = text;
    if (name) made.className = name;
    return made;
  };

  const values = (state) => state.values.map((one) => {
    const box = element("div", undefined, "reply");
    const what = { CSJ: "CSJ, static dry friction", BLK: "BLK, backlash at the rod" }[one.title] ?? one.title;
    box.append(element("dt", one.so_far ? `${what}, by the rows so far` : what));
    const told = element("dd");
    told.append(element("b", kept(one.shown)), element("small", kept(one.told)));
    box.append(told);
    return box;
  });

  const switchOf = (name) => document.querySelector(`input[data-show="${name}"]`);
  for (const box of document.querySelectorAll("input[data-show]")) {
    box.addEventListener("change", () => {
      for (const { plots } of charts.values()) for (const plot of plots) plot.series.forEach((one, at) => { if (one.label === box.dataset.show) plot.setSeries(at, { show: box.checked }); });
    });
  }

  const draw = (channel) => {
    if (typeof uPlot === "undefined") return;
    let chart = charts.get(channel.name);
    if (!chart) {
      const box = element("div", undefined, "channel");
      box.dataset.channel = channel.name;
      const head = element("div", undefined, "channel-head");
      const rms = element("span", "", "rms");
      head.append(element("h3", `${channel.title}, ${channel.unit}`), rms);
      const main = element("div", undefined, "plot main"), left = element("div", undefined, "plot residual");
      main.setAttribute("role", "img");
      main.setAttribute("aria-label", `${channel.title}, measured and simulated, over time`);
      left.setAttribute("role", "img");
      left.setAttribute("aria-label", `Residual of the ${channel.title.toLowerCase()} over time`);
      box.append(head, main, left);
      place("plots").append(box);
      const axis = { stroke: () => css("soft"), font: `11px ${getComputedStyle(document.body).fontFamily}`, grid: { stroke: () => css("grid"), width: 1 }, ticks: { show: false } };
      const seconds = (_, ticks) => ticks.map((tick, i) => (i === ticks.length - 1 ? `${tick} s` : `${tick}`));
      const options = (holder, series, top) => ({
        width: holder.clientWidth, height: holder.clientHeight, cursor: { sync: { key: "live" } }, legend: { show: false }, padding: [6, 18, 2, 0],
        scales: { x: { time: false } }, series: [{}, ...series],
        axes: [
          top ? { ...axis, size: 4, values: () => [] } : { ...axis, size: 20, gap: 2, values: seconds },
          { ...axis, size: top ? 63 : 50, gap: 4, space: top ? 26 : 16, label: top ? undefined : `residual, ${channel.residual_unit}`, labelSize: 13, labelFont: axis.font, labelGap: 0, values: (_, ticks) => minus(ticks) },
        ],
      });
      const line = (name, width) => ({ label: name, stroke: () => css(name), width, points: { show: false }, show: switchOf(name).checked });
      const plots = [
        new uPlot(options(main, [line("measured", 4), line("after", 1.5)], true), [[], [], []], main),
        new uPlot(options(left, [line("after", 1)], false), [[], []], left),
      ];
      new ResizeObserver(() => [main, left].forEach((holder, i) => plots[i].setSize({ width: holder.clientWidth, height: holder.clientHeight }))).observe(box);
      chart = { plots, rms };
      charts.set(channel.name, chart);
    }
    chart.rms.textContent = channel.rms_text;
    chart.plots[0].setData([channel.time, channel.measured, channel.model]);
    chart.plots[1].setData([channel.time, channel.residual]);
  };

  const show = (state) => {
    place("lamp").className = state.tone;
    place("headline").className = state.tone;
    if (place("headline").textContent !== kept(state.headline)) place("headline").textContent = kept(state.headline);
    place("shown").hidden = !state.channels.length;
    place("state").textContent = `${phases[state.phase]}, ${state.rows} rows, ${state.seconds.toFixed(1)} s`;
    place("details").replaceChildren(...state.details.map((text) => element("li", kept(text))));
    place("values").replaceChildren(...values(state));
    if (state.phase !== "waiting" || state.notes.length) place("notes").textContent = state.notes.join(" · ");
    state.channels.forEach(draw);
    document.body.dataset.version = state.version;
    document.body.dataset.phase = state.phase;
  };

  const poll = async () => {
    try {
      const answer = await fetch(`state?seen=${seen}`, { cache: "no-store" });
      if (answer.status === 200) {
        const state = await answer.json();
        seen = state.version;
        show(state);
      }
      lost = 0;
    } catch {
      lost += 1;
      if (lost > 2) {
        place("state").textContent = "ema watch has ended; what is shown is the last that it said";
        place("lamp").className = "";
      }
    }
    setTimeout(poll, lost > 2 ? 5 * POLL_MS : POLL_MS);
  };
  poll();
})();
