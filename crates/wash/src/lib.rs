//! girtin-wash
