"use strict";
/* Five steps for someone who has never heard of it: two sentences each, and a button that does what they say. */

const TOUR = [
  {
    title: "Watch",
    text: "A crawler of ten segments lies on ground that lets it slide forward far more easily than backward. Watch a contraction (red) run from its tail to its head, and carry the body with it.",
    act: "Show me the wave",
    perform() {
      setRace(false);
      setNoise(0);
      setPolicy(0, policyNamed("regularized"));
      setPlaying(true);
    },
  },
  {
    title: "Touch",
    text: "It senses one thing only, which segment is contracted most, and answers by switching on one neuron: that is a row of the board. Click another entry while it crawls, and see what becomes of the wave.",
    act: "Change one entry",
    perform() {
      setRace(false);
      setPlaying(true);
      setPolicy(0, policyNamed("regularized"));
      if (page.parameters.n_segments > 5) chooseEntry(5, 3);
      $("board").scrollIntoView({ block: "nearest" });
    },
  },
  {
    title: "Learn",
    text: "Nobody has to draw the diagonal: begin with any answer to anything, pay for moving forward, charge for kinks. Within some seconds of practice the board goes from all-to-all to nearest neighbours.",
    act: "Let it learn",
    perform() {
      setRace(false);
      forget();
      setPlaying(true);
      $("learning-pace").value = 3;
      startLearning();
      updateControls();
    },
  },
  {
    title: "Race",
    text: "Without the charge for kinks (ε = 0) the same learner finds a gait of few muscles that folds the body harder. Race it against the diagonal, and see what both pay for their speed.",
    act: "Start the race",
    perform() {
      setNoise(0);
      setPolicy(0, policyNamed("regularized"));
      setRace(true);
      setPlaying(true);
    },
  },
  {
    title: "Disturb",
    text: "Real senses err, so let each strain be sensed wrongly by up to s, and give the body a kick. The dots show how much of its speed each gait keeps, and how a wave that only knows its neighbours takes it.",
    act: "Disturb both",
    perform() {
      setPlaying(true);
      if (!page.race) setRace(true);
      setNoise(0.1);
      for (const lane of page.lanes) lane.kick();
    },
  },
];

let tourStep = 0;

function showTour(step) {
  tourStep = step;
  const { text, act } = TOUR[step];
  $("tour-text").textContent = text;
  $("tour-act").textContent = act;
  $("tour-next").textContent = step + 1 < TOUR.length ? "Next step" : "Begin again";
  for (const [i, item] of [...$("tour-steps").children].entries()) {
    const button = item.firstChild;
    if (i === step) button.setAttribute("aria-current", "step");
    else button.removeAttribute("aria-current");
  }
}

for (const [i, { title }] of TOUR.entries()) {
  const item = document.createElement("li"), button = document.createElement("button");
  button.type = "button";
  button.innerHTML = `<b>${i + 1}</b> ${title}`;
  button.addEventListener("click", () => showTour(i));
  item.append(button);
  $("tour-steps").append(item);
}
$("tour-act").addEventListener("click", () => TOUR[tourStep].perform());
$("tour-next").addEventListener("click", () => showTour((tourStep + 1) % TOUR.length));
showTour(0);
