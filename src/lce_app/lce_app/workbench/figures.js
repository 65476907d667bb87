// SPDX-License-Identifier: Apache-2.0
// Blocks of the report, fetched from the server and drawn by the report's own script.
const save = (content, name) => {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(content), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
};
const fileName = (plot, kind) => `${plot.figure.title.replace(/[^\p{L}\p{N}]+/gu, "-")}.${kind}`;

// The samples in view: of curves by their common x, of traces those within the plot.
const csv = (plot) => {
  const { xAxis, yAxis, traces, curves } = plot.figure, { x, y } = plot.scales;
  const name = ({ name, unit }) => `${name} [${unit}]`, lines = [];
  if (traces) {
    lines.push(`trace,${name(xAxis)},${name(yAxis)}`);
    plot.data.slice(1).forEach(([xs, ys], k) => xs.forEach((v, i) => {
      if (v >= x.min && v <= x.max && ys[i] >= y.min && ys[i] <= y.max) lines.push([traces[k].label, v, ys[i]].join());
    }));
  } else {
    const shown = plot.series.map((s, i) => i).filter((i) => i && plot.series[i].class !== "edge");
    lines.push([name(xAxis), ...shown.map((i) => `${plot.series[i].label} ${name(yAxis)}`)].join());
    plot.data[0].forEach((v, i) => {
      if (v >= x.min && v <= x.max) lines.push([v, ...shown.map((k) => plot.data[k][i] ?? "")].join());
    });
  }
  return new Blob([`${lines.join("\n")}\n`], { type: "text/csv" });
};
// The picture with its title and what its colours are.
const png = (plot) => new Promise((done) => {
  const { canvas } = plot.ctx, { title, traces, curves } = plot.figure, r = devicePixelRatio, head = 42 * r;
  const style = getComputedStyle(document.documentElement), colour = (name) => style.getPropertyValue(`--${name}`);
  const copy = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height + head });
  const context = copy.getContext("2d"), font = `${12 * r}px system-ui, sans-serif`;
  context.fillStyle = colour("panel");
  context.fillRect(0, 0, copy.width, copy.height);
  context.drawImage(canvas, 0, head);
  context.fillStyle = colour("ink");
  context.font = `600 ${font}`;
  context.fillText(title, 8 * r, 17 * r);
  context.font = font;
  let x = 8 * r;
  for (const { label, role } of traces ?? curves) {
    context.fillStyle = colour(role);
    context.fillRect(x, 30 * r, 14 * r, 3 * r);
    context.fillStyle = colour("quiet");
    context.fillText(label, x + 18 * r, 36 * r);
    x += 32 * r + context.measureText(label).width;
  }
  copy.toBlob(done);
});

export default {
  template: '<div class="figures" aria-live="off"></div>',
  props: { url: String, lit: Object, marking: Boolean },
  async mounted() {
    this.onTheme = () => this.drawing?.redraw();
    document.addEventListener("theme", this.onTheme);
    this.room = new ResizeObserver(() => this.drawing?.fit());
    this.room.observe(this.$el);
    this.$el.addEventListener("click", (event) => {
      const button = event.target.closest("button");
      if (button?.dataset.pick) this.pick(button);
      if (button?.dataset.take) this.take(button);
    });
    this.loaded = this.load();
  },
  beforeUnmount() {
    document.removeEventListener("theme", this.onTheme);
    this.room.disconnect();
    this.drawing?.clear();
  },
  watch: { url() { this.loaded = this.load(); }, lit() { this.light(); }, marking() { this.dragging(); } },
  methods: {
    async load() {
      this.$el.setAttribute("aria-busy", "true");
      try {
        await this.show(await fetch(this.url));
      } finally {
        this.$el.removeAttribute("aria-busy");
      }
    },
    async show(response) {
      if (response.status === 204) return; // the tab was filled anew meanwhile
      if (!response.ok) {
        this.$el.textContent = `The figures could not be computed (${response.status}).`;
        return;
      }
      const block = await response.arrayBuffer(), length = new DataView(block).getUint32(0, true);
      const { html, figures } = JSON.parse(new TextDecoder().decode(new Uint8Array(block, 4, length)));
      const numbers = new Float32Array(block, 4 + length);
      this.drawing?.clear();
      this.drawing = lceFigures(([begin, n]) => Array.from(numbers.subarray(begin, begin + n), (v) => (v === v ? v : null)));
      this.$el.innerHTML = html;
      const places = this.$el.querySelectorAll("figure[data-figure]");
      await this.drawing.draw(places, figures);
      for (const plot of this.drawing.plots) {
        const caption = plot.element.querySelector("figcaption");
        for (const kind of ["csv", "png", "svg", "pdf"]) {
          const button = Object.assign(document.createElement("button"), { type: "button", className: "take" });
          button.dataset.take = kind;
          button.textContent = kind.toUpperCase();
          button.setAttribute("aria-label", `${plot.figure.title} as ${kind.toUpperCase()}`);
          caption.append(button);
        }
      }
      for (const plot of this.drawing.plots) plot.hooks.setSelect = [...(plot.hooks.setSelect ?? []), this.mark];
      this.dragging();
      this.light();
      this.$el.dataset.drawn = places.length;
      this.$emit("drawn");
    },
    pick(button) {
      const pressed = button.getAttribute("aria-pressed") === "true";
      this.$el.querySelectorAll("[data-pick]").forEach((other) => other.setAttribute("aria-pressed", "false"));
      button.setAttribute("aria-pressed", String(!pressed));
      const { pick, row, column } = button.dataset;
      this.$emit("pick", pressed ? { pick: "", row: 0, column: 0 } : { pick, row: +row, column: +column });
    },
    dragging() {
      for (const plot of this.drawing?.plots ?? []) plot.cursor.drag.setScale = !this.marking;
    },
    mark(plot) {
      const { left, width } = plot.select;
      if (!this.marking || !width) return;
      const [begin, end] = [left, left + width].map((x) => plot.posToVal(x, "x"));
      plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false); // the server lights up what it takes
      clearTimeout(this.marked); // figures that are linked are dragged over together
      this.marked = setTimeout(() => this.$emit("mark", { begin, end }), 0);
    },
    async take(button) {
      const plot = this.drawing.plots.find((p) => p.element.contains(button)), kind = button.dataset.take;
      const content = await { csv, png }[kind]?.(plot) ?? await this.onPaper(plot, kind);
      if (content) save(content, fileName(plot, kind));
    },
    async onPaper(plot, kind) {
      const { min, max } = plot.scales.x, number = plot.element.dataset.figure;
      const response = await fetch(`${this.url.split("?")[0]}/${number}.${kind}?low=${min}&high=${max}`);
      if (response.ok) return response.blob();
      plot.element.querySelector("output").textContent = await response.text();
      return null;
    },
    light() {
      Object.entries(this.lit ?? {}).forEach(([name, spans]) => this.drawing?.light(name, spans));
    },
    async replace(curves) {
      await this.loaded;
      for (const plot of this.drawing?.plots ?? []) {
        const data = [...plot.data];
        let changed = false;
        plot.series.forEach((series, i) => {
          const text = curves[`${plot.figure.title}/${series.label}`];
          if (!text) return;
          const values = new Float32Array(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
          data[i] = Array.from(values, (v) => (v === v ? v : null));
          changed = true;
        });
        if (!changed) continue;
        const { min, max } = plot.scales.x;
        plot.setData(data, false);
        plot.setScale("x", { min, max }); // what is in view stays, and y follows
      }
      this.$el.dataset.replaced = 1 + Number(this.$el.dataset.replaced ?? 0);
    },
    async extend(columns, keep) {
      await this.loaded;
      for (const plot of this.drawing?.plots ?? []) {
        const more = columns[plot.figure.title];
        if (!more || !more[0].length) continue;
        const data = plot.data.map((old, i) => [...old, ...more[i]]), last = data[0].at(-1);
        const begin = keep === null ? 0 : data[0].findIndex((x) => x >= last - keep);
        plot.setData(data.map((column) => column.slice(begin)));
      }
    },
  },
};
