"use strict";
/* Kymographs that run under the body, and the two small charts: what learning and noise do. */

const STRIP_GAP = 6, AXIS = 20, LABELS = 36; // CSS pixels

/** One lane's past as pictures, a pixel per sample and segment, painted as the samples come. */
class Kymograph {
  constructor(lane, theme) {
    this.lane = lane;
    this.theme = theme;
    this.painted = 0; // samples
    const n = lane.nSegments, strongest = lane.ownCrawler.parameters.muscle_force_max;
    const hues = { 0: theme.force[0], 1: theme.strain[90], 2: hexChannels(theme.ink) };
    const strip = (name, rows, colour) => {
      const canvas = new OffscreenCanvas(COLUMNS, rows);
      return { name, rows, colour, canvas, pen: canvas.getContext("2d"), column: new ImageData(1, rows) };
    };
    this.strips = [
      strip("strain", n, (strain) => strainColour(strain, theme)),
      strip("force", n + 1, (force) => forceColour(force, strongest, theme)),
      strip("neuron", n + 1, (state) => hues[state]),
    ];
  }

  paint() {
    const { lane } = this;
    if (lane.samples < this.painted) this.painted = 0; // it has started over
    this.painted = Math.max(this.painted, lane.samples - COLUMNS);
    for (; this.painted < lane.samples; this.painted++) {
      const column = this.painted % COLUMNS;
      for (const strip of this.strips) {
        for (let i = 0; i < strip.rows; i++) {
          const [r, g, b] = strip.colour(lane[strip.name][column * strip.rows + i]);
          strip.column.data.set([r, g, b, 255], 4 * i);
        }
        strip.pen.putImageData(strip.column, column, 0);
      }
    }
  }

  /** Draw the strips that are shown, the present at the right edge. */
  draw(canvas, shown) {
    this.paint();
    const { pen, width, height } = prepare(canvas), { lane, theme } = this;
    const strips = this.strips.filter((strip) => shown.includes(strip.name));
    const left = LABELS, wide = width - left, visible = wide > 480 ? COLUMNS : COLUMNS / 2;
    const high = (height - AXIS - STRIP_GAP * (strips.length - 1)) / strips.length;
    pen.imageSmoothingEnabled = false;
    pen.font = "12px system-ui, sans-serif";
    strips.forEach((strip, k) => {
      const top = k * (high + STRIP_GAP);
      pen.fillStyle = theme.line;
      pen.fillRect(left, top, wide, high);
      this.copy(pen, strip, left, top, wide, high, visible);
      pen.fillStyle = theme.soft;
      pen.textAlign = "right";
      pen.textBaseline = "top";
      pen.fillText("head", left - 3, top);
      pen.textBaseline = "bottom";
      pen.fillText("tail", left - 3, top + high);
    });
    this.drawTimes(pen, left, wide, height, visible);
  }

  /* The ring of columns, cut where it wraps around. */
  copy(pen, strip, left, top, wide, high, visible) {
    const last = this.lane.samples, count = Math.min(last, visible), unit = wide / visible;
    for (let from = last - count; from < last; ) {
      const column = from % COLUMNS, length = Math.min(COLUMNS - column, last - from);
      const x = left + wide - (last - from) * unit;
      pen.drawImage(strip.canvas, column, 0, length, strip.rows, x, top, length * unit, high);
      from += length;
    }
  }

  drawTimes(pen, left, wide, height, visible) {
    const { lane, theme } = this, span = visible * SAMPLE, start = lane.time - span;
    pen.fillStyle = theme.soft;
    pen.textBaseline = "bottom";
    pen.textAlign = "center";
    for (let time = Math.max(Math.ceil(start / 20) * 20, 0); time <= lane.time; time += 20) {
      const x = left + wide * (1 - (lane.time - time) / span);
      pen.fillRect(x, height - AXIS, 1, 4);
      if (x > left + 12 && x < left + wide - 12) pen.fillText(`${time} τ`, x, height);
    }
  }
}

const hexChannels = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));

/** A small chart: scales, axis lines and labels; what it draws on them is the caller's. */
class Chart {
  constructor(canvas, theme, { right, top, xLabel, yTicks, xTicks }) {
    Object.assign(this, prepare(canvas));
    this.theme = theme;
    this.box = { left: 42, right: this.width - 10, top: 10, bottom: this.height - 34 };
    this.x = (value) => this.box.left + (value / right) * (this.box.right - this.box.left);
    this.y = (value) => this.box.bottom - (value / top) * (this.box.bottom - this.box.top);
    const { pen, box } = this;
    pen.font = "12px system-ui, sans-serif";
    pen.fillStyle = theme.soft;
    pen.strokeStyle = theme.line;
    pen.lineWidth = 1;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const [value, text] of yTicks) {
      this.line([[0, value], [right, value]], theme.line, 1);
      pen.fillText(text, box.left - 6, this.y(value));
    }
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const [value, text] of xTicks) pen.fillText(text, this.x(value), box.bottom + 4);
    pen.fillText(xLabel, (box.left + box.right) / 2, box.bottom + 19);
  }

  line(points, colour, width, dash = []) {
    const { pen } = this;
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.setLineDash(dash);
    pen.beginPath();
    for (const [x, y] of points) if (Number.isFinite(y)) pen.lineTo(this.x(x), this.y(y));
    pen.stroke();
    pen.setLineDash([]);
  }

  dot(x, y, colour, radius) {
    if (!Number.isFinite(y)) return;
    const { pen } = this;
    pen.beginPath();
    pen.arc(this.x(x), this.y(y), radius, 0, 2 * Math.PI);
    pen.fillStyle = colour;
    pen.fill();
    pen.strokeStyle = this.theme.paper;
    pen.lineWidth = 2;
    pen.stroke();
  }
}

/** Fig. 3C: a curve for each table, a dot where the noise is now. `curves`: { curve, colour, dash }. */
function drawNoiseChart(canvas, theme, curves, noise) {
  const speeds = curves.flatMap(({ curve }) => curve.means()).filter(Number.isFinite);
  const top = Math.max(0.002, Math.ceil(Math.max(0, ...speeds) * 1000 + 0.2) / 1000);
  const step = top > 0.006 ? 0.002 : 0.001;
  const yTicks = Array.from({ length: Math.floor(top / step + 0.01) + 1 }, (_, i) => [i * step, String(1000 * i * step)]);
  const right = NOISES[NOISES.length - 1];
  const chart = new Chart(canvas, theme, {
    right, top, xLabel: "noise s of the senses", yTicks,
    xTicks: [0, 0.05, 0.1, 0.15, 0.2].map((s) => [s, String(s)]),
  });
  for (const { curve, colour, dash } of curves) {
    chart.line(curve.means().map((speed, i) => [NOISES[i], speed]), colour, 2, dash);
  }
  for (const { curve, colour } of curves) chart.dot(noise, curve.at(noise), colour, 6);
}

/** How learning went. `points`: pairs of decisions learned from and entries on the diagonal. */
function drawLearningChart(canvas, theme, points, n) {
  const end = points.length ? points[points.length - 1][0] : 0, right = Math.max(20000, end * 1.04);
  const unit = [1e4, 5e4, 1e5, 2e5, 5e5, 1e6, 2e6, 5e6].find((step) => right / step <= 5) || 1e7;
  const xTicks = Array.from({ length: Math.floor(right / unit) + 1 }, (_, i) => [i * unit, `${(i * unit) / 1000}k`]);
  const chart = new Chart(canvas, theme, {
    right, top: n * 1.05, xLabel: "decisions learned from", xTicks, yTicks: [0, n / 2, n].map((y) => [y, String(y)]),
  });
  chart.line(points.map(([x, entries]) => [x, entries]), theme.red, 2);
}
