"""The policy of any agent: as a table, as a file, or asked at every decision."""
