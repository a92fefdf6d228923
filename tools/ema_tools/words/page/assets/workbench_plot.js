// Measured and simulated against time with their difference below, on one canvas a signal; all of them share one stretch of time.
const EmaPlots = (() => {
  "use strict";

  const RESIDUAL = 0.36; // share of the height
  const PAD = { left: 58, right: 10, top: 8, bottom: 20, gap: 10 };
  const css = (name, otherwise) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim() || otherwise;

  // About five whole steps between two numbers.
  function ticks(low, high, wanted) {
    const raw = (high - low) / wanted;
    if (!(raw > 0)) return [low];
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = power * [1, 2, 5, 10].find((one) => one * power >= raw);
    const found = [];
    for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; k += 1) found.push(Number((k * step).toPrecision(12)));
    return found;
  }

  function ends(lists, first, last) {
    let low = Infinity;
    let high = -Infinity;
    for (const list of lists) {
      for (let k = first; k <= last; k += 1) {
        if (list[k] < low) low = list[k];
        if (list[k] > high) high = list[k];
      }
    }
    const room = 0.06 * (high - low) || Math.abs(high) || 1;
    return [low - room, high + room];
  }

  // A line with, in every column of pixels, the lowest and the highest of its rows.
  function trace(context, list, first, last, x, y) {
    context.beginPath();
    let column = Math.round(x(first));
    let low = list[first];
    let high = list[first];
    context.moveTo(x(first), y(list[first]));
    for (let k = first + 1; k <= last; k += 1) {
      const here = Math.round(x(k));
      if (here !== column) {
        context.lineTo(column, y(low));
        context.lineTo(column, y(high));
        context.lineTo(x(k), y(list[k]));
        column = here;
        low = high = list[k];
      } else if (list[k] < low) low = list[k];
      else if (list[k] > high) high = list[k];
    }
    context.lineTo(column, y(low));
    context.lineTo(column, y(high));
    context.stroke();
  }

  // One signal: {measured, simulated, residual}, of which rows view[0] to view[1] are drawn; times in s. The residual's axis counts `scale` of `unit` in one unit of the signal.
  function draw(canvas, signal, view, startS, periodS, mark, scale = 1, unit = "") {
    const ratio = window.devicePixelRatio || 1;
    const width = canvas.clientWidth;
    const height = canvas.clientHeight;
    if (!width) return;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    context.font = `11px ${getComputedStyle(document.body).fontFamily}`;
    const [first, last] = view;
    const x = (row) => PAD.left + ((row - first) / Math.max(last - first, 1)) * (width - PAD.left - PAD.right);
    const inner = height - PAD.top - PAD.bottom - PAD.gap;
    const panel = (top, size, lists, lines, wanted, times = 1, told = "") => {
      const [low, high] = ends(lists, first, last);
      const y = (value) => top + size - ((value - low) / (high - low)) * size;
      context.textAlign = "right";
      context.textBaseline = "middle";
      for (const shown of ticks(low * times, high * times, wanted)) {
        const tick = shown / times;
        context.strokeStyle = css("grid", "#eceef0");
        context.lineWidth = 1;
        context.beginPath();
        context.moveTo(PAD.left, Math.round(y(tick)) + 0.5);
        context.lineTo(width - PAD.right, Math.round(y(tick)) + 0.5);
        context.stroke();
        context.fillStyle = css("soft", "#5b6673");
        context.fillText(String(shown).replace("-", "\u2212"), PAD.left - 6, y(tick));
      }
      if (told) {
        context.save();
        context.translate(9, top + 0.5 * size);
        context.rotate(-0.5 * Math.PI);
        context.textAlign = "center";
        context.fillText(told, 0, 0);
        context.restore();
      }
      for (const [list, colour, thick] of lines) {
        context.strokeStyle = colour;
        context.lineWidth = thick;
        trace(context, list, first, last, x, y);
      }
    };
    const upper = inner * (1 - RESIDUAL);
    const { measured, simulated, residual } = signal;
    panel(PAD.top, upper, [measured, simulated], [[measured, css("measured", "#9aa5b1"), 3], [simulated, css("after", "#0a6aa8"), 1.4]], 4);
    panel(PAD.top + upper + PAD.gap, inner * RESIDUAL, [residual], [[residual, css("before", "#c8501e"), 1.2]], 4, scale, unit);
    context.textAlign = "center";
    context.textBaseline = "top";
    context.fillStyle = css("soft", "#5b6673");
    const seconds = (row) => startS + row * periodS;
    const times = ticks(seconds(first), seconds(last), Math.max(2, Math.floor(width / 110)));
    times.forEach((time, k) => context.fillText(k + 1 < times.length ? String(time) : `${time} s`, x((time - startS) / periodS), height - PAD.bottom + 5));
    if (mark) {
      context.fillStyle = css("focus", "#0a6aa8");
      context.globalAlpha = 0.15;
      context.fillRect(Math.min(...mark), PAD.top, Math.abs(mark[1] - mark[0]), height - PAD.top - PAD.bottom);
      context.globalAlpha = 1;
    }
  }

  // The row under a place on the canvas, px from its left side.
  function rowAt(canvas, px, view) {
    const share = (px - PAD.left) / (canvas.clientWidth - PAD.left - PAD.right);
    return Math.round(view[0] + Math.min(Math.max(share, 0), 1) * (view[1] - view[0]));
  }

  return { draw, rowAt, ticks };
})();
