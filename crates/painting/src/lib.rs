//! Girtin's document: what is painted, how it is simulated, what it looks like, and every file.
//!
//! In the order data flows:
//! - [`wash_settings`]: the TOML of a single wash;
//! - [`composite`]: pigment becomes color;
//! - [`state_file`]: a wash's state as NumPy reads it;
//! - [`picture`]: pictures in and out.
#![forbid(unsafe_code)]

pub mod wash_settings;

pub mod composite;

pub mod state_file;
pub mod picture;

pub use wash_settings::{WashSettings, handling_of};
