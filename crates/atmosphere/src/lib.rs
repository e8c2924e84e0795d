//! Air: one file for each constituent, one for each method of solution.
