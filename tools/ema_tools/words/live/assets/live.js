"use strict";
(() => {
  const POLL_MS = 400;
  const place = (name) => document.getElementById(name);
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
  const phases = { waiting: "waiting", recording: "recording", judging: "judging", judged: "complete" };
  const charts = new Map();
  let seen = -1, lost = 0;

  const number = (value) => (value >= 0 ? "+" : "−") + Math.abs(value).toFixed(1);
  const element = (kind, text, name) => {
    const made = document.createElement(kind);
    if (text !== undefined) made.textContent = text;
    if (name) made.className = name;
    return made;
  };

  const values = (state) => state.values.map((one) => {
    const box = element("div", undefined, "reply");
    const [low, high] = one.shift_interval_percent;
    const between = low === null || high === null ? "" : `95 %: ${number(low)} .. ${number(high)} %`;
    const what = { CSJ: "CSJ, static dry friction", BLK: "BLK, backlash at the rod" }[one.title] ?? one.title;
    box.append(element("dt", one.so_far ? `${what}, by the rows so far` : what));
    const told = element("dd");
    told.append(element("b", `${number(one.shift_percent)} % of the healthy value`), element("small", one.so_far ? "not held against the other signals yet" : between));
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
      const axes = [0, 1].map(() => ({ stroke: () => css("soft"), grid: { stroke: () => css("grid"), width: 1 }, ticks: { stroke: () => css("grid") } }));
      axes[1].size = 56;
      const options = (holder, series) => ({
        width: holder.clientWidth, height: holder.clientHeight, cursor: { sync: { key: "live" } }, legend: { show: false },
        scales: { x: { time: false } }, axes, series: [{}, ...series],
      });
      const line = (name, width) => ({ label: name, stroke: () => css(name), width, points: { show: false }, show: switchOf(name).checked });
      const plots = [
        new uPlot(options(main, [line("measured", 4), line("after", 1.5)]), [[], [], []], main),
        new uPlot(options(left, [line("after", 1)]), [[], []], left),
      ];
      new ResizeObserver(() => [main, left].forEach((holder, i) => plots[i].setSize({ width: holder.clientWidth, height: holder.clientHeight }))).observe(box);
      chart = { plots, rms };
      charts.set(channel.name, chart);
    }
    chart.rms.textContent = `residual rms ${channel.rms.toPrecision(3)} ${channel.residual_unit}`;
    chart.plots[0].setData([channel.time, channel.measured, channel.model]);
    chart.plots[1].setData([channel.time, channel.residual]);
  };

  const show = (state) => {
    place("lamp").className = state.tone;
    place("headline").className = state.tone;
    if (place("headline").textContent !== state.headline) place("headline").textContent = state.headline;
    place("state").textContent = `${phases[state.phase]}, ${state.rows} rows, ${state.seconds.toFixed(1)} s`;
    place("details").replaceChildren(...state.details.map((text) => element("li", text)));
    place("values").replaceChildren(...values(state));
    place("notes").textContent = state.notes.join(" · ");
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
