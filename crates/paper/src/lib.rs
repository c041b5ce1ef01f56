//! girtin-paper
