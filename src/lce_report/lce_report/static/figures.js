// SPDX-License-Identifier: Apache-2.0
// The figures of a report and of the workbench: curves over x, traces in the plane, linked by name.
// array(spec) gives the numbers of an array of a figure; null is a gap.
"use strict";
// Labelled lines across a plot, at values [x, text] of x.
const lceMarks = (u, marks, colour) => {
  const { ctx, bbox } = u, { min, max } = u.scales.x, r = devicePixelRatio;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  Object.assign(ctx, { font: `${11 * r}px system-ui, sans-serif`, textAlign: "left", textBaseline: "alphabetic", lineWidth: r });
  ctx.strokeStyle = colour("ink");
  ctx.setLineDash([4 * r, 3 * r]);
  marks.forEach(([at, text], i) => {
    if (at < min || at > max) return;
    const x = Math.round(u.valToPos(at, "x", true)), y = bbox.top + 13 * (i % 3) * r, width = ctx.measureText(text).width;
    const left = x + width + 8 * r > bbox.left + bbox.width ? x - width - 5 * r : x + 5 * r;
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.fillStyle = colour("panel");
    ctx.fillRect(left - 2 * r, y + r, width + 4 * r, 13 * r);
    ctx.fillStyle = colour("ink");
    ctx.fillText(text, left, y + 12 * r);
  });
  ctx.restore();
};
const lceFigures = (array) => {
  const plots = [];
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  const digits = (v, n = 5) => (v == null ? "–" : String(Number(v.toPrecision(n))).replace("-", "−"));
  const amount = (v, unit) => `${digits(v)}${unit === "1" ? "" : ` ${unit}`}`;
  const named = ({ name, unit }) => (unit === "1" ? name : `${name} [${unit}]`);
  const axis = (about, size) => {
    const rule = { stroke: () => colour("grid"), width: 1 }, font = "12px system-ui, sans-serif";
    return {
      label: named(about), size, labelSize: 17, labelGap: 0, gap: 4, font, labelFont: font,
      stroke: () => colour("quiet"), grid: rule, ticks: { ...rule, size: 5 },
      values: (u, splits) => splits.map((v) => (v == null ? "" : digits(v, 8))),
      ...(about.whole ? { incrs: [1, 2, 5, 10, 20, 50, 100] } : {}),
    };
  };
  const axes = (figure) => [axis(figure.xAxis, 26), axis(figure.yAxis, 58)];
  // uPlot's own range, but 0 to 1 around nothing but zeros, where it takes 0 to 100.
  const log = (about) => (about.log ? { distr: 3 } : undefined);
  const range = (about) => (u, min, max) => {
    if (min == null) return [null, null];
    if (min === 0 && max === 0) return [0, 1];
    const [low, high] = uPlot.rangeNum(min, max, 0.1, true);
    return [about.from_zero ? Math.min(low, 0) : low, high];
  };

  // What is common to all figures: zoom with Ctrl + wheel, a line at zero, a name for those who do not see the canvas.
  const zoomable = (keys) => ({ hooks: { ready: [(u) => u.over.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    const box = u.over.getBoundingClientRect(), factor = event.deltaY < 0 ? 0.8 : 1.25;
    const at = { x: (event.clientX - box.left) / box.width, y: 1 - (event.clientY - box.top) / box.height };
    for (const key of keys) {
      const { min, max } = u.scales[key], centre = min + at[key] * (max - min);
      u.setScale(key, { min: centre - (centre - min) * factor, max: centre + (max - centre) * factor });
    }
  }, { passive: false })] } });
  const zero = { hooks: { drawAxes: [(u) => {
    const { min, max } = u.scales.y;
    if (!(min < 0 && max > 0)) return;
    const y = Math.round(u.valToPos(0, "y", true));
    u.ctx.fillStyle = colour("zero");
    u.ctx.fillRect(u.bbox.left, y, u.bbox.width, devicePixelRatio);
  }] } };
  const legend = (roles) => ({ markers: {
    stroke: (u, i) => (roles[i] ? `var(--${roles[i]})` : "transparent"), fill: "transparent", width: 3, dash: "solid",
  } });
  const weights = { measured: 2.4, heating: 2.2, cooling: 2.2, model: 1.5, before: 1.5, after: 1.5 };
  const weight = (role) => weights[role] ?? 1.2;
  const room = (element) => element.clientWidth - 16;

  // Linked figures: a shared range of x, and the x under the pointer.
  const groups = new Map();
  const group = (name) => {
    if (!groups.has(name)) groups.set(name, { lines: [], loops: [], range: null, pointer: null, lit: [] });
    return groups.get(name);
  };
  const linked = (name) => (name ? { hooks: {
    setScale: [(u, key) => {
      const { lines, loops } = group(name), { min, max } = u.scales[key];
      if (key !== "x" || min == null) return;
      group(name).range = [min, max];
      for (const other of lines) {
        const { x } = other.scales;
        if (other !== u && (x.min !== min || x.max !== max)) other.setScale("x", { min, max });
      }
      loops.forEach((loop) => loop.redraw(false));
    }],
    setCursor: [(u) => {
      const together = group(name), at = u.cursor.left >= 0 ? u.posToVal(u.cursor.left, "x") : null;
      if (together.pointer === null) requestAnimationFrame(() => {
        together.loops.forEach((loop) => loop.point(together.pointer.at));
        together.pointer = null;
      });
      together.pointer = { at };
    }],
  } } : {});

  // Samples that something points at: intervals of the linked x, shaded in curves, marked in traces.
  const light = (name, spans) => {
    const together = group(name);
    together.lit = spans;
    [...together.lines, ...together.loops].forEach((plot) => plot.redraw(false));
  };
  const shade = (name) => ({ hooks: { drawAxes: [(u) => {
    u.ctx.fillStyle = `color-mix(in srgb, ${colour("lit")} 40%, transparent)`;
    const { min, max } = u.scales.x;
    for (const [from, to] of name ? group(name).lit : []) {
      if (to < min || from > max) continue;
      const [a, b] = [Math.max(from, min), Math.min(to, max)].map((x) => u.valToPos(x, "x", true));
      u.ctx.fillRect(a, u.bbox.top, Math.max(b - a, devicePixelRatio), u.bbox.height);
    }
  }] } });

  const marked = (marks) => ({ hooks: { draw: [(u) => lceMarks(u, marks, colour)] } });

  const drawLines = (element, figure) => {
    const series = [{ label: figure.xAxis.name, value: (u, v) => amount(v, figure.xAxis.unit) }];
    const read = (numbers, { log }) => (log ? array(numbers).map((v) => (v == null ? v : 10 ** v)) : array(numbers));
    const data = [read(figure.x, figure.xAxis)], roles = [null], bands = [];
    const add = (options, values, role) => { series.push(options); data.push(values); roles.push(role); };
    for (const { low, high, role } of figure.curves) {
      if (!low) continue;
      const fill = () => `color-mix(in srgb, ${colour(role)} 22%, transparent)`;
      bands.push({ series: [data.length, data.length + 1], fill });
      const hidden = { class: "edge", stroke: "transparent", points: { show: false } };
      for (const edge of [high, low]) add({ ...hidden }, read(edge, figure.yAxis));
    }
    for (const { label, role, form, y } of figure.curves) {
      add({
        label, stroke: () => colour(role), width: weight(role),
        dash: form === "dashed" ? [6, 4] : [],
        points: { show: form === "points" || form === "marked", size: form === "marked" ? 8 : 4, fill: () => colour(role) },
        paths: form === "step" ? uPlot.paths.stepped({ align: 1 }) : form === "points" ? () => null : undefined,
        value: (u, v) => amount(v, figure.yAxis.unit),
      }, read(y, figure.yAxis), role);
    }
    const plot = new uPlot({
      width: room(element), height: figure.height, scales: { x: { time: false, ...log(figure.xAxis) }, y: log(figure.yAxis) ?? { range: range(figure.yAxis) } },
      series, bands, legend: legend(roles),
      cursor: { y: false, sync: figure.linked ? { key: figure.linked } : undefined, drag: { x: true, y: false } },
      axes: axes(figure), plugins: [zoomable(["x"]), shade(figure.linked), zero, linked(figure.linked), marked(figure.marks)],
    }, data, element);
    if (figure.linked) group(figure.linked).lines.push(plot);
    return plot;
  };

  const extent = (arrays) => {
    let low = Infinity, high = -Infinity;
    for (const v of arrays.flat()) {
      if (v != null && v < low) low = v;
      if (v != null && v > high) high = v;
    }
    const margin = 0.04 * (high - low || 1);
    return low <= high ? [low - margin, high + margin] : [0, 1];
  };

  // A trace over its own x; samples outside the linked range are only hinted at.
  const trace = ({ role, form, at }, together) => (u, index) => {
    uPlot.orient(u, index, (series, dx, dy, sx, sy, toX, toY, left, top, width, height) => {
      const [xs, ys] = u.data[index], { ctx } = u, r = 1.2 * devicePixelRatio;
      const inside = (i) => !at || !together.range || (at[i] >= together.range[0] && at[i] <= together.range[1]);
      ctx.save();
      ctx.beginPath();
      ctx.rect(left, top, width, height);
      ctx.clip();
      ctx.strokeStyle = ctx.fillStyle = colour(role);
      ctx.lineWidth = weight(role) * devicePixelRatio;
      ctx.setLineDash(form === "dashed" ? [6, 4] : []);
      const all = form === "points" ? 0.35 : 1;
      for (const wanted of [false, true]) {
        const here = (i) => xs[i] != null && ys[i] != null && inside(i) === wanted;
        ctx.beginPath();
        for (let i = 0; i < xs.length; i++) {
          if (!here(i)) continue;
          const x = toX(xs[i], sx, width, left), y = toY(ys[i], sy, height, top);
          if (form === "points") ctx.rect(x - r, y - r, 2 * r, 2 * r);
          else if (here(i - 1)) ctx.lineTo(x, y);
          else ctx.moveTo(here(i + 1) ? x : x - 5 * r, y);
          if (form !== "points" && !here(i - 1) && !here(i + 1)) ctx.lineTo(x + 5 * r, y); // alone: a dash
        }
        ctx.globalAlpha = wanted ? all : 0.12 * all;
        if (form === "points") ctx.fill(); else ctx.stroke();
      }
      if (at && together.lit.length) { // on top: a point for each sample that is lit
        ctx.beginPath();
        for (let i = 0; i < xs.length; i++) {
          if (xs[i] == null || ys[i] == null || !together.lit.some(([a, b]) => at[i] >= a && at[i] <= b)) continue;
          ctx.rect(toX(xs[i], sx, width, left) - 1.5 * r, toY(ys[i], sy, height, top) - 1.5 * r, 3 * r, 3 * r);
        }
        ctx.globalAlpha = 0.8;
        ctx.fillStyle = colour("lit");
        ctx.fill();
      }
      ctx.restore();
    });
    return null;
  };

  const drawLoop = (element, figure) => {
    const together = figure.linked ? group(figure.linked) : { range: null, lit: [] };
    const traces = figure.traces.map((t) => ({ ...t, x: array(t.x), y: array(t.y), at: t.at ? array(t.at) : null }));
    const whole = { x: extent(traces.map((t) => t.x)), y: extent(traces.map((t) => t.y)) };
    const scale = (key) => ({ time: false, range: (u, min, max) => (min == null ? whole[key] : [min, max]) });
    const facets = [{ scale: "x", auto: true }, { scale: "y", auto: true }];
    const plot = new uPlot({
      mode: 2, width: room(element), height: figure.height, scales: { x: scale("x"), y: scale("y") },
      legend: { live: false, ...legend([null, ...traces.map((t) => t.role)]) },
      cursor: { drag: { x: true, y: true, uni: 20 }, points: { show: false } },
      axes: axes(figure), plugins: [zoomable(["x", "y"]), zero],
      series: [null, ...traces.map((t) => ({
        label: t.label, stroke: () => colour(t.role), facets, paths: trace(t, together), points: { show: false },
      }))],
    }, [null, ...traces.map((t) => [t.x, t.y])], element);
    const reset = () => Object.entries(whole).forEach(([key, [min, max]]) => plot.setScale(key, { min, max }));
    plot.over.addEventListener("dblclick", reset);
    reset();
    const where = element.querySelector("output");
    plot.over.addEventListener("mousemove", () => {
      const x = plot.posToVal(plot.cursor.left, "x"), y = plot.posToVal(plot.cursor.top, "y");
      where.textContent = `${amount(x, figure.xAxis.unit)}, ${amount(y, figure.yAxis.unit)}`;
    });
    plot.over.addEventListener("mouseleave", () => { where.textContent = ""; });
    if (figure.linked) together.loops.push(Object.assign(plot, { point: pointer(plot, traces) }));
    return plot;
  };

  // A dot on each joined trace where the linked figures are pointed at.
  const pointer = (plot, traces) => {
    const dots = traces.filter((t) => t.at && t.form !== "points").map((t) => {
      const dot = document.createElement("i");
      dot.className = "dot";
      dot.style.background = `var(--${t.role})`;
      plot.over.append(dot);
      return [t, dot];
    });
    return (at) => dots.forEach(([t, dot]) => {
      let near = 0;
      for (let i = 1; i < t.at.length; i++) if (Math.abs(t.at[i] - at) < Math.abs(t.at[near] - at)) near = i;
      dot.style.display = at == null ? "none" : "block";
      dot.style.transform = `translate(${plot.valToPos(t.x[near], "x")}px, ${plot.valToPos(t.y[near], "y")}px)`;
    });
  };

  // Draw the figures into their elements; the reader may scroll while the rest is drawn.
  const draw = async (places, figures) => {
    let since = performance.now();
    for (const element of places) {
      const figure = figures[element.dataset.figure];
      const plot = (figure.traces ? drawLoop : drawLines)(element, figure);
      const canvas = plot.root.querySelector("canvas");
      const drawn = (figure.traces ?? figure.curves).map((c) => c.label).join(", ");
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", `${figure.title}; ${named(figure.yAxis)} over ${named(figure.xAxis)}: ${drawn}`);
      plots.push(Object.assign(plot, { element, figure }));
      if (performance.now() - since > 40) {
        await new Promise((next) => setTimeout(next, 0));
        since = performance.now();
      }
    }
  };
  const fit = () => plots.forEach((plot) => {
    const width = room(plot.element);
    if (width > 0 && plot.width !== width) plot.setSize({ width, height: plot.height });
  });
  addEventListener("resize", fit);
  const redraw = () => plots.forEach((plot) => plot.redraw(false, true));
  const clear = () => { removeEventListener("resize", fit); plots.splice(0).forEach((plot) => plot.destroy()); };

  // For tests: does a figure hold more than its grid?
  const rgb = (name) => [1, 3, 5].map((i) => parseInt(colour(name).slice(i, i + 2), 16));
  const inked = (u) => {
    const { left, top, width, height } = u.bbox, pale = [rgb("grid"), rgb("zero")];
    const { data } = u.ctx.getImageData(left, top, width, height);
    for (let i = 0; i < data.length; i += 4) {
      if (data[i + 3] > 60 && pale.every((p) => p.some((v, k) => Math.abs(v - data[i + k]) > 24))) return true;
    }
    return false;
  };
  return { clear, draw, fit, inked, light, plots, redraw };
};
