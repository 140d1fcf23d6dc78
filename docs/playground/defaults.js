"use strict";
// Written by crawler_bench/report/playground.py from the package's own defaults.
const DEFAULTS = {
  "parameters": {
    "n_segments": 10,
    "damping": 3.5,
    "tau_m": 1.0,
    "tau_f": 0.4,
    "muscle_force_max": 1.0,
    "friction_forward": 0.3,
    "friction_backward": 9.0,
    "friction_law": "table",
    "head_muscle": "external",
    "spike_phase": "every_pi",
    "neuron_rate": 1.59,
    "spike_gain": 1.0,
    "observation": "most_contracted",
    "decision_interval": 0.19,
    "penalty": "decision"
  },
  "choices": {
    "friction_law": [
      "table",
      "literal"
    ],
    "head_muscle": [
      "reaction",
      "external",
      "none"
    ],
    "spike_phase": [
      "pi",
      "2pi",
      "every_pi"
    ],
    "observation": [
      "most_contracted",
      "most_stretched"
    ],
    "penalty": [
      "decision",
      "rate"
    ]
  },
  "learner": {
    "learning_rate": 0.05,
    "discount": 0.95,
    "initial_q": 3.9,
    "regularization": 0.01,
    "episode_distance": 8.83,
    "time_limit": 4000.0
  },
  "policies": {
    "regularized": "0123456789",
    "unregularized": "4902305788",
    "fastest": "6650073678"
  }
};
