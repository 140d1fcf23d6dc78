"""Every numerical tolerance and limit of the physics, each with its reason.

Times are in tau_theta, forces in k L, lengths in L; what has no unit is relative.
"""

NEVER = 1e300
"""A time that does not come. Finite, so that JSON can hold it."""

NEGLIGIBLE = 1e-200
"""Drives and forces below this are 0: they would decay into denormal numbers, which are slow."""

# The exact integrator.
EVENT = 1e-13
"""Of forces, velocities and times at which a node starts or stops sliding: a few hundred roundings of 1."""

COINCIDENCE = 1e-13
"""A spike this close to the end of a decision is at its end: rounding must neither lose nor double it."""

LONGEST_EPOCH = 2.0
"""In units of the shortest time constant: rounding errors grow exponentially from the epoch on."""

SUM_OF_DECISIONS = 1.0 + 1e-9
"""Rounding of a sum of decision intervals must not begin an epoch one decision early."""

MOST_EVENTS = 200
"""For each node in 1 tau_theta; a crawl has a few for the whole body. Beyond, the integrator gives up."""

SURE_TURN = 1.5
"""Half the angle by which an ON neuron may turn in a decision before it can pass its spike and come round."""

# Searches for the time at which a margin falls below 0.
ROOT_PASSES = 100
"""Bisection alone halves any interval down to rounding in fewer."""

QUADRATIC = 1e-2
"""Safety on the error of a Newton step, which is about the square of the step."""

# Responses to decays.
CLOSE_EXPONENTS = 0.1
"""Spread of three exponents below which their divided difference is summed as a series."""

SERIES_TERMS = 9
"""With exponents so close, the terms beyond are below rounding."""

NEAR_EXPONENT = 2e-3
"""Largest exponent whose exponential series has only five terms above rounding."""

APART_RATES = 1e-3
"""Relative distance of two rates from which on partial fractions lose too few digits to matter."""

# The balance of forces with every node sliding, where rigid motion meets no resistance.
RIGID_RESISTANCE = 1e-9
"""A pivot in place of 0: forces out of balance drive a violent motion, which shows who has to stop."""

BALANCED = 1e-13
"""Relative to the sum of their magnitudes, forces whose sum is below this balance."""

EQUAL_FRICTION = 1e-9
"""Relative difference of the friction on the nodes sliding forward and backward that counts as a balance."""

WARM_PASSES = 8
"""Corrections of the states of the step before; two are usual, and then the states are built up from rest."""

# Parameters.
WHOLE_MULTIPLE = 1e-9
"""Relative distance of decision_interval / dt from a whole number."""
