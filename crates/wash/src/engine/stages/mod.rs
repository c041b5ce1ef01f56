//! Which rows each stage gives to its kernels.

mod pigment;
mod pores;
mod water;
