//! girtin-girtin
