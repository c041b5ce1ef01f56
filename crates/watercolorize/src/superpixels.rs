//! Pixels gathered into small patches of one color.
