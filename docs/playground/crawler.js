"use strict";
/* The crawler of Mishra, van Rees & Mahadevan 2020 [M20], "Coordinated crawling via reinforcement learning".

   Eq. 1-10, advanced step by step with the implicit midpoint rule. Lengths are in units of the segment length L, times in the
   neuronal time scale tau, forces in k L. Node 0 is the head, node N the tail; node j lies at x_j = -j + u_j
   and + is forward, so that segment i, between nodes i - 1 and i, is contracted when u_i - u_(i-1) > 0.

   Neurons are exact for any step; muscles and body are of second order: half the step, a quarter of the error.
   A node starts and stops sliding at the border of two steps, but always with velocity 0, which costs nothing. */

const LARGEST_STEP = 0.01; // tau
const ENDLESS = 1e300;
const ROUNDING = 1e-9; // a pivot below this share of the diagonal is no resistance at all

/** A generator of numbers in [0, 1) that gives the same ones for the same seed (sfc32 of PractRand). */
function seededRandom(seed) {
  let a = 0, b = 0, c = seed | 0, counter = 1;
  const next = () => {
    const sum = (((a + b) | 0) + counter) | 0;
    counter = (counter + 1) | 0;
    a = b ^ (b >>> 9);
    b = (c + (c << 3)) | 0;
    c = (((c << 21) | (c >>> 11)) + sum) | 0;
    return (sum >>> 0) / 4294967296;
  };
  for (let i = 0; i < 15; i++) next();
  return next;
}

/** What is not possible about a set of constants, or "" if they can be solved. */
function impossible(p) {
  if (!(p.n_segments >= 2 && p.n_segments <= 10 && Number.isInteger(p.n_segments))) {
    return "n_segments must be a whole number from 2 to 10";
  }
  for (const [name, value] of Object.entries(p)) {
    if (typeof value === "number" && !(Number.isFinite(value) && value > 0)) {
      return `${name} must be a number above 0`;
    }
  }
  if (p.neuron_rate >= Math.PI / 2 / LARGEST_STEP) return "neuron_rate is too high for the time step";
  const { forward } = frictionLimits(p);
  if (p.head_muscle === "external" && (p.n_segments + 1) * forward <= p.muscle_force_max) {
    return "an external head muscle needs more forward friction, or nothing holds the body";
  }
  return "";
}

/** Eq. 8: friction on a node that slides forward, and (its magnitude) backward. */
function frictionLimits(p) {
  if (p.friction_law === "table") return { forward: p.friction_forward, backward: p.friction_backward };
  const anisotropy = p.friction_backward / p.friction_forward;
  return { forward: p.friction_backward, backward: p.friction_backward * anisotropy };
}

class Crawler {
  /** A crawler at rest. `parameters` has the fields of CrawlerParameters; steps are at most `largestStep`. */
  constructor(parameters, largestStep = LARGEST_STEP) {
    const p = parameters, n = p.n_segments + 1;
    this.parameters = p;
    this.stepsPerDecision = Math.ceil(p.decision_interval / largestStep - 1e-9);
    this.dt = p.decision_interval / this.stepsPerDecision;
    for (const row of ["u", "v", "slip", "W", "drive", "force", "meanForce", "on", "spikedAt"]) {
      this[row] = new Float64Array(n);
    }
    this.g = new Float64Array(n);
    this.pivot = new Float64Array(n);
    this.onSpike = null; // called as onSpike(neuron, time)

    this.turn = p.neuron_rate * this.dt;
    this.tanTurn = Math.tan(this.turn);
    this.driveDecay = Math.exp(-this.dt / p.tau_m);
    this.forceDecay = Math.exp(-this.dt / p.tau_f);
    this.drag = p.damping + this.dt / 2; // c + k dt / 2, k = 1
    this.mobility = 1 / this.drag;
    this.limits = frictionLimits(p);
    this.spikesAtPi = p.spike_phase !== "2pi";
    this.spikesAtTwoPi = p.spike_phase !== "pi";
    this.contractionSign = p.observation === "most_contracted" ? 1 : -1;
    this.reset();
  }

  /** Back to the undeformed body, silent and at rest. */
  reset() {
    for (const row of [this.u, this.v, this.slip, this.drive, this.force, this.on]) row.fill(0);
    this.W.fill(ENDLESS);
    this.spikedAt.fill(-Infinity);
    this.time = 0;
    this.centroid = 0;
  }

  /** Eq. 10: the action switches one neuron on; the tail's goes with the head's. */
  switchOn(action) {
    this.on.fill(0);
    this.on[action] = 1;
    if (action === 0) this.on[this.on.length - 1] = 1;
  }

  /** Hold one neuron on for a decision interval; the displacement of the centroid, L. */
  decide(action) {
    const before = this.centroid;
    this.switchOn(action);
    for (let i = 0; i < this.stepsPerDecision; i++) this.step();
    this.measureCentroid();
    return this.centroid - before;
  }

  /** One step of dt: neurons drive muscles, muscles pull on the body. */
  step() {
    const { force, meanForce, driveDecay, forceDecay } = this;
    for (let i = 0; i < force.length; i++) {
      const before = force[i], spike = this.fire(i);
      if (spike >= 0) {
        this.contractAround(i, spike);
      } else {
        this.contract(i, driveDecay, forceDecay);
      }
      meanForce[i] = (before + force[i]) / 2;
    }
    this.moveBody();
    this.time += this.dt;
  }

  /* Eq. 6, dtheta/dt = rate (1 - cos theta + (1 + cos theta) I), with W = cot(theta / 2): switched off, W falls
     steadily; switched on, theta / 2 turns like the hand of a clock. theta = pi is W = 0, and theta = 2 pi is
     where W runs to minus infinity and comes back from above. At rest theta = 0, and W is endless.
     Returns when in the step the neuron spikes (eq. 7), or -1. */
  fire(i) {
    const { W, turn, tanTurn, spikesAtPi, spikesAtTwoPi } = this, old = W[i];
    if (this.on[i] === 0) {
      W[i] = old - turn;
      return spikesAtPi && old > 0 && W[i] <= 0 ? old / this.parameters.neuron_rate : -1;
    }
    const turned = 1 + old * tanTurn;
    W[i] = (old - tanTurn) / turned;
    if (spikesAtPi && old > 0 && W[i] <= 0) return Math.atan(old) / this.parameters.neuron_rate;
    return spikesAtTwoPi && turned < 0 ? Math.atan(-1 / old) / this.parameters.neuron_rate : -1;
  }

  /* Eq. 5: the drive F decays between spikes. Eq. 4: tau_f df/dt = -f + F_max min(1, F). */
  contract(i, driveDecay, forceDecay) {
    const { drive, force } = this, before = drive[i], after = before * driveDecay;
    const goal = (Math.min(before, 1) + Math.min(after, 1)) / 2 * this.parameters.muscle_force_max;
    drive[i] = after;
    force[i] = goal + (force[i] - goal) * forceDecay;
  }

  /* The same in a step with a spike, which adds a term to the sum of eq. 5. */
  contractAround(i, spike) {
    const { tau_m, tau_f, spike_gain } = this.parameters, later = this.dt - spike;
    this.contract(i, Math.exp(-spike / tau_m), Math.exp(-spike / tau_f));
    this.drive[i] += spike_gain;
    this.contract(i, Math.exp(-later / tau_m), Math.exp(-later / tau_f));
    this.spikedAt[i] = this.time + spike;
    if (this.onSpike) this.onSpike(i, this.time + spike);
  }

  /* Eq. 1-3 in the middle of the step, where u has become u + v dt / 2; A is the Laplacian of the chain:
         (c + dt / 2) A v + friction(v) = B f - A u = g. */
  moveBody() {
    this.pull();
    this.balance();
    const { u, v, dt } = this;
    for (let j = 0; j < u.length; j++) u[j] += dt * v[j];
  }

  /* g: a muscle pulls the two ends of its segment together; the head muscle pushes node 0 forward. */
  pull() {
    const { g, u, meanForce: force } = this, tail = u.length - 1, { head_muscle } = this.parameters;
    g.fill(0);
    for (let i = 1; i <= tail; i++) {
      const tension = force[i] - (u[i] - u[i - 1]);
      g[i - 1] -= tension;
      g[i] += tension;
    }
    if (head_muscle !== "none") g[0] += force[0];
    if (head_muscle === "reaction") g[1] -= force[0];
  }

  /* Dry friction is 9 or 0.3 on a node that slides, and whatever it takes, up to these, on one that sticks.
     Guess who slides (slip: 1 forward, 0 sticks, -1 backward) as in the step before, solve, correct. */
  balance() {
    for (let pass = 0; pass < 12; pass++) {
      this.solveSliding();
      if (!this.correctSlip()) return;
    }
    this.balanceFromRest();
  }

  /* (c + dt / 2) A v = g - friction for the nodes that slide, v = 0 for the others: Thomas algorithm. */
  solveSliding() {
    const { v, slip, g, pivot, mobility } = this, { forward, backward } = this.limits, tail = v.length - 1;
    let above = 0, coupling = 0;
    for (let j = 0; j <= tail; j++) {
      if (slip[j] === 0) {
        above = coupling = 0;
      } else {
        const friction = slip[j] > 0 ? forward : -backward;
        above = (g[j] - friction) * mobility + coupling * above;
        coupling = 1 / Math.max((j === 0 || j === tail ? 1 : 2) - coupling, ROUNDING);
      }
      v[j] = above;
      pivot[j] = coupling;
    }
    v[tail] *= pivot[tail];
    for (let j = tail - 1; j >= 0; j--) v[j] = (v[j] + v[j + 1]) * pivot[j];
  }

  /* The friction that it would take to hold node j. */
  holding(j) {
    const { g, v, drag } = this;
    return g[j] + drag * ((j > 0 ? v[j - 1] : 0) + (j + 1 < v.length ? v[j + 1] : 0));
  }

  /* Let go of who is pulled too hard, stop who slides against its own friction; was anything to correct? */
  correctSlip() {
    const { v, slip } = this, { forward, backward } = this.limits;
    let corrected = false;
    for (let j = 0; j < v.length; j++) {
      if (slip[j] !== 0) {
        if (v[j] * slip[j] >= 0) continue;
        slip[j] = 0;
      } else {
        const held = this.holding(j);
        if (held <= forward && held >= -backward) continue;
        slip[j] = held > 0 ? 1 : -1;
      }
      corrected = true;
    }
    return corrected;
  }

  /* Where correcting goes in a circle: let all stick, then let go of one set after the other. The nodes that
     slide backward only ever become more, and so do, given these, those that slide forward: it ends. */
  balanceFromRest() {
    const { slip } = this, { forward, backward } = this.limits;
    const release = (direction, overloaded) => {
      let released = false;
      for (let j = 0; j < slip.length; j++) {
        if (slip[j] === 0 && overloaded(this.holding(j))) {
          slip[j] = direction;
          released = true;
        }
      }
      return released;
    };
    slip.fill(0);
    do {
      for (let j = 0; j < slip.length; j++) slip[j] = Math.min(slip[j], 0);
      do this.solveSliding(); while (release(1, (held) => held > forward));
    } while (release(-1, (held) => held < -backward));
  }

  measureCentroid() {
    let sum = 0;
    for (let j = 0; j < this.u.length; j++) sum += this.u[j];
    this.centroid = sum / this.u.length;
  }

  /** r_2 of eq. 11: the largest |u_(i+1) - 2 u_i + u_(i-1)|. */
  strainGradient() {
    const { u } = this;
    let largest = 0;
    for (let i = 1; i < u.length - 1; i++) {
      largest = Math.max(largest, Math.abs(u[i + 1] - 2 * u[i] + u[i - 1]));
    }
    return largest;
  }

  /** Eq. 9: index, from 0 at the head, of the segment sensed as most contracted; equal ones by lot. */
  observe(noise, random) {
    const { u, contractionSign } = this;
    let best = -Infinity, index = 0, ties = 0;
    for (let i = 0; i < u.length - 1; i++) {
      let sensed = u[i + 1] - u[i];
      if (noise > 0) sensed += noise * (2 * random() - 1);
      sensed *= contractionSign;
      if (sensed > best) {
        best = sensed;
        index = i;
        ties = 1;
      } else if (sensed === best && random() * ++ties < 1) {
        index = i;
      }
    }
    return index;
  }

  /** Shake every node by up to `strength` L, as a foot on the ground beside it would. */
  kick(strength, random) {
    for (let j = 0; j < this.u.length; j++) this.u[j] += strength * (2 * random() - 1);
    this.measureCentroid();
  }
}
