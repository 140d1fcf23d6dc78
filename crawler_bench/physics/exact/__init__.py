"""The crawler from event to event, in closed form: no time step, exact to rounding."""
