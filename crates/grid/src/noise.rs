//! Gradient noise, fractal sums and cellular noise over the plane, tileable at will.
