"""Compile Python to machine code, once: the decorator of kernels and the cache; nothing about crawlers."""

from crawler_bench.physics.compiled.cache import KERNEL_HASH, cache_folder, source_hash
from crawler_bench.physics.compiled.kernels import inline_kernel, inner_kernel, kernel

__all__ = ["KERNEL_HASH", "cache_folder", "inline_kernel", "inner_kernel", "kernel", "source_hash"]
