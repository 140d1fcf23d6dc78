"use strict";
/* Tabular Q-learning as in [M20, eq. 12]: greedy, from values that start equal and high, equal ones by lot.

   Nothing explores on purpose: an action that was tried disappoints, and another takes its turn. An episode
   ends where the centroid has advanced by a fixed distance or time is up; crawling itself goes on for ever,
   so the value of what would follow is counted there, too. */

class Learner {
  /** `settings`: regularization, learning_rate, discount, initial_q, episode_distance, time_limit, noise. */
  constructor(crawler, settings, random) {
    this.crawler = crawler;
    this.settings = settings;
    this.random = random;
    this.n = crawler.parameters.n_segments;
    this.Q = new Float64Array(this.n * this.n).fill(settings.initial_q);
    this.onStage = false; // whether its own body is the one that is seen
    this.choices = new Float64Array(this.n * this.n); // how often each entry was chosen lately
    this.decisions = 0;
    this.distance = 0; // crawled in all episodes, L
    this.begin();
  }

  /** A new episode, from the undeformed body. */
  begin() {
    this.crawler.reset();
    this.observation = this.crawler.observe(this.settings.noise, this.random);
  }

  /** The action of highest value, equal ones by lot. */
  greedy(observation) {
    const { Q, n } = this, row = observation * n;
    let best = -Infinity, action = 0, ties = 0;
    for (let a = 0; a < n; a++) {
      const value = Q[row + a];
      if (value > best) {
        best = value;
        action = a;
        ties = 1;
      } else if (value === best && this.random() * ++ties < 1) {
        action = a;
      }
    }
    return action;
  }

  highestValue(observation) {
    const { Q, n } = this;
    let best = -Infinity;
    for (let i = observation * n; i < (observation + 1) * n; i++) best = Math.max(best, Q[i]);
    return best;
  }

  /** Practise for a number of decisions. */
  learn(decisions) {
    for (let i = 0; i < decisions; i++) {
      const action = this.greedy(this.observation);
      this.take(action, this.crawler.decide(action));
    }
  }

  /** Learn from an action that has just been carried out and moved the centroid by `displacement`. */
  take(action, displacement) {
    const { crawler, settings, Q } = this, entry = this.observation * this.n + action;
    const next = crawler.observe(settings.noise, this.random);
    const { penalty, decision_interval } = crawler.parameters;
    const weight = settings.regularization * (penalty === "rate" ? decision_interval : 1);
    const reward = displacement - weight * crawler.strainGradient(); // eq. 11
    const goal = reward + settings.discount * this.highestValue(next);
    Q[entry] = (1 - settings.learning_rate) * Q[entry] + settings.learning_rate * goal; // eq. 12
    this.choices[entry] += 1;
    this.decisions += 1;
    if (this.decisions % 2000 === 0) this.fade();
    this.distance += displacement;
    this.observation = next;
    const over = crawler.centroid >= settings.episode_distance || crawler.time >= settings.time_limit - 1e-9;
    if (over) this.begin();
  }

  /* Let the count of choices fade, so that it tells of the last 30,000 or so. */
  fade() {
    for (let i = 0; i < this.choices.length; i++) this.choices[i] *= 0.93;
  }

  /** The greedy action for every observation, the lowest of equal ones. */
  policy() {
    return Array.from({ length: this.n }, (_, o) => {
      const row = this.Q.subarray(o * this.n, (o + 1) * this.n);
      return row.indexOf(Math.max(...row));
    });
  }
}
