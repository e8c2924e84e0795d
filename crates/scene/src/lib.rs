//! Scene files, effects, the plan with its bounds, and presets.
