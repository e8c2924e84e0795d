//! Spheres against published values, references in high precision, and identities.

mod debye;
mod high_precision;
mod identities;
mod published;
#[rustfmt::skip]
mod references;
mod support;
