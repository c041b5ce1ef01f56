//! girtin-optics
