"use strict";
/* Speed against the noise of the senses, as in [M20, Fig. 3C], measured a little in every frame. */

const NOISES = [0, 0.0125, 0.025, 0.05, 0.075, 0.1, 0.15, 0.2];
const STARTS = 8;
const WARM_UP = 100; // tau of random action before a run, so that runs start from different bodies
const SETTLE = 100; // tau of the table before a speed is taken
const DURATION = 300; // tau over which it is taken
const CHUNK = 100; // decisions between two looks at the clock

/** The speeds of one table: of each noise, the mean over the starts that have been run. */
class NoiseCurve {
  constructor(parameters, policy) {
    this.parameters = parameters;
    this.policy = policy;
    this.speeds = NOISES.map(() => []);
    this.done = 0;
  }

  get finished() {
    return this.done === NOISES.length * STARTS;
  }

  /** Mean speed at each noise, L/tau; NaN where none has been measured. */
  means() {
    return this.speeds.map((each) => each.reduce((sum, speed) => sum + speed, 0) / (each.length || NaN));
  }

  /** Mean speed at any noise, between those measured. */
  at(noise) {
    const means = this.means(), i = Math.min(Math.max(NOISES.findIndex((s) => s > noise), 1), NOISES.length - 1);
    const right = noise >= NOISES[NOISES.length - 1] ? NOISES.length - 1 : i;
    const share = (noise - NOISES[right - 1]) / (NOISES[right] - NOISES[right - 1]);
    return means[right - 1] + share * (means[right] - means[right - 1]);
  }

  /** Go on measuring until the clock shows `deadline`, ms. All noises are run once, then again, ... */
  work(deadline) {
    while (!this.finished) {
      if (!this.run) this.begin();
      while (this.run) {
        this.goOn();
        if (performance.now() > deadline) return;
      }
    }
  }

  begin() {
    const start = Math.floor(this.done / NOISES.length), random = seededRandom(1000 + start);
    const crawler = new Crawler(this.parameters), interval = this.parameters.decision_interval;
    const [warmUp, settle, duration] = [WARM_UP, SETTLE, DURATION].map((time) => Math.round(time / interval));
    this.run = { crawler, random, made: 0, warmUp, settled: warmUp + settle, end: warmUp + settle + duration, origin: 0 };
  }

  goOn() {
    const { run, policy } = this, { crawler, random } = run, noise = NOISES[this.done % NOISES.length];
    const n = this.parameters.n_segments;
    for (let i = 0; i < CHUNK && run.made < run.end; i++, run.made++) {
      if (run.made === run.settled) run.origin = crawler.centroid;
      const answer = run.made < run.warmUp ? ANY : policy[crawler.observe(noise, random)];
      crawler.decide(answer === ANY ? Math.floor(random() * n) : answer);
    }
    if (run.made < run.end) return;
    this.speeds[this.done % NOISES.length].push((crawler.centroid - run.origin) / DURATION);
    this.done += 1;
    this.run = null;
  }
}
