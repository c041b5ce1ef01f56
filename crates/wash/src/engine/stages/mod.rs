//! Which rows each stage gives to its kernels.

mod film;
mod living;
mod mix;
mod packed;
mod pigment;
mod pores;
pub mod refine;
mod water;
