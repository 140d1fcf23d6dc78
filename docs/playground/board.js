"use strict";
/* The wiring board: a row for the segment that is contracted most, a column for the neuron that answers. */

class Board {
  /** `onChoice(observation, action)` is called when an entry is chosen. */
  constructor(table, n, onChoice) {
    this.n = n;
    this.entries = [];
    this.lit = [];
    table.replaceChildren();
    const head = table.createTHead().insertRow();
    head.append(this.heading("", "col"));
    for (let a = 0; a < n; a++) head.append(this.heading(a, "col"));
    const body = table.createTBody();
    this.rows = Array.from({ length: n }, (_, o) => {
      const row = body.insertRow();
      row.append(this.heading(o + 1, "row"));
      for (let a = 0; a < n; a++) row.insertCell().append(this.makeEntry(o, a, onChoice));
      return row;
    });
  }

  heading(text, scope) {
    const cell = document.createElement("th");
    cell.scope = scope;
    cell.textContent = text;
    if (text === "") cell.innerHTML = '<span class="hidden">segment contracted most</span>';
    return cell;
  }

  makeEntry(o, a, onChoice) {
    const label = document.createElement("label"), entry = document.createElement("input");
    entry.type = "radio";
    entry.name = `segment-${o + 1}`;
    entry.setAttribute("aria-label", `Segment ${o + 1} contracted most: switch on neuron ${a}`);
    entry.addEventListener("click", () => onChoice(o, a));
    const fill = document.createElement("span");
    label.append(entry, fill);
    this.entries.push({ entry, fill, share: -1 });
    return label;
  }

  at(o, a) {
    return this.entries[o * this.n + a];
  }

  /** Show a table; `shares`, if given, are how often each entry is chosen, else all or one of a row is. */
  show(policy, shares = null) {
    this.shares = shares || policy.flatMap((action) => this.sharesOf(action));
    for (let o = 0; o < this.n; o++) {
      for (let a = 0; a < this.n; a++) {
        const cell = this.at(o, a), chosen = policy[o] === a;
        const rounded = Math.round(50 * Math.sqrt(this.shares[o * this.n + a])) / 50;
        if (cell.entry.checked !== chosen) cell.entry.checked = chosen;
        if (cell.share !== rounded) cell.fill.style.setProperty("--share", (cell.share = rounded));
      }
    }
  }

  sharesOf(action) {
    return Array.from({ length: this.n }, (_, a) => (action === ANY ? 1 / this.n : Number(action === a)));
  }

  /** Light the row of what is sensed and the entry that answers. */
  light(observation, action) {
    const cell = this.at(observation, action), lit = [this.rows[observation], cell.fill];
    if (lit[0] === this.lit[0] && lit[1] === this.lit[1]) return;
    for (const each of this.lit) each.classList.remove("lit");
    for (const each of lit) each.classList.add("lit");
    this.lit = lit;
  }
}

/** Draw each entry as a wire from the segment that is sensed to the neuron that answers, as dark as its share. */
function drawWires(canvas, theme, shares, n, lit) {
  const { pen, width, height } = prepare(canvas), left = 52, step = (width - left - 12) / (n - 1);
  const top = 24, bottom = height - 24, radius = 5;
  const x = (i) => left + width - left - 12 - i * step; // the head is to the right, as on stage
  const wire = (o, a, colour, thickness, alpha) => {
    pen.globalAlpha = alpha;
    pen.strokeStyle = colour;
    pen.lineWidth = thickness;
    pen.beginPath();
    pen.moveTo(x(o), top);
    pen.bezierCurveTo(x(o), (top + bottom) / 2, x(a), (top + bottom) / 2, x(a), bottom);
    pen.stroke();
    pen.globalAlpha = 1;
  };
  for (let o = 0; o < n; o++) {
    for (let a = 0; a < n; a++) {
      const share = shares[o * n + a];
      if (share > 0.01) wire(o, a, theme.on, 1 + 2.5 * share, Math.min(0.12 + share, 1));
    }
  }
  wire(lit.observation, lit.action, theme.ink, 3, 1);
  pen.font = "12px system-ui, sans-serif";
  pen.fillStyle = theme.soft;
  pen.textBaseline = "middle";
  pen.textAlign = "left";
  pen.fillText("senses", 0, top);
  pen.fillText("drives", 0, bottom);
  pen.textAlign = "center";
  pen.textBaseline = "top";
  const end = (i, y, isLit, text, textAt) => {
    pen.fillStyle = isLit ? theme.ink : theme.on;
    pen.beginPath();
    pen.arc(x(i), y, isLit ? radius + 1.5 : radius, 0, 2 * Math.PI);
    pen.fill();
    pen.fillStyle = theme.soft;
    pen.fillText(text, x(i), textAt);
  };
  for (let i = 0; i < n; i++) {
    end(i, top, i === lit.observation, i + 1, 4);
    end(i, bottom, i === lit.action, i, height - 14);
  }
}

/** For every row how often each of its entries was chosen lately; all alike where none has been. */
function choiceShares(choices, n) {
  const shares = new Float64Array(choices.length);
  for (let o = 0; o < n; o++) {
    const row = choices.subarray(o * n, (o + 1) * n), sum = row.reduce((a, b) => a + b, 0);
    for (let a = 0; a < n; a++) shares[o * n + a] = (row[a] + 0.2) / (sum + 0.2 * n);
  }
  return shares;
}
