"use strict";
/* A lane: one crawler, the table that answers what it senses, and what has been seen of it lately. */

const ANY = -1; // an entry of a table: any neuron, by lot
const SAMPLE = 0.2; // tau between two columns of a kymograph
const COLUMNS = 600; // kept of the past
const SPEED_WINDOW = 500; // samples over which a speed is taken

/** A table from its digits, "x" being any neuron; null if these are not digits of such a table. */
function readPolicy(text, n) {
  const policy = Array.from(text, (digit) => (digit === "x" ? ANY : "0123456789".indexOf(digit)));
  const valid = policy.length === n && policy.every((a, i) => a < n && (a >= 0 || text[i] === "x"));
  return valid ? policy : null;
}

function writePolicy(policy) {
  return policy.map((action) => (action === ANY ? "x" : action)).join("");
}

class Lane {
  constructor(parameters, policy, random) {
    this.random = random;
    this.policy = policy;
    this.learner = null; // if there is one, it decides
    this.ownCrawler = new Crawler(parameters);
    this.nSegments = parameters.n_segments;
    const nodes = this.nSegments + 1;
    this.strain = new Float32Array(COLUMNS * this.nSegments);
    this.force = new Float32Array(COLUMNS * nodes);
    this.neuron = new Uint8Array(COLUMNS * nodes); // 0 off, 1 on, 2 spiked since the last column
    this.sampleTime = new Float64Array(COLUMNS);
    this.travelled = new Float64Array(COLUMNS);
    this.startOver();
  }

  /** The body on stage: the learner's own while it practises before our eyes. */
  get crawler() {
    return this.learner && this.learner.onStage ? this.learner.crawler : this.ownCrawler;
  }

  startOver() {
    this.ownCrawler.reset();
    this.time = 0; // since the start, tau
    this.distance = 0; // of the centroid since the start, L
    this.samples = 0;
    this.stepsLeft = 0; // of the decision under way
    this.action = 0;
    this.observation = this.ownCrawler.observe(0, this.random);
  }

  /** Let time pass, tau. */
  advance(duration, noise) {
    const end = this.time + duration;
    while (this.time < end) {
      const { crawler } = this;
      if (this.stepsLeft <= 0) this.choose(crawler, noise);
      crawler.step();
      this.time += crawler.dt;
      if (--this.stepsLeft === 0) this.finish(crawler);
      if (this.time >= this.samples * SAMPLE) this.sample(crawler);
    }
  }

  choose(crawler, noise) {
    const { learner } = this;
    if (learner && learner.onStage) {
      this.observation = learner.observation;
    } else {
      this.observation = crawler.observe(noise, this.random);
    }
    const answer = learner ? ANY : this.policy[this.observation];
    if (learner) this.action = learner.greedy(this.observation);
    else this.action = answer === ANY ? Math.floor(this.random() * this.nSegments) : answer;
    crawler.switchOn(this.action);
    this.stepsLeft = crawler.stepsPerDecision;
    this.before = crawler.centroid;
  }

  finish(crawler) {
    crawler.measureCentroid();
    const displacement = crawler.centroid - this.before;
    this.distance += displacement;
    if (this.learner && this.learner.onStage) this.learner.take(this.action, displacement);
  }

  /* A column of each kymograph. */
  sample(crawler) {
    const column = this.samples % COLUMNS, { u, force, on, spikedAt } = crawler, n = this.nSegments;
    for (let i = 0; i < n; i++) this.strain[column * n + i] = u[i + 1] - u[i];
    for (let i = 0; i <= n; i++) {
      this.force[column * (n + 1) + i] = force[i];
      const spiked = spikedAt[i] > crawler.time - SAMPLE;
      this.neuron[column * (n + 1) + i] = spiked ? 2 : on[i];
    }
    this.sampleTime[column] = this.time;
    this.travelled[column] = this.distance;
    this.samples += 1;
  }

  /** Mean speed of the last 100 tau, L/tau; NaN if it has not crawled long enough to tell. */
  speed() {
    const last = this.samples - 1, first = Math.max(last - SPEED_WINDOW, 0);
    if (last - first < SPEED_WINDOW / 5) return NaN;
    const [a, b] = [first % COLUMNS, last % COLUMNS];
    return (this.travelled[b] - this.travelled[a]) / (this.sampleTime[b] - this.sampleTime[a]);
  }

  /** Shake the body; the decision under way goes on. */
  kick() {
    const { crawler } = this, before = crawler.centroid;
    crawler.kick(0.3, this.random);
    this.before += crawler.centroid - before; // not crawled, so not counted
  }

  /** Let a learner decide from now on, or nobody but the table. */
  follow(learner) {
    this.learner = learner;
    this.stepsLeft = 0;
  }
}
