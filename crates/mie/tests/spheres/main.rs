//! Spheres against published values, references in high precision, and identities.

mod debye;
mod fourier;
mod hard_cases;
mod high_precision;
mod identities;
#[rustfmt::skip]
mod order_references;
mod published;
#[rustfmt::skip]
mod references;
mod support;
