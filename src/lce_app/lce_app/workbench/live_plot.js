// SPDX-License-Identifier: Apache-2.0
// A live plot: series of different rates on one moving time axis, a y axis for each unit, markers as labelled lines.
// In its columns undefined means "no sample of this series here", null is a gap.
const GAP_S = 2.5; // nodes report once a second: a longer silence is a gap
const digits = (v) => (v == null ? "–" : String(Number(v.toPrecision(5))).replace("-", "−"));
const decode = (text, Kind) => new Kind(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const font = "12px system-ui, sans-serif";

export default {
  template: '<div class="live-plot" aria-live="off"></div>',
  props: { name: String, series: Array, height: Number, span: Number },
  mounted() {
    this.onTheme = () => this.plot?.redraw(false, true);
    document.addEventListener("theme", this.onTheme);
    this.room = new ResizeObserver(() => {
      const width = this.$el.clientWidth;
      if (width > 0 && this.plot && this.plot.width !== width) this.plot.setSize({ width, height: this.height });
    });
    this.room.observe(this.$el);
    this.begin();
  },
  beforeUnmount() {
    document.removeEventListener("theme", this.onTheme);
    this.room.disconnect();
    this.plot?.destroy();
    this.plot = null;
    this.$emit("gone");
  },
  watch: { height() { this.plot?.setSize({ width: this.plot.width, height: this.height }); } },
  methods: {
    begin() {
      const units = [...new Set(this.series.map((s) => s.unit))];
      this.data = [[], ...this.series.map(() => [])];
      this.last = this.series.map(() => null); // time of the last sample of each series
      this.markers = [];
      const text = { font, labelFont: font, stroke: () => colour("quiet") };
      const rule = { stroke: () => colour("grid"), width: 1 };
      const axes = [{ ...text, size: 26, label: "time [s]", labelSize: 15, labelGap: 0, grid: rule, ticks: { ...rule, size: 5 }, values: (u, splits) => splits.map(digits) }];
      const scales = { x: { time: false, auto: false } };
      units.forEach((unit, i) => {
        const names = this.series.filter((s) => s.unit === unit).map((s) => s.label);
        const label = unit === "1" ? (names.length > 1 ? "" : names[0]) : `[${unit}]`;
        scales[unit] = { range: (u, min, max) => (min == null ? [0, 1] : min === max && min === 0 ? [0, 1] : uPlot.rangeNum(min, max, 0.1, true)) };
        axes.push({
          ...text, scale: unit, side: i ? 1 : 3, size: 54, label, labelSize: 17, labelGap: 0,
          grid: i ? { show: false } : rule, ticks: { ...rule, size: 5 }, values: (u, splits) => splits.map(digits),
        });
      });
      const value = (unit) => (u, v) => (v == null ? "–" : `${digits(v)}${unit === "1" ? "" : ` ${unit}`}`);
      const series = [{ label: "time", value: (u, v) => (v == null ? "–" : `${v.toFixed(2)} s`) }, ...this.series.map((s, i) => ({
        label: s.label, scale: s.unit, stroke: () => colour(s.colour), width: i ? 1.2 : 1.8, points: { show: false },
        dash: i > 7 ? [6, 4] : [], value: value(s.unit),
      }))];
      this.plot = new uPlot({
        width: Math.max(this.$el.clientWidth, 100), height: this.height, scales, axes, series,
        legend: { markers: { stroke: (u, i) => (i ? `var(--${this.series[i - 1].colour})` : "transparent"), fill: "transparent", width: 3, dash: "solid" } },
        cursor: { y: false, sync: { key: "live" }, drag: { x: true, y: false }, dataIdx: (u, i, at) => this.near(i, at) },
        hooks: {
          draw: [(u) => lceMarks(u, this.markers, colour)],
          setSelect: [(u) => { if (u.select.width > 0) this.$emit("zoomed"); }],
        },
      }, this.data, this.$el);
      const canvas = this.plot.root.querySelector("canvas");
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", `${this.name} over time [s], live; the values are in the table below`);
      this.$emit("ready");
    },
    // The sample of a series at or before an index of the common axis.
    near(i, at) {
      if (i === 0) return at;
      let k = at;
      while (k > 0 && this.data[i][k] == null) k--;
      return k;
    },
    // A sample into the common axis: almost always at its end, so the search begins there.
    insert(k, t, v) {
      const [x] = this.data;
      let at = x.length;
      while (at > 0 && x[at - 1] > t) at--;
      if (at > 0 && x[at - 1] === t) {
        this.data[k][at - 1] = v;
        return;
      }
      if (at === x.length) {
        x.push(t);
        for (let i = 1; i < this.data.length; i++) this.data[i].push(undefined);
      } else {
        x.splice(at, 0, t);
        for (let i = 1; i < this.data.length; i++) this.data[i].splice(at, 0, undefined);
      }
      this.data[k][at] = v;
    },
    extend(batches, markers, now) {
      if (!this.plot) return;
      batches.forEach((batch, i) => {
        if (!batch) return;
        const times = decode(batch[0], Float64Array), values = decode(batch[1], Float32Array);
        for (let j = 0; j < times.length; j++) {
          const t = times[j], before = this.last[i];
          if (before !== null && t - before > GAP_S) this.insert(i + 1, before + GAP_S / 2, null);
          this.insert(i + 1, t, Number.isFinite(values[j]) ? values[j] : null);
          this.last[i] = before === null ? t : Math.max(t, before);
        }
      });
      const begin = now - this.span;
      let old = 0;
      while (old < this.data[0].length && this.data[0][old] < begin - 5) old++; // a little more, for the line at the edge
      if (old > 200) this.data.forEach((column) => column.splice(0, old));
      this.markers = [...this.markers, ...markers].filter(([t]) => t >= begin - 5);
      this.plot.setData(this.data, false);
      this.plot.setScale("x", { min: begin, max: now });
      queueMicrotask(() => this.showLatest()); // after uPlot has drawn, which empties its legend
      this.$el.dataset.samples = this.data[0].length;
      this.$el.dataset.markers = this.markers.map(([, text]) => text).join("\n");
    },
    // The legend tells the latest values while nobody points at the plot.
    showLatest() {
      const { left } = this.plot?.cursor ?? { left: 0 };
      if (left != null && left >= 0) return;
      const end = this.data[0].length - 1;
      this.data.forEach((column, i) => {
        const at = end < 0 ? null : this.near(i, end);
        this.plot.legend.values[i] = { _: this.plot.series[i].value(this.plot, at === null ? null : column[at]) };
      });
      this.plot.setLegend(null, false);
    },
  },
};
