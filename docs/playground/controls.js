"use strict";
/* What every button, slider and key of the page does. */

function setPlaying(playing) {
  page.playing = playing;
  updateControls();
}

function setNoise(noise) {
  page.noise = page.settings.noise = noise;
  updateControls();
}

/** Bring every control in line with what is going on. */
function updateControls() {
  $("play").textContent = page.playing ? "Pause" : "Play";
  $("learn").textContent = page.learning ? "Stop learning" : page.learner ? "Go on learning" : "Learn";
  $("learn-here").textContent = page.learning ? "Stop learning" : "Let it learn";
  $("pace-text").textContent = `${page.pace}× · ${page.pace * FILM_PACE} τ/s`;
  $("learning-pace-text").textContent = LEARNING_PACES[$("learning-pace").value][1];
  $("noise").value = page.noise;
  $("noise-value").textContent = page.noise.toFixed(3);
  for (const slider of document.querySelectorAll("#learning input[name]")) {
    slider.nextElementSibling.textContent = page.settings[slider.name];
  }
}

function onClick(id, act) {
  $(id).addEventListener("click", () => {
    act();
    updateControls();
  });
}

onClick("play", () => setPlaying(!page.playing));
onClick("kick", () => page.lanes.forEach((lane) => lane.kick()));
onClick("start-over", () => build(page.lanes.map((lane) => lane.policy)));
onClick("learn", () => (page.learning ? stopLearning() : startLearning()));
onClick("learn-here", () => $("learn").click());
onClick("forget", () => {
  const goOn = page.learning;
  forget();
  if (goOn) startLearning();
  else setPolicy(0, policyNamed("any"));
});
onClick("copy", async () => {
  $("digits").select();
  try {
    await navigator.clipboard.writeText(location.href);
    $("copy").textContent = "Copied";
  } catch {
    $("copy").textContent = "Copy the address";
  }
  setTimeout(() => ($("copy").textContent = "Copy link"), 1500);
});
onClick("restore", () => {
  setParameters({ ...DEFAULTS.parameters });
  buildForm();
});

$("pace").addEventListener("input", () => {
  page.pace = PACES[$("pace").value];
  updateControls();
});
$("race").addEventListener("change", () => {
  setRace($("race").checked);
  updateControls();
});
for (const id of ["forces", "neurons"]) {
  $(id).addEventListener("change", () => document.body.classList.toggle(`show-${id}`, $(id).checked));
}
$("noise").addEventListener("input", () => setNoise(Number($("noise").value)));
$("learning-pace").addEventListener("input", () => {
  setLearningPace();
  updateControls();
});
for (const slider of document.querySelectorAll("#learning input[name]")) {
  slider.max = Math.max(slider.max, 2 * DEFAULTS.learner[slider.name]);
  slider.value = DEFAULTS.learner[slider.name];
  slider.addEventListener("input", () => {
    page.settings[slider.name] = Number(slider.value);
    if (slider.name === "initial_q" && page.learner) $("forget").click(); // it is where learning begins
    updateControls();
  });
}

for (const button of document.querySelectorAll("#presets [data-policy]")) {
  button.addEventListener("click", () => {
    setPolicy(page.edited, policyNamed(button.dataset.policy));
    updateControls();
  });
}
for (const lane of document.querySelectorAll("#editing input")) {
  lane.addEventListener("change", () => {
    page.edited = Number(lane.value);
    showPolicies();
  });
}
$("digits").addEventListener("input", () => {
  const policy = readPolicy($("digits").value.trim(), page.parameters.n_segments);
  $("digits").setAttribute("aria-invalid", String(!policy));
  if (policy) setPolicy(page.edited, policy);
});
$("digits").addEventListener("blur", () => {
  $("digits").removeAttribute("aria-invalid");
  showPolicies();
});

document.addEventListener("keydown", (event) => {
  if (event.target.closest("input, select, button, textarea") || event.ctrlKey || event.metaKey || event.altKey) return;
  const button = { " ": "play", k: "kick", l: "learn" }[event.key];
  if (!button) return;
  event.preventDefault();
  $(button).click();
});
addEventListener("hashchange", () => {
  readAddress();
  updateControls();
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  page.theme = readTheme();
  page.kymographs = page.lanes.map((lane) => new Kymograph(lane, page.theme));
});

readAddress();
updateControls();
requestAnimationFrame(frame);
