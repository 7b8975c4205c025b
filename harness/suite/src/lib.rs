//! Makes suites: the seeded generator, the global planner, the import of the original data.
