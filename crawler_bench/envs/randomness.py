"""NumPy's PCG64 on its raw state, so that compiled loops draw the numbers that NumPy would.

Handing a `Generator` to compiled code costs more than a whole decision of the crawler, and a batch of
crawlers needs a generator for each. So kernels take the four 64-bit words of a generator's state instead: a
live view of the generator's own memory (both then go on together) or a row of an array.

Source: O'Neill 2014, "PCG: A family of simple fast space-efficient statistically good algorithms for random
number generation"; PCG64 is its XSL-RR variant with 128 bits of state.
"""

import ctypes

import numpy as np
from numpy.typing import NDArray

from crawler_bench.physics.compiled import inner_kernel

State = NDArray[np.uint64]

_MULTIPLIER_HIGH = np.uint64(0x2360ED051FC65DA4)
_MULTIPLIER_LOW = np.uint64(0x4385DF649FCCF645)
_MASK_32 = np.uint64(0xFFFFFFFF)
_32, _58, _64, _11, _63 = (np.uint64(n) for n in (32, 58, 64, 11, 63))
_UNIT = 1.0 / 9007199254740992.0  # 2^-53


def live_state(generator: np.random.Generator) -> State:
    """A view, (4,) words, of the memory of a generator: draws from either move both.

    The view is valid as long as the generator lives.

    Raises:
        TypeError: if the generator is not a PCG64, as `np.random.default_rng` and Gymnasium make them.
    """
    if not isinstance(generator.bit_generator, np.random.PCG64):
        raise TypeError(f"a PCG64 generator is needed, not {type(generator.bit_generator).__name__}")
    pointer = ctypes.c_uint64.from_address(generator.bit_generator.ctypes.state_address).value
    return np.ctypeslib.as_array((ctypes.c_uint64 * 4).from_address(pointer))


@inner_kernel
def random(state: State) -> float:
    """Draw from [0, 1), as `Generator.random()` does.

    Args:
        state: (4,) low and high word of the state, low and high word of the increment; moved on.
    """
    low, high = state[0], state[1]
    # state = state * multiplier + increment, modulo 2^128
    product_low = low * _MULTIPLIER_LOW
    product_high = _high_product(low, _MULTIPLIER_LOW) + low * _MULTIPLIER_HIGH + high * _MULTIPLIER_LOW
    new_low = product_low + state[2]
    carry = np.uint64(1) if new_low < product_low else np.uint64(0)
    new_high = product_high + state[3] + carry
    state[0], state[1] = new_low, new_high
    # output: both halves xored, rotated right by the six highest bits
    mixed = new_high ^ new_low
    turn = new_high >> _58
    bits = (mixed >> turn) | (mixed << ((_64 - turn) & _63))
    return float(bits >> _11) * _UNIT


@inner_kernel
def _high_product(a: np.uint64, b: np.uint64) -> np.uint64:
    """High word of the product of two words."""
    a_low, a_high = a & _MASK_32, a >> _32
    b_low, b_high = b & _MASK_32, b >> _32
    low, cross, other = a_low * b_low, a_high * b_low, a_low * b_high
    middle = (low >> _32) + (cross & _MASK_32) + (other & _MASK_32)
    return a_high * b_high + (cross >> _32) + (other >> _32) + (middle >> _32)
