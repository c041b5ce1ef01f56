//! girtin-painting
