//! Scattering tables: a theory, averaged over drop sizes and the sun's disc.
