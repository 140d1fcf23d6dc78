"""Compiling Python to machine code, once: the decorator of every kernel and the cache. It knows no crawlers."""

from crawler_bench.physics.compiled.cache import KERNEL_HASH, cache_folder, source_hash
from crawler_bench.physics.compiled.kernels import kernel

__all__ = ["KERNEL_HASH", "cache_folder", "kernel", "source_hash"]
