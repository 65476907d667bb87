// SPDX-License-Identifier: Apache-2.0
"use strict";
(async () => {
  const runs = JSON.parse(document.getElementById("data").textContent);
  const packed = Uint8Array.from(atob(document.getElementById("numbers").textContent.trim()), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const numbers = new Float32Array(await new Response(stream).arrayBuffer());
  const array = ([begin, length]) => numbers.subarray(begin, begin + length);

  const root = document.documentElement;
  const dark = matchMedia("(prefers-color-scheme: dark)");
  root.dataset.theme = dark.matches ? "dark" : "light";
  const colour = (name) => getComputedStyle(root).getPropertyValue(`--${name}`).trim();
  const plots = [];
  const setTheme = (theme) => { root.dataset.theme = theme; plots.forEach((p) => p.redraw(false, true)); };
  document.getElementById("theme").onclick = () => setTheme(root.dataset.theme === "dark" ? "light" : "dark");
  dark.onchange = () => setTheme(dark.matches ? "dark" : "light");
  let before = null;
  onbeforeprint = () => { before = root.dataset.theme; setTheme("light"); };
  onafterprint = () => setTheme(before);

  const digits = (v) => (v == null ? "–" : Number(v.toPrecision(5)).toString());
  const axis = (label, extra) => ({
    label, stroke: () => colour("quiet"), grid: { stroke: () => colour("grid"), width: 1 },
    ticks: { stroke: () => colour("grid"), width: 1 }, font: "12px system-ui", labelFont: "12px system-ui",
    labelSize: 18, ...extra,
  });

  // Zoom about the pointer; both axes of an XY plot, the time axis of the others.
  const wheel = (keys) => ({ hooks: { ready: [(u) => u.over.addEventListener("wheel", (event) => {
    event.preventDefault();
    const factor = event.deltaY < 0 ? 0.8 : 1.25;
    const box = u.over.getBoundingClientRect();
    const at = { x: (event.clientX - box.left) / box.width, y: 1 - (event.clientY - box.top) / box.height };
    for (const key of keys) {
      const { min, max } = u.scales[key];
      const centre = min + at[key] * (max - min);
      u.setScale(key, { min: centre - (centre - min) * factor, max: centre + (max - centre) * factor });
    }
  }, { passive: false })] } });

  const frame = (parent, figure, run) => {
    const element = document.createElement("figure");
    const caption = document.createElement("figcaption");
    caption.textContent = `${figure.title} [${figure.unit}]`;
    element.append(caption);
    parent.append(element);
    const label = `${run}: ${figure.title} in ${figure.unit}, ${figure.series.map((s) => s.label).join(", ")}`;
    return { element, width: element.clientWidth - 20, label };
  };
  const finish = (plot, label) => {
    const canvas = plot.root.querySelector("canvas");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", label);
    plots.push(plot);
    return plot;
  };

  const overTime = (parent, figure, run, group) => {
    const { element, width, label } = frame(parent, figure, run);
    let busy = false;
    const together = { hooks: { setScale: [(u, key) => {
      if (key !== "x" || busy) return;
      const { min, max } = u.scales.x;
      for (const other of group) {
        if (other !== u && (other.scales.x.min !== min || other.scales.x.max !== max)) other.setScale("x", { min, max });
      }
    }] } };
    const plot = new uPlot({
      width, height: figure.low ? 150 : 210, scales: { x: { time: false } },
      cursor: { sync: { key: run }, drag: { x: true, y: false } },
      axes: [axis(figure.last ? "time [s]" : null, { size: 28 }), axis(figure.unit, { size: 58 })],
      plugins: [wheel(["x"]), together],
      series: [{ label: "t", value: (u, v) => `${digits(v)} s` }, ...figure.series.map((s) => ({
        label: s.label, stroke: () => colour(s.kind), width: s.kind === "model" ? 1.6 : 1.1, points: { show: false },
        paths: figure.step ? uPlot.paths.stepped({ align: 1 }) : undefined,
        value: (u, v) => (v == null ? "–" : `${digits(v)} ${figure.unit}`),
      }))],
    }, [array(figure.x), ...figure.series.map((s) => array(s.y))], element);
    group.push(plot);
    return finish(plot, label);
  };

  const path = (figure, kind) => (u, index) => {
    uPlot.orient(u, index, (series, dx, dy, sx, sy, toX, toY, left, top, w, h) => {
      const [xs, ys] = u.data[index];
      const { ctx } = u;
      ctx.save();
      ctx.beginPath();
      ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
      ctx.clip();
      ctx.strokeStyle = ctx.fillStyle = colour(kind);
      ctx.lineWidth = (kind === "model" ? 1.8 : 1.2) * devicePixelRatio;
      ctx.setLineDash(kind === "band" ? [6, 4] : []);
      ctx.beginPath();
      const r = 1.3 * devicePixelRatio;
      for (let i = 0; i < xs.length; i++) {
        const x = toX(xs[i], sx, w, left), y = toY(ys[i], sy, h, top);
        if (figure.line) { if (i) ctx.lineTo(x, y); else ctx.moveTo(x, y); } else ctx.rect(x - r, y - r, 2 * r, 2 * r);
      }
      if (figure.line) ctx.stroke(); else { ctx.globalAlpha = 0.55; ctx.fill(); }
      ctx.restore();
    });
    return null;
  };
  const extent = (arrays) => {
    let low = Infinity, high = -Infinity;
    for (const a of arrays) for (const v of a) { if (v < low) low = v; if (v > high) high = v; }
    const margin = 0.04 * (high - low || 1);
    return [low - margin, high + margin];
  };

  const against = (parent, figure, run) => {
    const { element, width, label } = frame(parent, figure, run);
    const xs = figure.series.map((s) => array(s.x)), ys = figure.series.map((s) => array(s.y));
    const whole = { x: extent(xs.filter((a) => a.length)), y: extent(ys.filter((a) => a.length)) };
    const scale = (key) => ({ time: false, range: (u, min, max) => (min == null ? whole[key] : [min, max]) });
    const plot = new uPlot({
      mode: 2, width, height: 240, scales: { x: scale("x"), y: scale("y") },
      legend: { live: false }, cursor: { drag: { x: true, y: true, uni: 20 }, points: { show: false } },
      axes: [axis(figure.xUnit, { size: 28 }), axis(figure.unit, { size: 58 })],
      plugins: [wheel(["x", "y"])],
      series: [null, ...figure.series.map((s) => ({
        label: s.label, stroke: () => colour(s.kind), facets: [{ scale: "x", auto: true }, { scale: "y", auto: true }],
        paths: path(figure, s.kind), points: { show: false },
      }))],
    }, [null, ...xs.map((x, i) => [x, ys[i]])], element);
    const reset = () => { for (const k of ["x", "y"]) plot.setScale(k, { min: whole[k][0], max: whole[k][1] }); };
    plot.over.addEventListener("dblclick", reset);
    reset();
    const where = document.createElement("figcaption");
    where.textContent = "\u00a0";
    element.append(where);
    plot.over.addEventListener("mousemove", () => {
      const { left, top } = plot.cursor;
      where.textContent = `${digits(plot.posToVal(left, "x"))} ${figure.xUnit}, ${digits(plot.posToVal(top, "y"))} ${figure.unit}`;
    });
    return finish(plot, label);
  };

  for (const run of runs) {
    const section = document.createElement("section");
    const title = document.createElement("h2");
    title.textContent = `Run ${run.name}`;
    const figures = document.createElement("div");
    figures.className = "figures";
    const left = document.createElement("div"), right = document.createElement("div");
    figures.append(left, right);
    section.append(title, figures);
    document.getElementById("runs").append(section);
    const group = [];
    if (run.overTime.length) run.overTime[run.overTime.length - 1].last = true;
    run.overTime.forEach((f) => overTime(left, f, run.name, group));
    run.others.forEach((f, i) => against(i % 2 === 0 || i === 0 ? right : left, f, run.name));
  }

  await new Promise((done) => setTimeout(done, 0));
  const drawn = plots.filter((p) => {
    const { width, height } = p.ctx.canvas;
    const inside = p.ctx.getImageData(p.bbox.left, p.bbox.top, Math.min(p.bbox.width, width), Math.min(p.bbox.height, height));
    return inside.data.some((v, i) => i % 4 === 3 && v > 0);
  });
  document.body.dataset.figures = plots.length;
  document.body.dataset.drawn = drawn.length;
})();
