"use strict";
/* The page: one loop that lets time pass, learns, measures and draws, and the controls that steer it. */

const PACES = [1, 2, 4, 8, 12]; // times FILM_PACE
const FILM_PACE = 5; // tau in a second, as in the films
const LEARNING_PACES = [
  [0, "what you see is what learns"], [1e3, "1,000 decisions/s"], [1e4, "10,000 decisions/s"],
  [Infinity, "as fast as it goes"],
];
const LEARNING_SLICE = 24, MEASURING_SLICE = 5; // ms in a frame
const PRACTICE_STEP = 0.02; // tau
const $ = (id) => document.getElementById(id);

const page = {
  parameters: { ...DEFAULTS.parameters },
  random: seededRandom(Date.now()),
  lanes: [], kymographs: [], board: null, edited: 0,
  settings: { ...DEFAULTS.learner, noise: 0 },
  learner: null, learning: false, learningPace: Infinity, learningPoints: [], rate: 0,
  playing: !matchMedia("(prefers-reduced-motion: reduce)").matches,
  pace: 4, noise: 0, race: false, curves: new Map(), theme: readTheme(),
};

/* ---- what is crawling ---- */

/** The table of a name. A body of other than ten segments has the diagonal, too; of the others, none. */
function policyNamed(name) {
  const n = page.parameters.n_segments;
  if (name === "any") return Array(n).fill(ANY);
  if (name === "shuffled") return Array.from({ length: n }, () => Math.floor(page.random() * n));
  if (name === "regularized") return Array.from({ length: n }, (_, o) => o);
  return readPolicy(DEFAULTS.policies[name], n) || policyNamed("any");
}

function build(policies) {
  page.lanes = policies.map((policy) => new Lane(page.parameters, policy, page.random));
  page.race = policies.length > 1;
  page.edited = Math.min(page.edited, policies.length - 1);
  if (page.learning) page.lanes[0].follow(page.learner);
  page.kymographs = page.lanes.map((lane) => new Kymograph(lane, page.theme));
  page.board = new Board($("board"), page.parameters.n_segments, chooseEntry);
  for (const button of document.querySelectorAll("#presets [data-policy]")) {
    const digits = DEFAULTS.policies[button.dataset.policy];
    button.disabled = ["unregularized", "fastest"].includes(button.dataset.policy) && digits.length !== page.parameters.n_segments;
  }
  const lanes = document.querySelectorAll(".lane");
  lanes[1].hidden = $("editing").hidden = !page.race;
  document.body.classList.toggle("racing", page.race);
  $("race").checked = page.race;
  $("digits").maxLength = page.parameters.n_segments;
  $("expectation").textContent = expectation(page.parameters);
  showPolicies();
}

function showPolicies() {
  for (const [i, lane] of page.lanes.entries()) {
    const head = document.querySelectorAll(".lane-head code")[i];
    head.textContent = lane.learner ? "learning" : writePolicy(lane.policy);
  }
  const { policy } = page.lanes[page.edited];
  page.board.show(policy);
  if (document.activeElement !== $("digits")) $("digits").value = writePolicy(policy);
  document.querySelector(`#editing [value="${page.edited}"]`).checked = true;
  writeAddress();
}

function setPolicy(index, policy) {
  if (index === 0 && page.learning) stopLearning();
  page.lanes[index].policy = policy;
  showPolicies();
}

function chooseEntry(o, a) {
  if (page.edited === 0 && page.learning) stopLearning();
  setPolicy(page.edited, page.lanes[page.edited].policy.map((action, i) => (i === o ? a : action)));
}

function setRace(on, policy = policyNamed("unregularized")) {
  page.edited = 0;
  build(on ? [page.lanes[0].policy, policy] : [page.lanes[0].policy]);
}

function setParameters(parameters) {
  const policies = page.lanes.map((lane) => lane.policy), n = parameters.n_segments;
  forget();
  page.parameters = parameters;
  build(policies.map((policy) => (policy.length === n ? policy : policyNamed("regularized"))));
  const changed = changedReadings(parameters).map(([name, value]) => `${name} = ${value}`).join(", ");
  $("readings-text").textContent = changed ? `Not the default: ${changed}.` : "";
}

/* ---- the address: #0123456789, a second lane after "-", other constants after "&" ---- */

function writeAddress() {
  const tables = page.lanes.map((lane) => writePolicy(lane.policy)).join("-");
  const readings = changedReadings(page.parameters).map(([name, value]) => `&${name}=${value}`).join("");
  history.replaceState(null, "", `#${tables}${readings}`);
}

/** Build what an address asks for; whatever is not valid in it is left at its default. */
function readAddress() {
  const [tables, ...readings] = location.hash.slice(1).split("&");
  const parameters = { ...DEFAULTS.parameters };
  for (const reading of readings) {
    const [name, value] = reading.split("=");
    if (name in DEFAULTS.choices) {
      if (DEFAULTS.choices[name].includes(value)) parameters[name] = value;
    } else if (Object.hasOwn(FIELDS, name)) {
      parameters[name] = Number(value);
    }
  }
  page.parameters = impossible(parameters) ? { ...DEFAULTS.parameters } : parameters;
  const policies = tables.split("-", 2).map((text) => readPolicy(text, page.parameters.n_segments));
  forget();
  build(policies.every(Boolean) ? policies : [policyNamed("regularized")]);
  buildForm();
}

function buildForm() {
  const refuse = (why) => ($("readings-text").textContent = `Not possible: ${why}.`);
  buildReadings($("readings"), page.parameters, setParameters, refuse);
}

/* ---- learning ---- */

function startLearning() {
  const { parameters, settings } = page;
  if (!page.learner) {
    const random = seededRandom(2 ** 31 * page.random());
    page.learner = new Learner(new Crawler(parameters, PRACTICE_STEP), settings, random);
  }
  page.edited = 0;
  page.learning = true;
  page.lanes[0].follow(page.learner);
  setLearningPace();
  showPolicies();
}

function stopLearning() {
  if (!page.learning) return;
  page.learning = false;
  page.lanes[0].follow(null);
  page.lanes[0].policy = page.learner.policy();
  showPolicies();
}

function forget() {
  stopLearning();
  page.learner = null;
  page.learningPoints = [];
  page.rate = 0;
}

function setLearningPace() {
  page.learningPace = LEARNING_PACES[$("learning-pace").value][0];
  if (page.learner) page.learner.onStage = page.learningPace === 0;
  for (const lane of page.lanes) lane.stepsLeft = 0;
}

/** Practise out of sight for a frame that took `elapsed` seconds. */
function practise(elapsed) {
  const { learner, learningPace } = page, began = performance.now(), before = learner.decisions;
  if (learningPace > 0) {
    const wanted = learningPace * elapsed + (page.owed || 0);
    while (performance.now() - began < LEARNING_SLICE && learner.decisions - before < wanted) {
      learner.learn(Math.min(200, Math.ceil(wanted - (learner.decisions - before))));
    }
    page.owed = Number.isFinite(wanted) ? Math.min(wanted - (learner.decisions - before), learningPace) : 0;
    page.rate += 0.05 * ((learner.decisions - before) / elapsed - page.rate);
  } else {
    page.rate = page.pace * FILM_PACE / page.parameters.decision_interval;
  }
}

function notePoint() {
  const { learner, learningPoints } = page, last = learningPoints[learningPoints.length - 1];
  if (last && learner.decisions - last[0] < 1000) return;
  learningPoints.push([learner.decisions, learner.policy().filter((a, o) => a === o).length]);
  if (learningPoints.length > 1200) page.learningPoints = learningPoints.filter((_, i) => i % 2 === 0);
}

/* ---- measuring ---- */

/** The curves of figure 3C: the two gaits, random action, lane 1's table; begun when they are first asked for. */
function noiseCurves() {
  const { parameters, lanes } = page;
  const wanted = [
    ["regularized", policyNamed("regularized"), "red", []],
    ["random", policyNamed("any"), "soft", [2, 5]],
  ];
  const bent = readPolicy(DEFAULTS.policies.unregularized, parameters.n_segments);
  if (bent) wanted.splice(1, 0, ["unregularized", bent, "blue", [7, 4]]);
  const own = lanes[0].policy, known = wanted.some(([, policy]) => writePolicy(policy) === writePolicy(own));
  if (!known && !page.learning) wanted.push(["lane 1", own, "ink", [2, 2]]);
  return wanted.map(([name, policy, colour, dash]) => {
    const key = JSON.stringify([parameters, policy]);
    if (!page.curves.has(key)) page.curves.set(key, new NoiseCurve(parameters, policy));
    return { name, curve: page.curves.get(key), colour: page.theme[colour], dash };
  });
}

/* ---- the loop ---- */

let lastFrame = performance.now(), lastText = 0;

function frame(now) {
  const elapsed = Math.min(Math.max((now - lastFrame) / 1000, 0), 0.1), { lanes } = page;
  lastFrame = now;
  if (page.playing) for (const lane of lanes) lane.advance(elapsed * FILM_PACE * page.pace, page.noise);
  if (page.learning && elapsed > 0) practise(elapsed);
  const curves = noiseCurves(), leastDone = curves.map(({ curve }) => curve).sort((a, b) => a.done - b.done)[0];
  if (!page.learning) leastDone.work(performance.now() + MEASURING_SLICE);
  draw();
  if (now - lastText > 150) {
    lastText = now;
    report(curves);
  }
  requestAnimationFrame(frame);
}

function draw() {
  const { lanes, theme } = page, shown = ["strain"];
  const view = { forces: $("forces").checked, neurons: $("neurons").checked, race: page.race };
  if (view.forces) shown.push("force");
  if (view.neurons) shown.push("neuron");
  view.camera = lanes.reduce((sum, lane) => sum + lane.distance, 0) / lanes.length;
  for (const [i, lane] of lanes.entries()) {
    const [body, kymograph] = document.querySelectorAll(".lane")[i].querySelectorAll("canvas");
    new BodyDrawing(body, lane, theme, view).draw();
    page.kymographs[i].draw(kymograph, shown);
  }
  page.board.light(lanes[page.edited].observation, lanes[page.edited].action);
  drawWires($("wires"), theme, page.board.shares, page.parameters.n_segments, lanes[page.edited]);
}

/** Texts, charts and the learning board, a few times in a second. */
function report(curves) {
  const { lanes, learner, theme } = page, n = page.parameters.n_segments;
  for (const [i, lane] of lanes.entries()) {
    const speed = lane.speed(), moved = `${lane.distance < 0 ? "\u2212" : "+"}${Math.abs(lane.distance).toFixed(2)} L`;
    const pace = Number.isNaN(speed) ? "…" : speed.toFixed(4);
    const text = `${moved} in ${lane.time.toFixed(0)} τ · speed ${pace} L/τ`;
    document.querySelectorAll(".lane-head output")[i].textContent = text;
  }
  if (page.learning) {
    notePoint();
    if (page.edited === 0) page.board.show(learner.policy(), choiceShares(learner.choices, n));
  }
  drawLearningChart($("learning-chart"), theme, page.learningPoints, n);
  if (learner) {
    const right = learner.policy().filter((a, o) => a === o).length, count = learner.decisions.toLocaleString("en");
    const rate = page.learning ? `, ${Math.round(page.rate).toLocaleString("en")} a second` : "";
    $("learning-text").textContent = `${count} decisions${rate} · ${right} of ${n} entries on the diagonal`;
  } else {
    $("learning-text").textContent = "It knows nothing yet: every value is the same.";
  }
  drawNoiseChart($("noise-chart"), theme, curves, page.noise);
  const speeds = curves.map(({ name, curve }) => `${name} ${curve.at(page.noise).toFixed(4)}`);
  $("noise-text").textContent = `At s = ${page.noise.toFixed(3)}: ${speeds.join(", ").replace(/NaN/g, "…")} L/τ`;
}
