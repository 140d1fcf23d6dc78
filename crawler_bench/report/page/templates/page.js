"use strict";
// Sorting and filtering of tables and claims, copying of commands, and figures beside their claims.

const all = (root, selector) => [...root.querySelectorAll(selector)];

// What a cell is sorted and filtered by: its number as the CSV has it, or its text.
function key(cell) {
  const text = cell.querySelector("data")?.value ?? cell.textContent.trim();
  return text === "–" ? "" : text;
}

function compare(one, other, down) {
  if (one === "" || other === "") return (one === "") - (other === ""); // what is not known comes last
  const order = one - other;
  const text = () => one.localeCompare(other, "en", { numeric: true });
  return (Number.isNaN(order) ? text() : order) * (down ? -1 : 1);
}

function sort(table, heading) {
  const headings = all(table, "thead th"), at = headings.indexOf(heading);
  const down = heading.getAttribute("aria-sort") === "ascending";
  headings.forEach((each) => each.removeAttribute("aria-sort"));
  heading.setAttribute("aria-sort", down ? "descending" : "ascending");
  const rows = all(table, "tbody tr").map((row) => [key(row.cells[at]), row]);
  rows.sort(([one], [other]) => compare(one, other, down));
  table.tBodies[0].append(...rows.map(([, row]) => row));
}

function say(output, items, what) {
  const shown = items.filter((each) => !each.hidden).length;
  if (output) output.textContent = shown === items.length ? "" : `${shown} of ${items.length} ${what}`;
}

for (const place of all(document, ".table")) {
  const table = place.querySelector("table"), choices = all(place, "select");
  for (const heading of all(table, "thead th")) {
    heading.firstElementChild.addEventListener("click", () => sort(table, heading));
  }
  const filter = () => {
    const rows = all(table, "tbody tr");
    for (const row of rows) {
      row.hidden = choices.some(({ value, dataset }) => value && key(row.cells[dataset.column]) !== value);
    }
    say(place.querySelector("output"), rows, "rows");
  };
  choices.forEach((each) => each.addEventListener("change", filter));
  filter();
}

for (const place of all(document, ".claims")) {
  const buttons = all(place, ".verdicts button"), search = place.querySelector("input"), items = all(place, ".claim");
  const filter = () => {
    const { verdict } = buttons.find((each) => each.getAttribute("aria-pressed") === "true").dataset;
    const words = search.value.trim().toLowerCase();
    for (const item of items) {
      item.hidden = (verdict && item.dataset.verdict !== verdict) || !item.textContent.toLowerCase().includes(words);
    }
    say(place.querySelector("output"), items, "claims");
  };
  for (const button of buttons) {
    button.addEventListener("click", () => {
      buttons.forEach((each) => each.setAttribute("aria-pressed", String(each === button)));
      filter();
    });
  }
  search.addEventListener("input", filter);
}

for (const button of all(document, ".copy")) {
  button.setAttribute("aria-label", `copy ${button.previousElementSibling.textContent}`);
  button.addEventListener("click", async () => {
    const code = button.previousElementSibling;
    getSelection().selectAllChildren(code); // for those whose browser does not let a file write to the clipboard
    try {
      await navigator.clipboard.writeText(code.textContent);
      button.textContent = "copied";
    } catch {
      button.textContent = "selected";
    }
    setTimeout(() => { button.textContent = "copy"; }, 1500);
  });
}

for (const peek of all(document, ".peek")) {
  const picture = document.getElementById(peek.dataset.figure).querySelector("img");
  peek.addEventListener("toggle", () => {
    if (peek.open && !peek.querySelector("img")) {
      peek.append(picture.cloneNode());
    }
  });
}

// Charts: Plotly's script is in the page, compressed. It is unpacked when the first chart comes near the screen, and
// each chart is drawn when it does, so that a reader of the claims does not wait for curves.
async function unpack(packed) {
  const bytes = Uint8Array.from(atob(packed), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
}

const PLOT = 420, NAME = 20, NAMES_APART = 240; // pixels: a chart without its legend, a line of it, a column of it
let plotly;
async function loadPlotly() {
  const script = document.createElement("script");
  script.textContent = await unpack(document.getElementById("plotly").textContent);
  document.head.append(script);
}

async function draw(place) {
  try {
    await (plotly ??= loadPlotly());
    const { data, layout } = JSON.parse(place.nextElementSibling.textContent);
    const names = data.filter(({ showlegend }) => showlegend !== false).length;
    layout.height = PLOT + NAME * Math.ceil(names / Math.max(1, Math.floor(place.clientWidth / NAMES_APART)));
    await Plotly.newPlot(place, data, layout, { displayModeBar: false, responsive: true });
    place.dataset.drawn = "";
  } catch (error) {
    place.textContent = `This browser cannot draw the chart (${error.message}).`;
  }
}

const approach = new IntersectionObserver((changes) => {
  for (const { target } of changes.filter(({ isIntersecting }) => isIntersecting)) {
    approach.unobserve(target);
    draw(target);
  }
}, { rootMargin: "50% 0px" });
all(document, ".chart").forEach((each) => approach.observe(each));
