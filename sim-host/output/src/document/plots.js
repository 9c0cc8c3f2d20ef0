// Turns the pictures of the page into plots that answer the mouse: the values under the pointer
// stand below, dragging enlarges, a double click shows all, a click on a name takes a line away.
"use strict";
for (const source of document.querySelectorAll("figure > script[type='application/json']")) {
  const plot = JSON.parse(source.textContent);
  const place = source.previousElementSibling;
  const picture = place.firstElementChild;
  const table = uPlot.join(plot.series.map((line) => [line.x, line.y]));
  const number = (value, digits) => (value == null ? "–" : String(Number(value.toPrecision(digits))));
  const category = (x) => plot.categories[x] ?? "";
  const named = plot.categories.length > 0;

  // What no line shows: the band that is allowed, and standard errors.
  const under = (chart) => {
    if (!plot.band) return;
    const [low, high] = plot.band.map((y) => chart.valToPos(y, "y", true));
    const { left, top, width, height } = chart.bbox;
    const [from, to] = [Math.max(high, top), Math.min(low, top + height)];
    chart.ctx.fillStyle = "rgba(0, 140, 100, 0.12)";
    if (to > from) chart.ctx.fillRect(left, from, width, to - from);
  };
  const over = (chart) => {
    plot.series.forEach((line, k) => {
      if (!line.error || !chart.series[k + 1].show) return;
      const { left, top, width, height } = chart.bbox;
      chart.ctx.save();
      chart.ctx.beginPath();
      chart.ctx.rect(left, top, width, height);
      chart.ctx.clip();
      chart.ctx.strokeStyle = line.color;
      chart.ctx.beginPath();
      line.x.forEach((x, i) => {
        const at = chart.valToPos(x, "x", true);
        chart.ctx.moveTo(at, chart.valToPos(line.y[i] - line.error[i], "y", true));
        chart.ctx.lineTo(at, chart.valToPos(line.y[i] + line.error[i], "y", true));
      });
      chart.ctx.stroke();
      chart.ctx.restore();
    });
  };
  // The range given is that of the whole; enlarged, what is seen fills the picture. Standard errors are in it, but for
  // those that are longer than the whole picture is high.
  const ends = plot.series.flatMap((line) => (line.error ?? []).flatMap((error, i) => [line.y[i] - error, line.y[i] + error]));
  const range = (chart, low, high) => {
    const { min, max } = chart.scales.x;
    const whole = min <= table[0][0] && max >= table[0][table[0].length - 1];
    if (whole && plot.y_range) return plot.y_range;
    const [least, most] = whole && ends.length ? [Math.min(...ends), Math.max(...ends)] : [low, high];
    const height = high - low;
    return uPlot.rangeNum(Math.max(Math.min(low, least), low - height), Math.min(Math.max(high, most), high + height), 0.1, true);
  };
  // As many digits as tell two ticks apart; on a logarithmic axis ticks without a label are null.
  const ticks = (_, all, which, _space, step) => {
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    const rounded = Number(step.toFixed(digits));
    const shown = digits + (Math.abs(step - rounded) > 1e-6 * step ? 1 : 0);
    const fixed = { minimumFractionDigits: shown, maximumFractionDigits: shown };
    return all.map((value) => (value == null ? "" : plot.logarithmic && which === 1 ? number(value, 2) : value.toLocaleString("en", fixed)));
  };
  const axis = { values: ticks, font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif", labelSize: 18, grid: { stroke: "#e6e6e6", width: 1 }, ticks: { stroke: "#ccc", width: 1 } };
  const size = () => ({ width: place.clientWidth, height: plot.wide ? 290 : 230 });
  const chart = new uPlot({
    ...size(),
    scales: {
      x: { time: false, range: (_, low, high) => (named ? [-0.5, plot.categories.length - 0.5] : [low, high]) },
      y: { distr: plot.logarithmic ? 3 : 1, range: plot.logarithmic ? undefined : range },
    },
    axes: [
      { ...axis, label: plot.x_label, ...(named ? { splits: () => plot.categories.map((_, k) => k), values: (_, all) => all.map(category) } : {}) },
      { ...axis, label: plot.y_label, size: (_, all) => Math.max(58, 22 + 7 * Math.max(...(all ?? []).map((text) => text.length))) },
    ],
    cursor: { drag: { x: true, y: false }, points: { size: 5 } },
    legend: { live: true, markers: { dash: (_, k) => (plot.series[k - 1]?.dash ? (plot.series[k - 1].dash[0] > 3 ? "dashed" : "dotted") : "solid") } },
    hooks: { drawClear: [under], draw: [over] },
    series: [
      { label: named ? "" : plot.x_label, value: (_, x) => (x == null ? "–" : named ? category(x) : number(x, 5)) },
      ...plot.series.map((line) => ({
        label: line.name || plot.y_label,
        stroke: line.color,
        width: line.joined ? 1.5 : 0,
        paths: line.joined ? undefined : () => null,
        dash: line.dash,
        points: { show: line.dotted, size: 6, fill: line.color },
        value: (_, y) => number(y, 4),
      })),
    ],
  }, table, place);
  picture.remove();
  place.parentElement.classList.add("live");
  addEventListener("resize", () => chart.setSize(size()));
}
