//! Which rows each stage gives to its kernels.

mod film;
mod living;
mod packed;
mod pigment;
mod pores;
mod water;
