"use strict";
/* The body on its ground: a larva seen from the side, its head to the right, as the films draw it. */

// ColorBrewer's RdBu, from blue (stretched) to red (contracted), safe for colour-blind readers; by night the
// middle is dark, so that rest does not dazzle.
const SCALES = {
  day: [
    [5, 48, 97], [33, 102, 172], [67, 147, 195], [146, 197, 222], [209, 229, 240], [247, 247, 247],
    [253, 219, 199], [244, 165, 130], [214, 96, 77], [178, 24, 43], [103, 0, 31],
  ],
  night: [
    [198, 226, 255], [132, 190, 250], [82, 148, 222], [56, 106, 165], [48, 70, 100], [44, 48, 56],
    [96, 58, 52], [160, 74, 58], [222, 98, 72], [250, 140, 105], [255, 206, 180],
  ],
};
const FORCES = {
  day: [[255, 255, 255], [251, 197, 220], [231, 85, 156], [160, 5, 110], [73, 0, 106]],
  night: [[34, 37, 43], [84, 36, 74], [158, 42, 116], [232, 96, 164], [255, 196, 226]],
};
const STRAIN_LIMIT = 0.4; // at the ends of the scale
const SLIMMEST = 0.3; // L, width at which a segment stops looking thinner
const TALLEST = 2.4; // heights at rest, where it stops bulging
const MARGIN = 3.6; // L of ground beside the body
const RACE_MARGIN = 7; // more of it, so that both are seen

/** Colours at 256 places along a scale, as [r, g, b]. */
function ramp(stops) {
  return Array.from({ length: 256 }, (_, i) => {
    const at = (i / 255) * (stops.length - 1), left = Math.min(Math.floor(at), stops.length - 2);
    return stops[left].map((channel, c) => Math.round(channel + (at - left) * (stops[left + 1][c] - channel)));
  });
}

/** Everything that a drawing takes its colours from: the page's style, by day or by night. */
function readTheme() {
  const style = getComputedStyle(document.documentElement);
  const names = ["ink", "soft", "paper", "earth", "earth-ink", "skin", "line", "red", "blue", "on", "outline"];
  const theme = Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
  const time = matchMedia("(prefers-color-scheme: dark)").matches ? "night" : "day";
  return { ...theme, strain: ramp(SCALES[time]), force: ramp(FORCES[time]) };
}

function strainColour(strain, theme) {
  const at = (strain / STRAIN_LIMIT + 1) / 2;
  return theme.strain[Math.round(255 * Math.min(Math.max(at, 0), 1))];
}

function forceColour(force, strongest, theme) {
  return theme.force[Math.round(255 * Math.min(Math.max(force / strongest, 0), 1))];
}

const css = ([r, g, b]) => `rgb(${r} ${g} ${b})`;

/** Make a canvas as fine as the screen; its context, in CSS pixels, and its size. */
function prepare(canvas) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2);
  const width = canvas.clientWidth, height = canvas.clientHeight;
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  return { pen, width, height };
}

class BodyDrawing {
  /** `view`: camera (L), race, and whether to show forces and neurons. */
  constructor(canvas, lane, theme, view) {
    Object.assign(this, prepare(canvas));
    this.lane = lane;
    this.crawler = lane.crawler;
    this.theme = theme;
    this.view = view;
    const n = lane.nSegments;
    this.ground = Math.round(0.8 * this.height);
    // A larva is some seven times as long as it is high; a short crawler is drawn stouter.
    const restHeight = Math.max(n / 7, 0.9);
    const margin = view.race ? RACE_MARGIN : MARGIN;
    this.scale = Math.min(this.width / (n + margin), (0.68 * this.height) / (TALLEST * restHeight));
    this.restHeight = restHeight * this.scale;
    this.stroke = Math.max(this.height / 150, 1.4);
    this.offset = lane.distance - this.crawler.centroid; // of the body that was put back to the start
  }

  draw() {
    this.drawGround();
    this.placeNodes();
    this.drawBody();
    if (this.view.forces) this.drawForces();
    if (this.view.neurons) this.drawNeurons();
  }

  x(position) {
    return this.width / 2 + (position + this.lane.nSegments / 2 - this.view.camera) * this.scale;
  }

  drawGround() {
    const { pen, theme, width, height, ground, scale } = this, middle = this.lane.nSegments / 2;
    pen.fillStyle = theme.earth;
    pen.fillRect(0, ground, width, height - ground);
    pen.fillStyle = theme["earth-ink"];
    pen.fillRect(0, ground - this.stroke / 2, width, this.stroke);
    pen.font = "12px system-ui, sans-serif";
    pen.textAlign = "center";
    pen.textBaseline = "top";
    const half = width / 2 / scale, from = this.view.camera - middle;
    const spacing = [1, 2, 5, 10].find((step) => step * scale > 64);
    for (let tick = Math.floor(from - half); tick <= from + half; tick++) {
      const labelled = tick % spacing === 0, length = labelled ? 8 : 4;
      pen.fillRect(this.x(tick) - 0.5, ground, 1, length);
      if (labelled && Math.abs(this.x(tick) - width / 2) < width / 2 - 18) pen.fillText(`${tick} L`.replace("-", "\u2212"), this.x(tick), ground + 11);
    }
  }

  /* Columns of the nodes; a segment never looks thinner than can be seen. */
  placeNodes() {
    const { u } = this.crawler;
    this.strains = Array.from({ length: u.length - 1 }, (_, i) => u[i + 1] - u[i]);
    let place = u[0] + this.offset;
    this.nodes = [this.x(place)];
    for (const strain of this.strains) this.nodes.push(this.x((place -= Math.max(1 - strain, SLIMMEST))));
    // A segment bulges so that its area stays the same.
    this.bulges = this.strains.map((strain) => {
      const share = strain < 1 ? 1 / (1 - strain) : TALLEST;
      return this.restHeight * Math.min(Math.max(share, 1 / TALLEST), TALLEST);
    });
    const { bulges } = this, last = bulges.length - 1;
    const fold = (j) => Math.min(bulges[Math.max(j - 1, 0)], bulges[Math.min(j, last)]);
    this.waists = this.nodes.map((_, j) => 0.84 * fold(j));
  }

  drawBody() {
    const { pen, nodes, waists, theme } = this, tail = nodes.length - 1;
    pen.strokeStyle = theme.outline;
    pen.lineWidth = this.stroke;
    pen.lineJoin = "round";
    const cap = Math.min(0.5 * this.restHeight, 0.9 * this.scale);
    this.drawCap(nodes[tail], -0.7 * cap, waists[tail]);
    for (let i = tail; i > 0; i--) this.drawSegment(i);
    this.drawCap(nodes[0], cap, waists[0]);
    this.drawFace(nodes[0], cap, waists[0]);
    pen.fillStyle = theme.outline;
    const size = Math.max(0.1 * Math.min(this.scale, this.restHeight), 3);
    for (const node of nodes) {
      pen.beginPath();
      pen.moveTo(node - 1.2 * size, this.ground);
      pen.lineTo(node + 0.5 * size, this.ground);
      pen.lineTo(node - 0.9 * size, this.ground + size);
      pen.fill();
    }
  }

  /* A barrel whose mean height is the bulge. */
  drawSegment(i) {
    const { pen, ground } = this, left = this.nodes[i], right = this.nodes[i - 1];
    const [low, high] = [this.waists[i], this.waists[i - 1]];
    const rise = (this.bulges[i - 1] - (low + high) / 2) / (Math.PI / 4);
    pen.beginPath();
    pen.moveTo(left, ground);
    for (let k = 0; k <= 16; k++) {
      const t = (1 - Math.cos((Math.PI * k) / 16)) / 2; // closer together where the arch is steep
      const top = low + (high - low) * t + rise * Math.sqrt(1 - (2 * t - 1) ** 2);
      pen.lineTo(left + (right - left) * t, ground - top);
    }
    pen.lineTo(right, ground);
    pen.fillStyle = css(strainColour(this.strains[i - 1], this.theme));
    pen.fill();
    pen.stroke();
  }

  /* Round off an end of the body; reach is positive for the head. */
  drawCap(node, reach, waist) {
    const { pen, ground } = this;
    pen.beginPath();
    pen.moveTo(node, ground);
    for (let k = 0; k <= 12; k++) {
      const angle = (Math.PI / 2) * (k / 12);
      pen.lineTo(node + reach * Math.cos(angle) ** 0.7, ground - waist * Math.sin(angle) ** 0.9);
    }
    pen.lineTo(node, ground);
    pen.fillStyle = this.theme.skin;
    pen.fill();
    pen.stroke();
  }

  /* An eye that looks ahead, and a mouth. */
  drawFace(node, reach, waist) {
    const { pen, ground } = this, size = Math.max(0.15 * Math.min(2 * reach, waist), 2);
    const dot = (x, radius, colour) => {
      pen.beginPath();
      pen.arc(x, ground - 0.62 * waist, radius, 0, 2 * Math.PI);
      pen.fillStyle = colour;
      pen.fill();
    };
    dot(node + 0.45 * reach, 1.5 * size, "#fff");
    pen.stroke();
    dot(node + 0.45 * reach + 0.45 * size, 0.85 * size, "#222");
    pen.beginPath();
    const [x, y, wide, high] = [node + 0.55 * reach, ground - 0.34 * waist, 0.38 * reach, 0.14 * waist];
    pen.ellipse(x, y, wide, high, 0, 0.25 * Math.PI, 0.85 * Math.PI);
    pen.strokeStyle = "#333";
    pen.stroke();
  }

  /* A bar in each segment, as thick as its muscle pulls; that of the head muscle reaches into the head. */
  drawForces() {
    const { pen, nodes, crawler } = this, strongest = crawler.parameters.muscle_force_max;
    pen.lineCap = "round";
    for (let i = 0; i < nodes.length; i++) {
      const share = crawler.force[i] / strongest;
      if (share < 0.02) continue;
      const [from, to] = i > 0 ? [nodes[i], nodes[i - 1]] : [nodes[0], nodes[0] + 0.5 * this.scale];
      pen.beginPath();
      pen.moveTo(from + 5, this.ground - 0.2 * this.restHeight);
      pen.lineTo(to - 5, this.ground - 0.2 * this.restHeight);
      pen.lineWidth = 1 + share * 0.2 * this.restHeight;
      pen.strokeStyle = css(forceColour(0.35 + 0.4 * share, 1, this.theme));
      pen.stroke();
    }
  }

  /* A disc over each segment, filled as far as its neuron has come on its way to the next spike. */
  drawNeurons() {
    const { pen, nodes, crawler, theme } = this, { W, on, spikedAt } = crawler;
    const radius = Math.min(0.26 * this.scale, 11), y = this.ground - 0.72 * this.height;
    for (let i = 0; i < nodes.length; i++) {
      const x = i > 0 ? (nodes[i] + nodes[i - 1]) / 2 : nodes[0] + 0.45 * this.scale;
      const turn = 2 * Math.atan2(1, W[i]) - (crawler.spikesAtPi ? Math.PI : 0); // theta, 0 at a spike
      const filled = (((turn / (2 * Math.PI)) % 1) + 1) % 1;
      const flash = Math.max(1 - (crawler.time - spikedAt[i]) / 1.5, 0);
      if (flash > 0) {
        pen.globalAlpha = flash;
        pen.fillStyle = theme.on;
        pen.beginPath();
        pen.arc(x, y, radius * (1.7 - 0.5 * flash), 0, 2 * Math.PI);
        pen.fill();
        pen.globalAlpha = 1;
      }
      pen.fillStyle = theme.paper;
      pen.strokeStyle = on[i] ? theme.on : theme.outline;
      pen.lineWidth = on[i] ? 3 : 1.2;
      pen.beginPath();
      pen.arc(x, y, radius, 0, 2 * Math.PI);
      pen.fill();
      pen.stroke();
      pen.fillStyle = on[i] ? theme.on : theme.soft;
      pen.beginPath();
      pen.moveTo(x, y);
      pen.arc(x, y, radius - 2.5, -Math.PI / 2, -Math.PI / 2 + 2 * Math.PI * filled);
      pen.fill();
    }
  }
}
