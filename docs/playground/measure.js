"use strict";
/* Speed against the noise of the senses, as in [M20, Fig. 3C], measured a little in every frame. */

const NOISES = [0, 0.0125, 0.025, 0.05, 0.075, 0.1, 0.15, 0.2];
const STARTS = 6;
const WARM_UP = 100; // tau of random action before a run, so that runs start from different bodies
const DURATION = 300; // tau over which a speed is taken
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
    this.run = { crawler, random, left: Math.round(WARM_UP / interval), settling: true, origin: 0 };
  }

  goOn() {
    const { run, policy } = this, { crawler, random } = run, noise = NOISES[this.done % NOISES.length];
    const n = this.parameters.n_segments;
    for (let i = 0; i < CHUNK && run.left > 0; i++, run.left--) {
      const answer = run.settling ? ANY : policy[crawler.observe(noise, random)];
      crawler.decide(answer === ANY ? Math.floor(random() * n) : answer);
    }
    if (run.left > 0) return;
    if (run.settling) {
      run.settling = false;
      run.left = Math.round(DURATION / this.parameters.decision_interval);
      run.origin = crawler.centroid;
    } else {
      this.speeds[this.done % NOISES.length].push((crawler.centroid - run.origin) / DURATION);
      this.done += 1;
      this.run = null;
    }
  }
}
