//! Spheres against published values, references in high precision, and identities.

mod debye;
mod fourier;
mod high_precision;
mod identities;
mod instructions_and_errors;
#[rustfmt::skip]
mod order_references;
mod published;
#[rustfmt::skip]
mod references;
mod support;
