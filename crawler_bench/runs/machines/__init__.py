"""Where the work of a sweep is done: on this machine, or on others through Dask."""
