//! A matte cut out by hand.
