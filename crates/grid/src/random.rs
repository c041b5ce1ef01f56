//! Numbers that are a function of (seed, stage, place).
