"use strict";
/* The form of all constants: what the paper gives, what it leaves open, what was fitted. */

// Of each field of CrawlerParameters: label, unit, smallest and largest value, step, and where it is from.
const FIELDS = {
  friction_law: ["Friction law", "eq. 8: 9 is the backward limit (table S1) or, read literally, the forward one"],
  head_muscle: ["Head muscle", "does it push against the next node, against nothing, or not exist"],
  spike_phase: ["A spike at θ =", "eq. 7 says π, its text multiples of 2π; every π is both"],
  observation: ["It senses the segment", "eq. 9's argmin, taken literally, is the most stretched one"],
  penalty: ["Strain costs per", "eq. 11: per decision; per time, it keeps its weight for any interval"],
  neuron_rate: ["Rate of the neurons", "1/τ · multiplies eq. 6, fitted", 0.1, 10, 0.1],
  spike_gain: ["Gain of a spike", "multiplies the sum of eq. 5, fitted", 0.1, 10, 0.1],
  tau_f: ["Muscle relaxation τ_f", "τ · named in eq. 4 and not given, fitted", 0.05, 5, 0.05],
  tau_m: ["Decay of a spike τ_m", "τ · table S1", 0.05, 5, 0.05],
  decision_interval: ["Decision interval", "τ · fitted; the paper has 0.01", 0.01, 2, 0.01],
  friction_forward: ["Friction forward", "kL · table S1: 9 / 30", 0.01, 20, 0.05],
  friction_backward: ["Friction backward", "kL · table S1", 0.01, 300, 0.5],
  muscle_force_max: ["Strongest muscle force", "kL · table S1", 0.1, 20, 0.1],
  damping: ["Damping c/k", "τ · table S1", 0.1, 20, 0.1],
  n_segments: ["Segments", "fig. 1", 2, 10, 1],
};

/** Fill the form; `onChange(parameters)` is called with every possible set, `onRefusal(why)` else. */
function buildReadings(form, parameters, onChange, onRefusal) {
  form.replaceChildren();
  for (const [name, [text, source, low, high, step]] of Object.entries(FIELDS)) {
    const label = document.createElement("label"), title = document.createElement("span");
    const note = document.createElement("small");
    title.textContent = text;
    note.textContent = source;
    let field;
    if (name in DEFAULTS.choices) {
      field = document.createElement("select");
      for (const choice of DEFAULTS.choices[name]) field.add(new Option(choice.replace("_", " "), choice));
    } else {
      field = document.createElement("input");
      Object.assign(field, { type: "number", min: low, max: high, step });
    }
    field.name = name;
    field.value = parameters[name];
    field.addEventListener("change", () => {
      const next = readReadings(form), why = impossible(next);
      if (why) onRefusal(why);
      else onChange(next);
    });
    label.append(title, field, note);
    form.append(label);
  }
}

function readReadings(form) {
  const value = ({ name, value }) => (name in DEFAULTS.choices ? value : Number(value));
  return Object.fromEntries(Array.from(form.elements, (field) => [field.name, value(field)]));
}

/** The constants that differ from the defaults, as [name, value]. */
function changedReadings(parameters) {
  return Object.entries(parameters).filter(([name, value]) => DEFAULTS.parameters[name] !== value);
}

/** What to expect of a set of constants that cannot crawl, or "". */
function expectation(parameters) {
  const { forward, backward } = frictionLimits(parameters), strongest = parameters.muscle_force_max;
  if (strongest >= forward) return "";
  return `It does not crawl: sliding forward takes ${forward} kL, backward ${backward} kL,
    and no muscle pulls with more than ${strongest} kL.`;
}
